"""Order of convergence, Richardson's estimate and error bars from values on refined meshes.

Celik et al. 2008, J. Fluids Eng. 130:078001 (grid convergence index), with three meshes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

SAFETY = 1.25  # of the grid convergence index with three meshes
NOTHING = 1e-9  # in any unit: rounding
LEAST, MOST = 0.5, 6.0  # orders outside say that the meshes are too coarse to tell one


@dataclass(frozen=True)
class Estimate:
    """What is known of one measure.

    limit: value on an infinitely fine mesh (Richardson), else the finest value. order: observed,
    None where it cannot be told. errors: (n,) error bar of each mesh, coarse to fine, in the
    measure's unit: SAFETY times the distance to the limit; where there is no order, SAFETY times
    the largest distance to any finer value, and for the finest the last change. changes: (n − 1,)
    relative change from each mesh to the next. note: why there is no order, "" where there is.
    """

    limit: float
    order: float | None
    errors: tuple[float, ...]
    changes: tuple[float, ...]
    note: str = ""


def estimate(sizes: Sequence[float], values: Sequence[float]) -> Estimate:
    """Of one measure on meshes of edge lengths ``sizes``, coarse to fine, at least two."""
    pairs = itertools.pairwise(values)
    changes = tuple(
        abs(b - a) / max(abs(b), NOTHING) if abs(b - a) > NOTHING else 0.0 for a, b in pairs
    )
    order, note = _order(sizes[-3:], values[-3:])
    if order is None:
        errors = [
            SAFETY * max(abs(v - finer) for finer in values[n + 1 :])
            for n, v in enumerate(values[:-1])
        ]
        errors.append(SAFETY * abs(values[-1] - values[-2]))
        return Estimate(values[-1], None, tuple(errors), changes, note)
    ratio = (sizes[-2] / sizes[-1]) ** order
    limit = values[-1] + (values[-1] - values[-2]) / (ratio - 1)
    return Estimate(limit, order, tuple(SAFETY * abs(v - limit) for v in values), changes)


def _order(sizes: Sequence[float], values: Sequence[float]) -> tuple[float | None, str]:
    """p with f(h) = f₀ + C hᵖ through three points, and why there is none."""
    if len(values) < 3:
        return None, "two meshes tell no order"
    first, second = values[1] - values[0], values[2] - values[1]
    if abs(second) <= NOTHING * max(abs(values[2]), 1.0):
        return None, "the last two values are the same"
    if first / second <= 0:
        return None, "the values go up and down"

    def gap(p: float) -> float:
        coarse = sizes[0] ** p - sizes[1] ** p
        return math.log(coarse / (sizes[1] ** p - sizes[2] ** p)) - math.log(first / second)

    if gap(LEAST) > 0:
        return None, f"the changes do not shrink with an order of {LEAST:g} or more"
    if gap(MOST) < 0:
        return None, f"the first change is too large for an order of {MOST:g} or less"
    from scipy.optimize import brentq

    return float(brentq(gap, LEAST, MOST)), ""
