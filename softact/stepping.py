"""Load steps: ramps, adaptive increments, prediction, and what to do when Newton fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from softact.model import Model, Support
from softact.newton import Newton, NewtonOutcome
from softact.terms import State, SurfaceForce, SurfacePressure

# Newton counts that let the increment grow, and beyond which it shrinks.
EASY, HARD = 5, 8
GROWTH, SHRINK, CUT = 1.6, 0.7, 0.4


@dataclass(frozen=True)
class LoadStep:
    """Loads at the end of a step; they ramp linearly from the last ones. None: unchanged.

    pressure: cavity -> MPa. gravity: (3,) mm/s². traction: surface -> (3,) MPa.
    surface_pressure: surface -> MPa. supports: replace the ones before. shift: obstacle -> (3,) mm
    from where it was placed. presence: obstacle -> 1 (put there) or 0 (removed: its force fades
    over the step). max_increment: fraction of the step, None for the solver's.
    """

    name: str
    pressure: Mapping[str, float] | None = None
    gravity: Sequence[float] | None = None
    traction: Mapping[str, Sequence[float]] | None = None
    surface_pressure: Mapping[str, float] | None = None
    supports: Sequence[Support] | None = None
    shift: Mapping[str, Sequence[float]] | None = None
    presence: Mapping[str, float] | None = None
    max_increment: float | None = None


@dataclass(frozen=True)
class Settings:
    """How equilibrium is sought; fractions are of a step. See the spec's ``solver``."""

    initial_increment: float = 0.1
    max_increment: float = 0.1
    min_increment: float = 1e-4
    max_iterations: int = 15
    tolerance: float = 1e-8
    predictor: Literal["none", "linear", "quadratic"] = "quadratic"


@dataclass(frozen=True)
class Attempt:
    """One try at an increment, for the convergence history; see ``NewtonOutcome``."""

    step: str
    fraction: float
    iterations: int
    converged: bool
    residuals: list[float]
    reason: str
    unstable_modes: int


@dataclass
class Progress:
    """What the run has done: attempts so far and, where it stopped early, why."""

    attempts: list[Attempt] = field(default_factory=list)
    stopped: str | None = None

    @property
    def cutbacks(self) -> int:
        """Number of attempts that failed."""
        return sum(not a.converged for a in self.attempts)


