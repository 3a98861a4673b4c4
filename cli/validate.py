"""`softact validate`: every fault of a spec at once, without meshing, and what its file holds."""

import sys

import click

from softact.cli._files import tell_file
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

    Nothing is meshed or written, and no script is run. Of a STEP file or a mesh it says which
    solids and faces it found. Exits with 2 when a spec has a fault.

    \b
    Example:
      softact validate configs/pneunet_glove.yaml
    """
    from softact.spec import load

    faults = 0
    for path in specs:
        try:
            geometry = load(path, overrides).geometry
        except SpecError as error:
            faults += len(error.lines)
            for line in error.lines:
                click.echo(line, err=True)
        else:
            faults += tell_file(path, geometry)
    if faults:
        sys.exit(SpecError.exit_code)
