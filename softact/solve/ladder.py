"""One load step: adaptive increments, and what to do when Newton fails.

The ladder, in this order: a smaller increment; a line search; volume instead of pressure
(``softact.solve.rungs.volume``); quasi-static dynamics (``softact.solve.rungs.motion``). Newton's
step is always shortened before it turns an element inside out. Each rung hands back to load
control as soon as it has passed the trouble.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from itertools import takewhile

import numpy as np

from softact.solve.checkpoint import Checkpoint, told
from softact.solve.diagnosis import causes
from softact.solve.increments import CUT, next_size
from softact.solve.newton import NewtonOutcome
from softact.solve.passed import Passed
from softact.solve.path import LoadDrive, Point
from softact.solve.ramp import LoadStep, Ramp
from softact.solve.rungs import inflation
from softact.solve.rungs import motion as dynamics
from softact.solve.rungs import volume as branch
from softact.system.term import State

# Newton iterations that friction takes more, at any increment, to find out what sticks and slips.
FOR_FRICTION = 3
# The rungs between are left out where so many attempts have gained less than this part of a step.
PATIENCE, LEAST_GAIN = 25, 0.01
# Newton iterations of a step, after a first inflation, that may bring no increment under load
# control.
MOST_IN_VAIN = 600
# Volume control is tried when the increment has come down to this part of the largest.
VOLUME_BELOW = 0.05
# A limit of the load is expected where displacements grow this much faster than at first; part of
# the way to it that the next increment may go.
RUNS_AHEAD, TOWARDS_LIMIT = 1.3, 0.5
# Part of the largest increment by which a motion loads further, and how much farther the next one
# goes where nothing was gained since the last.
REACH, FARTHER = 0.2, 2.5
# Kinds of control (``Attempt``) that are motions.
MOTIONS = ("dynamics", "motion")

RETURNED = "that equilibrium was passed before the limit"


class Ladder:
    """A ``softact.solve.stepping.Stepper`` on its way through one step.

    path: the last equilibria under load control. size: next increment. searched_at, traced_at:
    where line search and volume control were tried last. passed: see ``Passed``. vain_before: see
    ``_in_vain``.
    """

    def __init__(self, stepper, number: int, step: LoadStep):
        state, settings, model = stepper.state, stepper.settings, stepper.model
        self.stepper, self.number, self.step = stepper, number, step
        self.begun = replace(state, x=state.x.copy())
        self.ramp = Ramp(state, step, stepper.newton.held(state), model.cavity_volume)
        self.ramp.apply(state, 0.0)
        model.contacts.check_clear(state, step.presence or ())
        self.drive = LoadDrive(self.ramp)
        self.largest = step.max_increment or settings.max_increment
        self.size = min(settings.initial_increment, self.largest)
        self.path = [Point(0.0, state.x.copy(), self.drive.loads(state))]
        held_still = not model.sum(int(self.ramp.moves_supports))
        self.may_trace = self.ramp.only_pressures and held_still
        self.searched_at = self.traced_at = None
        self.passed = Passed(model)
        self.passed.add(0.0, state.x)
        self.vain_before = self._in_vain()

    def resume(self, inside: Checkpoint) -> None:
        """Go on from a checkpoint inside the step."""
        stepper = self.stepper
        self.path, self.size, self.traced_at = inside.path, inside.size, inside.traced_at
        if inside.passed:
            self.passed.take(inside.passed)
        for point in self.path:
            self.passed.add(point.s, point.x)
        stepper.go_to(self.drive, self.path[-1])
        stepper.state.memory = inside.state.memory
        stepper.model.contacts.resume(stepper.state)

    def climb(self) -> str | None:
        """Solve the step; returns why it ends early, None where it does not."""
        if self.path[-1].s == 0.0 and inflation.needed(self.stepper, self.ramp):
            fault = self._inflate()
            if fault:
                return fault
        while self.path[-1].s < 1.0:
            done = self.path[-1].s
            fault = self._trace() if self._at_limit() else self._advance()
            if fault:
                return fault
            if self.path[-1].s > done:
                self._checkpoint()
        return None

    def _advance(self) -> str | None:
        """Try the next increment under load control, and help where it fails."""
        stepper, done = self.stepper, self.path[-1].s
        least = VOLUME_BELOW * self.largest
        self.size = min(self.size, max(TOWARDS_LIMIT * (self._limit_ahead() - done), least))
        # Two halves rather than one whole and a sliver.
        target = 1.0 if done + 1.01 * self.size >= 1.0 else done + self.size
        outcome = self._onward(stepper.attempt(self.drive, self.path, target), target)
        if outcome.converged:
            self.path = stepper.accept(self.step, self.drive, self.path, target, outcome)
            self.passed.add(target, stepper.state.x)
            own = 0 if stepper.model.contacts.symmetric else FOR_FRICTION
            self.size = next_size(self.size, outcome.iterations - own, self.largest)
            return None
        stepper.reject(self.step, self.drive, self.path, target, outcome)
        return self._help(outcome)

    def _onward(self, outcome: NewtonOutcome, s: float) -> NewtonOutcome:
        """The outcome; failed where its state is one of a branch that was left."""
        x = self.stepper.state.x
        if outcome.converged and self.passed.returned(self.path[-1].x, x, s):
            return replace(outcome, converged=False, reason=RETURNED)
        return outcome

    def _help(self, outcome: NewtonOutcome) -> str | None:
        """Go on after an attempt that failed; returns why that is not possible."""
        done = self.path[-1].s
        self.size *= CUT
        if self._in_vain() - self.vain_before > MOST_IN_VAIN:
            return self._no_equilibrium(outcome.reason)
        stuck = self._stuck()
        if self.size < VOLUME_BELOW * self.largest and not stuck:
            if self.searched_at != done:
                self.searched_at = done
                self._search()
                if self.path[-1].s > done:
                    return None
            if self.may_trace and self.traced_at != done:
                return self._trace()
        if stuck or self.size < self.stepper.settings.min_increment:
            return self._move_on(lambda: self._no_equilibrium(outcome.reason))
        return None

    def _search(self) -> None:
        """Try the next increment with a line search."""
        stepper, s = self.stepper, self.path[-1].s + self.size
        stepper.newton.line_search = True
        try:
            outcome = self._onward(stepper.attempt(self.drive, self.path, s), s)
        finally:
            stepper.newton.line_search = False
        if outcome.converged:
            told = {"control": "search"}
            self.path = stepper.accept(self.step, self.drive, self.path, s, outcome, **told)
            self.passed.add(s, stepper.state.x)
        else:
            stepper.reject(self.step, self.drive, self.path, s, outcome)

    def _trace(self) -> str | None:
        """Control by volume, and a motion beyond a limit that does not come back."""
        self.traced_at = self.path[-1].s
        self.passed.leave()
        found = branch.trace(
            self.stepper, self.step, self.ramp, self.path, self.size, self.largest, self.passed
        )
        if not found.limit:
            self.path, self.size = found.path, max(found.size, self.size)
            for point in self.path:
                self.passed.add(point.s, point.x)
            return None
        # Far from here there may be equilibria again.
        self.stepper.go_to(self.drive, self.path[-1])
        fault = self._move_on(lambda: found.limit)
        if fault is None:
            self.stepper.progress.remarks.insert(-1, found.snap)
        return fault

    def _move_on(self, why: Callable[[], str]) -> str | None:
        """Damped motion to the next equilibrium, where it is allowed (``dynamics.settle``); None
        where it arrives, else ``why()``."""
        settings, reach = self.stepper.settings, self._reach()
        if not settings.dynamics:
            return why()
        self.path, reached = dynamics.settle(self.stepper, self.step, self.drive, self.path, reach)
        self.size = min(settings.initial_increment, reach)
        if not reached:
            return why()
        self.passed.leave()
        self.passed.add(self.path[-1].s, self.path[-1].x)
        self.vain_before = self._in_vain()
        return None

    def _reach(self) -> float:
        """How much further (fraction of the step) a motion loads that begins now."""
        controls = [a.control for a in self._attempts if a.converged]
        moved = len(list(takewhile(lambda c: c in MOTIONS, reversed(controls))))
        return self.largest * min(1.0, REACH * FARTHER**moved)

    def _inflate(self) -> str | None:
        """Carry sheets without stiffness to their first equilibrium."""
        changes = [abs(b - a) for a, b in self.ramp.pressures.values()]
        self.path, fault = inflation.inflate(
            self.stepper, self.step, self.drive, self.path, max(changes, default=0.0), self.largest
        )
        if fault:
            return f"step '{self.step.name}' at {self.path[-1].s:.2%}: {fault}"
        self.vain_before = self._in_vain()  # statics was tried on the way
        self._checkpoint()
        return None

    def _checkpoint(self) -> None:
        stepper = self.stepper
        self.stepper.on_checkpoint(
            Checkpoint(
                self.number,
                self.begun,
                stepper.state,
                list(self.path),
                self.size,
                self.traced_at,
                stepper.accepted,
                told(stepper.progress.attempts),
                list(stepper.progress.remarks),
                list(stepper.progress.notes),
                asdict(stepper.newton.counts),
                passed=self.passed.kept(),
            )
        )

    # --- what the attempts so far say ---------------------------------------------------------

    @property
    def _attempts(self) -> list:
        return [a for a in self.stepper.progress.attempts if a.step == self.step.name]

    def _in_vain(self) -> int:
        """Newton iterations of the run so far that brought no increment under load control.

        What was spent before the step, or before statics took over, is ``vain_before``."""
        useful = sum(
            a.iterations
            for a in self.stepper.progress.attempts
            if a.converged and a.control not in ("volume", "arc")
        )
        return self.stepper.newton.counts.newton_iterations - useful

    def _stuck(self) -> bool:
        """Whether the last attempts gained next to nothing."""
        fractions = [a.fraction if a.converged else 0.0 for a in self._attempts]
        if len(fractions) <= PATIENCE:
            return False
        return max(fractions) - max(fractions[:-PATIENCE]) < LEAST_GAIN

    def _faster(self) -> float:
        """Last known speed by the first; 1 where none is known."""
        speeds = [a.speed for a in self._attempts if a.converged and a.speed > 0.0]
        return speeds[-1] / speeds[0] if speeds else 1.0

    def _limit_ahead(self) -> float:
        """Fraction at which the displacements would run away; inf where they do not.

        At a limit of the load they grow with the root of the way to it, so that the inverse square
        of their speed is linear in the fraction.
        """
        last = [a for a in self._attempts if a.converged][-2:]
        if len(last) < 2 or min(a.speed for a in last) <= 0.0 or self._faster() < RUNS_AHEAD:
            return np.inf
        (one, before), (two, now) = ((a.speed**-2, a.fraction) for a in last)
        return now + two * (now - before) / (one - two) if one > two else np.inf

    def _at_limit(self) -> bool:
        """Whether pressure has come so near to a limit that only volume goes on."""
        done = self.path[-1].s
        near = self._limit_ahead() - done < VOLUME_BELOW * self.largest
        return near and self.may_trace and self.traced_at != done

    def _no_equilibrium(self, reason: str) -> str:
        state, attempts = self.stepper.state, self.stepper.progress.attempts
        modes = next(a.unstable_modes for a in reversed(attempts) if a.converged)
        jumps = sum(a.converged and a.control == "dynamics" for a in self._attempts)
        why = causes(self.stepper.model, state, modes, self._faster(), jumps) or [reason]
        return (
            f"no equilibrium found beyond {self.path[-1].s:.2%} of step '{self.step.name}' "
            f"({_loads(state)}): {'; '.join(why)}"
        )


def _loads(state: State) -> str:
    parts = [f"{name} at {1e3 * float(p):.4g} kPa" for name, p in sorted(state.pressure.items())]
    return ", ".join(parts) or "no pressure"
