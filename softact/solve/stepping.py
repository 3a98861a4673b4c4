"""Load steps one after the other, and attempts at an equilibrium: prediction, Newton, contact.

What is attempted, and what is done where Newton fails, is ``softact.solve.ladder``'s.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from softact.model import Model, Support
from softact.solve import acceptance
from softact.solve.checkpoint import Checkpoint
from softact.solve.ladder import Ladder
from softact.solve.newton import Counts, Loaded, Newton, NewtonOutcome
from softact.solve.path import Drive, Point, extrapolate
from softact.solve.ramp import LoadStep
from softact.solve.settings import Settings
from softact.system.term import State, SurfaceForce, SurfacePressure

__all__ = ["Attempt", "LoadStep", "Progress", "Settings", "Stepper"]

# Part of a step over which the change of the loads is taken.
RATE_STEP = 1e-4


@dataclass(frozen=True)
class Attempt:
    """One try at an increment, for the convergence history; see ``NewtonOutcome``.

    control: "load", "search" (load, with a line search), "volume", "arc" (the way through the
    displacements), "dynamics" (an equilibrium that a damped motion has led to) or "motion" (a state
    of the first inflation, no equilibrium). kinetic_ratio: largest kinetic by internal energy on
    the way, where there was a motion. speed: norm of the displacements' change (mm) per change of
    the fraction at the equilibrium; 0 where not known.
    """

    step: str
    fraction: float
    iterations: int
    converged: bool
    residuals: list[float]
    reason: str
    unstable_modes: int
    control: str = "load"
    kinetic_ratio: float = 0.0
    speed: float = 0.0


@dataclass(frozen=True)
class Trying:
    """What is being tried: an iteration of Newton's method on the way from an accepted state.

    fraction: of the step, of that state. control: see ``Attempt``. iteration: in this solve;
    residual: relative. iterations: of the run so far.
    """

    step: str
    fraction: float
    control: str
    iteration: int
    residual: float
    iterations: int


@dataclass
class Progress:
    """What the run has done: attempts so far, remarks that a reader has to know before he trusts
    it, notes that he may read and, where it stopped early, why."""

    attempts: list[Attempt] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    stopped: str | None = None

    @property
    def cutbacks(self) -> int:
        """Number of attempts that failed."""
        return sum(not a.converged for a in self.attempts)


class Stepper:
    """Carries a model through its steps.

    on_accept is called with (state, attempt, increment number) at each new equilibrium, and once
    with the unloaded state before the first; on_reject with each attempt that failed; on_checkpoint
    after each increment from which the run could go on; on_iteration at each iteration, so that it
    has to be quick. accepted: number of states so far. control: how the next state is sought.
    rest: the last of the accepted states, with its loads; nothing may pass through anything on the
    way from it.
    """

    def __init__(
        self,
        model: Model,
        settings: Settings,
        on_accept: Callable[[State, Attempt, int], None],
        on_reject: Callable[[Attempt], None] = lambda attempt: None,
        on_checkpoint: Callable[[Checkpoint], None] = lambda checkpoint: None,
        on_iteration: Callable[[Trying], None] = lambda trying: None,
    ):
        self.model, self.settings = model, settings
        self.on_accept, self.on_reject = on_accept, on_reject
        self.on_checkpoint, self.on_iteration = on_checkpoint, on_iteration
        self.newton = Newton(model, settings.tolerance, settings.max_iterations)
        self.newton.watch = self._watch
        self.step, self.fraction, self.control = "", 0.0, "load"
        self.progress = Progress()
        self.state = model.initial_state()
        self.rest = self._copy()
        self.accepted = 0

    def run(
        self,
        steps: Sequence[LoadStep],
        supports: Sequence[Support],
        start: Checkpoint | None = None,
        begin: int | None = 0,
    ) -> Progress:
        """Solve the steps in order; stops where no further equilibrium is found.

        start: where an earlier run stood. begin: number of the step to begin with; None: go on
        inside the step of ``start``.
        """
        for step in steps:
            for surface in step.traction or {}:
                self.model.add_surface_load(SurfaceForce, surface)
            for surface in step.surface_pressure or {}:
                self.model.add_surface_load(SurfacePressure, surface)
        inside = start if begin is None else None
        first = start.step if inside else begin
        if start:
            self._restore(start, start.begun if inside else start.state)
        replaced = [step.supports for step in steps[: first + 1] if step.supports is not None]
        self.newton.set_supports(replaced[-1] if replaced else supports, self.state)
        if not start:
            self.model.contacts.check_clear(self.state)
            self.model.contacts.remember(self.state)
            self.record(Attempt(steps[0].name, 0.0, 0, True, [], "", 0))
        for number, step in enumerate(steps[first:], first):
            if number > first and step.supports is not None:
                self.newton.set_supports(step.supports, self.state)
            ladder = Ladder(self, number, step)
            self.step, self.fraction = step.name, 0.0
            if inside:
                ladder.resume(inside)
            self.progress.stopped = ladder.climb()
            if self.progress.stopped:
                break
            inside = None
        return self.progress

    def _restore(self, start: Checkpoint, state: State) -> None:
        self.state = replace(state, x=state.x.copy())
        self.rest = self._copy()
        self.model.contacts.resume(self.state)
        self.progress.attempts = [Attempt(**attempt) for attempt in start.attempts]
        self.progress.remarks, self.progress.notes = list(start.remarks), list(start.notes)
        modes = [a.unstable_modes for a in self.progress.attempts if a.converged]
        self.newton.resume(Counts(**start.counts), modes[-1] if modes else 0)
        self.accepted = start.rows

    def record(self, attempt: Attempt) -> None:
        """Count an attempt and tell of it; the state is as the attempt left it."""
        self.progress.attempts.append(attempt)
        if attempt.converged:
            self.step, self.fraction = attempt.step, attempt.fraction
            self.on_accept(self.state, attempt, self.accepted)
            self.accepted += 1
        else:
            self.on_reject(attempt)

    def _watch(self, iteration: int, residual: float) -> None:
        done = self.newton.counts.newton_iterations + iteration
        told = Trying(self.step, self.fraction, self.control, iteration, residual, done)
        self.on_iteration(told)

    def attempt(
        self, drive: Drive, path: Sequence[Point], s: float, at_most: int | None = None
    ) -> NewtonOutcome:
        """Seek the equilibrium at the place ``s``, from a prediction or from the last point, in at
        most so many iterations where fewer are allowed than otherwise."""
        contacts, start = self.model.contacts, path[-1]
        self.control = "search" if self.newton.line_search else drive.control
        drive.set(self.state, s, start.q)
        self.state.x = start.x.copy()
        overrun = contacts.overrun(self.rest, self.state)
        if overrun:
            return NewtonOutcome(False, 0, [], overrun, 0)
        outcome = None
        for guess in self._guesses(drive, path, s):
            held, control = drive.set(self.state, s, guess.q)
            if guess is not start and not contacts.admissible(self.state, start.x, guess.x):
                continue
            self.state.x = guess.x.copy()
            outcome = self._equilibrium(held, control, guess.origin, at_most)
            if outcome.converged or outcome.iterations > 1:
                break  # a guess with inverted elements ends at once: then start from the last state
        return outcome

    def _guesses(self, drive: Drive, path: Sequence[Point], s: float) -> list[Point]:
        """First guesses, the best first; the last point is always among them."""
        order = {"none": 0, "linear": 1, "quadratic": 2}[self.settings.predictor]
        touching = len(self.model.contacts) > 0
        orders = sorted({order, 1} if touching else {order}, reverse=True)
        guesses = [extrapolate(path[-(k + 1) :], s) for k in orders if k and len(path) > 1]
        if touching:
            # Where bodies begin to touch the path has a kink, and a polynomial through it presses
            # them into each other: what is far out of balance is left out.
            errors = [self.newton.imbalance(self._loaded(drive, s, g.x)) for g in guesses]
            best = min(range(len(errors)), key=errors.__getitem__, default=None)
            guesses = [] if best is None or errors[best] > 1.0 else [guesses[best]]
        return [*guesses, path[-1]]

    def _equilibrium(self, held, control, origin, at_most) -> NewtonOutcome:
        """Newton, and once more with stiffer contact as long as bodies overlap too far."""
        outcome = self.newton.solve(self.state, held, control, origin, at_most)
        while outcome.converged and self.model.contacts.stiffen(self.state):
            again = self.newton.solve(self.state, held, control)
            outcome = replace(again, iterations=outcome.iterations + again.iterations)
        return self.checked(outcome)

    def checked(self, outcome: NewtonOutcome) -> NewtonOutcome:
        """The outcome; failed where its state is none that follows the last one."""
        if not outcome.converged:
            return outcome
        fault = acceptance.fault(self.model, self.rest, self.state)
        return replace(outcome, converged=False, reason=fault) if fault else outcome

    def accept(self, step, drive, path, s, outcome, **motion) -> list[Point]:
        """Take the state as the next point of the path; returns the last points.

        motion: ``control`` and ``kinetic_ratio`` of the attempt, where there was one.
        """
        self.model.contacts.remember(self.state)
        self.rest = self._copy()
        point = Point(s, self.state.x.copy(), drive.loads(self.state), self._rate(drive, s))
        told = self._told(step, drive, point, outcome)
        self.record(replace(told, speed=self._speed(point), **motion))
        return [*(replace(p, rate=None) for p in path[-2:]), point]

    def _speed(self, point: Point) -> float:
        """Norm of the displacements' rate at a point; 0 where it is not known."""
        if point.rate is None:
            return 0.0
        owned = self.model.nodes.owned
        rate = point.rate[self.model.displacement_dofs[:owned]]
        return float(np.sqrt(self.model.sum(float((rate**2).sum()))))

    def _rate(self, drive: Drive, s: float) -> np.ndarray | None:
        """Change of the unknowns with s under load control; elsewhere they are not followed."""
        if drive.control != "load" or drive.holds_volume or s >= 1.0:
            return None
        here, later = (self._loaded(drive, place) for place in (s, s + RATE_STEP))
        return self.newton.rate(here, later, RATE_STEP)

    def _loaded(self, drive: Drive, s: float, x: np.ndarray | None = None) -> Loaded:
        """The state, or one with the unknowns x, under the loads of the place ``s``."""
        state = replace(self.state, x=self.state.x if x is None else x)
        held, _ = drive.set(state, s, drive.loads(state))
        return Loaded(state, held)

    def reject(self, step, drive, path, s, outcome) -> None:
        """Go back to the last point of the path."""
        tried = self._told(step, drive, Point(s, self.state.x, drive.loads(self.state)), outcome)
        self.go_to(drive, path[-1])
        self.record(tried)

    def go_to(self, drive: Drive, point: Point) -> None:
        """Put the state at a point of a path."""
        drive.set(self.state, point.s, point.q)
        self.state.x = point.x.copy()
        self.rest = self._copy()

    def _copy(self) -> State:
        return replace(self.state, x=self.state.x.copy())

    @staticmethod
    def _told(step, drive, point, outcome) -> Attempt:
        return Attempt(
            step.name,
            float(drive.fraction(point)),
            outcome.iterations,
            outcome.converged,
            outcome.residuals,
            outcome.reason,
            outcome.unstable_modes - (outcome.softening if drive.holds_volume else 0),
            drive.control,
        )
