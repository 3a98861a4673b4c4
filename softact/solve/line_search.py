"""How far to go along a step of Newton's method where forces have kinks.

(Crisfield, Non-linear Finite Element Analysis of Solids and Structures, 1991, section 9.2.)
"""

from __future__ import annotations

import math
from collections.abc import Callable

# A search ends when the slope has fallen to this part, or after so many evaluations.
SLACKENED, SEARCHES = 0.8, 5
# Part of the bracket that a new place keeps off its ends.
NEAREST = 0.1


def part_of_step(slope: Callable[[float], float], part: float) -> float:
    """Part of a step, at most ``part``, at which the energy's slope along it has fallen to
    ``SLACKENED`` of what it is before; else that with the smallest one that was seen.

    slope: of the energy, at parts of the step; not finite where an element is inverted. Where it
    has changed its sign the place is sought by false position between one short of it and one
    beyond; an end that stays counts half each time, so that it moves, too (Illinois method).
    """
    first = slope(0.0)
    if not first:
        return part
    low, high = (0.0, 1.0), (part, 0.0)  # parts before and beyond it; 0: none beyond is known
    seen: dict[float, float] = {}
    while len(seen) < SEARCHES:
        ratio = slope(part) / first
        seen[part] = abs(ratio) if math.isfinite(ratio) else math.inf
        if not math.isfinite(ratio):
            ratio = -1.0
        if seen[part] <= SLACKENED or (ratio > 0 and not high[1]):
            break
        if ratio > 0:
            low, high = (part, ratio), (high[0], 0.5 * high[1])
        else:
            low, high = (low[0], (0.5 if high[1] else 1.0) * low[1]), (part, ratio)
        to = low[1] / (low[1] - high[1])
        part = low[0] + min(max(to, NEAREST), 1 - NEAREST) * (high[0] - low[0])
    return min(seen, key=lambda t: seen[t])
