"""Least squares behind the reduced model: a smooth function of the pressure, and a compliance.

A strain of the rod under loads is w = w₀(p) + c(p) Q: w₀ a spline through knots, c(p) a compliance,
Q the mean moment or force in the rod. Both are linear in what is sought.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

MOST_KNOTS = 12
DENSE = 200
#: A compliance is known where the loads move the strain by this much, apart from what a function of
#: the pressure alone could explain (radians over the rod, or stretch), and by this many of its
#: standard errors.
SEEN, CERTAIN = 5e-3, 8.0
#: A further term of c(p) has to take away this part of what was left.
WORTH = 0.15
HIGHEST_DEGREE = 2


@dataclass(frozen=True)
class Curve:
    """A function of the pressure through knots, monotone between them where its knots are."""

    knots: np.ndarray
    values: np.ndarray

    def __call__(self, pressure: np.ndarray) -> np.ndarray:
        if len(self.knots) < 4:
            return basis(self.knots, pressure) @ self.values
        spline = CubicSpline(self.knots, self.values)
        slopes = spline(np.linspace(self.knots[0], self.knots[-1], DENSE), 1)
        steps = np.diff(self.values)
        for sign in (1.0, -1.0):
            if (sign * steps >= 0).all() and (sign * slopes < 0).any():
                return PchipInterpolator(self.knots, self.values)(pressure)
        return spline(pressure)


@dataclass(frozen=True)
class Compliance:
    """c(p) = Σ terms (p/largest)ⁱ; empty terms: the loads of the runs do not tell it."""

    terms: tuple[float, ...]
    largest: float

    def __call__(self, pressure: np.ndarray) -> np.ndarray:
        part = np.asarray(pressure, float) / self.largest
        return sum((term * part**i for i, term in enumerate(self.terms)), np.zeros_like(part))


def knots_of(pressure: np.ndarray) -> np.ndarray:
    """At most ``MOST_KNOTS`` pressures, as the states lie, the first and the last among them."""
    distinct = np.unique(np.round(pressure, 6))
    count = min(MOST_KNOTS, max(2, (len(distinct) + 1) // 2 + 1), len(distinct))
    places = np.linspace(0, len(distinct) - 1, count)
    return np.interp(places, np.arange(len(distinct)), distinct)


def basis(knots: np.ndarray, pressure: np.ndarray) -> np.ndarray:
    """(states, knots) weights of the values at knots in a spline."""
    if len(knots) == 1:
        return np.ones((len(pressure), 1))
    if len(knots) < 4:
        return np.stack([np.interp(pressure, knots, row) for row in np.eye(len(knots))], axis=1)
    return CubicSpline(knots, np.eye(len(knots)))(pressure)


def curve(pressure: np.ndarray, values: np.ndarray) -> Curve:
    """The smooth function of the pressure nearest to values."""
    knots = knots_of(pressure)
    return Curve(knots, np.linalg.lstsq(basis(knots, pressure), values, rcond=None)[0])


def strain(
    pressure: np.ndarray, values: np.ndarray, loads: np.ndarray, length: float
) -> tuple[Curve, Compliance]:
    """w₀(p) and c(p) of values (states,) under loads (states,).

    length: by which a strain is multiplied to get what is seen, mm (1 for a stretch).
    """
    knots, largest = knots_of(pressure), float(np.abs(pressure).max())
    splines = basis(knots, pressure)
    best, residual = None, None
    for degree in range(HIGHEST_DEGREE + 1):
        columns = np.column_stack([loads * (pressure / largest) ** i for i in range(degree + 1)])
        terms, left = _terms(splines, columns, values, length)
        if terms is None:
            break
        found = Compliance(tuple(terms), largest)
        if (found(np.linspace(pressure.min(), pressure.max(), 21)) <= 0).any():
            break
        if residual is not None and left > (1 - WORTH) * residual:
            break
        best, residual = found, left
    best = best or Compliance((), largest)
    rest = np.linalg.lstsq(splines, values - best(pressure) * loads, rcond=None)[0]
    return Curve(knots, rest), best


def _terms(
    splines: np.ndarray, columns: np.ndarray, values: np.ndarray, length: float
) -> tuple[np.ndarray | None, float]:
    """Factors of ``columns``, None where they are not known; and the root mean square left."""
    onto = np.linalg.qr(splines)[0]

    def apart(part: np.ndarray) -> np.ndarray:
        return part - onto @ (onto.T @ part)

    own, target = apart(columns), apart(values)
    freedom = len(values) - splines.shape[1] - columns.shape[1]
    if (
        freedom < 1
        or np.linalg.matrix_rank(own, tol=1e-9 * np.abs(columns).max(initial=1e-300))
        < (columns.shape[1])
    ):
        return None, 0.0
    terms = np.linalg.lstsq(own, target, rcond=None)[0]
    left = target - own @ terms
    spread = np.sqrt(left @ left / freedom * np.diag(np.linalg.inv(own.T @ own)))
    seen = np.ptp(own @ terms) * length
    if seen < SEEN or abs(terms[0]) < CERTAIN * spread[0]:
        return None, 0.0
    return terms, float(np.sqrt(left @ left / len(left)))
