"""Rotations in space."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np


def rotation_about(axis: Sequence[float] | np.ndarray, degrees: float) -> np.ndarray:
    """Rotation matrix (3, 3) about a direction, of any length (Rodrigues)."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.deg2rad(degrees)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


class RotationVector:
    """The rotation R = exp([ω]×) by a rotation vector ω (3,), radians, less than a full turn.

    matrix: (3, 3). first: (3, 3, 3), derivatives of R by ω_i. second: (3, 3, 3, 3), by ω_i and ω_j.
    With s = |ω|² and K = [ω]×, R = I + a(s) K + b(s) K²; a and b are series in s without a
    singularity at 0. integral: instead of R its mean V = ∫₀¹ exp(τ [ω]×) dτ on the way: a rod that
    is bent and stretched alike all along, with the strain s in its own frame, ends at V s.
    """

    def __init__(self, vector: np.ndarray, integral: bool = False):
        cross, unit = cross_with(vector), UNIT
        s, square = float(vector @ vector), cross @ cross
        (a, a1, a2), (b, b1, b2) = (SERIES @ s ** np.arange(TERMS))[integral : integral + 2]
        mixed = unit @ cross + cross @ unit  # derivatives of K² by ω_i
        pairs = np.einsum("iab,jbc->ijac", unit, unit)
        both = np.einsum("i,jab->ijab", vector, unit), np.einsum("i,jab->ijab", vector, mixed)
        eye, outer = np.eye(3)[:, :, None, None], np.outer(vector, vector)[:, :, None, None]
        self.matrix = np.eye(3) + a * cross + b * square
        along = vector[:, None, None]
        self.first = a * unit + b * mixed + 2 * along * (a1 * cross + b1 * square)
        self.second = (
            b * (pairs + pairs.swapaxes(0, 1))
            + 2 * a1 * (both[0] + both[0].swapaxes(0, 1))
            + 2 * b1 * (both[1] + both[1].swapaxes(0, 1))
            + (2 * a1 * eye + 4 * a2 * outer) * cross
            + (2 * b1 * eye + 4 * b2 * outer) * square
        )


def cross_with(v: np.ndarray) -> np.ndarray:
    """Matrices (..., 3, 3) of w -> v × w, of vectors (..., 3)."""
    out = np.zeros((*v.shape, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[..., j, k] = -v[..., i]
        out[..., k, j] = v[..., i]
    return out


def _series(first: int) -> list[np.ndarray]:
    """Coefficients of Σ (−s)^k / (2k + first)! and of its first two derivatives."""
    terms = [(-1) ** k / math.factorial(2 * k + first) for k in range(TERMS + 2)]
    series = np.polynomial.Polynomial(terms)
    return [series.deriv(order).coef[:TERMS] for order in range(3)]


UNIT = cross_with(np.eye(3))
TERMS = 30  # exact to rounding up to s = (2π)²
# Of sin √s / √s, (1 − cos √s) / s, and the next one.
SERIES = np.array([_series(first) for first in (1, 2, 3)])
