"""The last rung: let the actuator move to its next equilibrium.

Implicit quasi-static dynamics with the mass of the material and a viscosity of its solids
(``Solid.resist``). The backward Euler method damps the motion, too, the more the longer the time
step; steps grow until the body rests, and Newton without inertia then confirms the equilibrium. The
path between is that of an overdamped body; the largest ratio of kinetic to internal energy on it is
reported. Mass alone holds back what moves as a whole, and not what snaps locally
(docs/performance.md).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from softact.solve.acceptance import state_fault, way_fault
from softact.solve.path import Point

MOST_TIME_STEPS, MOST_ITERATIONS = 300, 600
MOST_OF_SHEETS = 400  # iterations where sheets without stiffness move far
# A time step is solved to this tolerance, in at most so many iterations; part of its length that
# one which fails keeps, and that of the first below which there is no hope.
ROUGHLY, MOST_AT_ONCE = 1e-4, 6
CUT, SHORTEST = 0.25, 1e-3
RELAXATION = 10.0  # viscosity by shear modulus, in times that a shear wave takes through the body
# Kinetic by internal energy below which the body is taken to rest, part of it below which that is
# tried again, and ratio above which the motion is not quasi-static.
AT_REST, REST_AGAIN, QUASI_STATIC = 1e-9, 0.01, 0.05


def growth(iterations: int) -> float:
    """Factor for the next time step after one of so many Newton iterations."""
    return {0: 2.0, 1: 2.0, 2: 2.0, 3: 1.5, 4: 1.2}.get(iterations, 0.8)


def settle(stepper, step, drive, path: list[Point], further: float) -> tuple[list[Point], bool]:
    """Load further by this fraction of the step and let the body come to rest.

    Returns the path from there and whether an equilibrium was found; the state is at its end.
    """
    stepper.control = "dynamics"
    motion = _Motion(stepper, drive, path[-1], _reachable(stepper, drive, path[-1], further))
    outcome = motion.run()
    if outcome is None or not outcome.converged:
        stepper.go_to(drive, path[-1])
        stepper.model.contacts.resume(stepper.state)
        return path, False
    ratio = motion.kinetic_ratio
    told = {"control": "dynamics", "kinetic_ratio": ratio}
    path = stepper.accept(step, drive, [], motion.goal, outcome, **told)
    verdict = "" if ratio <= QUASI_STATIC else ", more than quasi-static motion may have"
    stepper.progress.remarks.append(
        f"step '{step.name}': no equilibrium nearby at {motion.start.s:.2%}; the actuator moved to "
        f"that at {motion.goal:.2%} in {motion.time_steps} damped time steps (kinetic energy at "
        f"most {ratio:.2%} of the internal energy{verdict})"
    )
    return path, True


def _reachable(stepper, drive, start: Point, further: float) -> float:
    """Place to which a motion may load: obstacles, which go there at once, must not come too far
    into the body."""
    while True:
        goal = min(1.0, start.s + further)
        drive.set(stepper.state, goal, start.q)
        if stepper.model.contacts.overrun(stepper.rest, stepper.state) is None:
            return goal
        further /= 2


class _Motion:
    """path: the last two states of the motion, s being the time (s)."""

    def __init__(self, stepper, drive, start: Point, goal: float):
        self.stepper, self.drive, self.start, self.goal = stepper, drive, start, goal
        self.path = [Point(0.0, start.x, start.q)]
        self.kinetic_ratio, self.time_steps = 0.0, 0

    def run(self):
        """Outcome of the static solve after the motion; None where it did not come to rest."""
        model, counts = self.stepper.model, self.stepper.newton.counts
        model.add_inertia()
        first = time_step = self._sound_crosses()
        last = counts.newton_iterations + (MOST_OF_SHEETS if model.sheets else MOST_ITERATIONS)
        at_rest, failed = AT_REST, False
        while (
            self.time_steps < MOST_TIME_STEPS
            and time_step > SHORTEST * first
            and counts.newton_iterations < last
        ):
            self.time_steps += 1
            outcome = self._go_on(time_step, RELAXATION * first / time_step)
            if not outcome.converged:
                time_step, failed = CUT * time_step, True
                continue
            ratio = self._ratio(self._velocity)
            self.kinetic_ratio = max(self.kinetic_ratio, ratio)
            if ratio < at_rest:
                rest = self._rest()
                if rest.converged:
                    return rest
                at_rest = REST_AGAIN * ratio
            time_step *= min(growth(outcome.iterations), 1.0 if failed else np.inf)
            failed = False
        self._stop_motion()
        return None

    @property
    def _velocity(self) -> np.ndarray:
        """Rate of the unknowns over the last time step (local,)."""
        if len(self.path) < 2:
            return np.zeros_like(self.start.x)
        before, now = self.path
        return (now.x - before.x) / (now.s - before.s)

    def _go_on(self, time_step: float, resistance: float):
        """Solve a time step and, where that is found, add its end to the path."""
        model, state, now = self.stepper.model, self.stepper.state, self.path[-1]
        for inertia in model.inertia:
            inertia.time_step, inertia.away_from = time_step, now.x + time_step * self._velocity
        for solid in model.solids.values():
            solid.resist(now.x, resistance)
        outcome = self._arrived(now, self._solve(now, ROUGHLY, MOST_AT_ONCE))
        if outcome.converged:
            model.contacts.resume(state)
            self.path = [now, Point(now.s + time_step, state.x.copy(), self.drive.loads(state))]
        return outcome

    def _arrived(self, now: Point, outcome):
        """The outcome; failed where something was passed through since ``now``."""
        model, state = self.stepper.model, self.stepper.state
        fault = outcome.converged and way_fault(model, replace(state, x=now.x), state)
        return replace(outcome, converged=False, reason=fault) if fault else outcome

    def _rest(self):
        """Solve without inertia from the last state of the motion, which stands where it fails."""
        now = self.path[-1]
        self._stop_motion()
        outcome = self._arrived(now, self._solve(now))
        fault = outcome.converged and state_fault(self.stepper.model, self.stepper.state)
        if fault:
            outcome = replace(outcome, converged=False, reason=fault)
        if not outcome.converged:
            self.stepper.state.x = now.x.copy()
        return outcome

    def _solve(self, start: Point, tolerance: float = 0.0, at_most: int | None = None):
        state = self.stepper.state
        held, control = self.drive.set(state, self.goal, start.q)
        state.x = start.x.copy()
        newton = self.stepper.newton
        exact, newton.tolerance = newton.tolerance, max(tolerance, newton.tolerance)
        try:
            return newton.solve(state, held, control, at_most=at_most)
        finally:
            newton.tolerance = exact

    def _stop_motion(self) -> None:
        for inertia in self.stepper.model.inertia:
            inertia.time_step = None
        for solid in self.stepper.model.solids.values():
            solid.resist(None)

    def _sound_crosses(self) -> float:
        """Time (s) in which a shear wave crosses the body: its size times √(ρ/μ)."""
        model = self.stepper.model
        solids = [s.material.density / s.material.shear_modulus for s in model.solids.values()]
        sheets = [p.sheet.density / p.sheet.stiffness for p in model.sheets.values()]
        slowest = max(solids + sheets)
        return model.diagonal * float(np.sqrt(slowest))

    def _ratio(self, velocity) -> float:
        """Kinetic by internal energy."""
        model, state = self.stepper.model, self.stepper.state
        kinetic = model.sum(sum(float(velocity @ i.momentum(velocity)) for i in model.inertia) / 2)
        return kinetic / max(model.strain_energy(state), 1e-300)
