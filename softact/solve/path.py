"""What is prescribed along a path of equilibria, and what follows from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Protocol

import numpy as np

from softact.model import Model
from softact.solve.border import ArcControl, Control, VolumeControl
from softact.solve.ramp import Ramp
from softact.system.term import Origin, State


@dataclass(frozen=True)
class Point:
    """An equilibrium on a path, or a guess: its place s, the unknowns x (local,), and the loads
    q (k,) that were unknown. rate: change of x with s there, where known. origin: what a guess was
    extrapolated from."""

    s: float
    x: np.ndarray
    q: np.ndarray
    rate: np.ndarray | None = None
    origin: Origin | None = None


class Drive(Protocol):
    """A way along the equilibria of a step.

    control: see ``Attempt``. holds_volume: whether volumes stay prescribed, as they are by
    injection.
    """

    control: str
    holds_volume: bool

    def set(self, state: State, s: float, q: np.ndarray) -> tuple[np.ndarray, Control | None]:
        """Load ``state`` for the place s; q is the guess of the unknown loads. Returns the
        prescribed displacements, and what is prescribed instead of the unknown loads."""

    def loads(self, state: State) -> np.ndarray:
        """The unknown loads q as ``state`` has them."""

    def fraction(self, point: Point) -> float:
        """Fraction of the step's loads."""


class LoadDrive:
    """s is the fraction of the step; the pressures of injected cavities (MPa) follow."""

    control = "load"

    def __init__(self, ramp: Ramp):
        self._ramp = ramp
        self.holds_volume = bool(ramp.injected)

    def set(self, state: State, s: float, q: np.ndarray) -> tuple[np.ndarray, Control | None]:
        """See ``Drive``."""
        free = dict(zip(self._ramp.injected, map(float, q), strict=True))
        if free:
            state.put("pressure", {**state["pressure"], **free})
        return self._ramp.apply(state, s), self._ramp.control(s)

    def loads(self, state: State) -> np.ndarray:
        """See ``Drive``."""
        return np.array([state["pressure"].get(name, 0.0) for name in self._ramp.injected])

    def fraction(self, point: Point) -> float:
        """See ``Drive``."""
        return point.s


class VolumeDrive:
    """s is the volume that is conjugate to the step's pressures, Σ Δp V (mJ); the fraction of the
    step follows.

    All pressures keep the proportions of the step, so these are the step's own equilibria, also
    where the fraction has a maximum.
    """

    control = "volume"
    holds_volume = False  # the actuator will be driven by pressure

    def __init__(self, model: Model, ramp: Ramp):
        self._model, self._ramp = model, ramp
        self._start = {name: start for name, (start, _) in ramp.pressures.items()}
        self._change = {name: end - start for name, (start, end) in ramp.pressures.items()}

    def set(self, state: State, s: float, q: np.ndarray) -> tuple[np.ndarray, Control | None]:
        """See ``Drive``."""
        held = self._ramp.apply(state, float(q[0]))
        return held, VolumeControl([self._change], np.array([s]))

    def loads(self, state: State) -> np.ndarray:
        """See ``Drive``."""
        along = sum(d * (state["pressure"][n] - self._start[n]) for n, d in self._change.items())
        return np.array([along / sum(d * d for d in self._change.values())])

    def fraction(self, point: Point) -> float:
        """See ``Drive``."""
        return float(point.q[0])

    def place(self, point: Point) -> Point:
        """A point of the step's ``LoadDrive`` as one of this drive."""
        state = State(point.x)
        s = sum(d * self._model.cavity_volume(state, name) for name, d in self._change.items())
        return Point(s, point.x, np.array([point.s]))


class ArcDrive(VolumeDrive):
    """s is the arc length, that of the way through the displacements; the fraction of the step
    follows.

    Also where the volume turns back: there ``VolumeDrive`` has no equilibrium ahead.
    path: the points of a ``VolumeDrive`` so far, two at least; points: they, as ones of this drive.
    """

    control = "arc"

    def __init__(self, model: Model, ramp: Ramp, path: Sequence[Point]):
        super().__init__(model, ramp)
        self._is_displacement = np.zeros(model.unknowns.local, dtype=bool)
        self._is_displacement[model.displacement_dofs] = True
        places = [0.0]
        for before, after in pairwise(path):
            places.append(places[-1] + self.length(after.x - before.x))
        self.points = [replace(point, s=s) for point, s in zip(path, places, strict=True)]
        self.aim(*self.points[-2:])

    def aim(self, before: Point, last: Point) -> None:
        """Go on from the last point in the direction of these two."""
        change = np.where(self._is_displacement, last.x - before.x, 0.0)
        self._last, self._tangent = last, change / self.length(change)

    def length(self, change: np.ndarray) -> float:
        """Norm of the displacements in a change of the unknowns (local,)."""
        owned = slice(self._model.unknowns.owned)
        change = np.where(self._is_displacement, change, 0.0)[owned]
        return float(np.sqrt(self._model.sum(float(change @ change))))

    def set(self, state: State, s: float, q: np.ndarray) -> tuple[np.ndarray, Control | None]:
        """See ``Drive``."""
        held = self._ramp.apply(state, float(q[0]))
        way = np.array([s - self._last.s])
        return held, ArcControl([self._change], self._last.x, self._tangent, way)


def extrapolate(path: Sequence[Point], s: float, straight: bool = False) -> Point:
    """Polynomial through the points, taken at ``s``.

    Where the rate at the last point is known, x follows the parabola through the last two and this
    rate, or the rate alone (straight): it keeps to the newest part of the path.
    """
    places = np.array([point.s for point in path])
    weights = []
    for i, place in enumerate(places):
        others = np.delete(places, i)
        weights.append(float(np.prod((s - others) / (place - others))))
    rate = path[-1].rate
    if len(path) > 1 and rate is not None:
        before, now = path[-2:]
        gone, ahead = now.s - before.s, s - now.s
        bend = (rate - (now.x - before.x) / gone) / gone * (not straight)
        x = now.x + ahead * (rate + ahead * bend)
    else:
        x = _combined(weights, [point.x for point in path])
    q = _combined(weights, [point.q for point in path])
    origin = Origin(tuple(point.x for point in path), tuple(weights))
    return Point(s, x, q, origin=origin)


def _combined(weights: Sequence[float], arrays: Sequence[np.ndarray]) -> np.ndarray:
    """Σ w a of arrays of one shape."""
    pairs = zip(weights, arrays, strict=True)
    return sum((w * array for w, array in pairs), np.zeros_like(arrays[0]))
