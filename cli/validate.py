"""`softact validate`: every fault of a spec at once, without meshing."""

import sys
from typing import TYPE_CHECKING

import click

from softact.errors import SpecError

if TYPE_CHECKING:
    from softact.inputs import Checked


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
    written. Exits with 2 when a file has a fault. A value of a spec that is right in form and looks
    a unit wrong is warned of, and is no fault.

    \b
    Examples:
      softact validate configs/pneunet_glove.yaml
      softact validate configs/sweeps/*.yaml my_silicone.yaml
    """
    from pathlib import Path

    from softact.inputs import validate as check

    faults = 0
    for path in files:
        try:
            checked = check(Path(path), overrides)
        except SpecError as error:
            faults += len(error.lines)
            for line in error.lines:
                click.echo(line, err=True)
        else:
            _tell(path, checked)
    if faults:
        sys.exit(SpecError.exit_code)


def _tell(path: str, checked: "Checked") -> None:
    """Say that a file has no fault, what it is, and what looks odd in it."""
    from softact.spec import plausible

    said = [f"{path}: ok"] if checked.spec else [f"{path}: ok", checked.called]
    warnings = plausible.lines(checked.spec, checked.source) if checked.spec else []
    for line in warnings:
        click.echo(f"warning: {line}", err=True)
    if warnings:
        said.append(f"{len(warnings)} warning{'s' if len(warnings) > 1 else ''}")
    click.echo(", ".join(said))
