"""`softact validate`: every fault of a spec at once, without meshing."""

import sys

import click

from softact.errors import SpecError


@click.command(short_help="Check specs; every fault at once, without meshing.")
@click.argument("specs", nargs=-1, required=True, metavar="SPEC...")
@click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="PATH=VALUE",
    help="Replace a value of the spec, as 'softact run' does.",
)
def validate(specs: tuple[str, ...], overrides: tuple[str, ...]) -> None:
    """Check specs: every fault in a line of its own, with file, line and path.

    Nothing is meshed or written. Exits with 2 when a spec has a fault. A value that is right in
    form and looks a unit wrong is warned of, and is no fault.

    \b
    Example:
      softact validate configs/pneunet_glove.yaml
    """
    from softact.spec import opened, plausible, spec_of

    faults = 0
    for path in specs:
        try:
            source = opened(path, overrides)
            warnings = plausible.lines(spec_of(source), source)
        except SpecError as error:
            faults += len(error.lines)
            for line in error.lines:
                click.echo(line, err=True)
        else:
            for line in warnings:
                click.echo(f"warning: {line}", err=True)
            click.echo(f"{path}: ok" + _counted(len(warnings)))
    if faults:
        sys.exit(SpecError.exit_code)


def _counted(warnings: int) -> str:
    return f", {warnings} warning{'s' if warnings > 1 else ''}" if warnings else ""
