"""A mesh of CAD entities, carried onto the same entities of another shape.

Points on the boundary keep their place on their vertex, curve or surface: the parameter of a curve,
from its start to its end; on a surface what the curves around it give to a harmonic field, put onto
the surface. Those inside follow as a harmonic field does.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import factorial
from types import ModuleType

import numpy as np

EDGE, TRIANGLE, TETRAHEDRON = 1, 2, 4  # gmsh's numbers
OTHER_CELLS = "the mesh of the changed geometry has other cells"


class NotMovedError(Exception):
    """Why no mesh of the same cells follows a change of the geometry."""


@dataclass(frozen=True)
class _Entity:
    """A vertex, curve or surface. own: (k,) points inside of it; parameters: where they are on it;
    bounds: of these; elements: gmsh's, as it gives them; triangles: (m, 3) of a surface."""

    dimension: int
    tag: int
    own: np.ndarray
    parameters: np.ndarray
    bounds: np.ndarray
    elements: tuple[Sequence, Sequence, Sequence]
    triangles: np.ndarray


class CarriedMesh:
    """The mesh of the current gmsh model. tags: (n,) gmsh's, rising; points: (n, 3) mm."""

    def __init__(self, gmsh: ModuleType):
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        order = np.argsort(tags)
        self.tags, self.points = tags[order], coordinates.reshape(-1, 3)[order]
        self._number = np.zeros(int(tags.max(initial=0)) + 1, dtype=np.int64)
        self._number[self.tags] = np.arange(len(tags))
        #: (dimension, tag) -> corners of its edges (k, 2), triangles (k, 3), tetrahedra (k, 4)
        self.parts = dict(self._parts(gmsh))
        self._entities = list(self._read(gmsh))
        cells = [part for (d, _), part in self.parts.items() if d == 3]
        self._inside = Extension(self.points, np.vstack([*cells, np.empty((0, 4), np.int64)]))

    def _parts(self, gmsh: ModuleType) -> Iterator[tuple[tuple[int, int], np.ndarray]]:
        for d, kind in enumerate((EDGE, TRIANGLE, TETRAHEDRON), start=1):
            for _, tag in gmsh.model.getEntities(d):
                corners = gmsh.model.mesh.getElementsByType(kind, tag)[1].astype(np.int64)
                if len(corners):
                    yield (d, tag), self._number[corners].reshape(-1, d + 1)

    def _read(self, gmsh: ModuleType) -> Iterator[_Entity]:
        for dimension, tag in gmsh.model.getEntities():
            if dimension == 3:
                continue
            nodes, _, parameters = gmsh.model.mesh.getNodes(dimension, tag, False, True)
            own = self._number[nodes.astype(np.int64)]
            bounds: list[list[float]] = []
            if dimension:
                bounds = gmsh.model.getParametrizationBounds(dimension, tag)
            triangles = np.empty((0, 3), dtype=np.int64)
            if dimension == 2:
                triangles = self.parts.get((2, tag), triangles)
            elements = gmsh.model.mesh.getElements(dimension, tag)
            places = np.asarray(parameters), np.asarray(bounds)
            yield _Entity(dimension, tag, own, *places, elements, triangles)

    def carried(self, gmsh: ModuleType) -> np.ndarray:
        """Its points (n, 3) on the entities of the current gmsh model.

        Raises NotMovedError where that has others.
        """
        there = [(d, tag) for d, tag in gmsh.model.getEntities() if d < 3]
        if there != [(e.dimension, e.tag) for e in self._entities]:
            raise NotMovedError(OTHER_CELLS)
        shift, known = np.zeros_like(self.points), np.zeros(len(self.points), dtype=bool)
        for entity in self._entities:  # vertices, curves, then surfaces between them
            if len(entity.own):
                shift[entity.own] = self._places(gmsh, entity, shift) - self.points[entity.own]
                known[entity.own] = True
        return self.points + self._inside(shift, known)

    def put(self, gmsh: ModuleType) -> None:
        """Give the vertices, curves and surfaces of the current gmsh model this mesh."""
        points = self.carried(gmsh)
        for entity in self._entities:
            own = self.tags[entity.own]
            where = entity.dimension, entity.tag
            gmsh.model.mesh.addNodes(*where, own, points[entity.own].ravel())
        for entity in self._entities:
            gmsh.model.mesh.addElements(entity.dimension, entity.tag, *entity.elements)

    def _places(self, gmsh: ModuleType, entity: _Entity, shift: np.ndarray) -> np.ndarray:
        """Places (k, 3) of an entity's points on the one of its tag in the current model."""
        dimension, tag = entity.dimension, entity.tag
        if dimension == 0:
            return np.reshape(gmsh.model.getValue(0, tag, []), (1, 3))
        if dimension == 1:
            (start,), (end,) = gmsh.model.getParametrizationBounds(1, tag)
            low, high = entity.bounds.ravel()
            at = start + (entity.parameters - low) / (high - low) * (end - start)
            return np.reshape(gmsh.model.getValue(1, tag, at), (-1, 3))
        used, cells = np.unique(entity.triangles, return_inverse=True)
        known = ~np.isin(used, entity.own)
        extended = Extension(self.points[used], cells.reshape(-1, 3))(shift[used], known)
        places = (self.points[used] + extended)[~known][np.argsort(np.argsort(entity.own))]
        near, _ = gmsh.model.getClosestPoint(2, tag, places.ravel())
        return np.reshape(near, (-1, 3))


class Extension:
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
