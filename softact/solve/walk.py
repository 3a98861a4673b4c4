"""A run on its way: what has been reached, and attempts at the next equilibrium.

A ``Walk`` is what the ladder and each of its rungs is handed. What is attempted, and what is done
where Newton's method fails, is theirs.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import asdict, replace

import numpy as np

from softact.contact.dropped import PLACE, slipping, smooth
from softact.loads.load_step import LoadStep
from softact.loads.support import Support
from softact.model import Model
from softact.solve import acceptance, generalised_alpha
from softact.solve.border import Control
from softact.solve.checkpoint import Checkpoint
from softact.solve.diagnosis import causes
from softact.solve.generalised_alpha import START, GeneralisedAlpha
from softact.solve.increments import INCREMENTS, next_size
from softact.solve.newton import Counts, Loaded, Newton, NewtonOutcome, SolveOptions
from softact.solve.pace import Pace
from softact.solve.passed import Passed
from softact.solve.path import Drive, LoadDrive, Point, extrapolate
from softact.solve.progress import Attempt, Listeners, Progress, Trying
from softact.solve.ramp import Ramp, said
from softact.solve.settings import Settings
from softact.solve.settling import settled
from softact.system.term import Origin, State

# Part of a step over which the change of the loads is taken.
RATE_STEP = 1e-4
# Where the increment has come down to this part of the largest, the rungs beyond a smaller one are
# tried, but where so many attempts have gained less than this part of a step.
SMALL = 0.05
PATIENCE, LEAST_GAIN = 25, 0.01
# A limit of the load is expected where displacements grow this much faster than at first; part of
# the way to it that the next increment may go.
RUNS_AHEAD, TOWARDS_LIMIT = 1.3, 0.5
# Newton iterations more that an increment may take where solids touch, to find out what touches,
# and with friction what sticks and slips.
FOR_CONTACT = 4  # docs/contact.md
# How often the way is halved on which a first guess meets something.
HALVINGS = 4
TOO_LONG = "the increment is too long for the accuracy in time"
# A limit point is named where it is so near, as a part of the step, and displacements grow so much
# faster than at first.
NAMED, RUNS_AWAY = 0.02, 3.0
# How a state of a step with inertia was found, see ``Attempt``.
INERTIA = "inertia"
RETURNED = "that equilibrium was passed before the limit"


class Walk:
    """A run on its way through its steps.

    Of the run: state, as it is being tried; rest: the last accepted one, with its loads: nothing
    may pass through anything on the way from it; accepted: number of states so far; control: how
    the next one is sought. Of the present step, see ``begin``: its ramp and drive; path: its last
    equilibria under load control; size: next increment, largest: its bound; passed: see there;
    searched_at, traced_at: where line search and volume control were tried last; vain_before: see
    ``in_vain``.
    """

    def __init__(self, model: Model, settings: Settings, listeners: Listeners):
        self.model, self.settings, self.listeners = model, settings, listeners
        self.progress = Progress()
        self.state = model.initial_state()
        self.rest = self._copy()
        self.accepted, self.control = 0, "load"

    @functools.cached_property
    def newton(self) -> Newton:
        """Newton's method, made when all loads have made their terms and coupled their nodes."""
        s = self.settings
        newton = Newton(self.model, s.tolerance, s.max_iterations, s.factor)
        newton.watch = self._watch
        return newton

    # --- steps ----------------------------------------------------------------------------------

    def set_supports(self, supports: Sequence[Support]) -> None:
        """Change what is held from here on."""
        self.newton.set_supports(supports, self.state)

    def begin(self, number: int, step: LoadStep) -> None:
        """Begin a step, of this number in the spec, at the state as it is."""
        state, model, settings = self.state, self.model, self.settings
        self.number, self.step = number, step
        self.begun = self._copy()
        self.ramp = Ramp(state, step, self.newton.held(state), model.cavity_volume)
        self.ramp.apply(state, 0.0)
        state.clock = state.clock.arrived()
        model.forget_rates(state)
        model.contacts.check_clear(state, self.ramp.put_there)
        self.drive = LoadDrive(self.ramp)
        self.pace = Pace(step.timing, settings, model)
        self.alpha = self._begin_inertia()
        self.largest = (step.max_increment or settings.max_increment) / self.pace.strokes
        self.size = self.pace.first(self.largest)
        self.path = [Point(0.0, state.x.copy(), self.drive.loads(state))]
        held_still = not model.sum(int(self.ramp.moves_supports))
        self.may_trace = self.ramp.only_pressures and held_still and not self.ramp.timed
        self.searched_at: float | None = None
        self.traced_at: float | None = None
        self.passed = Passed(model)
        self.passed.add(0.0, state.x)
        self.vain_before = self.in_vain()

    def _begin_inertia(self) -> GeneralisedAlpha | None:
        """The increments of a step with inertia; None, with all at rest, where it has none."""
        timing = self.step.timing
        if timing is None or timing.dynamics is None:
            generalised_alpha.forget(self.state)
            return None
        alpha = GeneralisedAlpha(self.model, timing.dynamics)
        alpha.begin(self.state)
        return alpha

    def restore(self, start: Checkpoint, state: State) -> None:
        """Stand where an earlier run stood, at one of its states."""
        self.state = replace(state, x=state.x.copy())
        self.rest = self._copy()
        self.model.contacts.resume(self.state)
        self.progress.attempts = [Attempt(**attempt) for attempt in start.attempts]
        self.progress.remarks, self.progress.notes = list(start.remarks), list(start.notes)
        modes = [a.unstable_modes for a in self.progress.attempts if a.converged]
        self.newton.resume(Counts(**start.counts), modes[-1] if modes else 0)
        self.accepted = start.rows

    def resume(self, inside: Checkpoint) -> None:
        """Go on from a checkpoint inside the step that has been begun."""
        self.path, self.size, self.traced_at = inside.path, inside.size, inside.traced_at
        if inside.passed:
            self.passed.take(inside.passed)
        for point in self.path:
            self.passed.add(point.s, point.x)
        self.go_to(self.drive, self.path[-1])
        self.state.memory, self.state.clock = inside.state.memory, inside.state.clock
        self.ramp.arrived(self.state, self.path[-1].s)
        self.rest = self._copy()
        self.model.contacts.resume(self.state)

    @property
    def done(self) -> float:
        """Fraction of the step that is solved."""
        return self.path[-1].s

    @property
    def is_small(self) -> bool:
        """Whether the increment has come down so far that more than a smaller one is tried."""
        return self.size < SMALL * self.largest

    # --- attempts -------------------------------------------------------------------------------

    def _watch(self, iteration: int, residual: float) -> None:
        done = self.newton.counts.newton_iterations + iteration
        tried = (self.control, iteration, residual, done)
        self.listeners.iteration(Trying(self.step.name, self.done, *tried))

    def attempt(
        self,
        drive: Drive,
        path: Sequence[Point],
        s: float,
        at_most: int | None = None,
        line_search: bool = False,
    ) -> NewtonOutcome:
        """Seek the equilibrium at the place ``s``, from a prediction or from the last point.

        at_most: iterations, where fewer are allowed than otherwise. line_search: at each iteration.
        """
        contacts, start = self.model.contacts, path[-1]
        self.control = "search" if line_search else drive.control
        shy = self.model.is_solid and drive is self.drive and not (line_search or self.is_small)
        options = replace(self.newton.options, at_most=at_most, line_search=line_search, shy=shy)
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
            outcome = self._equilibrium(held, control, guess.origin, options)
            if outcome.converged or outcome.iterations > 1:
                break  # a guess with inverted elements ends at once: then start from the last state
        assert outcome is not None  # the last point is always among the guesses
        return outcome

    def _guesses(self, drive: Drive, path: Sequence[Point], s: float) -> list[Point]:
        """First guesses, the best first; the last point is always among them."""
        order = {"none": 0, "linear": 1, "quadratic": 2}[self.settings.predictor]
        orders = sorted({order, 1} if len(self.model.contacts) else {order}, reverse=True)
        guesses = [extrapolate(path[-(k + 1) :], s, k == 1) for k in orders if k and len(path) > 1]
        if not any(self._kinks(point) for point in (*guesses, path[-1])):
            guesses = guesses[:1]
        else:
            # Where bodies begin to touch the path has a kink, and a polynomial through it presses
            # them into each other: what is far out of balance is left out.
            errors = [self.newton.imbalance(self._loaded(drive, s, g.x)) for g in guesses]
            best = min(range(len(errors)), key=errors.__getitem__, default=None)
            guesses = [] if best is None or errors[best] > 1.0 else [guesses[best]]
        return [*guesses, path[-1]]

    def _kinks(self, point: Point) -> bool:
        """Whether contact makes kinks where the model has a point's displacements."""
        return self.model.contacts.kinks(replace(self.state, x=point.x))

    def _equilibrium(
        self,
        held: np.ndarray,
        control: Control | None,
        origin: Origin | None,
        options: SolveOptions,
    ) -> NewtonOutcome:
        outcome = self.newton.solve(self.state, held, control, origin, options)
        again = replace(options, at_most=None)
        outcome = settled(self.newton, self.state, outcome, held, control, again)
        return self.checked(outcome)

    def checked(self, outcome: NewtonOutcome) -> NewtonOutcome:
        """The outcome; failed where its state is none that follows the last one."""
        if not outcome.converged:
            return outcome
        fault = acceptance.fault(self.model, self.rest, self.state)
        return replace(outcome, converged=False, reason=fault) if fault else outcome

    def onward(self, outcome: NewtonOutcome, s: float) -> NewtonOutcome:
        """The outcome under load control; failed where its state is one of a branch that was
        left."""
        x = self.state.x
        if outcome.converged and self.passed.returned(self.path[-1].x, x, s):
            return replace(outcome, converged=False, reason=RETURNED)
        return outcome

    def advance(self) -> NewtonOutcome:
        """Try the next increment under load control."""
        least = SMALL * self.largest
        self.size = min(self.size, max(TOWARDS_LIMIT * (self.limit_ahead() - self.done), least))
        end = self.pace.next_turn(self.done)
        starts = self.alpha is not None and self.done == 0.0
        size = START * self.size if starts else self.size
        # Two halves rather than one whole and a sliver.
        target = end if self.done + 1.01 * size >= end else self.done + size
        if not starts:
            target = self._before_passing(target)
        gone = target - self.done
        outcome = self._next(target, starts)
        if not outcome.converged:
            self.reject(self.drive, self.path, target, outcome)
            return outcome
        moved, error = self._moved(target, starts)
        error = max(error, self.ramp.flow_error(self.state, target))
        in_time = self.pace.in_time(self.state, error)
        if not in_time.accepted:  # an equilibrium was found: no other rung is wanted
            self.reject(
                self.drive, self.path, target, replace(outcome, converged=False, reason=TOO_LONG)
            )
            self.size = in_time.factor * gone
            return outcome
        self.state.memory = {**self.state.memory, **moved}
        control = None if self.alpha is None else INERTIA
        self.path = self.accept(self.drive, self.path, target, outcome, control=control)
        self.passed.add(target, self.state.x)
        if not starts:
            self.size = min(self._longer(outcome), in_time.factor * gone)
        turns = end < 1.0 and target == end
        if starts or turns:
            self.path = self.path[-1:]
        if turns:
            self.size = self.pace.first(self.size)
            self.model.forget_rates(self.state)
        return outcome

    def _before_passing(self, target: float) -> float:
        """The place ``target``, or one before it up to which the first guess keeps bodies apart,
        where it does so anywhere: beyond, a kink is in the way, and what is found there may be on
        its other side."""
        path, contacts = self.path, self.model.contacts
        if not (self.model.is_solid and len(contacts) and len(path) > 1):
            return target

        def fine(s: float) -> bool:
            there = self._loaded(self.drive, s, extrapolate(path[-3:], s).x).state
            if not contacts.admissible(there, path[-1].x, there.x):
                return False
            return acceptance.way_fault(self.model, self.rest, there) is None

        if fine(target):
            return target
        low, high = self.done, target
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if fine(middle) else (low, middle)
        if low == self.done:
            return target
        self.size = low - self.done
        return low

    def _longer(self, outcome: NewtonOutcome) -> float:
        """How long the next increment may be after one that ended so."""
        if self.alpha is not None:  # the error in time says it
            return min(self.largest, INCREMENTS.growth * self.size)
        own, contacts = 0, self.model.contacts
        if contacts.kinks(self.state) and (self.model.is_solid or not contacts.symmetric):
            own = FOR_CONTACT
        return next_size(self.size, outcome.iterations - own, self.largest)

    def _next(self, target: float, starts: bool) -> NewtonOutcome:
        """Seek the state at the end of the next increment. starts: it is the first with inertia."""
        if self.alpha is None:
            return self.onward(self.attempt(self.drive, self.path, target), target)
        self.alpha.act(self.state, self.path[-1].x, self._elapsed(target), starts)
        outcome = self.attempt(self.drive, self.path, target)
        self.state.motion = None
        return outcome

    def _moved(self, target: float, starts: bool) -> tuple[dict[str, np.ndarray | float], float]:
        """What a state remembers of its motion, and the error in time; nothing without inertia."""
        if self.alpha is None:
            return {}, 0.0
        elapsed = self._elapsed(target)
        ended = self.alpha.ended(self.state, self.path[-1].x, elapsed, starts)
        return ended, 0.0 if starts else self.alpha.error(self.state, ended, elapsed)

    def _elapsed(self, target: float) -> float:
        """Time from the last state to a place in the step, s."""
        assert self.step.timing is not None  # or it has no inertia
        return (target - self.done) * self.step.timing.duration

    # --- what came of them ----------------------------------------------------------------------

    def record(self, attempt: Attempt) -> None:
        """Count an attempt and tell of it; the state is as the attempt left it."""
        self.progress.attempts.append(attempt)
        if attempt.converged:
            self.listeners.accept(self.state, attempt, self.accepted)
            self.accepted += 1
        else:
            self.listeners.reject(attempt)

    def remark(self, text: str) -> None:
        """Say what a reader has to know before he trusts the run."""
        self.progress.remarks.append(text)
        self.listeners.remark(text)

    def accept(
        self,
        drive: Drive,
        path: Sequence[Point],
        s: float,
        outcome: NewtonOutcome,
        control: str | None = None,
        kinetic_ratio: float = 0.0,
    ) -> list[Point]:
        """Take the state as the next point of a path; returns the last points.

        control, kinetic_ratio: of the ``Attempt``, where they are not those of the drive.
        """
        point = Point(s, self.state.x.copy(), drive.loads(self.state), self._rate(drive, s))
        attempt = replace(
            self._as_attempt(drive, point, outcome),
            speed=self._speed(point),
            kinetic_ratio=kinetic_ratio,
        )
        self.state.memory = self.ramp.accounted(self.state, point.s)
        # Whoever hears of it sees the forces that are in balance, friction's as they were counted.
        self.record(replace(attempt, control=control) if control else attempt)
        self.model.remember(self.state)
        self.state.clock = self.state.clock.arrived()
        self.ramp.arrived(self.state, point.s)
        self.rest = self._copy()
        return [*(replace(p, rate=None) for p in path[-2:]), point]

    def reject(self, drive: Drive, path: Sequence[Point], s: float, outcome: NewtonOutcome) -> None:
        """Go back to the last point of the path."""
        point = Point(s, self.state.x, drive.loads(self.state))
        tried = self._as_attempt(drive, point, outcome)
        self.go_to(drive, path[-1])
        self.record(tried)

    def go_to(self, drive: Drive, point: Point) -> None:
        """Put the state at a point of a path."""
        drive.set(self.state, point.s, point.q)
        self.state.x = point.x.copy()
        self.rest = self._copy()

    def checkpoint(self) -> None:
        """Hand out all that is needed to go on from here."""
        self.listeners.checkpoint(
            Checkpoint(
                self.number,
                self.begun,
                self.state,
                self.path,
                self.size,
                self.traced_at,
                self.accepted,
                [asdict(attempt) for attempt in self.progress.attempts],
                list(self.progress.remarks),
                list(self.progress.notes),
                asdict(self.newton.counts),
                passed=self.passed.kept(),
            )
        )

    def _copy(self) -> State:
        return replace(self.state, x=self.state.x.copy())

    def _as_attempt(self, drive: Drive, point: Point, outcome: NewtonOutcome) -> Attempt:
        return Attempt(
            self.step.name,
            float(drive.fraction(point)),
            outcome.iterations,
            outcome.converged,
            outcome.residuals,
            outcome.reason,
            outcome.unstable_modes - (outcome.softening if drive.holds_volume else 0),
            drive.control,
        )

    def _speed(self, point: Point) -> float:
        """Norm of the displacements' rate at a point; 0 where it is not known."""
        if point.rate is None:
            return 0.0
        owned = self.model.nodes.owned
        rate = point.rate[self.model.displacement_dofs[:owned]]
        return float(np.sqrt(self.model.sum(float((rate**2).sum()))))

    def _rate(self, drive: Drive, s: float) -> np.ndarray | None:
        """Change of the unknowns with s under load control; elsewhere they are not followed."""
        if drive.control != "load" or drive.holds_volume or s >= 1.0 or self.ramp.timed:
            return None
        here, later = (self._loaded(drive, place) for place in (s, s + RATE_STEP))
        return self.newton.rate(here, later, RATE_STEP)

    def _loaded(self, drive: Drive, s: float, x: np.ndarray | None = None) -> Loaded:
        """The state, or one with the unknowns x, under the loads of the place ``s``."""
        state = replace(self.state, x=self.state.x if x is None else x)
        held, _ = drive.set(state, s, drive.loads(state))
        return Loaded(state, held)

    # --- what the attempts so far say -----------------------------------------------------------

    @property
    def attempts(self) -> list[Attempt]:
        """Those of the present step."""
        return [a for a in self.progress.attempts if a.step == self.step.name]

    def in_vain(self) -> int:
        """Newton iterations of the run so far that brought no increment under load control.

        What was spent before the step, or before statics took over, is ``vain_before``."""
        useful = sum(
            a.iterations
            for a in self.progress.attempts
            if a.converged and a.control not in ("volume", "arc")
        )
        return self.newton.counts.newton_iterations - useful

    def stuck(self) -> bool:
        """Whether the last attempts gained next to nothing."""
        fractions = [a.fraction if a.converged else 0.0 for a in self.attempts]
        if len(fractions) <= PATIENCE:
            return False
        return max(fractions) - max(fractions[:-PATIENCE]) < LEAST_GAIN

    def faster(self) -> float:
        """Ratio of the last known speed to the first; 1 where none is known."""
        speeds = [a.speed for a in self.attempts if a.converged and a.speed > 0.0]
        return speeds[-1] / speeds[0] if speeds else 1.0

    def limit_ahead(self) -> float:
        """Fraction at which the displacements would run away; inf where they do not.

        At a limit of the load they grow with the root of the way to it, so that the inverse square
        of their speed is linear in the fraction.
        """
        last = [a for a in self.attempts if a.converged][-2:]
        if len(last) < 2 or min(a.speed for a in last) <= 0.0 or self.faster() < RUNS_AHEAD:
            return np.inf
        (one, before), (two, now) = ((a.speed**-2, a.fraction) for a in last)
        return now + two * (now - before) / (one - two) if one > two else np.inf

    def limit_point(self) -> str | None:
        """The limit of the load that is near, in words; None where there is none."""
        limit = self.limit_ahead()
        if limit - self.done > NAMED or self.faster() < RUNS_AWAY:
            return None
        return f"limit point at {self.loads_at(limit)} ({limit:.2%})"

    def loads_at(self, fraction: float) -> str:
        """The loads that change in the step, at a fraction of it, in words."""
        return said(self.model, self.ramp.changing(fraction))

    def at_limit(self) -> bool:
        """Whether pressure has come so near to a limit that only volume goes on."""
        near = self.limit_ahead() - self.done < SMALL * self.largest
        return near and self.may_trace and self.traced_at != self.done

    def no_equilibrium(self, reason: str) -> str:
        """Why there is none from here on, as what the last state says of the physics."""
        modes = next(a.unstable_modes for a in reversed(self.progress.attempts) if a.converged)
        jumps = sum(a.converged and a.control == "dynamics" for a in self.attempts)
        found = smooth(self.model, self.state, self.ramp.let_go)
        found += causes(self.model, self.state, modes, self.faster(), jumps)
        limit, dropped = self.limit_point(), slipping(self.model, self.state)
        why = [limit, *found] if limit else found or [reason]
        if dropped or reason.startswith(PLACE):  # nothing else is the cause
            why = dropped or [reason]
        loads = [
            (f, n, value) for f, named in self.state.loads.items() for n, value in named.items()
        ]
        return (
            f"no equilibrium found beyond {self.done:.2%} of step '{self.step.name}' "
            f"({said(self.model, loads)}): {'; '.join(why)}"
        )
