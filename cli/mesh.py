"""`softact mesh`: the mesh of a spec, without solving."""

import click


@click.command(short_help="Mesh the actuator of a spec, without solving it.")
@click.argument("spec")
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="File to write; its suffix says what.  [default: <name of the spec>.msh]",
)
@click.option(
    "--set",
    "overrides",
    multiple=True,
    metavar="PATH=VALUE",
    help="Replace a value of the spec, such as geometry.mesh_size='2 mm'. May be repeated.",
)
@click.option(
    "--timeout",
    type=click.FloatRange(min=0, min_open=True),
    default=300.0,
    show_default=True,
    metavar="SECONDS",
    help="Stop gmsh after this time.",
)
def mesh(spec: str, output: str | None, overrides: tuple[str, ...], timeout: float) -> None:
    """Mesh the actuator of a spec, without solving it.

    .msh is gmsh's mesh with named parts, .vtu the same for ParaView, .stl the surface,
    .step the exact geometry for a CAD program.

    \b
    Example:
      softact mesh configs/pneunet_glove.yaml -o finger.vtu
    """
    from pathlib import Path

    from softact.errors import SpecError
    from softact.geometry import export
    from softact.spec import load

    loaded = load(spec, overrides)
    path = Path(output or f"{loaded.name}.msh")
    if path.is_dir():
        raise SpecError(f"{path}: this is a folder; give the name of a file")
    export(loaded.geometry, path, timeout=timeout)
    click.echo(f"wrote {path}")
