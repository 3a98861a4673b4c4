"""Which facets may touch which, and which of these may have come near since that was found."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy.sparse

from softact.contact.backs import Backs
from softact.contact.sight import spheres
from softact.system import jit

if TYPE_CHECKING:
    from mpi4py import MPI

# Facets with normals that may turn to face each other within an increment.
FACING = 0.5


class Looking(NamedTuple):
    """Candidates of each facet: those of facet i are candidate[start[i]:start[i + 1]]."""

    start: np.ndarray
    candidate: np.ndarray

    def of(self, kept: np.ndarray) -> Looking:
        """Those that are kept (pairs,)."""
        if kept.all():
            return self
        before = np.concatenate([[0], np.cumsum(kept, dtype=np.int64)])
        return Looking(before[self.start], self.candidate[kept])

    def involved(self) -> tuple[np.ndarray, Looking]:
        """Numbers (m,), rising, of the facets that look or are looked at, and the same pairs as
        numbered among these."""
        looks = np.diff(self.start) > 0
        there = looks.copy()
        there[self.candidate] = True
        numbers, renumbered = np.flatnonzero(there), np.cumsum(there) - 1
        start = np.append(self.start[numbers], self.start[-1])
        return numbers, Looking(start, renumbered[self.candidate].astype(np.int32))

    @property
    def facet(self) -> np.ndarray:
        """The facet (pairs,) that looks at each candidate."""
        return np.repeat(np.arange(len(self.start) - 1), np.diff(self.start))


def facet_normals(nodes: np.ndarray) -> np.ndarray:
    """Unit normals (k, 3) of the flat triangles of the corners of facets (k, n, 3)."""
    n = np.cross(nodes[:, 1] - nodes[:, 0], nodes[:, 2] - nodes[:, 0])
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def neighbours(numbers: np.ndarray) -> Looking:
    """The facets that have a node in common with each, which are no contact; numbers: (k, n) of
    their nodes."""
    count = len(numbers)
    facet = np.repeat(np.arange(count), numbers.shape[1])
    of_node = scipy.sparse.csr_matrix((np.ones(len(facet), np.int8), (facet, numbers.ravel())))
    shared = of_node @ of_node.T
    return Looking(shared.indptr.astype(np.int64), shared.indices.astype(np.int32))


class Pairs:
    """The pairs of facets that may touch before the next search, the same on all processes.

    ``looking``: the candidates of each facet, found by ``search`` at some places of the nodes. From
    how far apart a pair was there at least, and from how far its facets have moved since, ``near``
    tells which may have come near.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        numbers: np.ndarray,
        side: np.ndarray,
        reach: np.ndarray,
        depth: np.ndarray,
        backs: Backs,
        overlooks: Callable[[np.ndarray, np.ndarray], np.ndarray],
    ):
        """numbers: (k, n) of the facets' nodes. side: (k,) of which body (facets of one side do not
        touch; −1: any other). reach, depth: (k,) mm, how far they look, and how deep inside of
        each other. backs: pairs that never touch; overlooks: pairs of which only the second
        looks at the first."""
        self._library = jit.load_library(comm, Path(__file__).with_name("_pairs.c"))
        self._library.candidates.restype = self._library.near.restype = ctypes.c_int64
        self._adjoining, self.side, self._reach = neighbours(numbers), side, reach
        self._backs, self._overlooks, self._depth = backs, overlooks, depth
        self._room = 64 * len(numbers)

    def search(self, nodes: np.ndarray) -> None:
        """Find what may touch before the next search, of facets with nodes (k, n, 3) mm."""
        looking, joined = self._within_reach(nodes)
        i, j = looking.facet, looking.candidate
        sees, seen = self._overlooks(i, j), self._overlooks(j, i)
        apart = ~joined | seen  # also beside where the sheet is glued
        self.looking = looking.of(apart & ~sees & ~self._backs(i, j))
        self.nodes = nodes
        facets = np.empty((len(nodes), self._library.body_size()))
        self._distance = np.empty(len(self.looking.candidate))
        count, size = ctypes.c_int64(len(nodes)), ctypes.c_int32(nodes.shape[1])
        self._library.bodies(count, size, *_pointers(nodes, facets))
        self._library.apart(count, *_pointers(facets, *self.looking, self._depth, self._distance))

    def take(self, facet: np.ndarray, other: np.ndarray, nodes: np.ndarray) -> None:
        """From here on, these pairs (m,) alone may touch, wherever they go."""
        i, j = np.unique(np.column_stack([facet, other]), axis=0).T
        start = np.searchsorted(i, np.arange(len(nodes) + 1))
        self.looking = Looking(start.astype(np.int64), j.astype(np.int32))
        self.nodes, self._distance = nodes, np.full(len(j), -np.inf)

    def _within_reach(self, nodes: np.ndarray) -> tuple[Looking, np.ndarray]:
        """Facets within reach that may turn to face each other, and which of them (pairs,) have a
        node in common."""
        centre, radius = spheres(nodes)
        side = np.ascontiguousarray(self.side, np.int64)
        arrays = centre, radius, self._reach, facet_normals(nodes), side, *self._adjoining
        start = np.zeros(len(nodes) + 1, np.int64)
        while len(nodes):
            found, joined = np.empty(self._room, np.int32), np.empty(self._room, bool)
            count = self._library.candidates(
                ctypes.c_int64(len(nodes)),
                *_pointers(*arrays),
                ctypes.c_double(FACING),
                *_pointers(start),
                ctypes.c_int64(self._room),
                *_pointers(found, joined),
            )
            if count < 0:
                raise MemoryError("no room to look for what may touch")
            if count <= self._room:
                return Looking(start, found[:count]), joined[:count]
            self._room = 2 * count
        return Looking(start, np.empty(0, np.int32)), np.empty(0, bool)

    def near(
        self,
        nodes: np.ndarray,
        within: np.ndarray,
        directions: tuple[np.ndarray, np.ndarray] | None = None,
        facing: float = 1.0,
    ) -> np.ndarray:
        """Which candidates (pairs,) may be nearer than ``within`` (k,) mm to the facet that looks
        at them, or overlap with it, where the facets have these nodes (k, n, 3); all others are
        farther off, or deeper in each other than they look.

        directions: see ``Closest``; of those, only pairs whose normals' product may be below
        ``facing``.
        """
        mark = np.zeros(len(self.looking.candidate), bool)
        if not len(mark):
            return mark
        centre, spread = np.empty((len(nodes), 3)), np.empty(len(nodes))
        count, size = ctypes.c_int64(len(nodes)), ctypes.c_int32(nodes.shape[1])
        self._library.motion(count, size, *_pointers(self.nodes, nodes, centre, spread))
        known = *self.looking, self._distance, centre, spread, within
        faces = _pointers(*directions) if directions else [None, None]
        self._library.near(
            count, *_pointers(*known), *faces, ctypes.c_double(facing), *_pointers(mark)
        )
        return mark


def _pointers(*arrays: np.ndarray) -> list[ctypes.c_void_p]:
    assert all(a.flags.c_contiguous for a in arrays)
    return [ctypes.c_void_p(a.ctypes.data) for a in arrays]
