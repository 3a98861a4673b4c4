"""Drucker stability of a law: does more stretch always need more stress, in every mode?"""

from dataclasses import dataclass

import numpy as np

from softact.fit.candidates import Constants
from softact.fit.modes import MODES, sheet_energy
from softact.materials import Law

# Searched in every mode; a law that is stable as far as this is called stable throughout.
SMALLEST, LARGEST = 0.1, 10.0


@dataclass(frozen=True)
class Stability:
    """Range of stretch in which a law is stable in one mode; None: no end within the search."""

    mode: str
    below: float | None
    above: float | None

    def fails_within(self, low: float, high: float) -> float | None:
        """Return the stretch nearest to 1 at which the law fails between ``low`` and ``high``."""
        failures = []
        if self.below is not None and self.below > low:
            failures.append(self.below)
        if self.above is not None and self.above < high:
            failures.append(self.above)
        return min(failures, key=lambda s: abs(np.log(s))) if failures else None


def drucker(law: type[Law] | Law, k: Constants) -> list[Stability]:
    """Return where a law is stable in uniaxial, equibiaxial and planar deformation.

    Stable: the matrix d(σ1, σ2)/d(ε1, ε2) of Cauchy stress and logarithmic strain in plane stress
    is positive definite (incompressible; Abaqus Theory Guide, Drucker's postulate). A stretch at
    which the law has no value ends the range too.
    """
    return [_range(law, k, mode) for mode in MODES]


def _range(law: type[Law] | Law, k: Constants, mode: str) -> Stability:
    powers = MODES[mode].powers
    # Start a hair off the undeformed state, where some laws have no second derivative.
    up = np.concatenate([[1e-4], np.linspace(0.005, np.log(LARGEST), 460)])
    down = -np.concatenate([[1e-4], np.linspace(0.005, -np.log(SMALLEST), 460)])
    return Stability(mode, _first_failure(law, k, powers, down), _first_failure(law, k, powers, up))


def _is_stable(
    law: type[Law] | Law, k: Constants, powers: tuple[float, float, float], log: np.ndarray
) -> np.ndarray:
    with np.errstate(all="ignore"):
        energy = sheet_energy(law, k, (powers[0] * log, powers[1] * log))
        a = energy.hessian.get((0, 0), 0.0)
        b = energy.hessian.get((0, 1), 0.0)
        c = energy.hessian.get((1, 1), 0.0)
        # Where one stiffness dwarfs the other the determinant is rounding: let that pass.
        return np.isfinite(energy.value) & (a > 0) & (c > 0) & (a * c - b * b > -1e-10 * a * c)


def _first_failure(
    law: type[Law] | Law, k: Constants, powers: tuple[float, float, float], path: np.ndarray
) -> float | None:
    failed = np.flatnonzero(~_is_stable(law, k, powers, path))
    if not len(failed):
        return None
    i = int(failed[0])
    if i == 0:
        return 1.0
    good, bad = path[i - 1], path[i]
    for _ in range(40):
        middle = 0.5 * (good + bad)
        if _is_stable(law, k, powers, np.array([middle]))[0]:
            good = middle
        else:
            bad = middle
    return float(np.exp(good))
