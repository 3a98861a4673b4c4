"""How the points of a mesh move with the parameters of its geometry.

A mesh that softact makes itself is made once more for a slightly larger and a slightly smaller
parameter, with the numbers of steps that it has (``repeated``), and its sections of triangles are
carried along: the same cells, other places. One that gmsh makes from CAD entities is carried along
as a whole (``carrying.py``). The middles of edges that are curved move from the curved wall of the
one to that of the other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from softact.geometry.carrying import OTHER_CELLS, CarriedMesh, NotMovedError
from softact.geometry.curved import are_curved, curves_of, curving
from softact.geometry.gmsh_groups import TETRAHEDRA, Cells, meshes_taken
from softact.geometry.steps import OtherCountsError, Tape, recorded, repeated
from softact.mesh.curves import Curves

if TYPE_CHECKING:
    from softact.geometry.base import Geometry

REPEATED, CARRIED = "repeated", "carried"
PARTS = "planes of the mesh that coincide would part, so that no mesh of the same cells follows"
FINER = "a mesh from CAD entities is carried along with through_wall 1 only"


@dataclass(frozen=True)
class Moved:
    """Points (n, 3) mm of a mesh, its edges (k, 2) that may be curved, and for each change of its
    geometry the velocities (n + k, 3) of points and of middles of edges, mm per unit of the
    parameter, or why there are none. means: REPEATED or CARRIED."""

    points: np.ndarray
    edges: np.ndarray
    velocities: Sequence[np.ndarray | str]
    means: str

    def store(self, path: Any) -> None:
        """Write it to a file of numpy's."""
        arrays = {f"v{k}": v for k, v in enumerate(self.velocities) if not isinstance(v, str)}
        why = [v if isinstance(v, str) else "" for v in self.velocities]
        places = {"points": self.points, "edges": self.edges}
        np.savez(path, why=why, means=self.means, **places, **arrays)

    @classmethod
    def stored(cls, path: Any) -> Moved:
        """Read what ``store`` wrote."""
        with np.load(path) as file:
            why = [str(text) for text in file["why"]]
            velocities = [text or file[f"v{k}"] for k, text in enumerate(why)]
            return cls(file["points"], file["edges"], velocities, str(file["means"]))

    def of_points(self, velocity: np.ndarray) -> np.ndarray:
        """Velocities (n, 3) of the points alone."""
        return velocity[: len(self.points)]

    def of_middles(self, velocity: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """Velocities (..., 3) of the middles of edges between points (..., 2)."""
        own = Curves(self.edges, velocity[len(self.points) :])
        return own.middles_of(ends, self.of_points(velocity)[ends])


#: A geometry with a smaller and one with a larger parameter, and the difference of the two.
Pair = tuple["Geometry", "Geometry", float]


def moved(gmsh: ModuleType, geometry: Geometry, pairs: Sequence[Pair], curved: bool) -> Moved:
    """How the mesh of a solid moves. curved: whether its edges may be."""
    with curving(curved):
        return _moved(gmsh, geometry, pairs)


def _moved(gmsh: ModuleType, geometry: Geometry, pairs: Sequence[Pair]) -> Moved:
    with meshes_taken() as taken, recorded() as numbers:
        geometry.mesh(gmsh)
    if not taken or len(gmsh.model.mesh.getElementsByType(TETRAHEDRA[0])[0]):
        return _carried(gmsh, geometry, pairs)
    base = taken[0]
    used = np.unique(base[1])
    renumber = np.full(len(base[0]), -1)
    renumber[used] = np.arange(len(used))
    curves = base[2].renumbered(renumber)

    def places(other: Geometry) -> np.ndarray:
        points, curved = _repeated(gmsh, other, numbers, base)
        return _with_middles(points[used], curved.renumbered(renumber), curves.edges)

    found = [_velocity(places, pair) for pair in pairs]
    return Moved(base[0][used], curves.edges, found, REPEATED)


def _with_middles(points: np.ndarray, curves: Curves, edges: np.ndarray) -> np.ndarray:
    """Places (n + k, 3) of points and of the middles of edges (k, 2)."""
    return np.vstack([points, curves.middles_of(edges, points[edges])])


def _velocity(places_of: Callable[[Geometry], np.ndarray], pair: Pair) -> np.ndarray | str:
    low, high, width = pair
    try:
        return (places_of(high) - places_of(low)) / width
    except NotMovedError as error:
        return str(error)


def _repeated(
    gmsh: ModuleType, other: Geometry, numbers: Tape, base: Cells
) -> tuple[np.ndarray, Curves]:
    """Points, and curved edges, of the mesh of another geometry with the cells of ``base``."""
    try:
        with meshes_taken() as taken, repeated(numbers):
            other.mesh(gmsh)
    except OtherCountsError:
        raise NotMovedError(PARTS) from None
    points, cells, curves = taken[0]
    if points.shape != base[0].shape or not np.array_equal(cells, base[1]):
        raise NotMovedError(OTHER_CELLS)
    return points, curves


def _carried(gmsh: ModuleType, geometry: Geometry, pairs: Sequence[Pair]) -> Moved:
    """The same for the mesh of CAD entities that the current gmsh model holds."""
    mesh = CarriedMesh(gmsh)
    if geometry.least_steps > 1:
        nothing = np.empty((0, 2), np.int64)
        return Moved(mesh.points, nothing, [FINER] * len(pairs), CARRIED)

    def curves(points: np.ndarray) -> Curves:
        return curves_of(gmsh, points, mesh.parts, 3) if are_curved() else Curves()

    edges = curves(mesh.points).edges

    def places(other: Geometry) -> np.ndarray:
        gmsh.model.add("other")
        other.entities(gmsh)
        try:
            points = mesh.carried(gmsh)
            return _with_middles(points, curves(points), edges)
        finally:
            gmsh.model.remove()

    return Moved(mesh.points, edges, [_velocity(places, pair) for pair in pairs], CARRIED)
