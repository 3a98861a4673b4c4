"""Thick spheres and tubes of an incompressible material under pressure inside: exact.

Ogden, Non-linear Elastic Deformations, 1984, sections 5.3.2 and 5.3.3.
"""

from __future__ import annotations

import numpy as np

from softact.estimate.uniaxial import matrix
from softact.materials import Law

POINTS = 201
#: Stretches at the inside that are tried; the pressure is followed up to its first maximum.
MOST_STRETCH, STEPS = 6.0, 240


def _energy(law: Law, stretches: np.ndarray) -> np.ndarray:
    """(...,) MPa at principal stretches (..., 3)."""
    flat = stretches.reshape(-1, 3)
    C = np.zeros((len(flat), 3, 3))
    C[:, range(3), range(3)] = flat**2
    return matrix(law).material().energy(C).reshape(stretches.shape[:-1])


def _slope(law: Law, stretches: np.ndarray, change: np.ndarray) -> np.ndarray:
    """Derivative of the energy along a change of the stretches."""
    step = 1e-5
    ahead, behind = _energy(law, stretches + step * change), _energy(law, stretches - step * change)
    return (ahead - behind) / (2 * step)


def sphere_pressure(law: Law, inner: float, outer: float, stretch: np.ndarray) -> np.ndarray:
    """(n,) MPa in a sphere whose inside is stretched by ``stretch``.

    p = ∫ dW(s, s, s⁻²)/ds /(s³ − 1) ds from the outside's stretch to the inside's.
    """
    a = np.asarray(stretch, float)[:, None]
    b = np.cbrt(1 + (a**3 - 1) * (inner / outer) ** 3)
    s, weight = _between(b, a)
    along = np.stack([s, s, s**-2.0], axis=-1)
    change = np.stack([np.ones_like(s), np.ones_like(s), -2 * s**-3.0], axis=-1)
    return (weight * _slope(law, along, change) / (s**3 - 1)).sum(axis=1)


def tube_pressure(
    law: Law, inner: float, outer: float, stretch: np.ndarray, axial: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(n,) MPa in a tube with stretches at the inside and along it, and (n,) N that pull it.

    p = ∫ dW/ds /(s² l − 1) ds with W(s, l, 1/(s l)); the pull is the mean axial stress times the
    section, with no pressure on the ends.
    """
    a, along = np.asarray(stretch, float)[:, None], np.asarray(axial, float)[:, None]
    b = np.sqrt((1 + (a**2 * along - 1) * (inner / outer) ** 2) / along)
    s, weight = _between(b, a)
    along = np.broadcast_to(along, s.shape)
    state = np.stack([s, along, 1 / (s * along)], axis=-1)
    nothing = np.zeros_like(s)
    hoop = _slope(law, state, np.stack([np.ones_like(s), nothing, -1 / (s**2 * along)], axis=-1))
    pull = _slope(law, state, np.stack([nothing, np.ones_like(s), -1 / (s * along**2)], axis=-1))
    parts = weight * hoop / (s**2 * along - 1)
    pressure = parts.sum(axis=1)
    # Radial stress from the outside in: minus what the wall beyond a radius carries.
    radial = -(np.cumsum(parts, axis=1) - parts / 2)
    # R² − r² l is the same all along: R² = A² (a² l − 1)/(s² l − 1).
    reference = inner**2 * (a**2 * along - 1) / (s**2 * along - 1)
    radius = s * np.sqrt(reference)
    # dr/ds along the wall, R being a function of s: r² = s² R².
    rate = np.abs(s * reference - s**3 * along * reference / (s**2 * along - 1)) / radius
    area = 2 * np.pi * radius * rate * weight
    return pressure, ((radial + along * pull) * area).sum(axis=1)


def _between(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, POINTS) from low to high (n, 1), in order, and their weights."""
    edges = np.linspace(0.0, 1.0, POINTS + 1)
    middle = (edges[1:] + edges[:-1]) / 2
    return low + (high - low) * middle, np.broadcast_to((high - low) / POINTS, (len(low), POINTS))


def inner_stretches() -> np.ndarray:
    """(STEPS,) from just above 1, closer together there."""
    return 1 + (MOST_STRETCH - 1) * (np.arange(1, STEPS + 1) / STEPS) ** 2


def rising(pressure: np.ndarray) -> int:
    """Number of values up to the first maximum."""
    falls = np.flatnonzero(np.diff(pressure) <= 0)
    return int(falls[0]) + 1 if len(falls) else len(pressure)