class Stepper:
    """Carries a model through its steps.

    on_accept is called with (state, attempt, increment number) at each new equilibrium, and once
    with the unloaded state before the first; on_reject with each attempt that failed.
    """

    def __init__(
        self,
        model: Model,
        settings: Settings,
        on_accept: Callable[[State, Attempt, int], None],
        on_reject: Callable[[Attempt], None] = lambda attempt: None,
    ):
        self.model, self.settings = model, settings
        self.on_accept, self.on_reject = on_accept, on_reject
        self.newton = Newton(model, settings.tolerance, settings.max_iterations)
        self.progress = Progress()
        self.state = model.initial_state()
        self._accepted = 0

    def run(self, steps: Sequence[LoadStep], supports: Sequence[Support]) -> Progress:
        """Solve the steps in order; stops where no further equilibrium is found."""
        for step in steps:
            for surface in step.traction or {}:
                self.model.add_surface_load(SurfaceForce, surface)
            for surface in step.surface_pressure or {}:
                self.model.add_surface_load(SurfacePressure, surface)
        for number, step in enumerate(steps):
            held = step.supports if step.supports is not None else supports
            if number == 0 or step.supports is not None:
                self.newton.set_supports(held, self.state)
            supports = held
            if number == 0:
                self.model.contacts.check_clear(self.state)
                self.model.contacts.remember(self.state)
                self._record(Attempt(step.name, 0.0, 0, True, [], "", 0))
            if not self._solve_step(step):
                break
        return self.progress

    def _record(self, attempt: Attempt) -> None:
        self.progress.attempts.append(attempt)
        if attempt.converged:
            self.on_accept(self.state, attempt, self._accepted)
            self._accepted += 1
        else:
            self.on_reject(attempt)

    def _solve_step(self, step: LoadStep) -> bool:
        s = self.settings
        ramp = _Ramp(self.state, step, *self.newton.held(self.state))
        ramp.apply(self.state, 0.0)
        self.model.contacts.check_clear(self.state, step.presence or ())
        largest = step.max_increment or s.max_increment
        size = min(s.initial_increment, largest)
        path = [(0.0, self.state.x.copy())]
        while path[-1][0] < 1.0:
            done = path[-1][0]
            # Two halves rather than one whole and a sliver.
            target = 1.0 if done + 1.01 * size >= 1.0 else done + size
            outcome = self._attempt(ramp, path, target)
            attempt = Attempt(
                step.name,
                target,
                outcome.iterations,
                outcome.converged,
                outcome.residuals,
                outcome.reason,
                outcome.unstable_modes,
            )
            if outcome.converged:
                self.model.contacts.remember(self.state)
                path = [*path[-2:], (target, self.state.x.copy())]
                size = min(largest, size * _growth(outcome.iterations))
            else:
                ramp.apply(self.state, done)
                self.state.x = path[-1][1].copy()
                size *= CUT
            self._record(attempt)
            if size < s.min_increment:
                self.progress.stopped = (
                    f"step '{step.name}': no equilibrium found beyond {done:.2%} of the step "
                    f"({_loads(self.state)}): {outcome.reason}"
                )
                return False
        return True

    def _attempt(self, ramp: _Ramp, path, target: float) -> NewtonOutcome:
        order = {"none": 0, "linear": 1, "quadratic": 2}[self.settings.predictor]
        orders = {order, 1} if len(self.model.contacts) else {order}
        guesses = [
            extrapolate(path[-(k + 1) :], target)
            for k in sorted(orders, reverse=True)
            if k and len(path) > 1
        ]
        outcome = None
        contacts, start = self.model.contacts, path[-1][1]
        if len(contacts):
            guesses = self._nearest(guesses, start, ramp.apply(self.state, target))
        for guess in (*guesses, start):
            held = ramp.apply(self.state, target)
            if guess is not start and not contacts.admissible(self.state, start, guess):
                continue
            self.state.x = guess.copy()
            outcome = self._equilibrium(held)
            if outcome.converged or outcome.iterations > 1:
                break  # a guess with inverted elements ends at once: then start from the last state
        return outcome

    def _nearest(self, guesses, start, held) -> list[np.ndarray]:
        """The better of the guesses, or none where ``start`` is better: where bodies begin to
        touch, the path has a kink, and no polynomial goes through it."""
        best = min((*guesses, start), key=lambda x: self.newton.imbalance(self.state, x, held))
        return [] if best is start else [best]

    def _equilibrium(self, held) -> NewtonOutcome:
        """Newton, and once more with stiffer contact as long as bodies overlap too far."""
        outcome = self.newton.solve(self.state, held)
        while outcome.converged and self.model.contacts.stiffen(self.state):
            again = self.newton.solve(self.state, held)
            outcome = replace(again, iterations=outcome.iterations + again.iterations)
        return outcome


class _Ramp:
    """Loads and prescribed displacements between the start and the end of a step."""

    NAMED = ("pressure", "traction", "surface_pressure", "shift", "presence")

    def __init__(self, state: State, step: LoadStep, held_now, held_then):
        self._held = held_now, held_then
        gravity = state.gravity if step.gravity is None else np.asarray(step.gravity, float)
        self._gravity = state.gravity.copy(), gravity
        self._named = {}
        for kind in self.NAMED:
            start, change = dict(getattr(state, kind)), getattr(step, kind) or {}
            end = start | {name: np.asarray(v, float) for name, v in change.items()}
            start = {name: start.get(name, np.zeros_like(v)) for name, v in end.items()}
            if kind == "presence":  # what is put there is there from the start
                start |= {name: value for name, value in end.items() if value == 1.0}
            self._named[kind] = start, end

    def apply(self, state: State, fraction: float) -> np.ndarray:
        """Set the loads of ``state``; returns the prescribed displacements (mm)."""

        def between(start, end):
            return (1 - fraction) * start + fraction * end

        state.gravity = between(*self._gravity)
        for kind, (start, end) in self._named.items():
            setattr(state, kind, {name: between(start[name], end[name]) for name in start})
        return between(*self._held)


def extrapolate(path: Sequence[tuple[float, np.ndarray]], target: float) -> np.ndarray:
    """Lagrange polynomial through (fraction, unknowns), taken at ``target``."""
    result = np.zeros_like(path[0][1])
    for i, (t, x) in enumerate(path):
        weight = 1.0
        for j, (other, _) in enumerate(path):
            if j != i:
                weight *= (target - other) / (t - other)
        result += weight * x
    return result


def _growth(iterations: int) -> float:
    if iterations <= EASY:
        return GROWTH
    return 1.0 if iterations <= HARD else SHRINK


def _loads(state: State) -> str:
    parts = [f"{name} at {1e3 * p:.4g} kPa" for name, p in sorted(state.pressure.items())]
    return ", ".join(parts) or "no pressure"
