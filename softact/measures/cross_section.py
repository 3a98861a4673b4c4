"""The cross-section of a rod that a chain of modules is: its strains, moment, force, stiffness.

A rod that is bent and stretched alike all along relates its ends as a module does its faces:
ω = L κ and t = L V(ω) ν, with the curvature κ, the stretches ν along x, y and z in its own frame,
and L the pitch. Moment and force are the derivatives of the module's energy by κ and ν, per length;
the stiffness is their derivative.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.system.rotation import RotationVector
from softact.system.term import EVERYTHING, State

if TYPE_CHECKING:
    from softact.bodies.repeat import Repeat
    from softact.model import Model


class CrossSection:
    """Of a model of a module in a state, for the whole actuator.

    strain: (6,) κ, rad/mm, and ν. load: (6,) moment N·mm and force N.
    """

    def __init__(self, model: Model, state: State):
        assert model.repeat is not None
        self._model, self._state = model, state
        self.repeat: Repeat = model.repeat
        turn, shift = self.repeat.motion(state.x)
        self._integral = RotationVector(turn, integral=True)
        self._stretched = np.linalg.solve(self._integral.matrix, shift)
        self.strain = np.concatenate([turn, self._stretched]) / self.repeat.length
        self._pull = self._conjugate()
        self.load = self.slopes.T @ self._pull

    def _conjugate(self) -> np.ndarray:
        """What acts on ω and t (6,): loads, and what holds them."""
        dofs = self.repeat.dofs
        pull = self._model.force(self._state)[0][dofs] / self.repeat.scale
        pull = np.where(self._model.assembler.fixed[dofs] == 1, pull, 0.0)
        wrench = self._state["wrench"].get(EVERYTHING, np.zeros(6))
        return self._model.mesh.layout.copies * (pull + wrench) * self.repeat.free

    @property
    def slopes(self) -> np.ndarray:
        """Derivatives (6, 6) of ω and t by L κ and L ν."""
        slopes = np.eye(6)
        slopes[3:, :3] = (self._integral.first @ self._stretched).T
        slopes[3:, 3:] = self._integral.matrix
        return slopes

    @property
    def free(self) -> np.ndarray:
        """Which strains (6,) symmetry leaves."""
        return self.repeat.free

    def stiffness(self, by_motion: np.ndarray | None = None) -> np.ndarray:
        """Derivatives (k, k) of moment and force by the k free strains, all others held: N·mm²,
        N·mm, N. The air keeps its pressure. by_motion: derivatives (k, k) of what acts on ω and t
        by them, where they are known."""
        slopes, free = self.slopes, np.flatnonzero(self.free)
        second = np.zeros((6, 6))
        force = self._pull[3:]
        second[:3, :3] = np.einsum("a,ijab,b->ij", force, self._integral.second, self._stretched)
        second[:3, 3:] = np.einsum("a,iab->ib", force, self._integral.first)
        second[3:, :3] = second[:3, 3:].T
        of_motion = np.zeros((6, 6))
        of_motion[np.ix_(free, free)] = self._of_motion(free) if by_motion is None else by_motion
        found = self.repeat.length * (slopes.T @ of_motion @ slopes + second)
        return found[np.ix_(free, free)]

    def _of_motion(self, free: np.ndarray) -> np.ndarray:
        """Derivatives (k, k) of what acts on ω and t by them: the inverse of how far unit loads
        move them."""
        model, dofs = self._model, self.repeat.dofs[free]
        fixed = model.assembler.fixed.copy()
        model.assembler.fixed[dofs] = 0
        # Imported here: commands that solve nothing know the measures, too.
        from petsc4py import PETSc

        solve = PETSc.KSP().create(model.comm)
        try:
            solve.setOperators(model.tangent(self._state))
            solve.setType(PETSc.KSP.Type.PREONLY)
            solve.getPC().setType(PETSc.PC.Type.CHOLESKY)
            solve.getPC().setFactorSolverType("mumps")
            right, answer = (model.unknowns.create_vector() for _ in range(2))
            moved = []
            for dof, scale in zip(dofs, self.repeat.scale[free], strict=True):
                right.setArray(scale * (np.arange(model.unknowns.owned) == dof))
                solve.solve(right, answer)
                moved.append(answer.getArray()[dofs] * self.repeat.scale[free])
        finally:
            solve.destroy()
            model.assembler.fixed[:] = fixed
        return model.mesh.layout.copies * np.linalg.inv((moved + np.transpose(moved)) / 2)
