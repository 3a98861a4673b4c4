"""The first inflation of sheets: implicit quasi-static dynamics from a state without stiffness.

A flat pouch has no stiffness across its plane and no volume, so statics has nothing to start from.
Here the loads grow with the smooth-step amplitude a(τ) = τ³ (10 − 15 τ + 6 τ²) over a time T, and
backward Euler carries the sheet along, M ẍ + α M ẋ + f(x) = p V'. T and α follow from the speed v
at which the kinetic energy is well below that of the final membrane strain e = p L/(2 E t):
½ ρ t v² = VELOCITY² ½ E t e². A sheet of the size L then takes L/v for a path of its size, and α is
such that a tenth of the pressure pushes it at v. Each time step is an increment with its kinetic by
internal energy. One that is longer than it takes to leave an unstable state would stay there: its
incremental potential (Radovitzky and Ortiz 1999) has a saddle and no minimum, as the inertia of its
matrix tells, and it is cut back. As soon as the motion is quasi-static, statics is tried: a time
step without end. It takes over where the equilibrium that it finds is stable, and no farther than
time steps go; else the motion goes on. Where the work of the loads went is told: see ``balance``.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from softact.solve.acceptance import state_fault, way_fault
from softact.solve.energy_balance import EnergyBalance
from softact.solve.path import Point

QUASI_STATIC = 0.05  # kinetic by internal energy; damping by the pressure's force
NOTHING = 1e-14  # stored energy of an unstressed sheet by that of a strain of 1
VELOCITY = 0.1  # v by e times the speed of sound
LARGEST_STRAIN = 0.1  # that counts for v
SLOWNESS = 6.0  # T by L/v
AT_REST = 1e-6  # kinetic by internal energy
# Largest displacement in a time step at rest, by the body's size: long limbs creep against damping
# under forces that are small beside that of the pressure.
STILL = 1e-3
FIRST, SHORTEST = 1e-2, 1e-10  # time steps, of T
SHORTER = 0.4  # after a time step that failed
LONGER = ((6, 2.0), (12, 1.5), (20, 1.1))  # Newton iterations up to which one grows, and how much
IN_SIGHT = 0.8  # of the way that contact looks ahead, for the next time step
LOOSE = 1e-4  # tolerance of a time step, also by the full pressure's force; statics: the solver's
TIGHT = 1e-6  # ... of one under the full load
TIGHTER = 1e-8  # ... and of one that the last would have left where it was
TRIES_APART = 4  # time steps between tries of statics, doubling
SELDOM = 8  # ... at most under the full load
SETTLING = 200  # time steps at most after the loads have reached their value
# Time step, of T, down to which one that ends at a saddle is cut back.
FINEST = 1e-5
SADDLE = "the time step is too long to leave an unstable state"
FAR = "the equilibrium is farther than a time step goes"
UNSTABLE = "the equilibrium is unstable"


def needed(stepper, ramp) -> bool:
    """Whether a step inflates sheets that carry nothing yet."""
    model = stepper.model
    walls = {n for n, names in model.mesh.layout.cavities.items() if set(names) & set(model.sheets)}
    pressed = walls & set(ramp.pressures)
    if not pressed or not stepper.settings.dynamics:
        return False
    unit = sum(part.sheet.stiffness * part.triangles.areas.sum() for part in model.sheets.values())
    return model.strain_energy(stepper.state) < NOTHING * unit


def smooth_step(tau: float) -> float:
    """a(τ), from 0 to 1 with no velocity and no acceleration at either end."""
    tau = min(max(tau, 0.0), 1.0)
    return tau**3 * (10 - 15 * tau + 6 * tau * tau)


def inflate(stepper, step, drive, path: list[Point], pressure: float, largest: float):
    """Load from ``path[-1]`` on until statics holds; see the module.

    pressure: largest change of the step, MPa. Returns the path and why it stopped early, None where
    it did not.
    """
    stepper.control = "motion"
    return _Inflation(stepper, step, drive, path, pressure, largest).run()


class _Inflation:
    def __init__(self, stepper, step, drive, path, pressure, largest):
        self.stepper, self.step, self.drive, self.path = stepper, step, drive, path
        self.model, self.largest = stepper.model, largest
        size, sheets = self.model.diagonal, [p.sheet for p in self.model.sheets.values()]
        softest = min(sheet.stiffness for sheet in sheets)
        sound = min(np.sqrt(sheet.stiffness / sheet.density) for sheet in sheets)
        strain = min(pressure * size / (2 * softest), LARGEST_STRAIN)
        speed = VELOCITY * strain * float(sound)
        self.duration = SLOWNESS * size / speed
        self.damping = 0.1 * pressure / (speed * max(sheet.density for sheet in sheets))
        self.worst, self.quasi_static_from = 0.0, None
        self.pressure_force = self._full_force(pressure)
        self.held_back, self.tight = 0.0, False
        start = path[-1]
        self.balance = EnergyBalance(
            self.model, stepper.newton, drive, stepper.state, start.s, start.q
        )

    def _full_force(self, pressure: float) -> float:
        """Norm of the nodal forces of the pressure on the sheets as they lie, N."""
        gradient = np.zeros(self.model.unknowns.local)
        for cavity in self.model.cavities.values():
            cavity.add_volume_gradient(self.path[-1].x, pressure, gradient)
        return float(np.linalg.norm(gradient))

    def run(self):
        model, state = self.model, self.stepper.state
        model.add_inertia()
        start, x = self.path[-1], self.path[-1].x
        velocity, time, q = np.zeros_like(x), 0.0, start.q
        time_step, steps, next_try, apart, after = FIRST * self.duration, 0, 0, TRIES_APART, 0
        while after < SETTLING:
            if time_step < SHORTEST * self.duration:
                return self._end("the time steps of the inflation became too short")
            s = self._load(start.s, time + time_step)
            if s - self.path[-1].s > 1.01 * self.largest:
                time_step *= SHORTER
                continue
            self._move_from(x, velocity, time_step)
            state.x = x.copy()
            outcome = self._next(x, s, q)
            outcome = self._arrived(x, outcome)
            strayed = model.contacts.strayed(state)
            if time_step > FINEST * self.duration:
                outcome = self._at_minimum(outcome)
            if not outcome.converged:
                self.stepper.reject(self.step, self.drive, self.path, s, outcome)
                time_step *= SHORTER
                continue
            time, steps = time + time_step, steps + 1
            moved = float(np.abs(state.x - x).max())
            velocity, x, q = (state.x - x) / time_step, state.x.copy(), self.drive.loads(state)
            ratio = self._keep(s, q, outcome, velocity, time_step)
            after += s >= 1.0
            at_rest = s >= 1.0 and ratio < AT_REST and moved < STILL * model.diagonal
            if s >= 1.0 and apart > SELDOM:
                next_try, apart = min(next_try, steps), SELDOM
            if ratio < QUASI_STATIC and (steps >= next_try or at_rest):
                refused = self._statics(s, q, max(moved, STILL * model.diagonal))
                if refused is None:
                    return self._end(None)
                apart = min(2 * apart, SELDOM if s >= 1.0 else 32)
                next_try, state.x = steps + apart, x.copy()
                if at_rest and refused != UNSTABLE:  # which motion would leave
                    return self._come_to_rest("came to rest" if self.tight else "may still creep")
            factor = next((f for n, f in LONGER if outcome.iterations <= n), SHORTER)
            time_step *= min(factor, IN_SIGHT / max(strayed, 1e-300))
        if ratio < AT_REST:
            return self._come_to_rest("still creep")  # after SETTLING time steps
        return self._end("the sheets do not come to rest under the full load")

    def _come_to_rest(self, what: str):
        self.stepper.progress.remarks.append(
            f"step '{self.step.name}': the sheets {what} at the end, where they are in balance "
            f"to {LOOSE:g} of their forces and not to the solver's tolerance: which folds are "
            "slack is not decided further"
        )
        return self._end(None)

    def _load(self, begun: float, time: float) -> float:
        return begun + (1 - begun) * smooth_step(time / self.duration)

    def _next(self, x, s, q):
        """Outcome of a time step from x. Under the full load to TIGHT, where that is found: else a
        long limb, which small forces move far, would be taken to rest; to TIGHTER where x is in
        balance to TIGHT, for it would stay there whatever the time step."""
        if s < 1.0:
            return self._solve(s, q, search=True)
        outcome = self._solve(s, q, TIGHT, search=True)
        self.tight = outcome.converged
        if self.tight and outcome.iterations:
            return outcome
        state = self.stepper.state
        state.x = x.copy()
        again = self._solve(s, q, TIGHTER if self.tight else LOOSE, search=True)
        if self.tight and not again.converged:
            state.x = x.copy()
            return outcome
        return again

    def _solve(self, s, q, tolerance=LOOSE, search=False):
        held, control = self.drive.set(self.stepper.state, s, q)
        newton, model = self.stepper.newton, self.model
        wanted = newton.tolerance, model.force_floor
        newton.line_search = search
        if tolerance:
            newton.tolerance, model.force_floor = tolerance, tolerance * self.pressure_force
        try:
            return newton.solve(self.stepper.state, held, control)
        finally:
            newton.tolerance, model.force_floor = wanted
            newton.line_search = False

    def _move_from(self, x, velocity, time_step) -> None:
        """Inertia and damping of one step of backward Euler, M (c (x − x₀) − v₀/Δt) with
        c = 1/Δt² + α/Δt, as the inertia of a step of its own."""
        factor = 1 / time_step**2 + self.damping / time_step
        for inertia in self.model.inertia:
            inertia.time_step = factor**-0.5
            inertia.away_from = x + velocity / (time_step * factor)

    def _keep(self, s, q, outcome, velocity, time_step) -> float:
        """Record an increment; returns its kinetic by internal energy."""
        self._without_inertia()
        balance = self.balance
        balance.move(s, q, velocity, time_step, self.damping)
        ratio = balance.kinetic / max(self.model.strain_energy(self.stepper.state), 1e-300)
        if self.quasi_static_from is None and ratio < QUASI_STATIC and balance.damped > 0:
            self.quasi_static_from = s
        if self.quasi_static_from is not None:
            self.worst = max(self.worst, ratio)
            drag = self.damping * float(np.linalg.norm(balance.momentum(velocity)))
            self.held_back = max(self.held_back, drag / (s * self.pressure_force))
        outcome = replace(outcome, unstable_modes=0)  # of no equilibrium, but of a motion
        self.model.contacts.stiffen(self.stepper.state)  # for the next time step
        told = {"control": "motion", "kinetic_ratio": ratio}
        self.path = self.stepper.accept(self.step, self.drive, self.path, s, outcome, **told)
        return ratio

    def _falls(self, outcome) -> bool:
        """Whether the potential falls in some direction from where Newton's method ended."""
        held = outcome.softening if self.drive.holds_volume else 0
        return outcome.converged and outcome.iterations > 0 and outcome.unstable_modes > held

    def _at_minimum(self, outcome):
        """The outcome of a time step; failed where it is no minimum of its potential."""
        return replace(outcome, converged=False, reason=SADDLE) if self._falls(outcome) else outcome

    def _statics(self, s, q, reach: float) -> str | None:
        """Why the equilibrium that Newton's method finds from the state is not taken; None: it is
        the last point of the path now. reach: how far (mm) a displacement may be from there."""
        self._without_inertia()
        state, contacts = self.stepper.state, self.model.contacts
        begun = state.x.copy()
        outcome = self._solve(s, q, tolerance=0.0, search=True)
        while outcome.converged and contacts.stiffen(state):
            again = self._solve(s, q, tolerance=0.0, search=True)
            outcome = replace(again, iterations=outcome.iterations + again.iterations)
        outcome = self._arrived(begun, outcome)
        if not outcome.converged:
            return outcome.reason
        fault = state_fault(self.model, state)
        if fault:
            return fault
        if self._falls(outcome):
            return UNSTABLE
        if np.abs(state.x - begun).max() > reach:
            return FAR
        self.balance.move(s, q)
        self.path = self.stepper.accept(self.step, self.drive, self.path[-1:], s, outcome)[-1:]
        return None

    def _arrived(self, x: np.ndarray, outcome):
        """The outcome; failed where something was passed through on the way from ``x``."""
        state = self.stepper.state
        before = replace(self.stepper.rest, x=x)
        fault = outcome.converged and way_fault(self.model, before, state)
        return replace(outcome, converged=False, reason=fault) if fault else outcome

    def _without_inertia(self):
        for inertia in self.model.inertia:
            inertia.time_step = None

    def _end(self, fault: str | None):
        self._without_inertia()
        self.stepper.go_to(self.drive, self.path[-1])
        begun, end = self.quasi_static_from, self.path[-1].s
        slow = begun is not None and max(self.worst, self.held_back) <= QUASI_STATIC
        if begun is None:
            told = "its kinetic energy never fell below 5 % of the internal energy"
        else:
            verdict = ": more than quasi-static motion may have" * (self.worst > QUASI_STATIC)
            motion = ": increments of a motion, not equilibria" * (self.held_back > QUASI_STATIC)
            told = (
                f"quasi-static from {begun:.2%} on, where the kinetic energy is at most "
                f"{self.worst:.2%} of the internal energy{verdict} and damping takes at most "
                f"{self.held_back:.2%} of the pressure's force{motion}"
            )
        told += f"; {self._energies()}"
        progress = self.stepper.progress
        (progress.notes if slow else progress.remarks).append(
            f"step '{self.step.name}': inflated by implicit dynamics to {end:.2%}, {told}"
        )
        return self.path, fault

    def _energies(self) -> str:
        """Where the work went, of the whole actuator."""
        balance, copies = self.balance, self.model.mesh.layout.copies
        each = balance.work, balance.stored, balance.kinetic, balance.damped, balance.lost
        work, stored, moving, damped, lost = (f"{copies * energy:.4g} mJ" for energy in each)
        return (
            f"of the loads' work of {work}, {stored} became strain energy and {moving} motion, "
            f"damping took {damped} and the time steps {lost}; {balance.unexplained:.2%} are "
            "unexplained"
        )
