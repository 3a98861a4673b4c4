"""The last rung: let the actuator move to its next equilibrium.

Implicit quasi-static dynamics with the mass of the material and a viscosity of its solids
(``Solid.resist``). The backward Euler method damps the motion, too, the more the longer the time
step; steps grow until the body rests, and Newton without inertia then confirms the equilibrium. The
path between is that of an overdamped body; the largest ratio of kinetic to internal energy on it is
reported. Mass alone holds back what moves as a whole, and not what snaps locally
(docs/performance.md).
"""

from __future__ import annotations

import numpy as np

from softact.drive import Point

MOST_TIME_STEPS, MOST_ITERATIONS = 100, 200
MOST_OF_SHEETS = 400  # iterations where sheets without stiffness move far
SLOWER, QUICKER = 1.6, 0.3
SHORTEST = 1e-4  # of the first time step
RELAXATION = 10.0  # viscosity by shear modulus, in times that a shear wave takes through the body
# Kinetic by internal energy below which the body is taken to rest, and above which the motion is
# not quasi-static.
AT_REST, QUASI_STATIC = 1e-9, 0.05


def settle(stepper, step, drive, path: list[Point], largest: float) -> tuple[list[Point], bool]:
    """Load further by ``largest`` of the step and let the body come to rest.

    Returns the path from there and whether an equilibrium was found; the state is at its end.
    """
    motion = _Motion(stepper, drive, path[-1], min(1.0, path[-1].s + largest))
    outcome = motion.run()
    if outcome is None or not outcome.converged:
        stepper.go_to(drive, path[-1])
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


class _Motion:
    def __init__(self, stepper, drive, start: Point, goal: float):
        self.stepper, self.drive, self.start, self.goal = stepper, drive, start, goal
        self.kinetic_ratio, self.time_steps = 0.0, 0

    def run(self):
        """Outcome of the static solve after the motion; None where it did not come to rest."""
        model, state = self.stepper.model, self.stepper.state
        model.add_inertia()
        x, velocity = self.start.x, np.zeros_like(self.start.x)
        first = time_step = self._sound_crosses()
        q = self.start.q
        counts = self.stepper.newton.counts
        most = MOST_OF_SHEETS if model.sheets else MOST_ITERATIONS
        last = counts.newton_iterations + most
        while (
            self.time_steps < MOST_TIME_STEPS
            and time_step > SHORTEST * first
            and counts.newton_iterations < last
        ):
            self.time_steps += 1
            for inertia in model.inertia:
                inertia.time_step, inertia.away_from = time_step, x + time_step * velocity
            for solid in model.solids.values():
                solid.resist(x, RELAXATION * first / time_step)
            state.x = x.copy()
            outcome = self._solve(q)
            if not outcome.converged:
                time_step *= QUICKER
                continue
            velocity, x, q = (state.x - x) / time_step, state.x.copy(), self.drive.loads(state)
            ratio = self._ratio(velocity)
            self.kinetic_ratio = max(self.kinetic_ratio, ratio)
            if ratio < AT_REST:
                self._stop_motion()
                outcome = self._solve(q)
                if outcome.converged:
                    return outcome
                state.x = x.copy()
            time_step *= SLOWER
        self._stop_motion()
        return None

    def _solve(self, q):
        held, control = self.drive.set(self.stepper.state, self.goal, q)
        return self.stepper.newton.solve(self.stepper.state, held, control)

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
