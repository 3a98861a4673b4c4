"""The first inflation of sheets: implicit quasi-static dynamics from a state without stiffness.

A flat pouch has no stiffness across its plane and no volume, so statics has nothing to start from.
Here the loads grow with the smooth-step amplitude a(τ) = τ³ (10 − 15 τ + 6 τ²) over a time T, and
backward Euler carries the sheet along, M ẍ + α M ẋ + f(x) = p V'. T and α follow from the speed v
at which the kinetic energy is well below that of the final membrane strain e = p L/(2 E t):
½ ρ t v² = c² ½ E t e² (c: ``Pace.velocity``). A sheet of the size L then takes L/v for a path of
its size, and α is such that a tenth of the pressure pushes it at v. Each time step is an increment
with its ratio of kinetic to internal energy. One that is longer than it takes to leave an unstable
state would stay there: its incremental potential (Radovitzky and Ortiz 1999) has a saddle and no
minimum, as the inertia of its matrix tells, and it is cut back. As soon as the motion is
quasi-static, statics is tried: a time step without end. It takes over where the equilibrium that it
finds is stable, and no farther than time steps go; else the motion goes on. Where the work of the
loads went is told: see ``energy_balance``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from softact.solve.acceptance import state_fault
from softact.solve.energy_balance import EnergyBalance
from softact.solve.newton import NewtonOutcome, SolveOptions
from softact.solve.rungs.backward_euler import BackwardEuler
from softact.solve.rungs.base import Stopped, Trouble, Went
from softact.solve.walk import Walk


@dataclass(frozen=True)
class Pace:
    """How an inflation goes (docs/sheets.md).

    quasi_static: ratio of kinetic to internal energy, and of damping to the pressure's force.
    nothing: ratio of the stored energy of an unstressed sheet to that of a strain of 1. velocity:
    ratio of v to e times the speed of sound; largest_strain: that counts for v. slowness: ratio of
    T to L/v. at_rest: ratio of kinetic to internal energy; still: ratio of the largest displacement
    in a time step at rest to the body's size: long limbs creep against damping under forces that
    are small beside that of the pressure. first, shortest: time steps, of T; shorter: after one
    that failed; longer: Newton iterations up to which one grows, and how much. in_sight: of the way
    that contact looks ahead, for the next time step. loose: tolerance of a time step, also by the
    full pressure's force (statics: the solver's), tight: of one under the full load, tighter: of
    one that the last would have left where it was. tries_apart: time steps between tries of
    statics, doubling up to seldom under the full load and to rarely before. settling: time steps at
    most after the loads have reached their value. finest: time step, of T, down to which one that
    ends at a saddle is cut back.
    """

    quasi_static: float = 0.05
    nothing: float = 1e-14
    velocity: float = 0.1
    largest_strain: float = 0.1
    slowness: float = 6.0
    at_rest: float = 1e-6
    still: float = 1e-3
    first: float = 1e-2
    shortest: float = 1e-10
    shorter: float = 0.4
    longer: tuple[tuple[int, float], ...] = ((6, 2.0), (12, 1.5), (20, 1.1))
    in_sight: float = 0.8
    loose: float = 1e-4
    tight: float = 1e-6
    tighter: float = 1e-8
    tries_apart: int = 4
    seldom: int = 8
    rarely: int = 32
    settling: int = 200
    finest: float = 1e-5


PACE = Pace()
SADDLE = "the time step is too long to leave an unstable state"
FAR = "the equilibrium is farther than a time step goes"
UNSTABLE = "the equilibrium is unstable"


class Inflation:
    """Carries sheets that have no stiffness yet to their first equilibrium, at a step's start."""

    name = "motion"

    def may(self, walk: Walk, trouble: Trouble) -> bool:
        """See ``Rung``."""
        if not trouble.begins:
            return False
        model = walk.model
        sheets = set(model.sheets)
        walls = {n for n, names in model.mesh.layout.cavities.items() if set(names) & sheets}
        if not walls & set(walk.ramp.pressures) or not walk.settings.dynamics:
            return False
        parts = model.sheets.values()
        unit = sum(part.sheet.stiffness * part.triangles.areas.sum() for part in parts)
        return model.strain_energy(walk.state) < PACE.nothing * unit

    def climb(self, walk: Walk, trouble: Trouble) -> Went | Stopped:
        """See ``Rung``."""
        walk.control = self.name
        changes = [abs(b - a) for a, b in walk.ramp.pressures.values()]
        fault = _Inflation(walk, max(changes)).run()
        if fault:
            return Stopped(f"step '{walk.step.name}' at {walk.done:.2%}: {fault}")
        walk.vain_before = walk.in_vain()  # statics was tried on the way
        walk.checkpoint()
        return Went.ON


