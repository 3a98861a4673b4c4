"""Edges of a mesh that are not straight: where their middles lie.

The tetrahedra beside them are quadratic in their shape as in their displacement (isoparametric).
One whose curved edges would fold it gets straight ones, with its neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

#: Corners of the edges of a tetrahedron in the order of a quadratic element's nodes (UFC).
EDGES = np.array([[2, 3], [1, 3], [1, 2], [0, 3], [0, 2], [0, 1]])
#: The same edges in the order of VTK, and in that of gmsh.
VTK_EDGES = np.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
GMSH_EDGES = VTK_EDGES[[0, 1, 2, 3, 5, 4]]
SIDES = np.array([[0, 1], [1, 2], [2, 0]])  # of a triangle
# Least part of a straight tetrahedron's volume element that a curved one keeps where it is looked
# at: in its nodes and between them.
LEAST = 0.1
# Part of an edge's length that its middle is off the straight line, from which it is curved.
STRAIGHT = 1e-9


@dataclass(frozen=True)
class Curves:
    """Edges (k, 2) by their ends, the lower number first and in ascending order, and the places
    (k, 3) mm of their middles. Edges that are not among them are straight."""

    edges: np.ndarray = field(default_factory=lambda: np.empty((0, 2), np.int64))
    places: np.ndarray = field(default_factory=lambda: np.empty((0, 3)))

    def __len__(self) -> int:
        return len(self.edges)

    def renumbered(self, renumber: np.ndarray) -> Curves:
        """The same between points that are numbered otherwise; those with an end at -1 are left
        out."""
        ends = renumber[self.edges]
        kept = (ends >= 0).all(axis=1)
        return of_edges(ends[kept], self.places[kept])

    def middles_of(self, ends: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Middles (..., 3) of edges between points (..., 2), which lie at ``points`` (..., 2, 3);
        the order of the ends does not matter."""
        middles = points.mean(axis=-2)
        if not len(self):
            return middles
        size = 1 + max(int(self.edges.max()), int(ends.max(initial=0)))
        known, wanted = (_keys(pairs, size) for pairs in (self.edges, ends))
        place = np.minimum(np.searchsorted(known, wanted), len(known) - 1)
        found = known[place] == wanted
        middles[found] = self.places[place[found]]
        return middles

    def nodes(self, cells: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Places (m, 10, 3) of the nodes of tetrahedra (m, 4) between ``points`` (n, 3): corners,
        then middles in the order of ``EDGES``."""
        corners = points[cells]
        middles = self.middles_of(cells[:, EDGES], corners[:, EDGES])
        return np.concatenate([corners, middles], axis=1)

    def triangles(self, corners: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Places (k, 6, 3) of the nodes of triangles (k, 3): corners, then middles of 01, 12, 20;
        (k, 3, 3) where all edges of the mesh are straight."""
        x = points[corners]
        if not len(self):
            return x
        middles = self.middles_of(corners[:, SIDES], x[:, SIDES])
        return np.concatenate([x, middles], axis=1)

    def sound(self, cells: np.ndarray, points: np.ndarray) -> tuple[Curves, int]:
        """The same without those of tetrahedra that they would fold, and the number of these."""
        kept, folded = self, 0
        # Only elements with a curved edge can fold, and straight edges can fold none.
        touched = np.isin(cells, np.unique(self.edges)).sum(axis=1) > 1
        cells = cells[touched]
        while len(kept):
            shape = determinants(kept.nodes(cells, points), SAMPLES)
            straight = np.linalg.det(points[cells[:, 1:]] - points[cells[:, :1]])
            bad = (shape < LEAST * straight[:, None]).any(axis=1)
            if not bad.any():
                break
            folded += int(bad.sum())
            kept = kept.without(cells[bad][:, EDGES].reshape(-1, 2))
        return kept, folded

    def without(self, edges: np.ndarray) -> Curves:
        """The same without some edges (k, 2)."""
        size = 1 + max(int(self.edges.max(initial=0)), int(edges.max(initial=0)))
        kept = ~np.isin(_keys(self.edges, size), _keys(edges, size))
        return Curves(self.edges[kept], self.places[kept])

    def middles(self, cells: np.ndarray, corners: np.ndarray) -> np.ndarray | None:
        """Middles (m, 6, 3) of the edges of tetrahedra (m, 4) with corners at (m, 4, 3), in the
        order of ``EDGES``; None where all edges of the mesh are straight."""
        return self.middles_of(cells[:, EDGES], corners[:, EDGES]) if len(self) else None


def _keys(pairs: np.ndarray, size: int) -> np.ndarray:
    low, high = np.moveaxis(np.sort(pairs, axis=-1).astype(np.int64), -1, 0)
    return low * size + high


def of_edges(ends: np.ndarray, places: np.ndarray) -> Curves:
    """Curves of edges (k, 2) in any order, each of which may be there several times."""
    ends = np.sort(ends, axis=1).astype(np.int64)
    edges, first = np.unique(ends, axis=0, return_index=True)
    return Curves(edges.reshape(-1, 2), places[first])


def bent(ends: np.ndarray, points: np.ndarray, places: np.ndarray) -> Curves:
    """Those edges (k, 2) between ``points`` (n, 3) whose middles at ``places`` (k, 3) are off the
    straight line."""
    x = points[ends]
    off = np.linalg.norm(places - x.mean(axis=1), axis=1)
    curved = off > STRAIGHT * np.linalg.norm(x[:, 1] - x[:, 0], axis=1)
    return of_edges(ends[curved], places[curved])


class EdgeNumbers:
    """The edges among pairs of points (..., 2), each once. ends: (k, 2), the lower number first."""

    def __init__(self, pairs: np.ndarray):
        self._size = 1 + int(pairs.max(initial=0))
        self._known = np.unique(_keys(pairs, self._size))
        self.ends = np.column_stack(np.divmod(self._known, self._size))

    def of(self, pairs: np.ndarray) -> np.ndarray:
        """Numbers (...) of edges that are among them, (..., 2)."""
        return np.searchsorted(self._known, _keys(pairs, self._size))


def edges_of(cells: np.ndarray) -> np.ndarray:
    """Edges (k, 2) of tetrahedra (m, 4), each once, the lower number first."""
    return EdgeNumbers(cells[:, EDGES]).ends


def of_quadratic(points: np.ndarray, tetrahedra: np.ndarray, edges: np.ndarray) -> Curves:
    """Curved edges of quadratic tetrahedra (m, 10), whose ``edges`` are GMSH_EDGES or VTK_EDGES."""
    ends = tetrahedra[:, edges].reshape(-1, 2).astype(np.int64)
    return bent(ends, points, points[tetrahedra[:, 4:].ravel()])


def gradients(barycentric: np.ndarray) -> np.ndarray:
    """Derivatives (q, 10, 3) of the quadratic functions of a tetrahedron with respect to its last
    three barycentric coordinates, at points (q, 4); nodes as in ``Curves.nodes``."""
    slope = np.vstack([-np.ones(3), np.eye(3)])  # (4, 3): of the barycentric coordinates
    corners = (4 * barycentric - 1)[:, :, None] * slope
    one, other = EDGES.T
    edges = 4 * (
        barycentric[:, one, None] * slope[other] + barycentric[:, other, None] * slope[one]
    )
    return np.concatenate([corners, edges], axis=1)


def determinants(nodes: np.ndarray, barycentric: np.ndarray) -> np.ndarray:
    """Volume element (m, q), six times the volume of a straight one, of quadratic tetrahedra
    (m, 10, 3) at barycentric points (q, 4)."""
    return np.linalg.det(np.einsum("qnj,mni->mqij", gradients(barycentric), nodes, optimize=True))


def volumes(nodes: np.ndarray) -> np.ndarray:
    """Volumes (m,) of quadratic tetrahedra (m, 10, 3), negative where one is inside out."""
    points, weights = CUBIC
    return determinants(nodes, points) @ weights / 6


def _samples() -> np.ndarray:
    corners = np.eye(4)
    middles = corners[EDGES].mean(axis=1)
    faces = (1 - corners) / 3
    return np.vstack([corners, middles, faces, np.full((1, 4), 0.25)])


SAMPLES = _samples()
# Exact for cubic polynomials, such as the volume element: the middle, and four points around it.
CUBIC = (
    np.vstack([np.full((1, 4), 0.25), np.full((4, 4), 1 / 6) + np.eye(4) / 3]),
    np.array([-0.8, 0.45, 0.45, 0.45, 0.45]),
)
