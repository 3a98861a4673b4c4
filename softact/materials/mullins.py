"""Materials that soften once they have been stretched: Mullins' effect as pseudo-elasticity.

Ogden and Roxburgh 1999 (Proc. R. Soc. A 455:2861), with the third constant of Mars 2004 (also that
of Abaqus): below the largest isochoric energy Wₘ that a point has had, the law's isochoric stress
counts η times, η = 1 − erf(z)/r with z = (Wₘ − W)/a and a = m + β Wₘ. The energy that comes back is
∫ η dW from 0; what a point has had beyond it is lost for good. There is no permanent set.
"""

from __future__ import annotations

from typing import Self

import numpy as np
from pydantic import Field, model_validator

from softact.fields import Part, fault
from softact.units import Dimensionless, Pressure

_ROOT_PI = np.sqrt(np.pi)


class Mullins(Part, title="Mullins"):
    """Softening below the largest stretch so far (Ogden and Roxburgh), without permanent set."""

    r: Dimensionless = Field(gt=1, description="1/r of the stress is lost at most")
    m: Pressure = Field(ge=0, description="energy density over which the stress comes back")
    beta: Dimensionless = Field(0.0, ge=0, description="by how much m grows with the largest one")

    @model_validator(mode="after")
    def _has_a_width(self) -> Self:
        if self.m == 0 and self.beta == 0:
            raise fault("m and beta are both zero; one of them has to be above")
        return self

    def _width(self, peak: np.ndarray) -> np.ndarray:
        return np.maximum(self.m + self.beta * peak, 1e-300)

    def softening(self, energy: np.ndarray, peak: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """η and ∂η/∂W (n,) at energies W of points that have had Wₘ, MPa."""
        width = self._width(peak)
        below = np.maximum(peak - energy, 0.0) / width
        slope = 2 / (_ROOT_PI * self.r) * np.exp(-(below**2)) / width
        from scipy.special import erf  # not before it is needed: it takes long to load

        return 1 - erf(below) / self.r, np.where(energy < peak, slope, 0.0)

    def recoverable(self, energy: np.ndarray, peak: np.ndarray) -> np.ndarray:
        """∫ η dW (n,) from 0 to W, MPa."""
        width, peak = self._width(peak), np.maximum(peak, energy)
        gone = _integral(peak / width) - _integral((peak - energy) / width)
        return energy - width * gone / self.r

    def lost(self, peak: np.ndarray) -> np.ndarray:
        """Energy density (n,) that points which have had Wₘ do not give back, MPa."""
        return peak - self.recoverable(peak, peak)


def _integral(z: np.ndarray) -> np.ndarray:
    """∫ erf dz from 0."""
    from scipy.special import erf

    return z * erf(z) + (np.exp(-(z**2)) - 1) / _ROOT_PI
