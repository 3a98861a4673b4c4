"""Laws written as W̄ = Σ f(λ̄i) in the isochoric principal stretches.

The law gives one pure formula f. Stress and tangent are formed in the principal axes (Simo and
Taylor, CMAME 85:273, 1991) and turned back; the shear moduli between two principal directions are
divided differences, evaluated so that equal stretches are no special case and need no perturbation.
"""

from typing import Any

import numpy as np

from softact.materials.base import Law, Material
from softact.materials.eigen import Vector, eigen_system
from softact.materials.jets import Exponential, Number
from softact.materials.kernel import (
    VOIGT,
    Tangent,
    Tensor,
    by_chunks,
    components,
    sum_of_products,
)

# Below this difference of logarithmic stretches a divided difference comes from its Hermite
# expansion (relative error under 1e-12 at the switch), above it from the quotient.
NEAR = 1e-3


class StretchLaw(Law):
    """A law with one formula ``stretch_energy(k, stretch)``, zero at a stretch of 1."""

    @staticmethod
    def stretch_energy(k: Any, stretch: Number) -> Number:
        """Return f(λ̄) in MPa; k holds the constants by name; float, array or series alike."""
        raise NotImplementedError

    @property
    def shear_modulus(self) -> float:
        """½ d²f/d(ln λ)² at λ = 1, in MPa."""
        return float(0.5 * self.stretch_energy(self, Exponential(np.zeros(1))).terms[2][0])

    def material(self) -> "StretchMaterial":
        """Return what the solver evaluates."""
        return StretchMaterial(self)


class StretchMaterial(Material):
    """Stress and tangent of a stretch law."""

    law: StretchLaw

    def __init__(self, law: StretchLaw):
        super().__init__(law)

    def energy(self, C: np.ndarray, fibres: np.ndarray | None = None) -> np.ndarray:
        """See ``Material.energy``."""
        self.check_fibres(fibres)
        with np.errstate(all="ignore"):
            squares, _ = eigen_system(components(np.asarray(C, dtype=float)))
            scale = (squares[0] * squares[1] * squares[2]) ** (-1.0 / 6.0)
            energies = [self.law.stretch_energy(self.law, scale * np.sqrt(c)) for c in squares]
            return energies[0] + energies[1] + energies[2]

    def stress_tangent(
        self, C: np.ndarray, fibres: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """See ``Material.stress_tangent``."""
        self.check_fibres(fibres)
        return by_chunks(C, None, self._points)

    def _points(self, C: Tensor, _: list[Tensor]) -> tuple[Tensor, Tangent]:
        squares, axes = eigen_system(C)
        logs = np.log(np.stack(squares)) * 0.5
        logs -= logs.mean(axis=0)
        _, t, s, r = self.law.stretch_energy(self.law, Exponential(logs)).terms
        stress, normal, shear = _principal(squares, logs, t, s, r)
        return _turn(axes, stress, normal, shear)


def _principal(
    squares: list[np.ndarray], logs: np.ndarray, t: np.ndarray, s: np.ndarray, r: np.ndarray
) -> tuple[Vector, dict[tuple[int, int], np.ndarray], Vector]:
    """Principal stresses, the 3×3 normal moduli and the shear moduli of the pairs 12, 13, 23.

    t, s, r are df/dε, d²f/dε², d³f/dε³ at the three logarithmic stretches ε.
    """
    inverse = [1.0 / c for c in squares]
    mean_t, mean_s = t.sum(axis=0) / 3.0, s.sum(axis=0) / 9.0
    beta = [t[i] - mean_t for i in range(3)]
    stress = [beta[i] * inverse[i] for i in range(3)]
    normal = {}
    for i in range(3):
        for j in range(i, 3):
            gamma = mean_s - (s[i] + s[j]) / 3.0
            if i == j:
                gamma = gamma + s[i] - 2.0 * beta[i]
            normal[i, j] = gamma * inverse[i] * inverse[j]
    shear = []
    for i, j in ((0, 1), (0, 2), (1, 2)):
        step = logs[i] - logs[j]
        near = np.abs(step) < NEAR
        # Hermite's rule for the mean of s between the two stretches.
        rise = np.where(
            near,
            0.5 * (s[i] + s[j]) - (r[i] - r[j]) * step / 12.0,
            (t[i] - t[j]) / np.where(near, 1.0, step),
        )
        shear.append((rise * _log_slope(step) * 0.5 * inverse[j] - beta[j] * inverse[j]
                      ) * inverse[i])  # fmt: skip
    return stress, normal, shear


def _log_slope(step: np.ndarray) -> np.ndarray:
    """2 (εi − εj) cj / (ci − cj) with step = εi − εj: 1 at equal stretches."""
    return np.where(step == 0.0, 1.0, 2.0 * step / np.where(step == 0.0, 1.0, np.expm1(2.0 * step)))


def _turn(
    axes: list[Vector], stress: Vector, normal: dict[tuple[int, int], np.ndarray], shear: Vector
) -> tuple[Tensor, Tangent]:
    """Turn principal stress and moduli into the axes of the model."""
    n = [[axis[i] * axis[j] for i, j in VOIGT] for axis in axes]
    m = [
        [a[i] * b[j] + a[j] * b[i] for i, j in VOIGT]
        for a, b in ((axes[0], axes[1]), (axes[0], axes[2]), (axes[1], axes[2]))
    ]
    S = [stress[0] * n[0][a] + stress[1] * n[1][a] + stress[2] * n[2][a] for a in range(6)]
    left, right = np.empty((6, 6, len(stress[0]))), np.stack([*n, *m])
    for i in range(3):
        left[i] = normal[min(i, 0), max(i, 0)] * right[0]
        for j in (1, 2):
            left[i] += normal[min(i, j), max(i, j)] * right[j]
        left[3 + i] = shear[i] * right[3 + i]
    return S, sum_of_products(left, right)
