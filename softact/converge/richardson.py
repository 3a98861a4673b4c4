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
SAME = 1e-5  # relative: values on three meshes that differ by less have no order and need none
#: A mesh is finer than another one where its cells are smaller by this ratio: a third more of them.
FINER = 1.1
#: Orders outside tell nothing: the meshes are too coarse, or the values agree by chance. What a
#: quadratic element computes converges with an order of four at best.
LEAST, MOST = 0.5, 4.5


@dataclass(frozen=True)
class Estimate:
    """What is known of one measure.

    limit: value on an infinitely fine mesh (Richardson); None where it is not known. order:
    observed, None where it cannot be told. errors: (n,) error bar of each mesh, coarse to fine, in
    the measure's unit: SAFETY times the distance to the limit; None where that is not known.
    changes: (n,) relative change from the last mesh before that counts; None of the first one and
    of those that do not count. note: why there is no order, "" where there is.
    """

    limit: float | None
    order: float | None
    errors: tuple[float | None, ...]
    changes: tuple[float | None, ...]
    note: str = ""

    @property
    def last_change(self) -> float | None:
        """From the second finest to the finest mesh that counts."""
        return next((c for c in reversed(self.changes) if c is not None), None)


def counting(sizes: Sequence[float]) -> list[int]:
    """Numbers of the meshes that count: the first one, and each that is finer than the last one
    before it that counts. sizes: edge lengths, coarse to fine."""
    found = [0]
    for number, size in enumerate(sizes):
        if size * FINER <= sizes[found[-1]] * (1 + NOTHING):
            found.append(number)
    return found


def estimate(sizes: Sequence[float], values: Sequence[float]) -> Estimate:
    """Of one measure on meshes of edge lengths ``sizes``, coarse to fine."""
    meshes = counting(sizes)
    changes: list[float | None] = [None] * len(values)
    for before, after in itertools.pairwise(meshes):
        changes[after] = change(values[before], values[after])
    last = meshes[-3:]
    order, limit, note = _limit([sizes[n] for n in last], [values[n] for n in last])
    errors = [None if limit is None else SAFETY * abs(v - limit) for v in values]
    return Estimate(limit, order, tuple(errors), tuple(changes), note)


def change(before: float, after: float) -> float:
    """Relative change from one value to another, 0 where they differ by rounding only."""
    difference = abs(after - before)
    return difference / max(abs(after), NOTHING) if difference > NOTHING else 0.0


def _limit(
    sizes: Sequence[float], values: Sequence[float]
) -> tuple[float | None, float | None, str]:
    """Order and limit of values on up to three meshes, and why they are not known."""
    if len(values) < 3:
        few = {1: "no mesh is finer than the first one", 2: "two meshes tell no order"}
        return None, None, few[len(values)]
    if max(values) - min(values) <= max(NOTHING, SAME * abs(values[-1])):
        return None, values[-1], "the same on three meshes"
    order, note = _order(sizes, values)
    if order is None:
        return None, None, note
    ratio = (sizes[-2] / sizes[-1]) ** order
    return order, values[-1] + (values[-1] - values[-2]) / (ratio - 1), ""


def _order(sizes: Sequence[float], values: Sequence[float]) -> tuple[float | None, str]:
    """p with f(h) = f₀ + C hᵖ through three points, and why there is none."""
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
