"""The last rung: let the actuator move to its next equilibrium.

Implicit quasi-static dynamics with the mass of the material and a viscosity of its solids
(``Solid``). The backward Euler method damps the motion, too, the more the longer the time step;
steps grow until the body rests, and Newton without inertia then confirms the equilibrium. The path
between is that of an overdamped body; the largest ratio of kinetic to internal energy on it is
reported. Mass alone holds back what moves as a whole, and not what snaps locally
(docs/performance.md).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import takewhile

import numpy as np

from softact.solve.acceptance import state_fault
from softact.solve.newton import NewtonOutcome
from softact.solve.path import Point
from softact.solve.rungs.backward_euler import BackwardEuler
from softact.solve.rungs.base import Stopped, Trouble, Went
from softact.solve.walk import Walk


@dataclass(frozen=True)
class Pace:
    """How a motion goes (docs/performance.md).

    time_steps, iterations: of a motion at most, of_sheets: iterations where sheets without
    stiffness move far. roughly, at_once: a time step is solved to this tolerance, in at most so
    many iterations. cut: part of its length that one which fails keeps; shortest: that of the first
    below which there is no hope. relaxation: ratio of viscosity to shear modulus, in times that a
    shear wave takes through the body. at_rest: ratio of kinetic to internal energy below which the
    body is taken to rest, again: part of it below which that is tried again; quasi_static: ratio
    above which the motion is not. reach: part of the largest increment by which a motion loads
    further, farther: by how much more the next one where nothing was gained since the last.
    """

    time_steps: int = 300
    iterations: int = 600
    of_sheets: int = 400
    roughly: float = 1e-4
    at_once: int = 6
    cut: float = 0.25
    shortest: float = 1e-3
    relaxation: float = 10.0
    at_rest: float = 1e-9
    again: float = 0.01
    quasi_static: float = 0.05
    reach: float = 0.2
    farther: float = 2.5


PACE = Pace()
# Kinds of control (``Attempt``) that are motions.
MOTIONS = ("dynamics", "motion")


class Motion:
    """Moves on to the next equilibrium, where the settings allow it."""

    name = "dynamics"

    def may(self, walk: Walk, trouble: Trouble) -> bool:
        """See ``Rung``."""
        if trouble.limit:
            return True
        hopeless = walk.stuck() or walk.size < walk.settings.min_increment
        return bool(trouble.failed) and hopeless

    def climb(self, walk: Walk, trouble: Trouble) -> Went | Stopped:
        """See ``Rung``."""
        settings, reach = walk.settings, self._reach(walk)
        moved = self._settle(walk, reach) if settings.dynamics else None
        if settings.dynamics:
            walk.size = min(settings.initial_increment, reach)
        if moved is None:
            return Stopped(trouble.limit or walk.no_equilibrium(trouble.failed))
        walk.passed.leave()
        walk.passed.add(walk.path[-1].s, walk.path[-1].x)
        walk.vain_before = walk.in_vain()
        if trouble.snap:
            walk.remark(trouble.snap)
        walk.remark(moved)
        return Went.ON

    @staticmethod
    def _reach(walk: Walk) -> float:
        """How much further (fraction of the step) a motion loads that begins now."""
        controls = [a.control for a in walk.attempts if a.converged]
        moved = len(list(takewhile(lambda c: c in MOTIONS, reversed(controls))))
        return walk.largest * min(1.0, PACE.reach * PACE.farther**moved)

    @staticmethod
    def _settle(walk: Walk, further: float) -> str | None:
        """Load further by this fraction of the step and let the body come to rest; what is to be
        said of it where it came to an equilibrium, which is the end of the walk's path then."""
        limit = walk.limit_point()
        walk.control = "dynamics"
        motion = _Motion(walk, _reachable(walk, further))
        outcome = motion.run()
        if outcome is None or not outcome.converged:
            walk.go_to(walk.drive, walk.path[-1])
            walk.model.contacts.resume(walk.state)
            return None
        ratio, start = motion.kinetic_ratio, walk.done
        walk.path = walk.accept(walk.drive, [], motion.goal, outcome, "dynamics", ratio)
        verdict = "" if ratio <= PACE.quasi_static else ", more than quasi-static motion may have"
        why = limit or f"no equilibrium nearby at {start:.2%} ({walk.loads_at(start)})"
        return (
            f"step '{walk.step.name}': {why}; the actuator moved to "
            f"that at {motion.goal:.2%} in {motion.time_steps} damped time steps (kinetic energy "
            f"at most {ratio:.2%} of the internal energy{verdict})"
        )


