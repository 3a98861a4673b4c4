"""The best design by gradients: sequential quadratic programming from several starts.

scipy's SLSQP (Kraft 1988, DFVLR-FB 88-28) on parameters that go from 0 to 1 between their ends.
Each run carries the derivatives of its measures (``softact.sensitivities``), and starts from the
last state of the nearest design where that can be; it is a trial like any other, so the same
command goes on from the runs in the cache.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc

from softact.errors import SpecError
from softact.optimise.study import Trials
from softact.sensitivities import stored
from softact.sweep.axes import Axis
from softact.sweep.parts import Part
from softact.units import conversion

if TYPE_CHECKING:
    from optuna.trial import FrozenTrial

    from softact.sweep.compute import Answer

#: Relative change of the objective at which a descent ends, and what of a bound is kept free, since
#: parameters are rounded to four digits.
SETTLED, ROOM = 1e-4, 5e-4
#: What a run that is not complete counts as, by the size of the objective: the step is cut.
LOST = 10.0
MOST_STEPS = 50  # of one descent


class _EnoughError(Exception):
    """The trials are used up."""


class Descent:
    """Descents of one optimisation. tell: hears of each new trial and the answer of its run; warn:
    of what is to be known of the best one."""

    def __init__(
        self,
        trials: Trials,
        tell: Callable[[FrozenTrial, Answer], None],
        warn: Callable[[str], None] = lambda line: None,
    ) -> None:
        self.trials, self.tell, self.warn = trials, tell, warn
        self.axes: list[Axis] = list(trials.wanted.parameters)
        (self.objective,) = trials.wanted.objectives
        self.sign = -1.0 if self.objective.goal == "maximise" else 1.0
        self.limits = [
            (constraint, side, bound)
            for constraint in trials.wanted.constraints
            for side, bound in ((1.0, constraint.below), (-1.0, constraint.above))
            if bound is not None
        ]
        self._known: dict[tuple[float, ...], tuple[np.ndarray, np.ndarray] | None] = {}
        self._good: tuple[np.ndarray, np.ndarray] | None = None

    def run(self) -> None:
        """Descend from the reference, if there is one, and from points of a Latin hypercube, until
        all have settled or the trials are used up.

        Raises SpecError where a run has no derivative that is needed.
        """
        try:
            for start in self._starts():
                self._good = None
                if self._at(start) is not None:
                    self._descend(start)
        except _EnoughError:
            pass
        for trial in self.trials.best():
            if said := self.trials.whole(trial):
                self.warn(said)

    def _starts(self) -> list[np.ndarray]:
        wanted = self.trials.wanted
        drawn = qmc.LatinHypercube(len(self.axes), seed=wanted.seed).random(wanted.starts)
        first = [self._position(wanted.reference)] if wanted.reference else []
        return [*first, *drawn][: wanted.starts]

    def _descend(self, start: np.ndarray) -> None:
        """One descent; the first row of what ``_at`` gives is the objective, then the limits."""
        here = self._at(start)
        assert here is not None  # its run is complete
        size = max(abs(float(here[0][0])), 1e-12)

        def values(position: np.ndarray) -> np.ndarray:
            found, good = self._at(position), self._good
            assert good is not None
            return found[0] if found else np.concatenate([[here[0][0] + LOST * size], good[0][1:]])

        def slopes(position: np.ndarray) -> np.ndarray:
            found = self._at(position) or self._good
            assert found is not None
            return found[1]

        held: Any = {
            "type": "ineq",
            "fun": lambda z: values(z)[1:] - ROOM,
            "jac": lambda z: slopes(z)[1:],
        }
        minimize(
            lambda z: values(z)[0] / size,
            start,
            jac=lambda z: slopes(z)[0] / size,
            bounds=[(0.0, 1.0)] * len(start),
            constraints=[held] if self.limits else [],
            method="SLSQP",
            options={"ftol": SETTLED, "maxiter": MOST_STEPS},
        )

    def _at(self, position: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Values (1 + limits,) and derivatives (1 + limits, parameters) at a position: the
        objective to be made small, and by how much each limit is kept; None where the run is not
        complete."""
        place = tuple(np.clip(position, 0.0, 1.0).tolist())
        if place not in self._known:
            self._known[place] = self._evaluated(place)
        found = self._known[place]
        if found is not None:
            self._good = found
        return found

    def _evaluated(self, place: Sequence[float]) -> tuple[np.ndarray, np.ndarray] | None:
        numbers = {axis.title: _number(axis, z) for axis, z in zip(self.axes, place, strict=True)}
        trial = self.trials.at(numbers)
        if trial is None:
            if len(self.trials.done) >= self.trials.wanted.trials:
                raise _EnoughError
            trial = self.trials.tried(numbers, self.tell)
        if trial.values is None:
            return None
        slopes = stored.read(self.trials.folder(trial))
        pairs = [self._part(trial, self.objective, slopes, self.sign)]
        for constraint, side, bound in self.limits:
            size = max(abs(bound), 1e-12)
            value, slope = self._part(trial, constraint, slopes, -side / size)
            pairs.append((value + side * bound / size, slope))
        by = np.array([_by_position(axis, z) for axis, z in zip(self.axes, place, strict=True)])
        return np.array([v for v, _ in pairs]), np.array([s for _, s in pairs]) * by

    def _part(
        self, trial: FrozenTrial, part: Part, slopes: list[stored.Slope], factor: float
    ) -> tuple[float, np.ndarray]:
        """A measure times a factor, and its derivatives (parameters,) by the axes as they are."""
        record = self.trials.record(trial)
        value, row = part.value(record), part.row(record)
        assert value is not None  # the trial has values
        found = []
        for axis, paths in zip(self.axes, self.trials.paths, strict=True):
            of = {s.parameter: s for s in slopes if (s.row, s.measure) == (row, part.measure)}
            if lacking := [path for path in paths if path not in of]:
                raise SpecError(
                    f"trial {trial.number} has no derivative of {part.measure} by {lacking[0]} "
                    "(its run.json says why); leave 'method: gradient' out"
                )
            found.append(sum(of[path].derivative * _factor(axis, of[path]) for path in paths))
        return factor * value, factor * np.array(found)

    def _position(self, coordinates: dict[str, Any]) -> np.ndarray:
        """Of a design, 0 to 1 for each parameter."""
        found = []
        for axis in self.axes:
            low, high = axis.ends
            number = float(axis.number(coordinates[axis.title]))
            if axis.scale == "log":
                low, high, number = math.log(low), math.log(high), math.log(number)
            found.append((number - low) / (high - low))
        return np.array(found)


def _factor(axis: Axis, slope: stored.Slope) -> float:
    """Units of a parameter by one of the axis."""
    unit = slope.at.partition(" ")[2]
    return conversion(axis.unit, unit) if unit else 1.0


def _number(axis: Axis, z: float) -> float:
    """The value of an axis, in its unit, at a part of the way between its ends."""
    low, high = axis.ends
    if axis.scale == "log":
        return math.exp(math.log(low) + z * (math.log(high) - math.log(low)))
    return low + z * (high - low)


def _by_position(axis: Axis, z: float) -> float:
    """Derivative of ``_number``."""
    low, high = axis.ends
    return _number(axis, z) * math.log(high / low) if axis.scale == "log" else high - low
