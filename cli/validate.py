"""`softact validate`: every fault of a spec at once, without meshing, and what its file holds."""

import sys
from typing import TYPE_CHECKING

import click

from softact.cli._files import tell_file
from softact.cli._options import set_option
from softact.errors import SpecError

if TYPE_CHECKING:
    from softact.inputs import Checked


@click.command(short_help="Check specs and other files; every fault at once, without meshing.")
@click.argument("files", nargs=-1, required=True, metavar="FILE...")
@set_option
def validate(files: tuple[str, ...], overrides: tuple[str, ...]) -> None:
    """Check files: every fault in a line of its own, with file, line and path.

    A file may be a spec, a sweep, an optimisation, a reference case, a material card, a list of
    test data or one of published requirements; it is checked as what it is. Nothing is meshed or
    written, and no script is run. Of a STEP file or a mesh that a spec names it says which solids
    and faces it found. Exits with 2 when a file has a fault. A value of a spec that is right in
    form and looks a unit wrong is warned of, and is no fault; walls that the mesh is too coarse for
    are noted.

    \b
    Examples:
      softact validate configs/pneunet_glove.yaml
      softact validate configs/sweeps/*.yaml my_silicone.yaml
    """
    from pathlib import Path

    from softact.inputs import validate as check
    from softact.units import printable

    faults = 0
    said_before: set[str] = set()  # a wrong --set is a fault of every spec
    for path in files:
        try:
            checked = check(Path(path), overrides)
        except SpecError as error:
            faults += len(error.lines)
            for line in error.lines:
                if line not in said_before:
                    click.echo(printable(line), err=True)
                said_before.add(line)
        else:
            faults += _tell(path, checked)
    if faults:
        sys.exit(SpecError.exit_code)


def _tell(path: str, checked: "Checked") -> int:
    """Say what a file is, what looks odd in it and what the file of its geometry holds; return the
    number of faults of the latter."""
    from softact.geometry.walls import expected
    from softact.spec import plausible

    if checked.spec is None:
        click.echo(f"{path}: ok, {checked.called}")
        return 0
    warnings = plausible.lines(checked.spec, checked.source)
    for line in warnings:
        click.echo(f"warning: {line}", err=True)
    geometry = checked.spec.geometry
    faults = tell_file(path, geometry, f"{path}: ok{_counted(len(warnings))}")
    thin = expected(geometry.walls())
    if thin:
        click.echo(f"{path}: note: {thin}")
    return faults


def _counted(warnings: int) -> str:
    return f", {warnings} warning{'s' if warnings > 1 else ''}" if warnings else ""
