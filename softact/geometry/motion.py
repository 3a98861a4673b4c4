"""How the points of a mesh move with the parameters of its geometry.

A mesh that softact makes itself is made once more for a slightly larger and a slightly smaller
parameter, with the numbers of steps that it has (``repeated``), and its sections of triangles are
carried along: the same cells, other places. One that gmsh makes from CAD entities is carried along
as a whole (``carrying.py``).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from softact.geometry.carrying import OTHER_CELLS, CarriedMesh, NotMovedError
from softact.geometry.curved import curving
from softact.geometry.gmsh_groups import Cells, meshes_taken
from softact.geometry.steps import OtherCountsError, Tape, recorded, repeated

if TYPE_CHECKING:
    from softact.geometry.base import Geometry

REPEATED, CARRIED = "repeated", "carried"
PARTS = "planes of the mesh that coincide would part, so that no mesh of the same cells follows"
CURVED = (
    "the walls are curved in the mesh, and how curved ones move is not followed yet; leave "
    "out curved: true under solver"
)
FINER = "a mesh from CAD entities is carried along with through_wall 1 only"


@dataclass(frozen=True)
class Moved:
    """Points (n, 3) mm of a mesh, and for each change of its geometry their velocities (n, 3), mm
    per unit of the parameter, or why there are none. means: REPEATED or CARRIED."""

    points: np.ndarray
    velocities: Sequence[np.ndarray | str]
    means: str

    def store(self, path: Any) -> None:
        """Write it to a file of numpy's."""
        arrays = {f"v{k}": v for k, v in enumerate(self.velocities) if not isinstance(v, str)}
        why = [v if isinstance(v, str) else "" for v in self.velocities]
        np.savez(path, points=self.points, why=why, means=self.means, **arrays)

    @classmethod
    def stored(cls, path: Any) -> Moved:
        """Read what ``store`` wrote."""
        with np.load(path) as file:
            why = [str(text) for text in file["why"]]
            velocities = [text or file[f"v{k}"] for k, text in enumerate(why)]
            return cls(file["points"], velocities, str(file["means"]))


#: A geometry with a smaller and one with a larger parameter, and the difference of the two.
Pair = tuple["Geometry", "Geometry", float]


def moved(gmsh: ModuleType, geometry: Geometry, pairs: Sequence[Pair], curved: bool) -> Moved:
    """How the mesh of a solid moves. curved: whether its edges may be."""
    with curving(curved):
        return _moved(gmsh, geometry, pairs)


def _moved(gmsh: ModuleType, geometry: Geometry, pairs: Sequence[Pair]) -> Moved:
    with meshes_taken() as taken, recorded() as numbers:
        geometry.mesh(gmsh)
    if not taken:
        return _carried(gmsh, geometry, pairs)
    base = taken[0]
    used = np.unique(base[1])
    if len(base[2]):
        return Moved(base[0][used], [CURVED] * len(pairs), REPEATED)
    found = [_velocity(lambda g: _repeated(gmsh, g, numbers, base), pair) for pair in pairs]
    return Moved(base[0][used], [v if isinstance(v, str) else v[used] for v in found], REPEATED)


def _velocity(points_of: Callable[[Geometry], np.ndarray], pair: Pair) -> np.ndarray | str:
    low, high, width = pair
    try:
        return (points_of(high) - points_of(low)) / width
    except NotMovedError as error:
        return str(error)


def _repeated(gmsh: ModuleType, other: Geometry, numbers: Tape, base: Cells) -> np.ndarray:
    """Points of the mesh of another geometry with the cells of ``base``."""
    try:
        with meshes_taken() as taken, repeated(numbers):
            other.mesh(gmsh)
    except OtherCountsError:
        raise NotMovedError(PARTS) from None
    points, cells, _ = taken[0]
    if points.shape != base[0].shape or not np.array_equal(cells, base[1]):
        raise NotMovedError(OTHER_CELLS)
    return points


def _carried(gmsh: ModuleType, geometry: Geometry, pairs: Sequence[Pair]) -> Moved:
    """The same for the mesh of CAD entities that the current gmsh model holds."""
    mesh = CarriedMesh(gmsh)
    if geometry.least_steps > 1:
        return Moved(mesh.points, [FINER] * len(pairs), CARRIED)

    def points(other: Geometry) -> np.ndarray:
        gmsh.model.add("other")
        other.build(gmsh)
        try:
            return mesh.carried(gmsh)
        finally:
            gmsh.model.remove()

    return Moved(mesh.points, [_velocity(points, pair) for pair in pairs], CARRIED)
