"""From a spec to all that a preview shows."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from softact.errors import SpecError
from softact.geometries import GEOMETRIES
from softact.geometry import step_drawing
from softact.geometry.base import draw_faces, make_mesh
from softact.geometry.flat_sheets import SheetGeometry
from softact.mesh.layout import Layout
from softact.mesh.msh_file import Tetrahedra, read_msh
from softact.mesh.sheets import SheetMesh
from softact.preview import drawing, figures
from softact.preview.cost import Cost, cost
from softact.preview.drawing import Drawing, Patch
from softact.preview.figures import Figures
from softact.preview.roles import LOADED, loads_of, roles
from softact.report.obstacles import COLOUR
from softact.spec import Spec, plausible
from softact.units import MASS

_OF_FACES = "Faces", "Number", "Names so far; kind, area and place"


@dataclass(frozen=True)
class Preview:
    """name, about: of the spec. steps: for each its name and what it does, in words. notes: what is
    to be known of the mesh. mesh: of a solid, for files. figures, cost: None without a spec."""

    name: str
    about: str
    drawing: Drawing
    notes: tuple[str, ...] = ()
    steps: tuple[tuple[str, str], ...] = ()
    figures: Figures | None = None
    cost: Cost | None = None
    mesh: Tetrahedra | None = None
    layout: Layout | None = None
    heads: tuple[str, str, str] = ("Parts", "Part", "What happens with it")


def of_spec(spec: Spec, timeout: float = 300.0) -> Preview:
    """Mesh a spec's geometry and look at it. Raises MeshError as ``make_mesh`` does."""
    layout, roles_of = spec.geometry.layout(), roles(spec)
    mesh, notes = _mesh(spec, timeout)
    if isinstance(mesh, Tetrahedra):
        drawn, counted = drawing.of_solid(mesh, layout, roles_of), figures.of_solid(mesh, spec)
    else:
        drawn, counted = drawing.of_sheets(mesh, layout, roles_of), figures.of_sheets(mesh, spec)
    for points, patch in (*_obstacles(spec, drawn.points), *_directions(spec, drawn.points)):
        drawn = drawn.add(points, patch)
    return Preview(
        spec.name,
        spec.description,
        drawn,
        (*notes, *plausible.lines(spec)),
        tuple((step.name, _said(spec, number)) for number, step in enumerate(spec.steps)),
        counted,
        cost(spec, counted),
        mesh if isinstance(mesh, Tetrahedra) else None,
        layout,
    )


def of_step(file: Path, timeout: float = 300.0, unit: str | None = None) -> Preview:
    """The faces of a STEP file with their numbers, and the names that they have or would be given.

    unit: of length, in place of the file's. Raises SpecError where there is no such file, MeshError
    where it cannot be read.
    """
    try:
        given = {"type": "from_step", "file": str(file), "unit": unit}
        geometry = GEOMETRIES["from_step"].model_validate(given)
    except ValidationError as error:
        raise SpecError(*(f"{file}: {fault['msg']}" for fault in error.errors())) from None
    with tempfile.TemporaryDirectory(prefix="softact-preview-") as folder:
        path = Path(folder) / "faces.npz"
        notes = draw_faces(geometry, path, timeout)
        points, faces = step_drawing.read(path)
    about = "The faces of a STEP file, by the numbers that select: may name in a spec."
    return Preview(file.name, about, drawing.of_faces(points, faces), tuple(notes), heads=_OF_FACES)


def _mesh(spec: Spec, timeout: float) -> tuple[Tetrahedra | SheetMesh, list[str]]:
    geometry = spec.geometry
    if isinstance(geometry, SheetGeometry):
        return geometry.checked_mesh(), geometry.notes()
    with tempfile.TemporaryDirectory(prefix="softact-preview-") as folder:
        path = Path(folder) / "mesh.msh"
        notes = make_mesh(geometry, path, timeout, spec.solver.curved)
        return read_msh(path, geometry.layout()), [*geometry.notes(), *notes]


def _said(spec: Spec, number: int) -> str:
    step = spec.steps[number]
    loads = [
        f"{words} {amount}" + (f" on '{name}'" if name else "")
        for words, name, amount in loads_of(step, spec.geometry.layout())
    ]
    return "; ".join([*loads, *(["supports change"] if step.supports else [])])


def _obstacles(spec: Spec, points: np.ndarray) -> Iterator[tuple[np.ndarray, Patch]]:
    low, high = points.min(axis=0), points.max(axis=0)
    for name, obstacle in spec.obstacles.items():
        extent = float((high - low).max())
        places, triangles = obstacle.shape().surface(extent, (low + high) / 2)
        said = f"obstacle, {obstacle.kind}" + (", a load cell" if obstacle.load_cell else "")
        if obstacle.mass is not None:
            said = f"free body, {obstacle.kind} of {MASS.format(obstacle.mass)}"
        yield places, Patch(name, COLOUR, said, triangles, opacity=0.45)


def _directions(spec: Spec, points: np.ndarray) -> Iterator[tuple[np.ndarray, Patch]]:
    """Arrows of gravity and of forces, at the tip or beside the actuator."""
    low, high = points.min(axis=0), points.max(axis=0)
    size = float((high - low).max())
    for step in spec.steps:
        gravity = step.loads.get("gravity")
        if gravity is not None and any(gravity):
            start = np.array([high[0] + 0.12 * size, low[1], (low[2] + high[2]) / 2])
            said = f"direction of gravity in step '{step.name}'"
            yield (
                _arrow(start, np.array(gravity, float), 0.2 * size),
                Patch("gravity", LOADED, said, np.array([[0, 1], [1, 2], [1, 3]])),
            )


def _arrow(start: np.ndarray, direction: np.ndarray, length: float) -> np.ndarray:
    """(4, 3): start, head, and the ends of two barbs."""
    along = direction / np.linalg.norm(direction)
    across = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    across /= np.linalg.norm(across)
    head = start + length * along
    barbs = [head - 0.2 * length * (along + sign * 0.5 * across) for sign in (1, -1)]
    return np.array([start, head, *barbs])
