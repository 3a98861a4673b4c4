"""What was found at the last few states."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np

Found = TypeVar("Found")
# States that are kept: those of a quadratic extrapolation, and the one it leads to.
COUNT = 4


class LastFew(Generic[Found]):
    """What a function of the unknowns, and of what a key tells, said at the last ``count`` states
    at which it was asked."""

    def __init__(self, count: int = COUNT):
        self._count = count
        self._known: list[tuple[bytes, bytes, Found]] = []

    def __call__(self, x: np.ndarray, key: bytes, find: Callable[[], Found]) -> Found:
        """What was found at the unknowns x (local,), or what ``find`` says there now."""
        at = x.tobytes()  # of two states bytes tell where they first differ
        for number, (known, of, found) in enumerate(self._known):
            if of == key and known == at:
                self._known.append(self._known.pop(number))
                return found
        found = find()
        self._known = [*self._known, (at, key, found)][-self._count :]
        return found

    def clear(self) -> None:
        """Let all of it go."""
        self._known.clear()
