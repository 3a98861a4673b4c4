"""Factors of the tangent by MKL's Pardiso, on the first process with as many threads as there are
processes."""

from __future__ import annotations

import ctypes
import os
import weakref

import numpy as np
from petsc4py import PETSc

from softact.model import Model
from softact.solve.analysis import Analysis
from softact.solve.factor import Factor
from softact.solve.gathered import Gathered, on_the_first
from softact.solve.pardiso import OUT_OF_MEMORY, Pardiso, Said

# Of a right-hand side, what the first answer after a factorisation may leave: with single rows as
# pivots an indefinite matrix may lose more, and is factorised again with pivots of two rows.
LEFT = 1e-8
_petsc = ctypes.CDLL(PETSc.__file__)
_OUT_OF_MEMORY, _OTHER = 3, 4  # PCFailedReason


class PardisoFactor(Factor):
    """Factors by Pardiso. See ``Factor``.

    Pivots are single rows at first. Where a symmetric matrix has negative eigenvalues beyond
    the pressures', or a pivot was too small, pivots of two rows say whether that is so.
    """

    _said = Said(0, 0, 0, 0.0, 0)
    _gathered: Gathered | None = None
    _analysis: Analysis | None = None
    _unproved = False  # whether no answer was looked at since the last factorisation

    def __init__(self, model: Model, snes: PETSc.SNES, pressures: int):
        super().__init__(model, snes, pressures)
        self._comm = model.comm
        usual = os.environ.get("OPENBLAS_NUM_THREADS") or len(os.sched_getaffinity(0))
        self._threads = max(self._comm.size, int(usual))
        self._made: list[Pardiso] = []  # the one that there is, on rank 0
        self.set_up()
        weakref.finalize(self, _let_go, self._pc, self._made)

    @property
    def analysis(self) -> Analysis | None:
        """See ``Factor``."""
        return self._analysis

    def _prepare(self, pc: PETSc.PC) -> None:
        pc.setType(PETSc.PC.Type.PYTHON)
        pc.setPythonContext(_Preconditioner(self))

    def _analyse(self) -> None:
        matrix, symmetric = self._model.assembler.matrix, self._model.contacts.symmetric
        self._gathered = gathered = Gathered(self._comm, matrix, upper=symmetric)

        def analyse() -> Said:
            _free(self._made)
            pattern = gathered.starts, gathered.columns
            self._made.append(Pardiso(*pattern, symmetric, self._threads))
            return self._made[0].analyse()

        self._said = said = on_the_first(self._comm, analyse)
        name = "nested dissection"
        self._analysis = Analysis(name, {name: said.operations}, said.memory_MB, solver="Pardiso")

    def factorise(self, pc: PETSc.PC) -> None:
        """Factors of the matrix as it is now; what failed is left to PETSc's solver. Collective."""
        self._factorise(pivoting=False)
        symmetric, first = self._model.contacts.symmetric, self._said
        if symmetric and (first.error or first.perturbed or first.negative != self._pressures):
            self._factorise(pivoting=True)
        self._unproved = symmetric and not self._said.error
        if self._said.error:
            full = self._said.error == OUT_OF_MEMORY
            _petsc.PCSetFailedReason(ctypes.c_void_p(pc.handle), _OUT_OF_MEMORY if full else _OTHER)

    def _factorise(self, pivoting: bool) -> None:
        assert self._gathered is not None, "the analysis comes first"
        values = self._gathered.values()

        def factorise() -> Said:
            return self._made[0].factorise(values, pivoting)

        self._said = on_the_first(self._comm, factorise)

    def answer(self, right: PETSc.Vec, answer: PETSc.Vec) -> None:
        """What the last factors give for a right-hand side. Collective."""
        answer.setArray(self.solve_all(right.getArray()[None])[0])
        if self._unproved:
            self._unproved = False
            if not self._left(right, answer) <= LEFT * right.norm():  # also of NaN
                self._factorise(pivoting=True)
                answer.setArray(self.solve_all(right.getArray()[None])[0])

    def _left(self, right: PETSc.Vec, answer: PETSc.Vec) -> float:
        """Norm of what an answer leaves of its right-hand side."""
        left = right.duplicate()
        self._model.assembler.matrix.mult(answer, left)
        left.axpy(-1.0, right)
        norm = left.norm()
        left.destroy()
        return norm

    def solve_all(self, rights: np.ndarray) -> np.ndarray:
        """See ``Factor``."""
        assert self._gathered is not None, "the analysis comes first"
        whole, answers = self._gathered.gather(rights), np.empty((0, 0))

        def solve() -> int:
            nonlocal answers
            answers, error = self._made[0].solve(whole)
            return error

        if on_the_first(self._comm, solve):
            return np.full_like(rights, np.nan)
        return self._gathered.scatter(answers, len(rights))

    def more_space(self) -> bool:
        """See ``Factor``: Pardiso takes what it needs."""
        return False

    @property
    def did_not_fit(self) -> bool:
        """See ``Factor``."""
        return self._said.error == OUT_OF_MEMORY

    def _negative(self) -> int:
        return self._said.negative


def _free(made: list[Pardiso]) -> None:
    while made:
        made.pop().free()


def _let_go(pc: PETSc.PC, made: list[Pardiso]) -> None:
    """Give the memory back. PETSc ends after Python's own objects have gone: it must not look for
    its preconditioner among them then."""
    pc.setType(PETSc.PC.Type.NONE)
    _free(made)


class _Preconditioner:
    """What PETSc calls: the factors of a matrix that it says has changed, and their answers."""

    def __init__(self, factor: PardisoFactor):
        self._factor = weakref.proxy(factor)  # PETSc's solver keeps this, and the factor keeps it

    def setUp(self, pc: PETSc.PC) -> None:
        """Factorise."""
        self._factor.factorise(pc)

    def apply(self, _pc: PETSc.PC, right: PETSc.Vec, answer: PETSc.Vec) -> None:
        """Solve."""
        self._factor.answer(right, answer)
