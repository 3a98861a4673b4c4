"""Factors of the tangent by MUMPS: LDLᵀ, or LU where it is not symmetric."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from softact.model import Model
from softact.solve.analysis import Analysis, Analyst
from softact.solve.factor import Factor
from softact.system.inertia import MUMPS_CONTROLS

# MUMPS's INFOG(1) where it could not allocate its factors, and where its working space was too
# small for them (users' guide, section 8).
OUT_OF_MEMORY, OUT_OF_SPACE = (-13, -19), (-8, -9)

# MUMPS's ICNTL(8): rows are not scaled, which takes an eighth of a factorisation, or they are.
SCALING, UNSCALED, SCALED = 8, 0, 7
DELAYED = 13  # of INFOG: pivots that were too small where they stood
MANY = 0.01  # of the unknowns


@dataclass(frozen=True)
class WorkingSpace:
    """Percent of working space above MUMPS's estimate: usual, and where there are sheets, which
    without stiffness delay many pivots; how much more is tried where that was too little, and how
    much at most."""

    usual: int = 60
    of_sheets: int = 400
    more: int = 4
    most: int = 10_000


SPACE = WorkingSpace()


class MumpsFactor(Factor):
    """Factors by MUMPS, on all processes. See ``Factor``.

    Rows are scaled from the first factorisation on that had to delay many pivots; not of sheets
    alone, whose displacements have rows of one size, and which delay pivots where they carry
    nothing.
    """

    _matrix: PETSc.Mat = None
    _scaling = UNSCALED

    def __init__(self, model: Model, snes: PETSc.SNES, pressures: int):
        super().__init__(model, snes, pressures)
        self._space = SPACE.of_sheets if model.sheets else SPACE.usual
        self.analyst = Analyst(model)
        self.set_up()

    @property
    def analysis(self) -> Analysis | None:
        """See ``Factor``."""
        return self.analyst.last

    def _prepare(self, pc: PETSc.PC) -> None:
        if self._matrix is not None:
            self._matrix.destroy()  # petsc4py keeps what Python lets go until it is told otherwise
        # LDLT where the tangent is symmetric (and indefinite); friction makes it unsymmetric.
        symmetric = self._model.contacts.symmetric
        pc.setType(PETSc.PC.Type.CHOLESKY if symmetric else PETSc.PC.Type.LU)
        pc.setFactorSolverType("mumps")
        pc.setFactorSetUpSolverType()
        self._matrix = pc.getFactorMatrix()
        controls = {**MUMPS_CONTROLS, 14: self._space, SCALING: self._scaling}
        for control, value in controls.items():
            self._matrix.setMumpsIcntl(control, value)

    def follow_layout(self) -> None:
        """See ``Factor``."""
        delayed = self._matrix.getMumpsInfog(DELAYED) if self._analysed else 0
        many = delayed > MANY * self._model.assembler.matrix.getSize()[0]
        if many and self._model.solids and self._scaling == UNSCALED:
            self._scaling = SCALED
            self._matrix.setMumpsIcntl(SCALING, SCALED)
        super().follow_layout()

    def _analyse(self) -> None:
        self.analyst.analyse(self._matrix)

    def more_space(self) -> bool:
        """See ``Factor``."""
        failed = PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE
        short = self._snes.getConvergedReason() == failed
        short = short and self._matrix.getMumpsInfog(1) in OUT_OF_SPACE
        if not short or self._space > SPACE.most:
            return False
        self._space = max(SPACE.more * self._space, SPACE.usual)
        self.set_up()  # its analysis sets the space aside
        return True

    @property
    def did_not_fit(self) -> bool:
        """See ``Factor``."""
        return self._matrix.getMumpsInfog(1) in OUT_OF_MEMORY

    def _negative(self) -> int:
        return self._matrix.getInertia()[0]

    def solve_all(self, rights: np.ndarray) -> np.ndarray:
        """See ``Factor``."""
        comm, (k, owned) = self._model.comm, rights.shape
        size = (owned, None), (None, k)
        right = PETSc.Mat().createDense(size, array=np.asfortranarray(rights.T), comm=comm)
        answer = PETSc.Mat().createDense(size, comm=comm)
        answer.setUp()
        self._matrix.matSolve(right, answer)
        found = np.array(answer.getDenseArray()).T
        right.destroy()
        answer.destroy()
        return np.ascontiguousarray(found)
