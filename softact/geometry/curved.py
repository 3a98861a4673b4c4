"""Curved edges of a mesh: their middles on the curves and surfaces of gmsh's geometry."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from types import ModuleType

import numpy as np

from softact.mesh.curves import Curves, EdgeNumbers, bent

#: Kinds of entities whose edges are straight, or whose shape is not known.
EXACT = ("Discrete", "Plane", "Line")
ROUNDS = 60  # of the averages in a wall: a few elements from side to side


_CURVED: ContextVar[bool] = ContextVar("curved", default=False)


@contextmanager
def curving(curved: bool) -> Iterator[None]:
    """Whether meshes follow curved walls with curved edges meanwhile; else all are straight."""
    token = _CURVED.set(curved)
    try:
        yield
    finally:
        _CURVED.reset(token)


def are_curved() -> bool:
    """Whether meshes follow curved walls with curved edges now."""
    return _CURVED.get()


def is_curved(gmsh: ModuleType, dimension: int) -> bool:
    """Whether a curve or surface below a dimension is not straight, and edges may be curved."""
    return are_curved() and any(
        not gmsh.model.getType(d, tag).startswith(EXACT)
        for d in range(1, dimension)
        for _, tag in gmsh.model.getEntities(d)
    )


def curves_of(
    gmsh: ModuleType,
    points: np.ndarray,
    parts: Mapping[tuple[int, int], np.ndarray],
    dimension: int,
) -> Curves:
    """Curved edges of a mesh of the current model.

    points: (n, 3) mm. parts: dimension and tag of an entity -> corners of its edges (k, 2),
    triangles (k, 3) or tetrahedra (k, 4). An edge within a surface or a solid is curved as much as
    those around it are, so that walls thinner than the curve is high are not folded.
    """
    solid = [_pairs(part).reshape(-1, 2) for (d, _), part in parts.items() if d == dimension]
    edges = EdgeNumbers(np.vstack(solid))
    moved, fixed = np.zeros((len(edges.ends), points.shape[1])), np.zeros(len(edges.ends), bool)
    straight = points[edges.ends].mean(axis=1)
    for d in range(1, dimension + 1):
        for (of, tag), part in parts.items():
            if of == d:
                own = edges.of(_pairs(part))
                free = np.unique(own[~fixed[own]])
                moved[free] = _off(gmsh, (d, tag), straight[free], moved, own, fixed, free)
        done = [edges.of(_pairs(part)).ravel() for (of, _), part in parts.items() if of == d]
        fixed[np.concatenate([*done, np.empty(0, int)]).astype(int)] = True
    return bent(edges.ends, points, straight + moved)


def _off(
    gmsh: ModuleType,
    entity: tuple[int, int],
    straight: np.ndarray,
    moved: np.ndarray,
    simplices: np.ndarray,
    fixed: np.ndarray,
    free: np.ndarray,
) -> np.ndarray:
    """How far (k, 3) the middles of the free edges of an entity are off the straight line.

    simplices: (m, s) numbers of the edges of each of its elements.
    """
    dimension, tag = entity
    if not len(free):
        return np.empty((0, moved.shape[1]))
    kind = gmsh.model.getType(dimension, tag)
    if dimension < 3 and not kind.startswith(EXACT):
        near, _ = gmsh.model.getClosestPoint(dimension, tag, straight.ravel())
        return np.reshape(near, (-1, 3)) - straight
    if dimension == 1 or not moved[np.unique(simplices)].any():
        return np.zeros((len(free), moved.shape[1]))
    return spread(simplices, moved, fixed)[free]


def spread(simplices: np.ndarray, moved: np.ndarray, fixed: np.ndarray) -> np.ndarray:
    """Displacements (n, 3) of all points or edges, those of free ones the mean of their
    neighbours'. simplices: (m, s) which of them are one element's."""
    from scipy import sparse  # not before it is needed: it takes long to load

    count, width = len(moved), simplices.shape[1]
    pairs = np.vstack([simplices[:, [a, b]] for a in range(width) for b in range(width) if a != b])
    joined = sparse.csr_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
    joined.data[:] = 1.0
    inner = ~fixed & (joined.getnnz(axis=1) > 0)
    rows = joined[inner]
    degree = np.asarray(rows.sum(axis=1))
    moved = moved.copy()
    for _ in range(ROUNDS):
        moved[inner] = (rows @ moved) / degree
    return moved


def _pairs(part: np.ndarray) -> np.ndarray:
    """Edges (m, s, 2) of elements (m, n)."""
    width = part.shape[1]
    return part[:, [[a, b] for a in range(width) for b in range(a + 1, width)]]
