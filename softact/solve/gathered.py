"""A matrix of all processes on the first one, for a solver that works in one process."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable
from contextlib import contextmanager
from typing import Any

import numpy as np
import scipy.sparse
from mpi4py import MPI
from petsc4py import PETSc

_petsc = ctypes.CDLL(PETSc.__file__)
_INT = np.dtype(PETSc.IntType)
WAIT = 2e-4  # seconds between two looks whether the first process is done


def on_the_first(comm: MPI.Comm, work: Callable[[], Any]) -> Any:
    """What ``work`` gives on rank 0, on all; the others sleep meanwhile, for it may need their
    cores. Collective."""
    found = work() if comm.rank == 0 else None
    if comm.size > 1:
        done = comm.Ibarrier()
        while not done.Test():
            time.sleep(WAIT)
    return comm.bcast(found)


class Gathered:
    """Rows of CSR of a PETSc matrix on rank 0, as long as the matrix keeps its layout.

    upper: of a symmetric matrix the entries from the diagonal on, otherwise all. starts (n + 1,),
    columns (m,): on rank 0, from 1, columns in ascending order; empty on the others.
    """

    def __init__(self, comm: MPI.Comm, matrix: PETSc.Mat, upper: bool):
        self._comm, self._matrix = comm, matrix
        first, end = matrix.getOwnershipRange()
        rows, columns = (np.concatenate(parts) for parts in zip(*self._pattern(), strict=True))
        rows += first
        kept = np.flatnonzero(columns >= rows) if upper else np.arange(len(rows))
        shape, places = (end - first, matrix.getSize()[1]), (rows[kept] - first, columns[kept])
        own = scipy.sparse.coo_matrix((kept, places), shape).tocsr()
        own.sort_indices()
        self._order, lengths = own.data, np.diff(own.indptr).astype(np.int32)
        self._counts = comm.allgather(len(kept)), comm.allgather(len(lengths))
        self._own = np.empty(len(kept))
        self.columns = self._gather(own.indices.astype(np.int32) + 1, self._counts[0])
        ends = np.cumsum(self._gather(lengths, self._counts[1])) + 1
        self.starts = np.concatenate([[1], ends]).astype(np.int32)

    def _blocks(self) -> list[tuple[ctypes.c_void_p, np.ndarray]]:
        """The sequential matrices that this process's rows consist of, and the global numbers of
        their columns."""
        whole = ctypes.c_void_p(self._matrix.handle)
        if self._comm.size == 1:
            return [(whole, np.arange(self._matrix.getSize()[1]))]
        here, beyond, numbers = (ctypes.c_void_p() for _ in range(3))
        _check(_petsc.MatMPIAIJGetSeqAIJ(whole, *map(ctypes.byref, (here, beyond, numbers))))
        first, end = self._matrix.getOwnershipRangeColumn()
        width = ctypes.c_int32() if _INT.itemsize == 4 else ctypes.c_int64()
        _check(_petsc.MatGetSize(beyond, None, ctypes.byref(width)))
        foreign = _view(numbers, width.value, _INT)
        return [(here, np.arange(first, end)), (beyond, foreign.copy())]

    def _pattern(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Own row, from 0, and global column of each entry of each block."""
        found = []
        for block, numbers in self._blocks():
            count = ctypes.c_int32() if _INT.itemsize == 4 else ctypes.c_int64()
            starts, columns, done = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_int()
            asked = (0, 0, 0, *map(ctypes.byref, (count, starts, columns, done)))
            _check(_petsc.MatGetRowIJ(block, *asked))
            lengths = np.diff(_view(starts, count.value + 1, _INT))
            rows = np.repeat(np.arange(count.value), lengths)
            found.append((rows, numbers[_view(columns, len(rows), _INT)]))
            _check(_petsc.MatRestoreRowIJ(block, *asked))
        return found

    def values(self) -> np.ndarray:
        """Values (m,) of the matrix as it is now, on rank 0; empty on the others. Collective."""
        with self._read() as parts:
            whole = parts[0] if len(parts) == 1 else np.concatenate(parts)
            np.take(whole, self._order, out=self._own)
        return self._gather(self._own, self._counts[0])

    @contextmanager
    def _read(self) -> Any:
        blocks, parts = [block for block, _ in self._blocks()], []
        for block in blocks:
            where, count = ctypes.c_void_p(), (ctypes.c_double * 10)()
            _check(_petsc.MatSeqAIJGetArrayRead(block, ctypes.byref(where)))
            _check(_petsc.MatGetInfo(block, 1, count))  # MAT_LOCAL; the third is nz_used
            parts.append((where, int(count[2])))
        try:
            yield [_view(where, count, np.dtype(float)) for where, count in parts]
        finally:
            for block, (where, _) in zip(blocks, parts, strict=True):
                _petsc.MatSeqAIJRestoreArrayRead(block, ctypes.byref(where))

    def gather(self, owned: np.ndarray) -> np.ndarray:
        """Vectors (k, n) of all unknowns on rank 0 from those of each process (k, owned); empty on
        the others. Collective."""
        if self._comm.size == 1:
            return np.ascontiguousarray(owned)
        return np.array([self._gather(vector, self._counts[1]) for vector in owned])

    def scatter(self, vectors: np.ndarray, count: int) -> np.ndarray:
        """The way back: of ``count`` vectors (k, n) on rank 0 the owned part (k, owned)."""
        if self._comm.size == 1:
            return vectors
        own = np.empty((count, self._counts[1][self._comm.rank]))
        for k in range(count):
            sent = [vectors[k], self._counts[1]] if self._comm.rank == 0 else None
            self._comm.Scatterv(sent, own[k])
        return own

    def _gather(self, own: np.ndarray, counts: list[int]) -> np.ndarray:
        if self._comm.size == 1:
            return own
        own = np.ascontiguousarray(own)
        all_of_them = np.empty(sum(counts) if self._comm.rank == 0 else 0, own.dtype)
        self._comm.Gatherv(own, [all_of_them, counts] if self._comm.rank == 0 else None)
        return all_of_them


def _view(address: ctypes.c_void_p, count: int, kind: np.dtype) -> np.ndarray:
    """The numbers at an address, not copied; where there are none, there may be no address."""
    if not count:
        return np.empty(0, kind)
    number = np.ctypeslib.as_ctypes_type(kind)
    return np.ctypeslib.as_array(ctypes.cast(address, ctypes.POINTER(number)), (count,))


def _check(code: int) -> None:
    if code:
        raise PETSc.Error(code)
