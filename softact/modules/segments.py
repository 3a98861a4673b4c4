"""Parts of a rod in a row whose modules are under pressures of their own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
PIECES = 2  # by module


@dataclass(frozen=True)
class Segments:
    """The equal segments of a rod. modules: of each. ends (segments,): how many of the actuator's
    two ends each has; bending (segments,): modules of each that bend. of (pieces,): in which of
    them each piece lies."""

    modules: float
    ends: Array
    bending: Array
    of: NDArray[np.int64]

    @classmethod
    def of_chain(cls, modules: float, count: int, stiff: float) -> Segments:
        """So many segments of an actuator of so many modules, of which its two ends take ``stiff``
        from what bends."""
        each, ends = modules / count, np.zeros(count)
        ends[0] += 1.0
        ends[-1] += 1.0
        pieces = max(1, round(PIECES * each))
        return cls(each, ends, each - stiff * ends / 2, np.repeat(np.arange(count), pieces))

    def spread(self, values: Array) -> Array:
        """Of each piece (pieces,) its part of what each segment has (segments,)."""
        return np.asarray((values / np.bincount(self.of))[self.of])

    def means(self, values: Array) -> Array:
        """Of each segment (segments, m) the mean of its pieces' values (pieces, m)."""
        return np.array([values[self.of == i].mean(axis=0) for i in range(len(self.ends))])

    def steepest(self, curvatures: Array) -> float:
        """The largest change of curvatures (pieces, any) from module to module of a segment."""
        steps = np.linalg.norm(np.diff(curvatures, axis=0), axis=1)[np.diff(self.of) == 0]
        by_module = len(self.of) / len(self.ends) / self.modules
        return float(steps.max(initial=0.0) * by_module)
