"""A rigid motion x → R x + t that is done several times, or taken back."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from softact.system.rotation import RotationVector


class Motions:
    """x → R_k x + S_k t, the motion done k times, for several whole numbers k; R = exp([ω]×).

    R_k = exp(k [ω]×), and S_k is the sum of R_j over 0 ≤ j < k, or minus that over k ≤ j < 0.
    turn: ω (3,), radians; k times it is less than a full turn. times: the numbers k, p of them.
    turns: R_k and its first and second derivatives by ω: (p, 3, 3), (p, 3, 3, 3), (p, 3, 3, 3, 3).
    sums: the same of S_k.
    """

    def __init__(self, turn: np.ndarray, times: Iterable[int]):
        wanted = [int(k) for k in times]
        low, high = min([*wanted, 0]), max([*wanted, 0])
        powers = [_power(turn, j) for j in range(low, high + 1)]
        by_order = [np.array(each) for each in zip(*powers, strict=True)]
        self.turns = tuple(each[np.subtract(wanted, low)] for each in by_order)
        self.sums = tuple(np.array([_sum(each, low, k) for k in wanted]) for each in by_order)


def _power(turn: np.ndarray, j: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """R_j and its derivatives by ω."""
    found = RotationVector(j * turn)
    return found.matrix, j * found.first, j**2 * found.second


def _sum(powers: np.ndarray, low: int, k: int) -> np.ndarray:
    """Over those of the numbers from ``low`` on that S_k, or a derivative of it, has."""
    return powers[-low : k - low].sum(axis=0) if k >= 0 else -powers[k - low : -low].sum(axis=0)
