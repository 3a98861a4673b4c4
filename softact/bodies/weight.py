"""Gravity on a body, as a term of the potential energy."""

from __future__ import annotations

import numpy as np

from softact.system.term import EVERYTHING, Origin, State


class Weight:
    """Gravity on a body; unit: nodal forces (3, local) N of 1 mm/s² along x, y and z."""

    def __init__(self, unit: np.ndarray):
        self._unit = unit

    @property
    def mass(self) -> float:
        """Of this process's part of the body, tonne: what all nodes weigh at 1 mm/s²."""
        return float(self._unit[0].sum())

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        gravity = state["gravity"].get(EVERYTHING)
        if gravity is not None and np.any(gravity):
            out -= gravity @ self._unit

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """The weight does not depend on the displacement."""

    def energy(self, state: State) -> float:
        """See ``Term``."""
        gravity = state["gravity"].get(EVERYTHING)
        return 0.0 if gravity is None else -float(gravity @ self._unit @ state.x)
