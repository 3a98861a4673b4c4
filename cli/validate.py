"""`softact validate`: every fault of a spec at once, without meshing, and what its file holds."""

import sys

import click

from softact.errors import MeshError, SoftactError, SpecError


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
    from softact.geometry import look
    from softact.spec import load

    faults = 0
    for path in specs:
        said: list[str] = []
        try:
            geometry = load(path, overrides).geometry
            said = geometry.notes()
            look(geometry, said)
        except SoftactError as error:
            faults += len(error.lines)
            at = f"{path}: geometry: " if isinstance(error, MeshError) else ""
            for line in error.lines:
                click.echo(at + line, err=True)
        else:
            click.echo(f"{path}: ok")
        for line in said:
            click.echo(f"  {line}")
    if faults:
        sys.exit(SpecError.exit_code)
