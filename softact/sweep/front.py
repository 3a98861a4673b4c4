"""Points that none beats, by one measure or by several."""

from __future__ import annotations

import numpy as np

_BLOCK = 256  # points that are held against all others at a time


def unbeaten(values: np.ndarray) -> np.ndarray:
    """Numbers (k,) of the rows of ``values`` (n, m) that none beats; more is better in each of the
    m. A row beats another that it is nowhere worse than, and better once."""
    found = [np.zeros(0, int)]
    for first in range(0, len(values), _BLOCK):
        block = values[first : first + _BLOCK, None]
        beaten = (values[None] >= block).all(axis=2) & (values[None] > block).any(axis=2)
        found.append(first + np.flatnonzero(~beaten.any(axis=1)))
    return np.concatenate(found)


def best(values: np.ndarray, count: int) -> list[int]:
    """``count`` rows of ``values`` (n, m), or all: those of the front of what none beats, spread
    evenly over it where it has more; then of the front of what is left, and so on."""
    chosen: list[int] = []
    left = np.arange(len(values))
    while len(left) and len(chosen) < count:
        front = left[unbeaten(values[left])]
        front = front[np.argsort(-values[front, 0], kind="stable")]
        wanted = min(count - len(chosen), len(front))
        places = np.linspace(0, len(front) - 1, wanted).round().astype(int)
        chosen += front[places].tolist()
        left = np.setdiff1d(left, front)
    return chosen