def growth(iterations: int) -> float:
    """Factor for the next time step after one of so many Newton iterations."""
    return {0: 2.0, 1: 2.0, 2: 2.0, 3: 1.5, 4: 1.2}.get(iterations, 0.8)


def _reachable(walk: Walk, further: float) -> float:
    """Place to which a motion may load: obstacles, which go there at once, must not come too far
    into the body."""
    while True:
        goal = min(1.0, walk.done + further)
        walk.drive.set(walk.state, goal, walk.path[-1].q)
        if walk.model.contacts.overrun(walk.rest, walk.state) is None:
            return goal
        further /= 2


class _Motion:
    """path: the last two states of the motion, s being the time (s)."""

    def __init__(self, walk: Walk, goal: float):
        self.walk, self.goal = walk, goal
        self.euler = BackwardEuler(walk, walk.drive)
        start = walk.path[-1]
        self.path = [Point(0.0, start.x, start.q)]
        self.kinetic_ratio, self.time_steps = 0.0, 0
        self._rough = replace(
            walk.newton.options,
            tolerance=max(PACE.roughly, walk.newton.tolerance),
            at_most=PACE.at_once,
        )

    def run(self) -> NewtonOutcome | None:
        """Outcome of the static solve after the motion; None where it did not come to rest."""
        model, counts = self.walk.model, self.walk.newton.counts
        first = time_step = self._wave_crosses()
        most = PACE.of_sheets if model.sheets else PACE.iterations
        last = counts.newton_iterations + most
        at_rest, failed = PACE.at_rest, False
        while (
            self.time_steps < PACE.time_steps
            and time_step > PACE.shortest * first
            and counts.newton_iterations < last
        ):
            self.time_steps += 1
            outcome = self._go_on(time_step, PACE.relaxation * first / time_step)
            if not outcome.converged:
                time_step, failed = PACE.cut * time_step, True
                continue
            ratio = self.euler.kinetic_ratio(self._velocity)
            self.kinetic_ratio = max(self.kinetic_ratio, ratio)
            if ratio < at_rest:
                rest = self._rest()
                if rest.converged:
                    return rest
                at_rest = PACE.again * ratio
            time_step *= min(growth(outcome.iterations), 1.0 if failed else np.inf)
            failed = False
        self.euler.still()
        return None

    @property
    def _velocity(self) -> np.ndarray:
        """Rate of the unknowns over the last time step (local,)."""
        if len(self.path) < 2:
            return np.zeros_like(self.path[0].x)
        before, now = self.path
        return (now.x - before.x) / (now.s - before.s)

    def _go_on(self, time_step: float, resistance: float) -> NewtonOutcome:
        """Solve a time step and, where that is found, add its end to the path."""
        walk, now = self.walk, self.path[-1]
        self.euler.move(now.x, self._velocity, time_step, resistance=resistance)
        outcome = self.euler.solve(now.x, self.goal, now.q, self._rough)
        if outcome.converged:
            walk.model.contacts.resume(walk.state)
            loads = walk.drive.loads(walk.state)
            self.path = [now, Point(now.s + time_step, walk.state.x.copy(), loads)]
        return outcome

    def _rest(self) -> NewtonOutcome:
        """Solve without inertia from the last state of the motion, which stands where it fails."""
        now, walk = self.path[-1], self.walk
        self.euler.still()
        outcome = self.euler.solve(now.x, self.goal, now.q, settled=True)
        fault = outcome.converged and state_fault(walk.model, walk.state)
        if fault:
            outcome = replace(outcome, converged=False, reason=fault)
        if not outcome.converged:
            walk.state.x = now.x.copy()
        return outcome

    def _wave_crosses(self) -> float:
        """Time (s) in which a shear wave crosses the body: its size times √(ρ/μ)."""
        model = self.walk.model
        slowest = max(body.slowness for body in model.bodies)
        return model.diagonal * float(np.sqrt(slowest))
