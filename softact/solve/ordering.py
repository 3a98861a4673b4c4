"""A nested dissection of a model's unknowns by METIS, on the graph of its nodes.

Reference: Karypis and Kumar, SIAM J. Sci. Comput. 20 (1998) 359. A pressure comes right after the
displacements of its vertex: what these leave of its pivot is what makes the matrix quasi-definite.
"""

from __future__ import annotations

import ctypes
import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.sparse
from petsc4py import PETSc

from softact.system import jit
from softact.system.assembly import Assembler
from softact.system.kernels import pointer
from softact.system.unknowns import Unknowns

_FILL = Path(__file__).with_name("_fill.c")
_OPTIONS = 40  # METIS_NOPTIONS
_DONE = 1  # METIS_OK


@functools.cache
def metis() -> ctypes.CDLL | None:
    """METIS, which PETSc is linked to, with integers of 32 bits; None where it is not."""
    library = ctypes.CDLL(PETSc.__file__)
    if not hasattr(library, "METIS_NodeND"):
        return None
    # It fills its options with −1: twice as many bytes where its integers are twice as long.
    options = np.zeros(2 * _OPTIONS, np.int32)
    library.METIS_SetDefaultOptions(pointer(options))
    return library if np.count_nonzero(options) == _OPTIONS else None


@dataclass(frozen=True)
class Dissection:
    """An order of the pivots.

    places: (all,) of each unknown among them, from 1. operations: floating point operations of a
    factorisation in it; MUMPS, which fills up blocks, takes up to a sixth more.
    """

    places: np.ndarray
    operations: float


def nested_dissection(assembler: Assembler) -> Dissection | None:
    """METIS's order, on rank 0; None on the others, and where METIS finds none. Collective. The
    graph is that of the matrix as it is laid out.
    """
    library = jit.load_library(assembler.unknowns.comm, _FILL)
    blocks, pairs = _blocks(assembler.unknowns), assembler.coupled
    gathered = assembler.unknowns.comm.gather((blocks, pairs))
    if gathered is None:
        return None
    first, width, head = np.concatenate([blocks for blocks, _ in gathered], axis=1)
    vertices, vertex = np.unique(head, return_inverse=True)
    vertex_of = np.empty(width.sum(), np.int32)
    for c in range(width.max(initial=0)):
        vertex_of[first[width > c] + c] = vertex[width > c]
    weight = np.bincount(vertex, width).astype(np.int32)
    i, j = vertex_of[np.concatenate([pairs for _, pairs in gathered], axis=1)]
    last = np.empty(0, int)
    if assembler.unknowns.far:  # no separator parts these from the others
        last = vertex_of[assembler.unknowns.number[assembler.unknowns.apart_dofs[:, 0]]]
        near = ~np.isin(i, last) & ~np.isin(j, last)
        i, j = i[near], j[near]
    graph = _adjacency(i, j, len(vertices))
    place = _dissected(graph, weight)
    if place is None:
        return None
    operations = _operations(library, graph, weight, place)
    place[last] = len(place)
    return Dissection(_expanded(place[vertex], first, width), operations)


def _blocks(unknowns: Unknowns) -> np.ndarray:
    """(3, n) first unknown and width of each block that this process owns, and the first unknown
    of the block that it is ordered with: for a pressure that of the displacements of its vertex, or
    of its cell's first; otherwise itself."""
    head, table = np.arange(len(unknowns.first)), unknowns.cell_blocks
    if len(table):
        pressures = np.flatnonzero(unknowns.width[table[0]] == 1)
        head[table[:, pressures]] = table[:, : len(pressures)]
    number = unknowns.number[unknowns.first]
    own = unknowns.first < unknowns.owned
    return np.array([number[own], unknowns.width[own], number[head[own]]])


def _adjacency(i: np.ndarray, j: np.ndarray, count: int) -> scipy.sparse.csr_matrix:
    """Symmetric graph of ``count`` vertices with the edges i j, each once, without loops."""
    apart = i != j
    i, j = i[apart], j[apart]
    shape = count, count
    half = scipy.sparse.csr_matrix((np.ones(len(i), np.int8), (i, j)), shape=shape)
    half.data[:] = 1  # sums of equal edges may have gone round to zero
    return (half + half.T).tocsr()


def _dissected(graph: scipy.sparse.csr_matrix, weight: np.ndarray) -> np.ndarray | None:
    """Place of each vertex, from 0, by METIS; None where it failed."""
    library, count = metis(), graph.shape[0]
    if library is None or not graph.nnz:
        return None
    starts, ends = graph.indptr.astype(np.int32), graph.indices.astype(np.int32)
    vertex, place = np.empty((2, count), np.int32)
    done = library.METIS_NodeND(
        ctypes.byref(ctypes.c_int32(count)), *map(pointer, (starts, ends, weight)), None,
        pointer(vertex), pointer(place),
    )  # fmt: skip
    return place if done == _DONE else None


def _operations(
    library: ctypes.CDLL, graph: scipy.sparse.csr_matrix, weight: np.ndarray, place: np.ndarray
) -> float:
    """Operations of a factorisation in the order ``place`` of vertices with ``weight`` rows each;
    infinitely many where there is no memory to count them."""
    library.operations.restype = ctypes.c_double
    starts, ends = (np.ascontiguousarray(a, np.int32) for a in (graph.indptr, graph.indices))
    given = map(pointer, (starts, ends, weight, place))
    found = float(library.operations(ctypes.c_int32(graph.shape[0]), *given))
    return found if found >= 0 else np.inf


def _expanded(place: np.ndarray, first: np.ndarray, width: np.ndarray) -> np.ndarray:
    """Places (all,), from 1, of the unknowns of blocks in the order ``place`` of their vertices;
    within a vertex the widest block comes first."""
    order = np.lexsort((-width, place))
    before = np.concatenate([[0], np.cumsum(width[order])[:-1]])
    places = np.empty(width.sum(), np.int32)
    for c in range(width.max()):
        has = width[order] > c
        places[first[order][has] + c] = before[has] + c + 1
    return places
