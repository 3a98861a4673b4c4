"""What an equilibrium answers to small forces, by the factors of a tangent.

Those of the last Newton step are there already. They are of a state a little before it (8 % off in
a trial), with a stress that was carried on; who uses them corrects what they give, or asks for
those of the tangent at the equilibrium itself.
"""

from __future__ import annotations

import numpy as np

from softact.solve.newton import Newton
from softact.system.term import State


class Responses:
    """Answers of one equilibrium."""

    def __init__(self, newton: Newton, state: State):
        self._newton, self._state = newton, state
        if not newton.has_factors:
            self.renew()

    def renew(self) -> None:
        """Factorise the tangent of the equilibrium."""
        self._newton.model.tangent(self._state)
        self._newton.factor.follow_layout()
        self._newton.factor.again()

    def __call__(self, forces: np.ndarray) -> np.ndarray:
        """Unknowns (k, local) that the factors give for forces (k, owned), zero at supports."""
        unknowns = self._newton.model.unknowns
        vector = unknowns.create_vector()
        found = np.empty((len(forces), unknowns.local))
        for answer, out in zip(self._newton.factor.solve_all(forces), found, strict=True):
            vector.setArray(answer)
            out[:] = unknowns.to_local(vector)
        vector.destroy()
        return found
