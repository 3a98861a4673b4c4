"""``GreenLaw`` in a sheet, with fine wrinkles or without, compiled: the law of woven fabric.

With the principal strains e1 ≥ e2 of the Green strain it is wrinkled where e1 > 0 and e2 < −ν e1,
and its stress there E e1 along the first direction: the closed form of ``TensionField``.
"""

from __future__ import annotations

import ctypes

import numpy as np

from softact.materials.plane_stress import GreenLaw, Response
from softact.materials.tension_field import KEPT
from softact.system.kernels import pointer
from softact.system.triangle_loops import library


class GreenSheet:
    """Plane-stress St. Venant-Kirchhoff, see ``GreenLaw``."""

    relaxed, kept = False, KEPT

    def __init__(self, law: GreenLaw):
        self.law = law
        self._constants = ctypes.c_double(law.young), ctypes.c_double(law.poisson)

    def evaluate(self, c: np.ndarray) -> Response:
        """See ``SheetLaw``."""
        count, c = len(c), np.ascontiguousarray(c, dtype=float)
        energy, stress, moduli = np.empty(count), np.empty((count, 3)), np.empty((count, 3, 3))
        library().green_response(
            ctypes.c_int64(count),
            pointer(c),
            *self._constants,
            ctypes.c_int32(self.relaxed),
            ctypes.c_double(self.kept),
            *map(pointer, (energy, stress, moduli)),
        )
        return energy, stress, moduli


class GreenTensionField(GreenSheet):
    """The relaxed form of it: (1 − kept) W_r + kept W."""

    relaxed = True

    def __init__(self, law: GreenLaw, kept: float = KEPT):
        super().__init__(law)
        self.kept = kept

    def state(self, c: np.ndarray) -> np.ndarray:
        """TAUT, WRINKLED or SLACK (n,)."""
        states, c = np.empty(len(c), np.int64), np.ascontiguousarray(c, dtype=float)
        count, poisson = ctypes.c_int64(len(c)), self._constants[1]
        library().green_states(count, pointer(c), poisson, pointer(states))
        return states