def smooth_step(tau: float) -> float:
    """a(τ), from 0 to 1 with no velocity and no acceleration at either end."""
    tau = min(max(tau, 0.0), 1.0)
    return tau**3 * (10 - 15 * tau + 6 * tau * tau)


class _Inflation:
    """Loads the walk from its last point on until statics holds; see the module.

    pressure: by which its time and damping are set, MPa.
    """

    def __init__(self, walk: Walk, pressure: float):
        self.walk, self.model, self.drive = walk, walk.model, walk.drive
        self.euler = BackwardEuler(walk, walk.drive)
        size, sheets = self.model.diagonal, [p.sheet for p in self.model.sheets.values()]
        softest = min(sheet.stiffness for sheet in sheets)
        sound = min(np.sqrt(sheet.stiffness / sheet.density) for sheet in sheets)
        strain = min(pressure * size / (2 * softest), PACE.largest_strain)
        speed = PACE.velocity * strain * float(sound)
        self.duration = PACE.slowness * size / speed
        self.damping = 0.1 * pressure / (speed * max(sheet.density for sheet in sheets))
        self.worst = 0.0
        self.quasi_static_from: float | None = None
        self.pressure_force = self._full_force(pressure)
        self.held_back, self.tight = 0.0, False
        start = walk.path[-1]
        self.balance = EnergyBalance(
            self.model, walk.newton, walk.drive, walk.state, start.s, start.q
        )

    def _full_force(self, pressure: float) -> float:
        """Norm of the nodal forces of the pressure on the sheets as they lie, N."""
        gradient = np.zeros(self.model.unknowns.local)
        for cavity in self.model.cavities.values():
            cavity.add_volume_gradient(self.walk.path[-1].x, pressure, gradient)
        return float(np.linalg.norm(gradient))

    def run(self) -> str | None:
        """Why it stopped early, None where it did not."""
        walk, model, state = self.walk, self.model, self.walk.state
        start, x = walk.path[-1], walk.path[-1].x
        velocity, time, q = np.zeros_like(x), 0.0, start.q
        time_step, steps, next_try, after = PACE.first * self.duration, 0, 0, 0
        apart, ratio = PACE.tries_apart, np.inf
        while after < PACE.settling:
            if time_step < PACE.shortest * self.duration:
                return self._end("the time steps of the inflation became too short")
            s = self._load(start.s, time + time_step)
            if s - walk.path[-1].s > 1.01 * walk.largest:
                time_step *= PACE.shorter
                continue
            self.euler.move(x, velocity, time_step, self.damping)
            outcome = self._next(x, s, q)
            strayed = model.contacts.strayed(state)
            if time_step > PACE.finest * self.duration:
                outcome = self._at_minimum(outcome)
            if not outcome.converged:
                walk.reject(self.drive, walk.path, s, outcome)
                time_step *= PACE.shorter
                continue
            time, steps = time + time_step, steps + 1
            moved = float(np.abs(state.x - x).max())
            velocity, x, q = (state.x - x) / time_step, state.x.copy(), self.drive.loads(state)
            ratio = self._keep(s, q, outcome, velocity, time_step)
            after += s >= 1.0
            still = ratio < PACE.at_rest and moved < PACE.still * model.diagonal
            at_rest = s >= 1.0 and still
            if s >= 1.0 and apart > PACE.seldom:
                next_try, apart = min(next_try, steps), PACE.seldom
            if ratio < PACE.quasi_static and (steps >= next_try or at_rest):
                refused = self._statics(s, q, max(moved, PACE.still * model.diagonal))
                if refused is None:
                    return self._end(None)
                apart = min(2 * apart, PACE.seldom if s >= 1.0 else PACE.rarely)
                next_try, state.x = steps + apart, x.copy()
                if at_rest and refused != UNSTABLE:  # which motion would leave
                    return self._come_to_rest("came to rest" if self.tight else "may still creep")
            factor = next((f for n, f in PACE.longer if outcome.iterations <= n), PACE.shorter)
            # What strayed farther was looked at when the state was accepted.
            time_step *= min(factor, PACE.in_sight / np.clip(strayed, 1e-300, 1.0))
        if ratio < PACE.at_rest:
            return self._come_to_rest("still creep")  # after ``settling`` time steps
        return self._end("the sheets do not come to rest under the full load")

    def _come_to_rest(self, what: str) -> str | None:
        self.walk.remark(
            f"step '{self.walk.step.name}': the sheets {what} at the end, where they are in "
            f"balance to {PACE.loose:g} of their forces and not to the solver's tolerance: which "
            "folds are slack is not decided further"
        )
        return self._end(None)

    def _load(self, begun: float, time: float) -> float:
        return begun + (1 - begun) * smooth_step(time / self.duration)

    def _next(self, x: np.ndarray, s: float, q: np.ndarray) -> NewtonOutcome:
        """Outcome of a time step from x. Under the full load to ``tight``, where that is found:
        else a long limb, which small forces move far, would be taken to rest; to ``tighter`` where
        x is in balance to ``tight``, for it would stay there whatever the time step."""
        if s < 1.0:
            return self._solve(x, s, q)
        outcome = self._solve(x, s, q, PACE.tight)
        self.tight = outcome.converged
        if self.tight and outcome.iterations:
            return outcome
        again = self._solve(x, s, q, PACE.tighter if self.tight else PACE.loose)
        if self.tight and not again.converged:
            self.walk.state.x = x.copy()
            return outcome
        return again

    def _solve(
        self, x: np.ndarray, s: float, q: np.ndarray, tolerance: float = PACE.loose
    ) -> NewtonOutcome:
        floor = tolerance * self.pressure_force
        options = SolveOptions(tolerance, force_floor=floor, line_search=True)
        return self.euler.solve(x, s, q, options, self.walk.rest)

    def _keep(
        self,
        s: float,
        q: np.ndarray,
        outcome: NewtonOutcome,
        velocity: np.ndarray,
        time_step: float,
    ) -> float:
        """Record an increment; returns the ratio of its kinetic to its internal energy."""
        self.euler.still()
        balance, walk = self.balance, self.walk
        balance.move(s, q, velocity, time_step, self.damping)
        ratio = balance.kinetic / max(self.model.strain_energy(walk.state), 1e-300)
        if self.quasi_static_from is None and ratio < PACE.quasi_static and balance.damped > 0:
            self.quasi_static_from = s
        if self.quasi_static_from is not None:
            self.worst = max(self.worst, ratio)
            drag = self.damping * float(np.linalg.norm(self.model.momentum(velocity)))
            self.held_back = max(self.held_back, drag / (s * self.pressure_force))
        outcome = replace(outcome, unstable_modes=0)  # of no equilibrium, but of a motion
        self.model.contacts.stiffen(walk.state)  # for the next time step
        walk.path = walk.accept(self.drive, walk.path, s, outcome, Inflation.name, ratio)
        return ratio

    def _falls(self, outcome: NewtonOutcome) -> bool:
        """Whether the potential falls in some direction from where Newton's method ended."""
        held = outcome.softening if self.drive.holds_volume else 0
        return outcome.converged and outcome.iterations > 0 and outcome.unstable_modes > held

    def _at_minimum(self, outcome: NewtonOutcome) -> NewtonOutcome:
        """The outcome of a time step; failed where it is no minimum of its potential."""
        return replace(outcome, converged=False, reason=SADDLE) if self._falls(outcome) else outcome

    def _statics(self, s: float, q: np.ndarray, reach: float) -> str | None:
        """Why the equilibrium that Newton's method finds from the state is not taken; None: it is
        the last point of the path now. reach: how far (mm) a displacement may be from there."""
        self.euler.still()
        walk, state = self.walk, self.walk.state
        begun = state.x.copy()
        options = replace(walk.newton.options, line_search=True)
        outcome = self.euler.solve(begun, s, q, options, walk.rest, settled=True)
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
        walk.path = walk.accept(self.drive, walk.path[-1:], s, outcome)[-1:]
        return None

    def _end(self, fault: str | None) -> str | None:
        self.euler.still()
        walk = self.walk
        walk.go_to(self.drive, walk.path[-1])
        begun, end = self.quasi_static_from, walk.path[-1].s
        slow = begun is not None and max(self.worst, self.held_back) <= PACE.quasi_static
        if begun is None:
            said = "its kinetic energy never fell below 5 % of the internal energy"
        else:
            verdict = ": more than quasi-static motion may have" * (self.worst > PACE.quasi_static)
            motion = ": increments of a motion, not equilibria" * (
                self.held_back > PACE.quasi_static
            )
            said = (
                f"quasi-static from {begun:.2%} on, where the kinetic energy is at most "
                f"{self.worst:.2%} of the internal energy{verdict} and damping takes at most "
                f"{self.held_back:.2%} of the pressure's force{motion}"
            )
        said += f"; {self._energies()}"
        (walk.progress.notes if slow else walk.progress.remarks).append(
            f"step '{walk.step.name}': inflated by implicit dynamics to {end:.2%}, {said}"
        )
        return fault

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
