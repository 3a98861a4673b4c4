"""`softact mesh`: the mesh of a spec, without solving."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import click

from softact.cli._force import force_file_option
from softact.cli._options import set_option, timeout_option

if TYPE_CHECKING:
    from pathlib import Path

    from softact.spec import Spec


@click.command(short_help="Mesh the actuator of a spec, without solving it.")
@click.argument("spec")
@click.option(
    "-o",
    "--output",
    metavar="FILE",
    help="File to write; its suffix says what.  [default: <name of the spec>.msh]",
)
@set_option
@click.option(
    "--part",
    type=click.Choice(["solid", "core"]),
    default="solid",
    show_default=True,
    help="The solid, for printing, or the air of its cavities, as a core for casting.",
)
@click.option(
    "--format",
    "suffix",
    type=click.Choice(["msh", "vtu", "stl", "step", "inp", "dxf", "svg", "html", "png"]),
    help="Format, where no file is named.  [default: msh]",
)
@timeout_option
@force_file_option
def mesh(
    spec: str,
    output: str | None,
    overrides: tuple[str, ...],
    part: Literal["solid", "core"],
    suffix: str | None,
    timeout: float,
    force: bool,
) -> None:
    """Mesh the actuator of a spec, without solving it.

    .msh is gmsh's mesh with named parts, .vtu the same for ParaView, .stl the surface,
    .step the exact geometry for a CAD program, .inp the mesh for Abaqus or CalculiX; .html and .png
    show it, as 'softact preview' does; .dxf and .svg the pattern that is cut for an
    actuator of sheets. With --part core, .stl and .step hold the air of
    the cavities, to be printed as a core for casting.

    \b
    Example:
      softact mesh configs/pneunet_glove.yaml -o finger.vtu
      softact mesh configs/pneunet_glove.yaml --part core -o core.stl
    """
    from pathlib import Path

    from softact.errors import SpecError
    from softact.geometry.base import export
    from softact.geometry.imported import Imported
    from softact.preview import SUFFIXES
    from softact.results.own_folder import check_file
    from softact.spec import load

    loaded = load(spec, overrides)
    if output and suffix and Path(output).suffix.lower() != f".{suffix}":
        raise SpecError(f"{output}: --format {suffix} is another format than the file's suffix")
    path = Path(output or f"{loaded.name}.{suffix or 'msh'}")
    reads = [Path(spec)]
    if isinstance(loaded.geometry, Imported):
        reads.append(Path(loaded.geometry.file))
    check_file(path, force, reads)
    if part == "core" and path.suffix.lower() in SUFFIXES:
        raise SpecError(f"{path}: a core is written to .stl or .step only")
    for text in loaded.geometry.notes():
        click.echo(text)
    notes = _drawn(loaded, path, timeout) if path.suffix.lower() in SUFFIXES else None
    if notes is None:
        notes = export(loaded.geometry, path, timeout=timeout, part=part)
    click.echo(f"wrote {path}")
    for text in notes:
        click.echo(f"note: {text}")


def _drawn(spec: Spec, path: Path, timeout: float) -> list[str]:
    """Write a page, a picture or a mesh with its names as ``softact preview`` does."""
    from softact.preview import of_spec, write

    found = of_spec(spec, timeout)
    write(found, path)
    return list(found.notes)
