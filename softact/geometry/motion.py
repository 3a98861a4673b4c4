"""How the points of a mesh move with the parameters of its geometry.

A mesh that softact makes itself is made once more for a slightly larger and a slightly smaller
parameter, with the numbers of steps that it has (``repeated``): the same cells, other places. One
that gmsh makes from CAD entities is carried along: its points on the boundary keep their place on
their vertex, curve or surface, and those inside follow as a harmonic field does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import factorial
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from softact.geometry.gmsh_groups import Cells, meshes_taken
from softact.geometry.steps import OtherCountsError, recorded, repeated

if TYPE_CHECKING:
    from softact.geometry.base import Geometry

REPEATED, CARRIED = "repeated", "carried"
PARTS = "planes of the mesh that coincide would part, so that no mesh of the same cells follows"
LINKED = "the mesh of the changed geometry has other cells"
FINER = "a mesh from CAD entities is carried along with through_wall 1 only"
TRIANGLE, TETRAHEDRON = 2, 4  # gmsh's numbers


class NotMovedError(Exception):
    """Why no mesh of the same cells follows a change of the geometry."""


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


def moved(gmsh: ModuleType, geometry: Geometry, pairs: Sequence[Pair]) -> Moved:
    """How the mesh of a solid moves."""
    with meshes_taken() as taken, recorded() as numbers:
        geometry.mesh(gmsh)
    if not taken:
        return _carried(gmsh, geometry, pairs)
    base = taken[0]
    used = np.unique(base[1])
    found = [_velocity(lambda g: _repeated(gmsh, g, numbers, base), pair) for pair in pairs]
    return Moved(base[0][used], [v if isinstance(v, str) else v[used] for v in found], REPEATED)


def _velocity(points_of: Any, pair: Pair) -> np.ndarray | str:
    low, high, width = pair
    try:
        return (points_of(high) - points_of(low)) / width
    except NotMovedError as error:
        return str(error)


def _repeated(gmsh: ModuleType, other: Geometry, numbers: list[int], base: Cells) -> np.ndarray:
    """Points of the mesh of another geometry with the cells of ``base``."""
    try:
        with meshes_taken() as taken, repeated(numbers):
            other.mesh(gmsh)
    except OtherCountsError:
        raise NotMovedError(PARTS) from None
    points, cells = taken[0]
    if points.shape != base[0].shape or not np.array_equal(cells, base[1]):
        raise NotMovedError(LINKED)
    return points


# --- carried ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Entity:
    """A vertex, curve or surface: the points inside of it (k,), and where they are on it."""

    dimension: int
    tag: int
    own: np.ndarray
    parameters: np.ndarray
    bounds: np.ndarray
    cells: np.ndarray


def _carried(gmsh: ModuleType, geometry: Geometry, pairs: Sequence[Pair]) -> Moved:
    """The same for the mesh of CAD entities that the current gmsh model holds."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    points = coordinates.reshape(-1, 3)[np.argsort(tags)]
    if geometry.least_steps > 1:
        return Moved(points, [FINER] * len(pairs), CARRIED)
    number = np.zeros(int(tags.max()) + 1, dtype=np.int64)
    number[np.sort(tags)] = np.arange(len(tags))
    entities = list(_entities(gmsh, number))
    cells = number[gmsh.model.mesh.getElementsByType(TETRAHEDRON)[1].astype(np.int64)]
    inside = _Extension(points, cells.reshape(-1, 4))

    def carry(other: Geometry) -> np.ndarray:
        gmsh.model.add("other")
        other.build(gmsh)
        try:
            return _carry(gmsh, points, entities, inside)
        finally:
            gmsh.model.remove()

    return Moved(points, [_velocity(carry, pair) for pair in pairs], CARRIED)


