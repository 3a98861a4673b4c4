"""`softact`: finds the commands, one file each beside this one, and turns errors into plain lines.

Exit codes: 0 done; 1 a check deviates; 2 the spec or another input is wrong; 3 the mesh failed;
4 no equilibrium was found; 70 a fault in softact itself; 128 + n stopped by signal n (130: Ctrl-C).
"""

import atexit
import errno
import importlib
import os
import pkgutil
import signal
import sys
import threading
import traceback
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn

import click
from click.shell_completion import shell_complete

from softact.child_processes import leave_current_folder
from softact.errors import NOT_IN_LOCALE, NOT_UTF8, SoftactError
from softact.files.streams import abandon_output, abandon_stdout, make_safe
from softact.nearest import nearest

WRONG_INPUT, BUG, INTERRUPTED, BROKEN_PIPE = 2, 70, 130, 141
FULL = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
FIRST = (
    "new",
    "run",
    "validate",
    "mesh",
    "list",
    "report",
    "compare",
    "schema",
    "doctor",
    "fit",
    "calibrate",
)


class Commands(click.Group):
    """The commands that are files beside this one; each is imported only when it is asked for."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands, the usual ones first."""
        package = importlib.import_module("softact.cli")
        names = {module.name for module in pkgutil.iter_modules(package.__path__)}
        names = {name for name in names if name != "main" and not name.startswith("_")}
        return [n for n in FIRST if n in names] + sorted(names - set(FIRST))

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the click command in the file ``cmd_name``."""
        if cmd_name not in self.list_commands(ctx):
            return None
        module = importlib.import_module(f"softact.cli.{cmd_name}")
        return next(v for v in vars(module).values() if isinstance(v, click.Command))

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Like click's, but an unknown command is answered with the nearest one."""
        known = self.list_commands(ctx)
        if args and args[0] not in known and not args[0].startswith("-"):
            hint = nearest(args[0], known)
            if args[0].endswith((".yaml", ".yml")):
                hint = _use(args[0])
            ctx.fail(f"There is no command '{args[0]}'; {hint}")
        return super().resolve_command(ctx, args)


def _use(file: str) -> str:
    """What is done with a file that stands where a command should."""
    from pathlib import Path

    from softact.spec.kinds import KINDS, kind_of, read_any

    try:
        kind = KINDS[kind_of(read_any(Path(file)))]
    except SoftactError:
        return f"to solve a spec write: softact run {file}"
    return f"{file} is {kind.called}; {kind.use.format(file)}"


def _version(ctx: click.Context, parameter: click.Parameter, wanted: bool) -> None:
    if not wanted or ctx.resilient_parsing:
        return
    # importlib.metadata is slow to import for a line that is seldom asked for.
    from importlib.metadata import version

    click.echo(f"softact {version('softact')}")
    ctx.exit()


