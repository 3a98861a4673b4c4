"""A row of chambers with walls and gaps between them: where each begins and ends, and how high it
reaches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from softact.geometry.boxes import SAME_PLANE

_USUAL_GAP, _USUAL_CHAMBER = 1.0, 6.0  # mm, where the lengths that are given leave them open


@dataclass(frozen=True)
class Row:
    """How equal chambers divide the length of a finger, mm."""

    chamber_length: float
    gap: float
    pitch: float
    length: float


@dataclass(frozen=True)
class Block:
    """A chamber with its walls, mm: where it begins and ends along x, where its air space does, and
    how high that and its roof reach."""

    outside: tuple[float, float]
    hollow: tuple[float, float]
    ceiling: float
    top: float


def divided(
    count: int,
    ends: float,
    walls: float,
    chamber: float | None,
    gap: float | None,
    pitch: float | None,
    length: float | None,
) -> Row:
    """Chamber length, gap, pitch and overall length, mm, from whichever of them are given.

    ends: length of both plugs. walls: of the two walls between neighbours.
    """
    if gap is None and (chamber is None) + (pitch is None) + (length is None) > 1:
        gap = _USUAL_GAP
    if chamber is None and pitch is None and length is None:
        chamber = _USUAL_CHAMBER
    if chamber is None:
        if gap is None:  # or it would have got its default
            assert pitch is not None and length is not None
            chamber = length - ends - (count - 1) * pitch
        elif pitch is not None:
            chamber = pitch - walls - gap
        else:
            assert length is not None
            chamber = (length - ends - (count - 1) * (walls + gap)) / count
    if gap is None:
        if pitch is not None:
            gap = pitch - walls - chamber
        else:
            assert length is not None
            gap = (length - ends - count * chamber) / max(count - 1, 1) - walls
    pitch = chamber + walls + gap
    return Row(chamber, gap, pitch, ends + chamber + (count - 1) * pitch)


def blocks(
    plugs: tuple[float, float],
    floor: float,
    lengths: Sequence[float],
    inner: Sequence[float],
    gaps: Sequence[float],
    heights: Sequence[float],
    roofs: Sequence[float],
) -> list[Block]:
    """The chambers (n), each with its walls; the ends belong to the first and the last. All in mm;
    gaps has n − 1, and the other lists n."""
    found, at, wall, last = [], 0.0, plugs[0], len(lengths) - 1
    for i, length in enumerate(lengths):
        start, end = at + wall, at + wall + length
        after = inner[i] if i < last else plugs[1]
        ceiling = floor + heights[i]
        found.append(Block((at, end + after), (start, end), ceiling, ceiling + roofs[i]))
        at = end + after + (gaps[i] if i < last else 0.0)
        wall = inner[i + 1] if i < last else 0.0
    return found


def areas(row: Sequence[Block], floor: float, bridge: float) -> tuple[float, float, float]:
    """Area of the row's side, mm², of its air space there, and the way between chambers, mm.
    bridge: height of what joins neighbours."""
    area = sum((b.outside[1] - b.outside[0]) * b.top for b in row)
    area += sum((two.outside[0] - one.outside[1]) * bridge for one, two in pairwise(row))
    air = sum((b.hollow[1] - b.hollow[0]) * (b.ceiling - floor) for b in row)
    return area, air, sum(two.hollow[0] - one.hollow[1] for one, two in pairwise(row))


def lifted(
    points: np.ndarray, row: Sequence[Block], low: float, ceiling: float, top: float
) -> np.ndarray:
    """Points (n, 3), mm, of chambers that all reach to ``ceiling`` and ``top``, at the heights
    of their own chambers; what lies below ``low`` stays."""
    x, z = points[:, 0], points[:, 2].copy()
    for block in row:
        here = (x > block.outside[0] - SAME_PLANE) & (x < block.outside[1] + SAME_PLANE)
        above = here & (z > low)
        z[above] = np.interp(z[above], [low, ceiling, top], [low, block.ceiling, block.top])
    return np.column_stack([points[:, :2], z])
