"""Which facet each point of a surface faces, where, and how far away."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.pairs import facet_normals
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


class Closest:
    """The compiled search; see ``_closest.c``.

    facing: product of the normals of a facet and of a point's own facet below which the point may
    face it.
    """

    def __init__(self, comm: MPI.Comm):
        source = Path(__file__).with_name("_closest.c")
        library = jit.load_library(comm, source)
        self._function, self._prepare = library.closest, library.prepare
        self._directions, self._size = library.directions, library.facet_size()
        library.facing.restype = ctypes.c_double
        self.facing: float = library.facing()

    def directions(self, nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Unit normals (k, 3) of the flat triangles of the corners of facets (k, n, 3), and how far
        (k,) the facets' normals may be from these."""
        nodes = np.ascontiguousarray(nodes)
        normal, leaning = np.empty((len(nodes), 3)), np.empty(len(nodes))
        pointers = (ctypes.c_void_p(a.ctypes.data) for a in (nodes, normal, leaning))
        self._directions(ctypes.c_int64(len(nodes)), ctypes.c_int32(nodes.shape[1]), *pointers)
        return normal, leaning

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
        lies: tuple[np.ndarray, np.ndarray] | None = None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Partner (m, q) (−1: none), place on it (m, q, 2) and signed gap (m, q) mm of points
        (m, q, 3) of some facets, whose own nodes are ``own`` (m, n, 3), among facets (k, n, 3).
        start, candidate: see ``Looking``, of these facets. reach, depth: (m,) largest gap and
        overlap, mm. before: partners that are kept where they still are. lies: (m, 4) and (k, 4)
        where facets are at rest, see ``Facets.lies``; by default all are beside each other."""
        places, nodes, reach, depth = map(np.ascontiguousarray, (places, nodes, reach, depth))
        own = np.ascontiguousarray(facet_normals(own))
        if lies is None:
            lies = np.ones((len(own), 4)), np.ones((len(nodes), 4))
        mine, theirs = map(np.ascontiguousarray, lies)
        shape = places.shape[:2]
        facets = np.empty((len(nodes), self._size))
        size = ctypes.c_int64(len(nodes)), ctypes.c_int32(nodes.shape[1])
        self._prepare(*size, *(ctypes.c_void_p(a.ctypes.data) for a in (nodes, theirs, facets)))
        partner = np.full(shape, -1, np.int32) if before is None else before.astype(np.int32)
        place, gap = np.empty((*shape, 2)), np.empty(shape)
        arrays = (places, own, mine, facets, start, candidate, reach, depth)
        pointers = [ctypes.c_void_p(a.ctypes.data) for a in (*arrays, partner, place, gap)]
        self._function(
            ctypes.c_int64(shape[0]),
            ctypes.c_int32(shape[1]),
            ctypes.c_int32(nodes.shape[1]),
            *pointers[:8],
            ctypes.c_double(SLACK),
            ctypes.c_double(KEEP),
            ctypes.c_double(TIE),
            *pointers[8:],
        )
        return partner, place, gap
