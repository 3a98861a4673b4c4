"""Laws of invariants in sheets of constant volume, compiled: those of knits.

The same as ``IncompressibleLaw`` and its ``TensionField``, point by point in C. The formula is the
law's own, see ``softact.materials.traced``.
"""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path

import numpy as np

from softact.materials import tension_field
from softact.materials.invariants import InvariantLaw
from softact.materials.plane_stress import Response
from softact.materials.traced import formula_in_c
from softact.system import jit
from softact.system.kernels import pointer

_NAMES = "MOST_ITERATIONS", "TOLERANCE", "FLOOR", "ROUNDING", "NOISE"


@functools.cache
def _library(formula: str) -> ctypes.CDLL:
    defined = [f"#define {name} {getattr(tension_field, name)!r}" for name in _NAMES]
    source = Path(__file__).with_name("_invariant_sheet.c").read_text(encoding="utf-8")
    text = "\n".join(["#include <math.h>", "#include <stdint.h>", *defined, formula, source])
    return jit.load_text("invariant_sheet", text)


class InvariantSheet:
    """A law at constant volume; fibres: (n, families, 3) in the sheet's frame and plane, or None.
    poisson: of the undeformed sheet, for where wrinkles are sought."""

    kept = 1.0

    def __init__(self, law: InvariantLaw, fibres: np.ndarray | None, poisson: float = 0.5):
        families = 0 if fibres is None else fibres.shape[1]
        formula, self._constants = formula_in_c(law, families)
        self._functions = _library(formula)
        self._poisson = poisson
        along = np.zeros((0, 0, 3)) if fibres is None else np.asarray(fibres, dtype=float)
        one, two = along[..., 0], along[..., 1]
        self._fibres = np.ascontiguousarray(np.stack([one**2, two**2, one * two], axis=-1))

    def evaluate(self, c: np.ndarray) -> Response:
        """See ``SheetLaw``; not finite where det C ≤ 0."""
        count, c = len(c), np.ascontiguousarray(c, dtype=float)
        energy, stress, moduli = np.empty(count), np.empty((count, 3)), np.empty((count, 3, 3))
        self._functions.sheet_response(
            *self._at(c),
            ctypes.c_double(self._poisson),
            ctypes.c_double(self.kept),
            *map(pointer, (energy, stress, moduli)),
        )
        return energy, stress, moduli

    def _at(self, c: np.ndarray) -> tuple[ctypes.c_int64 | ctypes.c_void_p, ...]:
        return ctypes.c_int64(len(c)), *map(pointer, (c, self._fibres, self._constants))


class InvariantTensionField(InvariantSheet):
    """The relaxed form of it: (1 − kept) W_r + kept W."""

    def __init__(
        self,
        law: InvariantLaw,
        fibres: np.ndarray | None,
        poisson: float,
        kept: float = tension_field.KEPT,
    ):
        super().__init__(law, fibres, poisson)
        self.kept = kept

    def state(self, c: np.ndarray) -> np.ndarray:
        """TAUT, WRINKLED or SLACK (n,)."""
        states, c = np.empty(len(c), np.int64), np.ascontiguousarray(c, dtype=float)
        self._functions.sheet_states(*self._at(c), pointer(states))
        return states
