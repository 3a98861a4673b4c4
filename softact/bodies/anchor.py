"""A solid linearised beside a state of another one, of which it differs a little."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.system.kernels import pointer
from softact.system.term import InvertedElementError

if TYPE_CHECKING:
    from softact.bodies.solid import Solid


@dataclass(frozen=True)
class Anchor:
    """A state: C (n, 6), and there the stress S (n, 6), the moduli D (n, 6, 6) and the stored
    energy (n,) of ``Solid.density``, at the quadrature points."""

    c: np.ndarray
    stress: np.ndarray
    moduli: np.ndarray
    density: np.ndarray

    def part(self, chosen: np.ndarray, points: int) -> Anchor:
        """The same of chosen cells (k,), each of which has so many points."""
        known = (self.c, self.stress, self.moduli, self.density)
        rows = (chosen[:, None] * points + np.arange(points)).ravel()
        return Anchor(*(array[rows] for array in known))

    def stress_of(self, solid: Solid, x: np.ndarray) -> np.ndarray:
        """S + D : (C − C₀)/2 (n, 6) at unknowns x (local,)."""
        known = solid.right_cauchy_green(x), self.c, self.stress, self.moduli
        return solid.at_points("linearised_stress", len(self.c), *known)

    def density_of(self, solid: Solid, x: np.ndarray) -> np.ndarray:
        """Stored energy (n,) of ``stress_of``."""
        known = solid.right_cauchy_green(x), self.c, self.stress, self.moduli
        return self.density + solid.at_points("energy_beside", len(self.c), *known, entries=1)[:, 0]

    def add_force(self, solid: Solid, x: np.ndarray, out: np.ndarray) -> None:
        """Add the force of ``stress_of`` to ``out`` (local,), in one loop.

        Raises InvertedElementError.
        """
        values = solid.pressure_values
        smallest = solid.assembler.library.force_beside(
            *solid.loop(x),
            pointer(solid.weights),
            0 if values is None else values.shape[1],
            None if values is None else pointer(values),
            *map(ctypes.c_double, solid.constants() or [0.0, 0.0]),
            *map(pointer, (self.c, self.stress, self.moduli)),
            pointer(out),
        )
        if not smallest > 0.0:
            raise InvertedElementError
