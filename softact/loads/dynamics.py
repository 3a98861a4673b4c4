"""Time integration of bodies with inertia: the constants of the generalised-alpha method.

J. Chung, G. M. Hulbert, "A time integration algorithm for structural dynamics with improved
numerical dissipation: the generalized-α method", J. Appl. Mech. 60 (1993) 371.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Dynamics:
    """Inertia in a step. spectral_radius: ρ∞ from 0 to 1, the part of a motion far above the
    resolved frequencies that is left after an increment; 1 damps nothing."""

    spectral_radius: float = 0.8

    @property
    def alpha_m(self) -> float:
        """Weight of the last acceleration (equation 25 of Chung and Hulbert)."""
        return (2 * self.spectral_radius - 1) / (self.spectral_radius + 1)

    @property
    def alpha_f(self) -> float:
        """Weight of the last forces (equation 25)."""
        return self.spectral_radius / (self.spectral_radius + 1)

    @property
    def gamma(self) -> float:
        """Newmark's γ: of second order (equation 17)."""
        return 0.5 - self.alpha_m + self.alpha_f

    @property
    def beta(self) -> float:
        """Newmark's β: damps high frequencies the most (equation 20)."""
        return (1 - self.alpha_m + self.alpha_f) ** 2 / 4
