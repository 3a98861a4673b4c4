"""The clock of a step: how long it lasts, and how its loads go with time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from softact.loads.dynamics import Dynamics

# A pressure turns where it goes back by this part of its range: less is noise of a measurement.
TURNS = 0.05


class Amplitude:
    """How far loads have gone to their new values, by the part of the duration that has passed."""

    @property
    def turns(self) -> tuple[float, ...]:
        """Parts between 0 and 1 at which loads turn or have a kink; an increment ends at each, so
        that no peak is missed."""
        return ()

    def at(self, part: float) -> float:
        """0: as at the start of the step; 1: the new values."""
        raise NotImplementedError

    def pressures(self, part: float) -> Mapping[str, float]:
        """Pressures (MPa) of cavities that are given in time, whatever the step begins with."""
        return {}


@dataclass(frozen=True)
class Steady(Amplitude):
    """Loads go to their new values at a constant rate."""

    def at(self, part: float) -> float:
        """See ``Amplitude``."""
        return part


@dataclass(frozen=True)
class Smooth(Amplitude):
    """Loads begin and end at rest: 3 t² − 2 t³."""

    def at(self, part: float) -> float:
        """See ``Amplitude``."""
        return part * part * (3.0 - 2.0 * part)


@dataclass(frozen=True)
class Sudden(Amplitude):
    """Loads are at their new values from the start on."""

    def at(self, part: float) -> float:
        """See ``Amplitude``."""
        return 1.0


@dataclass(frozen=True)
class Hold(Amplitude):
    """Loads stay as they are."""

    def at(self, part: float) -> float:
        """See ``Amplitude``."""
        return 1.0


@dataclass(frozen=True)
class _Cycles(Amplitude):
    """There and back, ``cycles`` times."""

    cycles: float

    @property
    def turns(self) -> tuple[float, ...]:
        """See ``Amplitude``: twice a cycle."""
        count = int(np.ceil(2 * self.cycles - 1e-9))
        return tuple(k / (2 * self.cycles) for k in range(1, count))


@dataclass(frozen=True)
class Sine(_Cycles):
    """(1 − cos 2π n t)/2: loads swing between their last and their new values."""

    def at(self, part: float) -> float:
        """See ``Amplitude``."""
        return float(1.0 - np.cos(2 * np.pi * self.cycles * part)) / 2


@dataclass(frozen=True)
class Triangle(_Cycles):
    """Loads go to their new values and back at a constant rate."""

    def at(self, part: float) -> float:
        """See ``Amplitude``."""
        return 1.0 - abs(1.0 - 2.0 * ((self.cycles * part) % 1.0))


@dataclass(frozen=True, eq=False)
class History(Amplitude):
    """Pressures of cavities in time, linear between the given ones; other loads as ``Steady``.

    parts: (n,) of the duration, rising from 0 to 1. values: cavity -> (n,) MPa.
    """

    parts: np.ndarray
    values: Mapping[str, np.ndarray]

    def at(self, part: float) -> float:
        """See ``Amplitude``."""
        return part

    def pressures(self, part: float) -> dict[str, float]:
        """See ``Amplitude``."""
        return {n: float(np.interp(part, self.parts, v)) for n, v in self.values.items()}

    @property
    def turns(self) -> tuple[float, ...]:
        """See ``Amplitude``: where one of the pressures turns beyond noise."""
        found: set[int] = set()
        for values in self.values.values():
            found.update(turning_points(values, TURNS * float(np.ptp(values))))
        inside = (float(self.parts[i]) for i in sorted(found))
        return tuple(part for part in inside if 0.0 < part < 1.0)


def turning_points(values: np.ndarray, least: float) -> list[int]:
    """Numbers of the local extremes of ``values`` (n,) from which they go back by more than
    ``least``."""
    found, extreme, rises = [], 0, 0
    for i, value in enumerate(values):
        gone = value - values[extreme]
        if rises * gone > 0:
            extreme = i
        elif abs(gone) > least:
            if rises:
                found.append(extreme)
            extreme, rises = i, 1 if gone > 0 else -1
    return found


@dataclass(frozen=True)
class Timing:
    """duration: of a step, s. amplitude: how its loads go. dynamics: with which inertia; None:
    without."""

    duration: float
    amplitude: Amplitude = Steady()
    dynamics: Dynamics | None = None

    @property
    def strokes(self) -> int:
        """How often loads go one way."""
        return len(self.amplitude.turns) + 1
