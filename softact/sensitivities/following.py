"""The derivatives of all measures by all parameters at each accepted state of a run.

A parameter's twin (``twin.py``) is the actuator with a little more (h) of it. It is put beside the
run's state, at the distance that it had at the last one and under its own loads, and brought to its
own equilibrium:

    δx ← δx − K⁻¹ (R(x + δx, θ + h) − R(x, θ)),  dm/dθ = (m(x + δx, θ + h) − m(x, θ)) / h

What δx converges to does not depend on the factors: those of the last Newton step mostly do. What
is left after two corrections is seen of the parameter with the largest second one, and where bodies
may go slack of each; where that is too much, the tangent at the state is factorised for all. With
prescribed volumes the pressures of their cavities follow by block elimination, as in
``softact.solve.border``.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from softact.errors import SpecError
from softact.sensitivities.twin import Twin
from softact.solve.checkpoint import Checkpoint, loads_of, plain_loads
from softact.solve.responses import Responses
from softact.system.term import State

if TYPE_CHECKING:
    from softact.solve.progress import Attempt
    from softact.solve.walk import Walk

#: The measures of a twin: the columns of curve.csv.
Evaluate = Callable[[Twin], dict[str, Any]]
JUMPED = "the actuator has jumped, and where it lands depends on the way"
SLIPPED = "something with friction touches, and where it sticks depends on the way"
REMEMBERED = "a material remembers where it has been, and no derivative of that is kept yet"
FILLED = "air flows into a cavity or is shut up in it, and no derivative of that is kept yet"
MOVED = "the actuator moves with inertia, and no derivative of that is kept yet"
NONE = "the run was begun without sensitivities, and goes on without them; for them start it anew"
OTHERS = "the run was begun with other parameters (-p); resume it with the same ones"
SINGULAR = "the tangent has no inverse there"


@dataclass(frozen=True)
class Slopes:
    """Derivatives at one state: parameter's path -> measure -> in internal units of the
    parameter."""

    of: Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Finding:
    """What is asked of a twin; all by the way from the actuator's state.

    accurate: what the next correction would be, as far as the last one tells. rounding: corrections
    below it are that, seen on the glove's finger. rough: where one larger than this is left, the
    twin is not found there. enough: corrections after which the rest mostly is rounding: the first
    finds the strains, the second what their stresses have done on the way to softer directions
    (docs/sensitivities.md). most: corrections.
    """

    accurate: float = 2e-5
    rounding: float = 5e-5
    rough: float = 1e-3
    enough: int = 2
    most: int = 8


FINDING = Finding()
NEXT_TO_NOTHING = 1e-6  # mm


@dataclass(frozen=True)
class _Here:
    """An accepted state, its part of the step, the force (local,) N out of balance there, the
    derivatives of prescribed volumes, and the supported unknowns."""

    state: State
    fraction: float
    force: np.ndarray
    pushes: Sequence[np.ndarray]
    fixed: np.ndarray


def _arrived(step: float, before: float) -> bool:
    """Whether a twin needs no further correction after one by ``step``, and before it one by
    ``before``."""
    return step <= FINDING.rounding or step**2 <= FINDING.accurate * before


class Following:
    """Carries the twins of a run along. walk: the run's own; ended: why there are no derivatives
    any more, and from which pressure on."""

    def __init__(self, walk: Walk, twins: Sequence[Twin], evaluate: Evaluate):
        self.walk, self.twins, self._evaluate = walk, list(twins), evaluate
        self.ended: str | None = None
        self._step: int | None = None
        self._before = walk.state.x.copy()  # the actuator's last state
        self._lost: set[str] = set()  # parameters whose twins were not found at the state
        self.times = {"equilibria": 0.0, "measures": 0.0}

    def accept(
        self, state: State, attempt: Attempt, number: int, row: Mapping[str, Any]
    ) -> Slopes | None:
        """The derivatives at an accepted state of this number, whose measures are ``row``; None
        where there are none. Collective."""
        self.ended = self.ended or self._end(state, attempt, number)
        if self.ended or attempt.control == "motion":
            return None
        if number == 0:  # at rest nothing moves
            for twin in self.twins:
                twin.look_beside(self.walk.model, state)
        else:
            self._follow_steps()
            if not self._solve(state, attempt.fraction):
                self.ended = SINGULAR
                return None
        return self._measured(row)

    def _end(self, state: State, attempt: Attempt, number: int) -> str | None:
        model = self.walk.model
        loads = self.walk.step.loads if number else {}  # at rest no step has begun
        contacts = model.contacts
        if attempt.control == "dynamics":
            return JUMPED
        if number and model.remembering:
            return REMEMBERED
        if number and self.walk.alpha is not None:
            return MOVED
        if any(loads.get(key) for key in ("supply", "exhaust", "sealed")):
            return FILLED
        return SLIPPED if not contacts.symmetric and contacts.touch(state) else None

    def _follow_steps(self) -> None:
        """Begin a step where the run has begun one since the last state."""
        number = self.walk.number
        if number == self._step:
            return
        for twin in self.twins:
            if self._step is not None:
                twin.end()
            twin.begin(number)
        self._step = number

    def skip_to(self, number: int, row: Mapping[str, Any]) -> None:
        """Put the twins, at rest, before the step of this number, with the loads that the earlier
        ones leave. row: what is counted on from it."""
        for earlier in range(number):
            for twin in self.twins:
                twin.pass_over(earlier)
        for twin in self.twins:
            twin.row = {**twin.row, **row}

    # --- kept -----------------------------------------------------------------------------------

    def kept(self) -> tuple[dict[str, Any], list[np.ndarray]]:
        """What a run needs to go on with its twins: plain data, and unknowns (local,)."""
        known = {
            twin.path: {
                "begun": plain_loads(twin.begun),
                "now": plain_loads(twin.state),
                "row": twin.row,
            }
            for twin in self.twins
        }
        vectors = [x for twin in self.twins for x in (twin.begun.x, twin.state.x)]
        return {"twins": known, "ended": self.ended}, vectors

    def resume(self, start: Checkpoint, begin: int | None) -> None:
        """Go on as the run does, see ``softact.solve.stepping.Stepper.run``.

        Raises SpecError where the earlier run had other twins.
        """
        known = start.beside.get("twins", {})
        if list(known) != [twin.path for twin in self.twins]:
            raise SpecError(OTHERS if known else NONE)
        inside = begin is None
        first = start.step if begin is None else begin
        pairs = zip(start.vectors[::2], start.vectors[1::2], strict=True)
        for twin, (begun, now) in zip(self.twins, pairs, strict=True):
            of = known[twin.path]
            began = State(begun.copy(), loads_of(of["begun"]))
            twin.restore(first, inside, began, State(now.copy(), loads_of(of["now"])), of["row"])
        self.ended = start.beside["ended"]
        self._step = first if inside else None

    # --- the twins' equilibria ------------------------------------------------------------------

    def _solve(self, state: State, fraction: float) -> bool:
        """Bring the twins to their equilibria beside ``state``; whether these could be found."""
        started = time.perf_counter()
        model = self.walk.model
        fixed = np.flatnonzero(model.assembler.fixed)
        respond = Responses(self.walk.newton, state)
        here = _Here(state, fraction, model.force(state)[0], self._pushes(state, fixed), fixed)
        for twin in self.twins:
            twin.place(model, state, self._before, fraction)
        yielding = self._yielding(respond, here)
        steps: dict[str, float] = {}
        left: Sequence[Twin] = self.twins
        for number in range(FINDING.most):
            before, found = steps, self._corrected(left, respond, here, yielding)
            if not np.isfinite(list(found.values())).all():
                return False
            steps = {**before, **found}
            if number + 1 < FINDING.enough:
                continue
            late = [t for t in left if not _arrived(found[t.path], before[t.path])]
            if number + 1 == FINDING.enough and all(body.smooth for body in model.bodies):
                left = [max(self.twins, key=lambda t: steps[t.path])]
                continue
            if late and number == FINDING.enough:
                late = list(self.twins)
                respond.renew()
                yielding = self._yielding(respond, here)
            left = late
            if not left:
                break
        self._lost = {t.path for t in left if steps[t.path] > FINDING.rough}
        self._before = state.x.copy()
        self.times["equilibria"] += time.perf_counter() - started
        return True

    def _yielding(self, respond: Responses, here: _Here) -> np.ndarray:
        """What the prescribed volumes' pushes (k, local) answer: (k, local)."""
        owned = slice(self.walk.model.unknowns.owned)
        pushes = [push[owned] for push in here.pushes]
        return respond(np.array(pushes)) if pushes else np.empty((0, 0))

    def _corrected(
        self, twins: Sequence[Twin], respond: Responses, here: _Here, yielding: np.ndarray
    ) -> dict[str, float]:
        """Correct twins by what is out of balance; returns by path the norm of each correction by
        that of all its way from the actuator's state, or of a way as that of a parameter to which
        the displacements are proportional where it is shorter."""
        owned = slice(self.walk.model.unknowns.owned)
        forces = []
        for twin in twins:
            force = twin.out_of_balance() - here.force
            force[here.fixed] = 0.0
            forces.append(force[owned])
        answers = respond(np.array(forces))
        steps, size = {}, self._length(here.state.x)
        for twin, answer in zip(twins, answers, strict=True):
            change = self._move(twin, answer, here, yielding)
            way = self._length(twin.state.x - here.state.x)
            least = twin.parameter.part * (size + NEXT_TO_NOTHING)
            steps[twin.path] = self._length(change) / max(way, least)
        return steps

    def _length(self, change: np.ndarray) -> float:
        """Norm of the displacements in a change of the unknowns (local,)."""
        model = self.walk.model
        owned = model.displacement_dofs[: model.nodes.owned]
        return float(np.sqrt(model.sum(float((change[owned] ** 2).sum()))))

    def _move(
        self, twin: Twin, answer: np.ndarray, here: _Here, yielding: np.ndarray
    ) -> np.ndarray:
        """Move a twin by −K⁻¹ of what is out of balance; the pressures of cavities of a prescribed
        volume such that they keep it. Returns the change of the unknowns (local,)."""
        if not here.pushes:
            twin.move(-answer, {})
            return -answer
        model, owned = self.walk.model, slice(self.walk.model.unknowns.owned)
        rows = np.array([push[owned] for push in here.pushes])
        compliance = model.sum(rows @ yielding[:, owned].T)
        lacking = self._lacking(twin, here) + model.sum(rows @ answer[owned])
        q = np.linalg.solve(compliance, lacking)
        change = q @ yielding - answer
        twin.move(change, dict(zip(self.walk.ramp.injected, map(float, q), strict=True)))
        return change

    def _pushes(self, state: State, fixed: np.ndarray) -> list[np.ndarray]:
        """Derivatives (local,) of the prescribed volumes with respect to the unknowns."""
        model, found = self.walk.model, []
        for name in self.walk.ramp.injected:
            row = np.zeros(model.unknowns.local)
            model.cavities[name].add_volume_gradient(state.x, 1.0, row)
            row = model.unknowns.sum_shared(row)
            row[fixed] = 0.0
            found.append(row)
        return found

    def _lacking(self, twin: Twin, here: _Here) -> np.ndarray:
        """What a twin's cavities lack to their volumes more than the actuator's do, mm³."""
        gaps = []
        for ramp, model, there in (
            (twin.ramp, twin.model, twin.state),
            (self.walk.ramp, self.walk.model, here.state),
        ):
            control = ramp.control(here.fraction)
            assert control is not None  # volumes are prescribed
            gaps.append(control.targets - control.values(model, there))
        return gaps[0] - gaps[1]

    def _measured(self, row: Mapping[str, Any]) -> Slopes:
        """The derivatives of a row's measures."""
        started = time.perf_counter()
        found = {}
        for twin in self.twins:
            twin.settle(self._evaluate(twin))
            if twin.path not in self._lost:
                found[twin.path] = twin.slopes(row)
        self.times["measures"] += time.perf_counter() - started
        return Slopes(found)
