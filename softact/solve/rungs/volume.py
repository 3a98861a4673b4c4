"""Equilibria beyond a pressure limit: traced by prescribing volume instead of pressure and, where
the volume turns back too, the way through the displacements."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from softact.solve.increments import CUT, growth
from softact.solve.newton import NewtonOutcome
from softact.solve.passed import Passed
from softact.solve.path import ArcDrive, LoadDrive, Point, VolumeDrive, extrapolate

# A traced branch ends after so many increments or Newton iterations of one kind of control, when it
# has come down to this part of the limit, or when volume control itself makes no way.
MOST_INCREMENTS, MOST_ITERATIONS = 40, 100
MOST_AT_ONCE = 8  # iterations of one increment
LOWEST = 0.3
SMALLEST = 1e-3  # of the first increment
# Conjugate volume that one increment may add, as a part of what there is.
LARGEST = 0.25
# Increments that fail in a row of a volume that may be turning back.
TURNS_BACK = 2
# An increment through the displacements may be so much longer than the way that was prescribed.
ASIDE = 2.0
# Stable increments with rising loads after which pressure takes over again.
CONFIDENT = 2


@dataclass(frozen=True)
class Found:
    """How a trace ended: points of the ``LoadDrive`` to go on from and the increment to go on
    with; or limit: why the load cannot be reached, and snap: the same where a motion gets past."""

    path: list[Point]
    size: float = 0.0
    limit: str | None = None
    snap: str | None = None


def trace(
    stepper, step, ramp, path: list[Point], size: float, largest: float, passed: Passed
) -> Found:
    """Follow a step's equilibria under volume control from the last point of its path.

    path, size: points and increment of the ``LoadDrive``. largest: change of the fraction in one
    increment. passed: equilibria that are none of the branch ahead. Load control goes on when the
    step's end is reached or the equilibria are stable again under rising pressure.
    """
    return _Trace(stepper, step, ramp, largest, passed).run(path, size)


class _Trace:
    def __init__(self, stepper, step, ramp, largest, passed):
        self.stepper, self.step, self.ramp, self.largest = stepper, step, ramp, largest
        self.passed = passed
        self.drive, self.load = VolumeDrive(stepper.model, ramp), LoadDrive(ramp)
        self.arc = ArcDrive(stepper.model, ramp)
        self._beyond = False  # whether an unstable equilibrium has been seen
        self._set_bounds(0)

    def run(self, path: list[Point], size: float) -> Found:
        stepper = self.stepper
        points = [self.drive.place(point) for point in path]
        increment = first = self._first(points, size)
        seen, rising, failed = list(points), 0, 0
        while self._worth_while(seen, len(points)) and increment >= SMALLEST * first:
            if failed >= TURNS_BACK and self.drive is not self.arc and len(seen) > 1:
                seen = self._follow_arc(seen)
                increment = first = seen[-1].s - seen[-2].s
            target = seen[-1].s + increment
            outcome = self._attempt(seen, target)
            fraction = float(self.drive.loads(stepper.state)[0])
            if outcome.converged and fraction >= 1.0 and self._arrive(seen):
                self._remark(seen)
                return Found([Point(1.0, stepper.state.x.copy(), np.empty(0))])
            if not outcome.converged or fraction >= 1.0:
                if not outcome.converged:
                    stepper.reject(self.step, self.drive, seen[-1:], target, outcome)
                    failed += 1
                increment *= CUT
                continue
            before = seen[-1]
            self._beyond |= outcome.unstable_modes > 0
            seen += stepper.accept(self.step, self.drive, [], target, outcome)
            stable = outcome.unstable_modes == 0 and seen[-1].q[0] > before.q[0]
            rising = rising + 1 if stable and outcome.iterations <= 6 else 0
            if rising >= CONFIDENT and seen[-1].q[0] >= max(p.q[0] for p in seen):
                self._remark(seen)
                back = [Point(float(p.q[0]), p.x, np.empty(0)) for p in seen[-3:]]
                return Found(back, min(self.largest, abs(back[-1].s - back[-2].s)))
            held_back = increment if failed else np.inf
            increment = min(self._next(seen, increment, outcome.iterations), held_back)
            failed = 0
        return self._end(path, points, seen, size)

    def _attempt(self, seen, target: float) -> NewtonOutcome:
        """Seek the next point, which has to lie ahead."""
        if self.drive is self.arc:
            self.arc.aim(*seen[-2:])
        outcome = self.stepper.attempt(self.drive, seen[-3:], target, MOST_AT_ONCE)
        if outcome.converged and self._lies_back(seen[-1], target, outcome.unstable_modes):
            return replace(outcome, converged=False, reason="that equilibrium lies back")
        return outcome

    def _lies_back(self, last: Point, target: float, unstable_modes: int) -> bool:
        """Whether an equilibrium is none of the branch ahead: far from the place that was
        predicted, or on the way to the limit again.

        Along a path the determinant of the tangent and the rate of the load change their signs
        together: no stable equilibria follow each other under falling loads.
        """
        state, told = self.stepper.state, self.stepper.model.contacts.symmetric  # by the inertia
        fraction = float(self.drive.loads(state)[0])
        returned = told and self._beyond and fraction < last.q[0] and unstable_modes == 0
        returned = returned or self.passed.returned(last.x, state.x, fraction)
        way = target - last.s
        return returned or (
            self.drive is self.arc and self.arc.length(state.x - last.x) > ASIDE * way
        )

    def _follow_arc(self, seen) -> list[Point]:
        """Prescribe the way through the displacements from here on."""
        self.drive = self.arc
        self._set_bounds(len(seen))
        return self.arc.lay(seen)

    def _set_bounds(self, increments: int) -> None:
        self._most_increments = increments + MOST_INCREMENTS
        self._most_iterations = self._iterations() + MOST_ITERATIONS

    def _iterations(self) -> int:
        return self.stepper.newton.counts.newton_iterations

    def _worth_while(self, seen, known: int) -> bool:
        low = seen[-1].q[0] < LOWEST * max(p.q[0] for p in seen)
        bounded = self._iterations() < self._most_iterations
        return len(seen) - known < self._most_increments and bounded and not low

    def _first(self, points, size) -> float:
        """Increment of the conjugate volume that changes the fraction by ``size``."""
        if len(points) > 1:
            a, b = points[-2:]
            return abs((b.s - a.s) / (b.q[0] - a.q[0])) * size
        return 0.01 * abs(points[-1].s)

    def _next(self, seen, increment, iterations) -> float:
        change = abs(seen[-1].q[0] - seen[-2].q[0])
        wanted = increment * growth(iterations)
        if change > 0:
            wanted = min(wanted, increment * self.largest / change)
        if self.drive is self.arc:
            return wanted
        return min(wanted, LARGEST * abs(seen[-1].s))

    def _arrive(self, seen) -> bool:
        """Solve for the end of the step itself, the last point being short of it."""
        stepper, state = self.stepper, self.stepper.state
        before, t = seen[-1], float(self.drive.loads(state)[0])
        here = Point(t, state.x.copy(), np.empty(0))
        start = extrapolate([Point(before.q[0], before.x, np.empty(0)), here], 1.0)
        outcome = stepper.attempt(self.load, [start], 1.0)
        if outcome.converged:
            stepper.accept(self.step, self.load, [], 1.0, outcome)
        else:
            stepper.go_to(self.drive, before)
        return outcome.converged

    def _limit(self, seen) -> float | None:
        """The highest maximum of the fraction on the way: top of the parabola through it, which
        stays below the end of the step, where the way has not been."""
        t = np.array([p.q[0] for p in seen])
        tops = [i for i in range(1, len(t) - 1) if t[i - 1] < t[i] >= t[i + 1]]
        if not tops:
            return None
        top = max(tops, key=t.__getitem__)
        s = np.array([p.s for p in seen[top - 1 : top + 2]])
        a, b, c = np.polyfit(s - s[1], t[top - 1 : top + 2], 2)
        peak = float(c - b * b / (4 * a))
        return peak if peak < 1.0 else float(t[top])

    def _told(self, fraction: float) -> str:
        name, (start, end) = max(self.ramp.pressures.items(), key=lambda p: abs(p[1][1] - p[1][0]))
        where = f" in '{name}'" if len(self.ramp.pressures) > 1 else ""
        return f"{1e3 * (start + fraction * (end - start)):.4g} kPa{where}"

    def _remark(self, seen) -> None:
        limit = self._limit(seen)
        if limit is not None:
            self.stepper.progress.remarks.append(
                f"step '{self.step.name}': snaps at {self._told(limit)}; the unstable "
                "equilibria up to where it catches itself were traced by volume"
            )

    def _end(self, path, points, seen, size) -> Found:
        """Nothing passed: a limit, or no more than load control knew."""
        limit = self._limit(seen)
        if limit is not None:
            at, end = self._told(limit), self._told(float(seen[-1].q[0]))
            branch = "could not be traced" if end == at else f"was traced down to {end}"
            branch, step = f"the unstable branch {branch}", f"step '{self.step.name}'"
            return Found(
                path,
                limit=f"{step}: pressure cannot exceed {at}: the structure snaps; {branch}",
                snap=f"{step}: snaps at {at}; {branch}",
            )
        for p in seen[len(points) :]:
            point = Point(float(p.q[0]), p.x, np.empty(0))
            path = [*path[-2:], point] if point.s > path[-1].s else [point]
        self.stepper.go_to(self.load, path[-1])
        return Found(path, size)