@click.group(
    cls=Commands,
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="'softact COMMAND --help' shows an example for each command. The shell completes "
    'commands, options and names after: eval "$(_SOFTACT_COMPLETE=bash_source softact)" '
    "(or zsh_source, fish_source).",
)
@click.option(
    "--version",
    is_flag=True,
    expose_value=False,
    is_eager=True,
    callback=_version,
    help="Print the version.",
)
@click.option(
    "--debug",
    is_flag=True,
    expose_value=False,
    help="Show Python's traceback of an error; works after any command too.",
)
@click.pass_context
def softact(ctx: click.Context) -> None:
    """From a YAML spec of a soft pneumatic actuator to its data sheet.

    How far it bends, how hard it pushes, how much air it takes. Start with

    \b
      softact new --does bend -o finger.yaml
      softact run finger.yaml
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and leave with its exit code."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        # As an exception, so that processes of the solver do not outlive this one.
        signal.signal(number, _leave)
    make_safe()
    as_program = arguments is None
    if as_program:
        leave_current_folder()
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in arguments
    code = _run([a for a in arguments if a != "--debug"], debug)
    if as_program and threading.active_count() == 1:
        _end(code)
    sys.exit(code)


def _end(code: int) -> NoReturn:
    """Leave without taking Python apart: with all that a report needs, that takes 0.2 s."""
    with suppress(OSError):
        sys.stderr.flush()
    atexit._run_exitfuncs()
    os._exit(code)


def _leave(number: int, frame: object) -> None:
    sys.exit(128 + number)


def _run(arguments: list[str], debug: bool) -> int:
    try:
        code = _click(arguments)
        sys.stdout.flush()
        return code if isinstance(code, int) else 0
    except BrokenPipeError:
        return _nobody_reads()
    except SystemExit as left:
        if isinstance(left.__context__, BrokenPipeError):  # as rich leaves
            return _nobody_reads()
        if isinstance(left.code, str):
            raise
        try:
            sys.stdout.flush()
        except BrokenPipeError:
            return _nobody_reads()
        return left.code or 0
    except (KeyboardInterrupt, click.Abort):
        click.echo("\nsoftact: stopped", err=True)  # after the ^C of the terminal
        return INTERRUPTED
    except Exception as error:
        if debug and not isinstance(error, click.ClickException):
            traceback.print_exc()
        return _tell(error)


def _click(arguments: list[str]) -> object:
    """What click's own main does; that one would turn a broken pipe into exit code 1."""
    if instruction := os.environ.get("_SOFTACT_COMPLETE"):
        return shell_complete(softact, {}, "softact", "_SOFTACT_COMPLETE", instruction)
    if "" in arguments:  # Path("") would be the current folder
        place = arguments.index("") + 1
        raise click.UsageError(
            f"word {place} of the call is empty ('{arguments[0]} ...'); is a shell variable unset?"
        )
    try:
        with softact.make_context("softact", arguments) as context:
            return softact.invoke(context)
    except click.exceptions.Exit as left:
        return left.exit_code


def _nobody_reads() -> int:
    """The reader of a pipe (head, less) has left; nothing is to be told to anybody."""
    abandon_output()
    return BROKEN_PIPE


def _tell(error: Exception) -> int:
    """Tell what went wrong as far as anybody hears it; return the exit code."""
    try:
        sys.stdout.flush()
    except OSError:
        abandon_stdout()
    try:
        return _print(error)
    except BrokenPipeError:
        return _nobody_reads()


def _print(error: Exception) -> int:
    """Print what went wrong in plain lines; return the exit code.

    What it holds of the call and of files may be anything; a terminal shall not obey it.
    """
    from softact.units import printable

    if isinstance(error, SoftactError):
        for line in dict.fromkeys(error.lines):
            click.echo(printable(line), err=True)
        return error.exit_code
    if isinstance(error, click.ClickException):
        text = "\n".join(map(printable, error.format_message().split("\n")))
        context = error.ctx if isinstance(error, click.UsageError) else None
        click.UsageError(text, context).show()  # without context it shows no usage
        return WRONG_INPUT
    if isinstance(error, OSError) and error.filename is not None:
        click.echo(printable(f"{error.filename}: {error.strerror}"), err=True)
        return WRONG_INPUT
    if isinstance(error, OSError) and error.errno in FULL:
        click.echo(f"softact: cannot write: {error.strerror}", err=True)
        return WRONG_INPUT
    if isinstance(error, UnicodeEncodeError):
        from softact.units import show

        utf8 = error.encoding.lower().replace("-", "") == "utf8"
        click.echo(f"{show(error.object)}: {NOT_UTF8 if utf8 else NOT_IN_LOCALE}", err=True)
        return WRONG_INPUT
    if isinstance(error, MemoryError):
        click.echo("softact: out of memory; what was finished is kept", err=True)
        return BUG
    what = " ".join(str(error).split())[:200] or "no message"
    click.echo(
        f"softact: this is a fault in softact, not in your input: {type(error).__name__}: {what} "
        "(run the same command with --debug to see where, and report it)",
        err=True,
    )
    return BUG


if __name__ == "__main__":
    main()
