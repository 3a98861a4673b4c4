"""MUMPS behind PETSc: the analysis of a matrix, with an order of the pivots that PETSc cannot give.

PETSc's factor begins with MUMPS's own structure, whose layout MUMPS's header says. It is used where
the header is that of the library, which the structure's own version tells.
"""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path

import numpy as np
import petsc4py
from mpi4py import MPI
from petsc4py import PETSc

from softact.errors import SoftactError
from softact.system import jit
from softact.system.kernels import pointer

_HEADER = "dmumps_c.h"
# Of PETSc, in which its factor is known to begin with MUMPS's structure; later ones have more than
# one such structure.
KNOWN = (3, 18), (3, 22)
_petsc = ctypes.CDLL(PETSc.__file__)
# MUMPS's ICNTL(7): let it choose; an order is given. What it says of its choice in INFOG(7).
ANY, GIVEN = 7, 1
CHOSEN = {0: "AMD", 1: "given", 2: "AMF", 3: "SCOTCH", 4: "PORD", 5: "METIS", 6: "QAMD"}


def analyse(factors: PETSc.Mat, matrix: PETSc.Mat, symmetric: bool) -> None:
    """MUMPS's analysis of a matrix, with its values there; the factorisation goes on from it.
    Collective. Raises PETSc.Error."""
    one, other = ctypes.c_void_p(factors.handle), ctypes.c_void_p(matrix.handle)
    if symmetric:
        code = _petsc.MatCholeskyFactorSymbolic(one, other, None, None)
    else:
        code = _petsc.MatLUFactorSymbolic(one, other, None, None, None)
    if code:
        raise PETSc.Error(code)


def _header() -> Path | None:
    """MUMPS's header, where a compiler's packages have it."""
    roots = [petsc4py.get_config()["PETSC_DIR"], sys.prefix, sys.base_prefix, "/usr"]
    found = (Path(root) / "include" / _HEADER for root in roots)
    return next((path for path in found if path.is_file()), None)


def _structure(factors: PETSc.Mat) -> ctypes.c_void_p:
    """Where MUMPS's structure is: at the beginning of the data of PETSc's factor, whose address
    stands behind those of its layouts in PETSc's ``_p_Mat``."""
    rows, columns = ctypes.c_void_p(), ctypes.c_void_p()
    _petsc.MatGetLayouts(ctypes.c_void_p(factors.handle), ctypes.byref(rows), ctypes.byref(columns))
    at, step = factors.handle, ctypes.sizeof(ctypes.c_void_p)
    words = ctypes.POINTER(ctypes.c_void_p)
    while True:  # both are part of the object, so it ends inside of it
        here = ctypes.cast(at, words)
        if (here[0], here[1]) == (rows.value, columns.value):
            return ctypes.c_void_p(here[2])
        at += step


class Structure:
    """MUMPS's own structure of factors that have been analysed once. Collective.

    fault: why it is not used, "" where it is; the same on all processes.
    """

    def __init__(self, comm: MPI.Comm, factors: PETSc.Mat):
        self._dmumps = getattr(_petsc, "dmumps_c", None)
        self.fault = "PETSc is not linked to MUMPS"
        here = PETSc.Sys.getVersion()[:2]
        if not KNOWN[0] <= here <= KNOWN[1]:
            self.fault = "it was tried with PETSc 3.18 to 3.22, not with {}.{}".format(*here)
        elif comm.allreduce(self._dmumps is not None, op=MPI.LAND):
            self.fault = self._unlike(comm, factors)

    def _unlike(self, comm: MPI.Comm, factors: PETSc.Mat) -> str:
        header = comm.bcast(_header() if comm.rank == 0 else None)
        if header is None:
            return f"{_HEADER} is not there: install libmumps-dev"
        try:
            self._library = jit.load_library(comm, Path(__file__).with_name("_mumps.c"), header)
        except SoftactError as error:
            return str(error)
        self._id = _structure(factors)
        fits = bool(self._library.mumps_fits(self._id))
        return "" if comm.allreduce(fits, op=MPI.LAND) else f"{header} is of another MUMPS"

    def analyse(self, ordering: int, order: np.ndarray | None = None) -> None:
        """Analyse the matrix again. order: where it is ``GIVEN``, the place (all,) of each unknown
        among the pivots, from 1, on rank 0."""
        self._library.mumps_analyse(self._id, self._dmumps, ordering, pointer(order))
