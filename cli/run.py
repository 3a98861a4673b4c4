"""`softact run`: solve one spec."""

import shlex
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from softact.cli._force import force_option
from softact.cli._measured import measured_options, read_all, tell
from softact.cli._options import set_option

if TYPE_CHECKING:
    from softact.run.start import Outcome
    from softact.spec import Spec


@click.command(short_help="Solve a spec; the results and a report go into a folder.")
@click.argument("spec")
@click.option(
    "-o",
    "--output",
    metavar="DIR",
    help="Folder for the results.  [default: results/<name of the spec>]",
)
@click.option(
    "-n",
    "--processes",
    type=click.IntRange(1, 1024),
    metavar="PROCS",
    help="MPI processes.  [default: the cores, up to two; one with sheets or a module]",
)
@set_option
@force_option
@click.option(
    "--resume",
    is_flag=True,
    help="Go on with the run in DIR from its last accepted increment; later steps and a higher "
    "last load may be added.",
)
@click.option(
    "--sensitivities",
    is_flag=True,
    help="Also differentiate all measures by all numbers of the spec, at every increment.",
)
@click.option(
    "-p",
    "--parameter",
    "parameters",
    multiple=True,
    metavar="PATH",
    help="The same by this number only, such as geometry.wall. May be repeated.",
)
@measured_options
def run(
    spec: str,
    output: str | None,
    processes: int | None,
    overrides: tuple[str, ...],
    force: bool,
    resume: bool,
    sensitivities: bool,
    parameters: tuple[str, ...],
    measured: tuple[Path, ...],
    columns: str | None,
) -> None:
    """Solve a spec and write its data sheet: curves, measures, fields and a report.

    The spec is checked before anything is written. Results that are in DIR already are
    replaced. Exits with 2 for a wrong spec, 3 where the mesh failed, 4 where no equilibrium
    was found; what was reached until then is kept.

    \b
    Examples:
      softact run configs/pneunet_glove.yaml
      softact run finger.yaml -o results/thin --set geometry.roof='0.8 mm'
      softact run finger.yaml --measured angle.csv
      softact run finger.yaml -p geometry.wall -p materials.body.c10
      softact run finger.yaml --resume --set steps.1.pressure='60 kPa'
    """
    from softact.cli._progress import ProgressLine
    from softact.results.own_folder import check_results
    from softact.run.start import run as solve
    from softact.run.start import usual_processes
    from softact.spec import load

    loaded = load(spec, overrides)
    directory = Path(output) if output else Path("results") / loaded.name
    called = shlex.join(["softact", "run", spec])
    read_in = read_all(measured, _columns(loaded) if measured else (), columns, called)
    # The spec that a run has stored is softact's own, as long as nobody has edited it.
    stored = load(spec).to_yaml() == Path(spec).read_text(encoding="utf-8")
    check_results(directory, force, reads=[*measured, *([] if stored else [Path(spec)])])

    with (
        resume_hint(directory, _again(spec, directory, overrides)),
        ProgressLine([step.name for step in loaded.steps]) as progress,
    ):
        outcome = solve(
            loaded,
            directory,
            processes=processes or usual_processes(loaded),
            progress=progress,
            measured=read_in,
            resume=resume,
            sensitivities=parameters if parameters or sensitivities else None,
        )
    tell(directory, read_in)
    _tell_verdict(outcome)
    click.echo(f"report: {directory / 'report.html'}")
    sys.exit(outcome.exit_code)


def _again(spec: str, directory: Path, overrides: Sequence[str]) -> str:
    """The command that goes on with the run."""
    changed = [word for override in overrides for word in ("--set", override)]
    return shlex.join(["softact", "run", spec, "-o", str(directory), *changed, "--resume"])


@contextmanager
def resume_hint(directory: Path, command: str) -> Iterator[None]:
    """Say how the run goes on where it was stopped, or its solver ended, with states behind it."""
    from softact.files.restart import RESTART
    from softact.run.start import SolverCrashError

    began = time.time()
    try:
        yield
    except (KeyboardInterrupt, SystemExit, SolverCrashError):
        restart = directory / RESTART
        if restart.is_file() and restart.stat().st_mtime >= began - 1:
            click.echo(f"\nwhat was solved is kept; it goes on with: {command}", err=True)
        raise


def _tell_verdict(outcome: "Outcome") -> None:
    """What is to be thought of the run, on standard error where it is not solved."""
    if outcome.verdict is None:
        if outcome.message:
            click.echo(outcome.message, err=True)
        return
    head, *reasons = outcome.verdict.lines
    unsolved = outcome.exit_code != 0
    colour = "red" if unsolved else {"green": "green"}.get(outcome.verdict.colour, "yellow")
    click.secho(head, fg=colour, bold=True, err=unsolved)
    for line in reasons:
        click.echo(line, err=unsolved)


def _columns(spec: "Spec") -> list[str]:
    from softact.measured.curve import run_columns

    return run_columns(spec)
