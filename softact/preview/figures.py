"""A mesh in figures, before anything is solved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softact.geometry.walls import Wall
from softact.mesh.msh_file import Tetrahedra
from softact.mesh.quality import quality, signed_volumes
from softact.mesh.sheets import SIDES, SheetMesh
from softact.preview.through import Thickness, thicknesses
from softact.spec import Spec

_TET_EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
#: Mean ratio below which an element is worth a look: a corner of a cube cut into six has 0.65.
POOR = 0.1
_FLAT = 1e-6  # of 1, the cosine of an angle


@dataclass(frozen=True)
class Figures:
    """kind: "tetrahedra" or "triangles". size: (3,) mm of the whole. volumes: of the whole, mm³ (of
    sheets: areas, mm²). worst: quality of the worst element, typical: the median, poor: how many
    are below POOR. thickness: of the cavities' walls; walls: those that the geometry names;
    curved: surfaces with a layer that do not lie in a plane."""

    kind: str
    cells: int
    nodes: int
    unknowns: int
    size: np.ndarray
    volumes: dict[str, float]
    worst: float
    typical: float
    poor: int
    thickness: list[Thickness]
    walls: tuple[Wall, ...]
    curved: tuple[str, ...] = ()


def of_solid(mesh: Tetrahedra, spec: Spec) -> Figures:
    """Of a solid and a spec's elements."""
    layout = spec.geometry.layout()
    shape, volume = (
        quality(mesh.points, mesh.cells),
        np.abs(signed_volumes(mesh.points, mesh.cells)),
    )
    edges = np.unique(np.sort(mesh.cells[:, _TET_EDGES].reshape(-1, 2), axis=1), axis=0)
    nodes = len(mesh.points) + len(edges)
    pressures = {"P2/P1": len(mesh.points), "P2/P0": len(mesh.cells)}.get(spec.solver.element, 0)
    volumes = {
        name: layout.copies * float(volume[mesh.region == number].sum())
        for number, name in enumerate(layout.regions)
    }
    return Figures(
        "tetrahedra",
        len(mesh.cells),
        nodes,
        3 * nodes + pressures,
        _size(mesh.points, spec),
        volumes,
        float(shape.min()),
        float(np.median(shape)),
        int((shape < POOR).sum()),
        thicknesses(mesh, layout),
        spec.geometry.walls() or (),
        tuple(layer.surface for layer in spec.layers if _is_curved(mesh, layer.surface)),
    )


def _is_curved(mesh: Tetrahedra, name: str) -> bool:
    """Whether the triangles of a surface lie in several planes that are not parallel."""
    a, b, c = np.moveaxis(mesh.points[mesh.surfaces[name]], 1, 0)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return bool(np.abs(normal @ normal[0]).min() < 1 - _FLAT)


def of_sheets(mesh: SheetMesh, spec: Spec) -> Figures:
    """Of sheets alone."""
    layout = spec.geometry.layout()
    a, b, c = np.moveaxis(mesh.points[mesh.triangles], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    squares = sum(((p - q) ** 2).sum(axis=1) for p, q in ((a, b), (b, c), (c, a)))
    shape = 4 * np.sqrt(3) * area / squares  # 1 for a regular triangle
    edges = np.unique(np.sort(mesh.triangles[:, list(SIDES)].reshape(-1, 2), axis=1), axis=0)
    nodes = len(mesh.points) + len(edges)
    volumes = {
        name: layout.copies * float(area[members].sum()) for name, members in mesh.parts.items()
    }
    return Figures(
        "triangles",
        len(mesh.triangles),
        nodes,
        3 * nodes,
        _size(mesh.points, spec),
        volumes,
        float(shape.min()),
        float(np.median(shape)),
        int((shape < POOR).sum()),
        [],
        (),
    )


def _size(points: np.ndarray, spec: Spec) -> np.ndarray:
    """Of the whole: twice what lies on one side of a symmetry plane."""
    low, high = points.min(axis=0), points.max(axis=0)
    size = high - low
    for axis in spec.geometry.layout().symmetry.values():
        size[axis] = 2 * max(abs(low[axis]), abs(high[axis]))
    return size
