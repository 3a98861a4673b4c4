"""Factors of the tangent within PETSc's SNES, whichever library makes them."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from petsc4py import PETSc

from softact.model import Model
from softact.solve.analysis import Analysis


class Factor(ABC):
    """The factors of a model's tangent.

    fresh: whether there are factors, and ``unstable_modes`` can be asked of them. layouts: how
    often the matrix had been laid out when they were set up.
    """

    fresh = False

    def __init__(self, model: Model, snes: PETSc.SNES, pressures: int):
        self._model, self._snes, self._pressures = model, snes, pressures
        self._modes = 0
        self._analysed = False
        self.layouts = model.assembler.layouts

    @property
    @abstractmethod
    def analysis(self) -> Analysis | None:
        """That of the last factorisation; None before the first."""

    @property
    def _pc(self) -> PETSc.PC:
        return self._snes.getKSP().getPC()

    def set_up(self) -> None:
        """A factorisation for the matrix as it is laid out now, instead of the one there is."""
        self.layouts = self._model.assembler.layouts
        self.fresh = self._analysed = False
        pc = self._pc
        pc.reset()
        self._snes.getKSP().setOperators(self._model.assembler.matrix)
        self._prepare(pc)

    @abstractmethod
    def _prepare(self, pc: PETSc.PC) -> None:
        """Make an empty preconditioner this factorisation, with nothing factorised yet."""

    def follow_layout(self) -> None:
        """Set up anew where the matrix has been laid out anew; its values are there."""
        if self._model.assembler.layouts != self.layouts:
            self.set_up()
        if not self._analysed:
            self._analyse()
            self._analysed = True

    @abstractmethod
    def _analyse(self) -> None:
        """Choose the order of the pivots for the matrix as it is laid out now. Collective."""

    @abstractmethod
    def more_space(self) -> bool:
        """Whether the factors did not fit into their working space and may have more now."""

    @property
    @abstractmethod
    def did_not_fit(self) -> bool:
        """Whether the last factorisation found no memory."""

    def unstable_modes(self) -> int:
        """Negative eigenvalues of the last factorised tangent beyond one per pressure unknown.

        The factors' inertia is the matrix's (Sylvester). The pressure block −1/K is negative, and
        eliminating it leaves the stiffness of the displacements: the inertias add up (Haynsworth).
        """
        if not self._model.contacts.symmetric:
            return 0  # LU factors have no inertia
        if self.fresh:
            self._modes = self._negative() - self._pressures
        return self._modes

    @abstractmethod
    def _negative(self) -> int:
        """Negative eigenvalues of the last factorised matrix."""

    def remember(self, unstable_modes: int) -> None:
        """What the last tangent of an interrupted run said."""
        self._modes = unstable_modes

    def again(self) -> None:
        """Factorise the matrix as it is now."""
        self._pc.setOperators(self._model.assembler.matrix)
        self._pc.setUp()

    def solve(self, right: PETSc.Vec, answer: PETSc.Vec) -> None:
        """What the last factors give for a right-hand side."""
        self._pc.apply(right, answer)

    @abstractmethod
    def solve_all(self, rights: np.ndarray) -> np.ndarray:
        """What the last factors give for several right-hand sides (k, owned), at once."""
