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

    Walls that the mesh is too coarse for are noted. Nothing is meshed or written. Exits with 2
    when a spec has a fault.

    \b
    Example:
      softact validate configs/pneunet_glove.yaml
    """
    from softact.spec import load
    from softact.walls import expected

    faults = 0
    for path in specs:
        try:
            loaded = load(path, overrides)
        except SpecError as error:
            faults += len(error.lines)
            for line in error.lines:
                click.echo(line, err=True)
        else:
            click.echo(f"{path}: ok")
            remark = expected(loaded.geometry.walls())
            if remark:
                click.echo(f"{path}: note: {remark}")
    if faults:
        sys.exit(SpecError.exit_code)