def _entities(gmsh: ModuleType, number: np.ndarray) -> Iterator[_Entity]:
    for dimension, tag in gmsh.model.getEntities():
        if dimension == 3:
            continue
        nodes, _, parameters = gmsh.model.mesh.getNodes(dimension, tag, False, True)
        own = number[nodes.astype(np.int64)]
        bounds: list[list[float]] = []
        if dimension:
            bounds = gmsh.model.getParametrizationBounds(dimension, tag)
        cells = np.empty((0, 3), dtype=np.int64)
        if dimension == 2:
            corners = gmsh.model.mesh.getElementsByType(TRIANGLE, tag)[1]
            cells = number[corners.astype(np.int64)].reshape(-1, 3)
        yield _Entity(dimension, tag, own, np.asarray(parameters), np.asarray(bounds), cells)


def _carry(
    gmsh: ModuleType, points: np.ndarray, entities: Sequence[_Entity], inside: _Extension
) -> np.ndarray:
    """Points of a mesh on the entities of the current gmsh model, which has as many of them."""
    there = [(d, tag) for d, tag in gmsh.model.getEntities() if d < 3]
    if there != [(e.dimension, e.tag) for e in entities]:
        raise NotMovedError(LINKED)
    shift, known = np.zeros_like(points), np.zeros(len(points), dtype=bool)
    for entity in entities:  # vertices, curves, then surfaces between them
        if len(entity.own):
            shift[entity.own] = _places(gmsh, entity, points, shift) - points[entity.own]
            known[entity.own] = True
    return points + inside(shift, known)


def _places(gmsh: ModuleType, entity: _Entity, points: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Places (k, 3) of an entity's points on the one of its tag in the current model."""
    dimension, tag = entity.dimension, entity.tag
    if dimension == 0:
        return np.reshape(gmsh.model.getValue(0, tag, []), (1, 3))
    if dimension == 1:
        (start,), (end,) = gmsh.model.getParametrizationBounds(1, tag)
        low, high = entity.bounds.ravel()
        at = start + (entity.parameters - low) / (high - low) * (end - start)
        return np.reshape(gmsh.model.getValue(1, tag, at), (-1, 3))
    used, cells = np.unique(entity.cells, return_inverse=True)
    known = ~np.isin(used, entity.own)
    extended = _Extension(points[used], cells.reshape(-1, 3))(shift[used], known)
    places = (points[used] + extended)[~known][np.argsort(np.argsort(entity.own))]
    near, _ = gmsh.model.getClosestPoint(2, tag, places.ravel())
    return np.reshape(near, (-1, 3))


class _Extension:
    """Harmonic fields on a mesh of triangles or tetrahedra: points (n, 3), cells (m, 3 or 4)."""

    def __init__(self, points: np.ndarray, cells: np.ndarray):
        from scipy import sparse  # not before it is needed: it takes long to load

        edges = points[cells[:, 1:]] - points[cells[:, :1]]
        inner = np.linalg.pinv(edges)
        gradients = np.concatenate([-inner.sum(axis=2, keepdims=True), inner], axis=2)
        square = np.linalg.det(edges @ np.swapaxes(edges, 1, 2))
        size = np.sqrt(np.maximum(square, 0.0)) / factorial(edges.shape[1])
        matrices = size[:, None, None] * (np.swapaxes(gradients, 1, 2) @ gradients)
        width = cells.shape[1]
        rows, columns = np.repeat(cells, width, axis=1), np.tile(cells, (1, width))
        self._matrix = sparse.csr_matrix(
            (matrices.ravel(), (rows.ravel(), columns.ravel())), shape=(len(points), len(points))
        )

    def __call__(self, values: np.ndarray, known: np.ndarray) -> np.ndarray:
        """The field (n, k) that has ``values`` at the known points (n,)."""
        from scipy.sparse.linalg import splu

        found, free = values.copy(), np.flatnonzero(~known)
        if len(free):
            right = -self._matrix[free][:, known] @ values[known]
            found[free] = splu(self._matrix[free][:, free].tocsc()).solve(right)
        return found
