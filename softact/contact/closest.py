"""Which facet each point of a surface faces, where, and how far away."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse
from scipy.spatial import cKDTree

from softact.contact.backs import Backs
from softact.contact.sight import spheres
from softact.system import jit

if TYPE_CHECKING:
    from mpi4py import MPI

# How far beyond its edge a facet still counts, barycentric: it closes the wedges between facets.
SLACK = 0.01
# The same for the facet that a point faced before: at an edge it must not change all the time.
KEEP = 0.1
# What differs by less, of the reach, is equally far: on flat walls points near an edge face both
# facets there, and rounding, which differs with the number of processes, must not choose.
TIE = 1e-9
# Facets with normals that may turn to face each other within an increment.
FACING = 0.5
SECOND = np.array([[4, 4, 0, -8, 0, 0], [4, 0, 0, -4, 4, -4], [4, 0, 4, 0, 0, -8]], float)


def derivatives(place: np.ndarray, nodes: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shape functions of facets at places (m, 2): values (m, n), first (m, 2, n), second (3, n)
    derivatives ss, st, tt."""
    s, t = place.T
    r, one, none = 1 - s - t, np.ones_like(s), np.zeros_like(s)
    if nodes == 3:
        values = np.stack([r, s, t], axis=-1)
        first = np.array([[-1.0, 1, 0], [-1, 0, 1]])
        return values, np.broadcast_to(first, (len(s), 2, 3)), np.zeros((3, 3))
    values = np.stack(
        [r * (2 * r - 1), s * (2 * s - 1), t * (2 * t - 1), 4 * r * s, 4 * s * t, 4 * t * r], -1
    )
    along_s = [one - 4 * r, 4 * s - 1, none, 4 * (r - s), 4 * t, -4 * t]
    along_t = [one - 4 * r, none, 4 * t - 1, -4 * s, 4 * s, 4 * (r - t)]
    return values, np.stack([np.stack(along_s, -1), np.stack(along_t, -1)], axis=1), SECOND


def facet_normals(nodes: np.ndarray) -> np.ndarray:
    """Unit normals (k, 3) of the flat triangles of the corners of facets (k, n, 3)."""
    n = np.cross(nodes[:, 1] - nodes[:, 0], nodes[:, 2] - nodes[:, 0])
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def neighbours(numbers: np.ndarray) -> np.ndarray:
    """Pairs of facets i < j that have a node in common, as sorted numbers i k + j; numbers: (k, n)
    of their nodes."""
    count = len(numbers)
    facet = np.repeat(np.arange(count), numbers.shape[1])
    of_node = scipy.sparse.csr_matrix((np.ones(len(facet), np.int8), (facet, numbers.ravel())))
    i, j = (of_node @ of_node.T).nonzero()
    return np.sort(i[i < j].astype(np.int64) * count + j[i < j])


def _among(keys: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Whether numbers (m,) are among sorted ones."""
    if not len(known):
        return np.zeros(len(keys), dtype=bool)
    return known[np.minimum(np.searchsorted(known, keys), len(known) - 1)] == keys


def candidates(
    nodes: np.ndarray,
    adjoining: np.ndarray,
    side: np.ndarray,
    reach: np.ndarray,
    backs: Backs,
    overlooks: Callable[[np.ndarray, np.ndarray], np.ndarray],
) -> tuple[np.ndarray, np.ndarray]:
    """Facets that each facet may touch before the next search, as (start (k + 1,), facet).

    nodes: (k, n, 3) places, adjoining: ``neighbours``, which are no contact, side: (k,) of which
    body (facets of one side do not touch; −1: any other), reach: (k,) mm, backs: pairs that never
    touch, overlooks: pairs of which only the second looks at the first.
    """
    centre, radius = spheres(nodes)
    tree = cKDTree(centre)
    # Both ways: the farther reach of two counts.
    pairs = tree.query_pairs(2 * (radius + reach).max(), output_type="ndarray")
    i, j = np.ascontiguousarray(pairs.T)
    near = np.linalg.norm(centre[i] - centre[j], axis=1)
    near = near < radius[i] + radius[j] + np.maximum(reach[i], reach[j])
    i, j = i[near], j[near]
    normal = facet_normals(nodes)
    near = np.einsum("ij,ij->i", normal[i], normal[j]) < FACING
    near &= (side[i] != side[j]) | (side[i] < 0)
    i, j = i[near], j[near]
    apart = ~_among(i * len(nodes) + j, adjoining)
    apart |= overlooks(i, j) | overlooks(j, i)  # also beside where the sheet is glued
    apart &= ~backs(i, j)
    i, j = np.concatenate([i[apart], j[apart]]), np.concatenate([j[apart], i[apart]])
    seen = ~overlooks(i, j)
    i, j = i[seen], j[seen]
    i, j = np.divmod(np.sort(i * len(nodes) + j), len(nodes))
    start = np.searchsorted(i, np.arange(len(nodes) + 1))
    return start.astype(np.int64), j.astype(np.int32)


class Closest:
    """The compiled search; see ``_closest.c``."""

    def __init__(self, comm: MPI.Comm):
        source = Path(__file__).with_name("_closest.c")
        library = jit.load_library(comm, source)
        self._function, self._prepare = library.closest, library.prepare
        self._size = library.facet_size()

    def __call__(
        self,
        places: np.ndarray,
        own: np.ndarray,
        nodes: np.ndarray,
        start: np.ndarray,
        candidate: np.ndarray,
        reach: np.ndarray,
        depth: np.ndarray,
        before: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Partner (m, q) (−1: none), place on it (m, q, 2) and signed gap (m, q) mm of points
        (m, q, 3) of some facets, whose own nodes are ``own`` (m, n, 3), among facets (k, n, 3).
        start: (m + 1,). reach, depth: (m,) largest gap and overlap, mm. before: partners that are
        kept where they still are."""
        places, nodes, reach, depth = map(np.ascontiguousarray, (places, nodes, reach, depth))
        own = np.ascontiguousarray(facet_normals(own))
        shape = places.shape[:2]
        facets = np.empty((len(nodes), self._size))
        size = ctypes.c_int64(len(nodes)), ctypes.c_int32(nodes.shape[1])
        self._prepare(*size, *(ctypes.c_void_p(a.ctypes.data) for a in (nodes, facets)))
        partner = np.full(shape, -1, np.int32) if before is None else before.astype(np.int32)
        place, gap = np.empty((*shape, 2)), np.empty(shape)
        arrays = (places, own, facets, start, candidate, reach, depth)
        pointers = [ctypes.c_void_p(a.ctypes.data) for a in (*arrays, partner, place, gap)]
        self._function(
            ctypes.c_int64(shape[0]),
            ctypes.c_int32(shape[1]),
            ctypes.c_int32(nodes.shape[1]),
            *pointers[:7],
            ctypes.c_double(SLACK),
            ctypes.c_double(KEEP),
            ctypes.c_double(TIE),
            *pointers[7:],
        )
        return partner, place, gap
