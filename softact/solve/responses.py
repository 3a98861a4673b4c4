"""What an equilibrium answers to small forces: K⁻¹ of right-hand sides, with the exact tangent.

The factors of the last Newton step are those of a tangent nearby (8 % off in a trial), with a
stress that was carried on. They are corrected (iterative refinement) where that is quick, and else
replaced by those of the exact tangent.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softact.solve.newton import Newton
from softact.system.term import State


@dataclass(frozen=True)
class Refining:
    """accurate: ratio of the norms of what is left and of a right-hand side, at the end. costs: how
    many right-hand sides are solved in the time of one factorisation (docs/sensitivities.md)."""

    accurate: float = 1e-7
    costs: float = 25.0


REFINING = Refining()


class Responses:
    """Answers of a model's equilibria. factorised: how often new factors were made."""

    def __init__(self, newton: Newton):
        self._newton, self.factorised = newton, 0

    def __call__(self, state: State, rights: np.ndarray) -> np.ndarray:
        """K⁻¹ of right-hand sides (k, owned), zero at supports, at an equilibrium: (k, owned)."""
        newton, model = self._newton, self._newton.model
        model.tangent(state)
        factor = newton.factor
        layouts = factor.layouts
        factor.follow_layout()
        scale = np.maximum(self._norms(rights), 1e-300)
        answers, left = np.zeros_like(rights), rights
        usable = newton.has_factors and layouts == factor.layouts
        before = 1.0
        for _ in range(12):
            if not usable:
                factor.again()
                self.factorised += 1
                usable, before = True, np.inf
            answers = answers + factor.solve_all(left)
            left = rights - self._times(answers)
            error = float((self._norms(left) / scale).max(initial=0.0))
            if error <= REFINING.accurate:
                break
            if not self._worth(before, error, len(rights)):
                if before == np.inf:
                    break  # the factors are exact, and rounding is all that is left
                answers, left, usable = np.zeros_like(rights), rights, False
            before = error if before != np.inf else before
        return answers

    def _worth(self, before: float, error: float, count: int) -> bool:
        """Whether more corrections cost less than new factors."""
        if before == np.inf or not np.isfinite(error):
            return False
        rate = error / before
        if rate >= 0.5:
            return False
        rounds = np.log(REFINING.accurate / error) / np.log(rate)
        return count * rounds < REFINING.costs

    def _times(self, answers: np.ndarray) -> np.ndarray:
        """K times vectors (k, owned)."""
        model = self._newton.model
        matrix = model.assembler.matrix
        vector, product = matrix.createVecs()
        found = np.empty_like(answers)
        for row, out in zip(answers, found, strict=True):
            vector.setArray(row)
            matrix.mult(vector, product)
            out[:] = product.getArray(readonly=True)
        vector.destroy()
        product.destroy()
        return found

    def _norms(self, rows: np.ndarray) -> np.ndarray:
        return np.sqrt(self._newton.model.sum((rows**2).sum(axis=1)))
