"""The third rung: equilibria beyond a pressure limit, traced by prescribing volume instead of
pressure and, where the volume turns back too, the way through the displacements."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from softact.solve.increments import INCREMENTS, growth
from softact.solve.newton import NewtonOutcome
from softact.solve.path import ArcDrive, LoadDrive, Point, VolumeDrive, extrapolate
from softact.solve.rungs.base import Stopped, Trouble, Went
from softact.solve.walk import Walk


@dataclass(frozen=True)
class Bounds:
    """When a traced branch ends, and how it goes (docs/performance.md).

    increments, iterations: of one kind of control, at most; at_once: iterations of one increment.
    lowest: part of the limit down to which it is followed. smallest: increment, of the first one.
    largest: conjugate volume that one increment may add, as a part of what there is. turns_back:
    increments that fail in a row of a volume that may be turning back. aside: an increment through
    the displacements may be so much longer than the way that was prescribed. confident: stable
    increments with rising loads after which pressure takes over again, easy: of so many iterations
    at most.
    """

    increments: int = 40
    iterations: int = 100
    at_once: int = 8
    lowest: float = 0.3
    smallest: float = 1e-3
    largest: float = 0.25
    turns_back: int = 2
    aside: float = 2.0
    confident: int = 2
    easy: int = 6


BOUNDS = Bounds()


@dataclass(frozen=True)
class Found:
    """How a trace ended: points of the ``LoadDrive`` to go on from and the increment to go on
    with; or limit: why the load cannot be reached, and snap: the same where a motion gets past."""

    path: list[Point]
    size: float = 0.0
    limit: str | None = None
    snap: str | None = None


class Volume:
    """Traces a step of pressures by volume, once at each place."""

    name = "volume"

    def may(self, walk: Walk, trouble: Trouble) -> bool:
        """See ``Rung``."""
        if trouble.ahead:
            return True
        if not trouble.failed:
            return False
        here = walk.may_trace and walk.traced_at != walk.done
        return walk.is_small and not walk.stuck() and here

    def climb(self, walk: Walk, trouble: Trouble) -> Went | Stopped:
        """See ``Rung``."""
        walk.traced_at = walk.done
        walk.passed.leave()
        memory = walk.state.memory
        found = _Trace(walk).run()
        if found.limit:
            # Far from here there may be equilibria again; what was strained on the way was not.
            walk.model.recall(walk.state, memory)
            walk.go_to(walk.drive, walk.path[-1])
            trouble.limit, trouble.snap = found.limit, found.snap
            return Went.NOT
        walk.path, walk.size = found.path, max(found.size, walk.size)
        for point in walk.path:
            walk.passed.add(point.s, point.x)
        return Went.ON


class _Trace:
    """Follows a step's equilibria under volume control from the last point of the walk's path.

    Load control goes on when the step's end is reached or the equilibria are stable again under
    rising pressure.
    """

    def __init__(self, walk: Walk):
        self.walk = walk
        self.drive: VolumeDrive = VolumeDrive(walk.model, walk.ramp)
        self.load = LoadDrive(walk.ramp)
        self._beyond = False  # whether an unstable equilibrium has been seen
        self._set_bounds(0)

    def run(self) -> Found:
        walk = self.walk
        path, size = walk.path, walk.size
        points = [self.drive.place(point) for point in path]
        increment = first = self._first(points, size)
        seen, rising, failed = list(points), 0, 0
        while self._worth_while(seen, len(points)) and increment >= BOUNDS.smallest * first:
            by_volume = not isinstance(self.drive, ArcDrive)
            if failed >= BOUNDS.turns_back and by_volume and len(seen) > 1:
                seen = self._follow_arc(seen)
                increment = first = seen[-1].s - seen[-2].s
            target = seen[-1].s + increment
            outcome = self._attempt(seen, target)
            fraction = float(self.drive.loads(walk.state)[0])
            if outcome.converged and fraction >= 1.0 and self._arrive(seen):
                self._remark(seen)
                return Found([Point(1.0, walk.state.x.copy(), np.empty(0))])
            if not outcome.converged or fraction >= 1.0:
                if not outcome.converged:
                    walk.reject(self.drive, seen[-1:], target, outcome)
                    failed += 1
                increment *= INCREMENTS.cut
                continue
            before = seen[-1]
            self._beyond |= outcome.unstable_modes > 0
            seen += walk.accept(self.drive, [], target, outcome)
            stable = outcome.unstable_modes == 0 and seen[-1].q[0] > before.q[0]
            rising = rising + 1 if stable and outcome.iterations <= BOUNDS.easy else 0
            if rising >= BOUNDS.confident and seen[-1].q[0] >= max(p.q[0] for p in seen):
                self._remark(seen)
                back = [Point(float(p.q[0]), p.x, np.empty(0)) for p in seen[-3:]]
                return Found(back, min(walk.largest, abs(back[-1].s - back[-2].s)))
            held_back = increment if failed else np.inf
            increment = min(self._next(seen, increment, outcome.iterations), held_back)
            failed = 0
        return self._end(path, points, seen, size)

    def _attempt(self, seen: list[Point], target: float) -> NewtonOutcome:
        """Seek the next point, which has to lie ahead."""
        if isinstance(self.drive, ArcDrive):
            self.drive.aim(*seen[-2:])
        outcome = self.walk.attempt(self.drive, seen[-3:], target, BOUNDS.at_once)
        if outcome.converged and self._lies_back(seen[-1], target, outcome.unstable_modes):
            return replace(outcome, converged=False, reason="that equilibrium lies back")
        return outcome

    def _lies_back(self, last: Point, target: float, unstable_modes: int) -> bool:
        """Whether an equilibrium is none of the branch ahead: far from the place that was
        predicted, or on the way to the limit again.

        Along a path the determinant of the tangent and the rate of the load change their signs
        together: no stable equilibria follow each other under falling loads.
        """
        walk, state = self.walk, self.walk.state
        known = walk.model.contacts.symmetric  # the inertia says it
        fraction = float(self.drive.loads(state)[0])
        returned = known and self._beyond and fraction < last.q[0] and unstable_modes == 0
        if returned or walk.passed.returned(last.x, state.x, fraction):
            return True
        if not isinstance(self.drive, ArcDrive):
            return False
        return self.drive.length(state.x - last.x) > BOUNDS.aside * (target - last.s)

    def _follow_arc(self, seen: list[Point]) -> list[Point]:
        """Prescribe the way through the displacements from here on."""
        self.drive = arc = ArcDrive(self.walk.model, self.walk.ramp, seen)
        self._set_bounds(len(seen))
        return arc.points

    def _set_bounds(self, increments: int) -> None:
        self._most_increments = increments + BOUNDS.increments
        self._most_iterations = self._iterations() + BOUNDS.iterations

    def _iterations(self) -> int:
        return self.walk.newton.counts.newton_iterations

    def _worth_while(self, seen: list[Point], known: int) -> bool:
        low = seen[-1].q[0] < BOUNDS.lowest * max(p.q[0] for p in seen)
        bounded = self._iterations() < self._most_iterations
        return len(seen) - known < self._most_increments and bounded and not low

    def _first(self, points: list[Point], size: float) -> float:
        """Increment of the conjugate volume that changes the fraction by ``size``."""
        if len(points) > 1:
            a, b = points[-2:]
            return abs((b.s - a.s) / (b.q[0] - a.q[0])) * size
        return 0.01 * abs(points[-1].s)

    def _next(self, seen: list[Point], increment: float, iterations: int) -> float:
        change = abs(seen[-1].q[0] - seen[-2].q[0])
        wanted = increment * growth(iterations)
        if change > 0:
            wanted = min(wanted, increment * self.walk.largest / change)
        if isinstance(self.drive, ArcDrive):
            return wanted
        return min(wanted, BOUNDS.largest * abs(seen[-1].s))

    def _arrive(self, seen: list[Point]) -> bool:
        """Solve for the end of the step itself, the last point being short of it."""
        walk, state = self.walk, self.walk.state
        before, t = seen[-1], float(self.drive.loads(state)[0])
        here = Point(t, state.x.copy(), np.empty(0))
        start = extrapolate([Point(before.q[0], before.x, np.empty(0)), here], 1.0)
        outcome = walk.attempt(self.load, [start], 1.0)
        if outcome.converged:
            walk.accept(self.load, [], 1.0, outcome)
        else:
            walk.go_to(self.drive, before)
        return outcome.converged

    def _limit(self, seen: list[Point]) -> float | None:
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

    def _pressure(self, fraction: float) -> str:
        """In words: that of the cavity whose pressure changes most."""
        pressures = self.walk.ramp.pressures
        name, (start, end) = max(pressures.items(), key=lambda p: abs(p[1][1] - p[1][0]))
        where = f" in '{name}'" if len(pressures) > 1 else ""
        return f"{1e3 * (start + fraction * (end - start)):.4g} kPa{where}"

    def _remark(self, seen: list[Point]) -> None:
        limit = self._limit(seen)
        if limit is not None:
            self.walk.remark(
                f"step '{self.walk.step.name}': snaps at {self._pressure(limit)}; the unstable "
                "equilibria up to where it catches itself were traced by volume"
            )

    def _end(self, path: list[Point], points: list[Point], seen: list[Point], size: float) -> Found:
        """Nothing passed: a limit, or no more than load control knew."""
        limit = self._limit(seen)
        if limit is not None:
            at, end = self._pressure(limit), self._pressure(float(seen[-1].q[0]))
            branch = "could not be traced" if end == at else f"was traced down to {end}"
            branch, step = f"the unstable branch {branch}", f"step '{self.walk.step.name}'"
            return Found(
                path,
                limit=f"{step}: pressure cannot exceed {at}: the structure snaps; {branch}",
                snap=f"{step}: snaps at {at}; {branch}",
            )
        for p in seen[len(points) :]:
            point = Point(float(p.q[0]), p.x, np.empty(0))
            path = [*path[-2:], point] if point.s > path[-1].s else [point]
        self.walk.go_to(self.load, path[-1])
        return Found(path, size)
