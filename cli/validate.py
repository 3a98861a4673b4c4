"""`softact validate`: every fault of a spec at once, without meshing."""

import sys

import click

from softact.errors import SpecError


@click.command(short_help="Check specs and other files; every fault at once, without meshing.")
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="PATH=VALUE",
    help="Replace a value of the spec, as 'softact run' does.",
)
def validate(files: tuple[str, ...], overrides: tuple[str, ...]) -> None:
    """Check files: every fault in a line of its own, with file, line and path.

    A file may be a spec, a sweep, an optimisation, a reference case, a material card, a list of
    test data or one of published requirements; it is checked as what it is. Nothing is meshed or
    written. Exits with 2 when a file has a fault. A value of a spec that is right in form and
    looks a unit wrong is warned of, and is no fault.

    \b
    Examples:
      softact validate configs/pneunet_glove.yaml
      softact validate configs/sweeps/*.yaml my_silicone.yaml
    """
    from pathlib import Path

    from softact.inputs import validate as check
    from softact.spec import plausible

    faults = 0
    for path in files:
        try:
            checked = check(Path(path), overrides)
            warnings = plausible.lines(checked.spec, checked.source) if checked.spec else []
        except SpecError as error:
            faults += len(error.lines)
            for line in error.lines:
                click.echo(line, err=True)
        else:
            for line in warnings:
                click.echo(f"warning: {line}", err=True)
            what = "" if checked.spec else f", {checked.called}"
            click.echo(f"{path}: ok{what}{_counted(len(warnings))}")
    if faults:
        sys.exit(SpecError.exit_code)


def _counted(warnings: int) -> str:
    return f", {warnings} warning{'s' if warnings > 1 else ''}" if warnings else ""
