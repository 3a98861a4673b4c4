"""MKL's Pardiso, where its user has installed it: factors of a sparse matrix in one process.

MKL is not free software, and not part of softact. Reference of its calls: Intel oneMKL developer
reference, "oneMKL PARDISO". Threads are GNU's, whose idle ones give their cores away.
"""

from __future__ import annotations

import ctypes
import functools
import importlib.metadata
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softact.system.kernels import pointer

_NAME = "libmkl_rt.so"
_GNU_THREADS = 3  # mkl_set_threading_layer
# Kinds of matrices: real, and symmetric but indefinite or not symmetric.
_SYMMETRIC, _UNSYMMETRIC = -2, 11
_ANALYSE, _FACTORISE, _SOLVE, _FREE = 11, 22, 33, -1
# A pivot below this part of the largest entry, as a power of ten, is put in its place and counted.
_SMALLEST_PIVOT = 13
OUT_OF_MEMORY = -2
HOW = "pip install 'softact[pardiso]' (it has a licence of its own), or say factor: mumps"


@functools.cache
def library() -> ctypes.CDLL | None:
    """MKL, from Python's own folders or from where the system looks; None where there is none."""
    folders = {Path(sys.prefix) / "lib", Path(sys.base_prefix) / "lib"}
    try:
        listed = importlib.metadata.files("mkl") or []
        folders |= {Path(str(path.locate())).parent for path in listed if _NAME in path.name}
    except importlib.metadata.PackageNotFoundError:
        pass
    there = [str(path) for folder in sorted(folders) for path in sorted(folder.glob(_NAME + "*"))]
    for name in (*there, _NAME):
        try:
            ctypes.CDLL("libgomp.so.1", mode=ctypes.RTLD_GLOBAL)  # MKL leaves its threads to it
            found = ctypes.CDLL(name)
            found.MKL_Set_Threading_Layer(_GNU_THREADS)
        except (OSError, AttributeError):
            continue
        return found
    return None


@dataclass(frozen=True)
class Said:
    """What Pardiso said of its last call.

    error: 0, or its number. negative: eigenvalues of a symmetric matrix. perturbed: pivots that
    were too small and were replaced. operations: floating point operations of a factorisation.
    memory_MB: at its peak.
    """

    error: int
    negative: int
    perturbed: int
    operations: float
    memory_MB: int  # noqa: N815 (a unit)


class Pardiso:
    """Factors of one matrix: its upper triangle where it is symmetric.

    starts (n + 1,), columns (m,): rows of CSR from 1, columns ascending, with all diagonal entries.
    Raises RuntimeError where there is no MKL.
    """

    def __init__(self, starts: np.ndarray, columns: np.ndarray, symmetric: bool, threads: int):
        mkl = library()
        if mkl is None:
            raise RuntimeError(f"no MKL: {HOW}")
        self._mkl, self._threads = mkl, threads
        self._starts, self._columns = starts, columns
        self._kind = ctypes.c_int(_SYMMETRIC if symmetric else _UNSYMMETRIC)
        self._size, self._handle = len(starts) - 1, np.zeros(64, np.int64)
        self._controls, self._values = np.zeros(64, np.int32), np.zeros(len(columns))
        mkl.pardisoinit(pointer(self._handle), ctypes.byref(self._kind), pointer(self._controls))
        # By their numbers in the reference, less one: nested dissection in threads; answers are
        # not refined where no pivot was replaced; smallest pivot; neither scaling nor matching,
        # which need the values; count operations.
        given = {1: 3, 7: 0, 9: _SMALLEST_PIVOT, 10: 0, 12: 0, 17: -1, 18: -1}
        for control, value in given.items():
            self._controls[control] = value

    def analyse(self) -> Said:
        """Choose the order of the pivots."""
        return self._call(_ANALYSE)

    def factorise(self, values: np.ndarray, pivoting: bool) -> Said:
        """Factors of the matrix with these values (m,). pivoting: of a symmetric one with pivots of
        two rows where one row's is small (Bunch and Kaufman); otherwise each row is one."""
        self._values = values
        self._controls[20] = int(pivoting)
        return self._call(_FACTORISE)

    def solve(self, rights: np.ndarray) -> tuple[np.ndarray, int]:
        """Answers (k, n) to right-hand sides (k, n), and the number of an error or 0."""
        rights = np.ascontiguousarray(rights, dtype=float)
        answers = np.empty_like(rights)
        return answers, self._call(_SOLVE, rights, answers).error

    def free(self) -> None:
        """Give the memory back; afterwards there are no factors."""
        if self._handle.any():
            self._call(_FREE)
            self._handle[:] = 0

    def _call(
        self, phase: int, rights: np.ndarray | None = None, answers: np.ndarray | None = None
    ) -> Said:
        error = ctypes.c_int(0)
        one, size, quiet = ctypes.c_int(1), ctypes.c_int(self._size), ctypes.c_int(0)
        count = ctypes.c_int(1 if rights is None else len(rights))
        nothing = np.zeros(1, np.int32)  # no order of the caller's
        self._mkl.MKL_Set_Num_Threads(self._threads)
        self._mkl.pardiso(
            pointer(self._handle), *map(ctypes.byref, (one, one, self._kind)),
            ctypes.byref(ctypes.c_int(phase)), ctypes.byref(size),
            *map(pointer, (self._values, self._starts, self._columns, nothing)),
            ctypes.byref(count), pointer(self._controls), ctypes.byref(quiet),
            pointer(rights), pointer(answers), ctypes.byref(error),
        )  # fmt: skip
        c = self._controls
        memory = max(int(c[14]), int(c[15]) + int(c[16]))  # kB: analysis; kept and factors
        return Said(error.value, int(c[22]), int(c[13]), 1e6 * int(c[18]), memory // 1024)
