"""How long increments of a step with a clock may be: to its next turn, and by accuracy in time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softact.loads.timing import Timing
from softact.model import Model
from softact.solve.settings import Settings
from softact.system.term import State

# The error of an increment grows with its square. Part of the increment that would just do; the
# smallest part of one to its next try; one with an error beyond so many tolerances is tried again.
SAFETY, SHRINK, REJECTED = 0.9, 0.2, 1.5


@dataclass(frozen=True)
class InTime:
    """Whether an increment is short enough, and by which factor the next may differ from it."""

    accepted: bool
    factor: float


class Pace:
    """The increments of one step. Without a clock a step has one turn, its end, and no error."""

    def __init__(self, timing: Timing | None, settings: Settings, model: Model):
        self._model, self._settings = model, settings
        self._timing = timing
        self._turns = (*(timing.amplitude.turns if timing else ()), 1.0)

    @property
    def strokes(self) -> int:
        """How often loads go one way: each has the increments of a step of its own."""
        return len(self._turns)

    def first(self, largest: float) -> float:
        """The first increment of the step, or after a turn, where it is at most ``largest``."""
        return min(self._settings.initial_increment / self.strokes, largest)

    def next_turn(self, done: float) -> float:
        """Where the next increment ends at the latest."""
        return next(turn for turn in self._turns if turn > done)

    def in_time(self, state: State, others: float) -> InTime:
        """What the error in time at the end of an increment says of it; others: that of the air and
        of the motion. Collective."""
        if self._timing is None:
            return InTime(True, np.inf)
        error = max(self._model.time_error(state), others)
        ratio = error / self._settings.time_tolerance
        factor = SAFETY * max(ratio, 1e-9) ** (-1 / 2)
        return InTime(ratio <= REJECTED, max(SHRINK, factor))
