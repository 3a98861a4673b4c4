"""Which way a part of the user's own points: from its clamp to its tip."""

from __future__ import annotations

from typing import Literal

import numpy as np

Direction = Literal["x", "-x", "y", "-y", "z", "-z"]


def component(axis: str) -> int:
    """0, 1 or 2: the coordinate that changes along ``axis``."""
    return "xyz".index(axis[-1])


def unit(axis: str) -> tuple[float, float, float]:
    """The unit vector."""
    vector = [0.0, 0.0, 0.0]
    vector[component(axis)] = -1.0 if axis.startswith("-") else 1.0
    return (vector[0], vector[1], vector[2])


def clamp_and_tip(axis: str, low: float, high: float) -> tuple[float, float]:
    """The coordinates of clamp and tip, of a body from ``low`` to ``high``."""
    return (high, low) if axis.startswith("-") else (low, high)


def order(axis: str, low: np.ndarray, high: np.ndarray) -> tuple[float, ...]:
    """What sorts boxes from the clamp on."""
    at = component(axis)
    along = -high[at] if axis.startswith("-") else low[at]
    rest = [low[k] for k in range(3) if k != at]
    return tuple(np.round([along, *rest], 6))
