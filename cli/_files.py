"""What is said of the files of the user's that a spec names: scripts, STEP files, meshes."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from softact.geometry.base import Geometry
    from softact.sweep.axes import Axis


def tell_scripts(base: object, axes: Sequence["Axis"]) -> None:
    """Say which scripts run where the runs of a study do, before the first one.

    base: the plain data of its base spec. axes: those of a sweep or an optimisation.
    """
    from softact.geometry.scripts import scripts_as_code

    files = [file for axis in axes if "geometry.file" in axis.path for file in axis.values or ()]
    for line in scripts_as_code(base, files):
        click.echo(line, err=True)


def tell_file(spec: str, geometry: "Geometry", ok: str) -> int:
    """Say what is in the file of a geometry, without a mesh, or what it lacks; no script is run.

    spec: name of the spec's file. ok: said of a spec without faults. Returns the number of faults.
    """
    from softact.errors import MeshError
    from softact.geometry.base import look

    notes, faults = geometry.notes(), []
    try:
        look(geometry, notes)
    except MeshError as error:
        faults = error.lines
    for line in faults:
        click.echo(f"{spec}: geometry: {line}", err=True)
    if not faults:
        click.echo(ok)
    for line in notes:
        click.echo(f"  {line}")
    return len(faults)
