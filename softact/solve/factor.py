"""Factors of the tangent: LDLᵀ or LU by MUMPS, within PETSc's SNES."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from petsc4py import PETSc

from softact.model import Model
from softact.solve.analysis import Analysis, Analyst
from softact.system.inertia import MUMPS_CONTROLS

# MUMPS's INFOG(1) where it could not allocate its factors, and where its working space was too
# small for them (users' guide, section 8).
OUT_OF_MEMORY, OUT_OF_SPACE = (-13, -19), (-8, -9)

# Rows of displacements alone are of one size: to scale them takes a fifth of a factorisation.
UNSCALED = {8: 0}


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


class Factor:
    """The factors of a model's tangent.

    fresh: whether there are factors, and ``unstable_modes`` can be asked of them. layouts: how
    often the matrix had been laid out when they were set up.
    """

    def __init__(self, model: Model, snes: PETSc.SNES, pressures: int):
        self._model, self._snes, self._pressures = model, snes, pressures
        self._space = SPACE.of_sheets if model.sheets else SPACE.usual
        self._modes = 0
        self.analyst = Analyst(model)
        self._matrix = self._prepared()

    @property
    def analysis(self) -> Analysis | None:
        """That of the last factorisation; None before the first."""
        return self.analyst.last

    def set_up(self) -> None:
        """A factorisation for the matrix as it is laid out now, instead of the one there is."""
        self._matrix.destroy()  # petsc4py keeps what Python lets go until it is told otherwise
        self._matrix = self._prepared()

    def _prepared(self) -> PETSc.Mat:
        """The factors of the matrix as it is laid out now, before the first factorisation."""
        model, ksp = self._model, self._snes.getKSP()
        self.layouts = model.assembler.layouts
        pc = ksp.getPC()
        pc.reset()
        ksp.setOperators(model.assembler.matrix)
        # LDLT where the tangent is symmetric (and indefinite); friction makes it unsymmetric.
        symmetric = model.contacts.symmetric
        pc.setType(PETSc.PC.Type.CHOLESKY if symmetric else PETSc.PC.Type.LU)
        pc.setFactorSolverType("mumps")
        pc.setFactorSetUpSolverType()
        factors = pc.getFactorMatrix()
        self.fresh = self._analysed = False
        controls = {**MUMPS_CONTROLS, 14: self._space}
        if not model.solids:
            controls |= UNSCALED
        for control, value in controls.items():
            factors.setMumpsIcntl(control, value)
        return factors

    def follow_layout(self) -> None:
        """Set up anew where the matrix has been laid out anew; its values are there."""
        if self._model.assembler.layouts != self.layouts:
            self.set_up()
        if not self._analysed:
            self.analyst.analyse(self._matrix)
            self._analysed = True

    def more_space(self) -> bool:
        """Whether the factors did not fit into their working space and may have more now."""
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
        """Whether the last factorisation found no memory."""
        return self._matrix.getMumpsInfog(1) in OUT_OF_MEMORY

    def unstable_modes(self) -> int:
        """Negative eigenvalues of the last factorised tangent beyond one per pressure unknown.

        The factors' inertia is the matrix's (Sylvester). The pressure block −1/K is negative, and
        eliminating it leaves the stiffness of the displacements: the inertias add up (Haynsworth).
        """
        if not self._model.contacts.symmetric:
            return 0  # LU factors have no inertia
        if self.fresh:
            self._modes = self._matrix.getInertia()[0] - self._pressures
        return self._modes

    def remember(self, unstable_modes: int) -> None:
        """What the last tangent of an interrupted run said."""
        self._modes = unstable_modes

    def again(self) -> None:
        """Factorise the matrix as it is now."""
        pc = self._snes.getKSP().getPC()
        pc.setOperators(self._model.assembler.matrix)
        pc.setUp()

    def solve_all(self, rights: np.ndarray) -> np.ndarray:
        """What the last factors give for several right-hand sides (k, owned), at once."""
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

    def solve(self, right: PETSc.Vec, answer: PETSc.Vec) -> None:
        """What the last factors give for a right-hand side."""
        self._snes.getKSP().getPC().apply(right, answer)
