"""The derivatives of all measures by all parameters at each accepted state of a run.

A parameter's twin (``twin.py``) stands at the run's state, under its own loads; what is out of
balance there is what the change of the parameter does. With K the tangent, K δx = −δR brings it to
its own equilibrium to first order, and each measure is taken there too:

    R(x, θ) = 0,  δx = −K⁻¹ (R(x, θ + h) − R(x, θ)),  dm/dθ = (m(x + δx, θ + h) − m(x, θ)) / h

With prescribed volumes the pressures of their cavities follow by block elimination, as in
``softact.solve.border``. All parameters share one tangent.
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
NONE = "the run was begun without sensitivities, and goes on without them; for them start it anew"
OTHERS = "the run was begun with other parameters (-p); resume it with the same ones"
SINGULAR = "the tangent has no inverse there"


@dataclass(frozen=True)
class Slopes:
    """Derivatives at one state: parameter's path -> measure -> in internal units of the
    parameter."""

    of: Mapping[str, Mapping[str, float]]


class Following:
    """Carries the twins of a run along. walk: the run's own; ended: why there are no derivatives
    any more, and from which pressure on."""

    def __init__(self, walk: Walk, twins: Sequence[Twin], evaluate: Evaluate):
        self.walk, self.twins, self._evaluate = walk, list(twins), evaluate
        self.ended: str | None = None
        self._step: int | None = None
        self._responses: Responses | None = None
        self.times = {"right_sides": 0.0, "linear_solves": 0.0, "measures": 0.0}

    def accept(
        self, state: State, attempt: Attempt, number: int, row: Mapping[str, Any]
    ) -> Slopes | None:
        """The derivatives at an accepted state of this number, whose measures are ``row``; None
        where there are none. Collective."""
        self.ended = self.ended or self._end(state, attempt)
        if self.ended or attempt.control == "motion":
            return None
        if number:  # at rest nothing moves
            self._follow_steps()
            if not self._solve(state, attempt.fraction):
                self.ended = SINGULAR
                return None
        return self._measured(row)

    def _end(self, state: State, attempt: Attempt) -> str | None:
        contacts = self.walk.model.contacts
        if attempt.control == "dynamics":
            return JUMPED
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

    # --- kept -----------------------------------------------------------------------------------

    def kept(self) -> tuple[dict[str, Any], list[np.ndarray]]:
        """What a run needs to go on with its twins: plain data, and unknowns (local,)."""
        known = {
            twin.parameter.path: {
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
        if list(known) != [twin.parameter.path for twin in self.twins]:
            raise SpecError(OTHERS if known else NONE)
        inside = begin is None
        first = start.step if begin is None else begin
        pairs = zip(start.vectors[::2], start.vectors[1::2], strict=True)
        for twin, (begun, now) in zip(self.twins, pairs, strict=True):
            of = known[twin.parameter.path]
            began = State(begun.copy(), loads_of(of["begun"]))
            twin.restore(first, inside, began, State(now.copy(), loads_of(of["now"])), of["row"])
        self.ended = start.beside["ended"]
        self._step = first if inside else None

    # --- the twins' equilibria ------------------------------------------------------------------

    def _solve(self, state: State, fraction: float) -> bool:
        """Bring the twins to their equilibria beside ``state``; whether these could be found."""
        started = time.perf_counter()
        model = self.walk.model
        owned, fixed = slice(model.unknowns.owned), np.flatnonzero(model.assembler.fixed)
        here = model.force(state)[0]
        rights = []
        for twin in self.twins:
            twin.place(model, state, fraction)
            right = twin.out_of_balance() - here
            right[fixed] = 0.0
            rights.append(right[owned])
        pushes = self._pushes(state, fixed)
        now = time.perf_counter()
        answers = self._respond(state, np.array([*rights, *(push[owned] for push in pushes)]))
        self.times["right_sides"] += now - started
        self.times["linear_solves"] += time.perf_counter() - now
        if not model.sum(int(np.isfinite(answers).all())) == model.comm.size:
            return False
        count = len(self.twins)
        self._move(answers[:count], pushes, answers[count:], state, fraction)
        return True

    def _respond(self, state: State, rights: np.ndarray) -> np.ndarray:
        """K⁻¹ of right-hand sides (k, owned), ghosts included: (k, local)."""
        if self._responses is None:
            self._responses = Responses(self.walk.newton)
        model = self.walk.model
        vector = model.unknowns.create_vector()
        found = []
        for answer in self._responses(state, rights):
            vector.setArray(answer)
            found.append(model.unknowns.to_local(vector))
        vector.destroy()
        return np.array(found)

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

    def _move(
        self,
        answers: np.ndarray,
        pushes: Sequence[np.ndarray],
        yielding: np.ndarray,
        state: State,
        fraction: float,
    ) -> None:
        """Move each twin by −K⁻¹ of what is out of balance; the pressures of cavities of a
        prescribed volume (pushes (local,), and K⁻¹ of them) such that they keep it."""
        model, names = self.walk.model, self.walk.ramp.injected
        owned = slice(model.unknowns.owned)
        rows = np.array([push[owned] for push in pushes])
        compliance = model.sum(rows @ yielding[:, owned].T) if len(pushes) else None
        for twin, answer in zip(self.twins, answers, strict=True):
            if compliance is None:
                twin.move(-answer, {})
                continue
            lacking = self._lacking(twin, state, fraction) + model.sum(rows @ answer[owned])
            q = np.linalg.solve(compliance, lacking)
            twin.move(q @ yielding - answer, dict(zip(names, map(float, q), strict=True)))

    def _lacking(self, twin: Twin, state: State, fraction: float) -> np.ndarray:
        """What a twin's cavities lack to their volumes more than the actuator's do, mm³."""
        gaps = []
        for ramp, model, there in (
            (twin.ramp, twin.model, twin.state),
            (self.walk.ramp, self.walk.model, state),
        ):
            control = ramp.control(fraction)
            assert control is not None  # volumes are prescribed
            gaps.append(control.targets - control.values(model, there))
        return gaps[0] - gaps[1]

    def _measured(self, row: Mapping[str, Any]) -> Slopes:
        """The derivatives of a row's measures."""
        started = time.perf_counter()
        found = {}
        for twin in self.twins:
            twin.settle(self._evaluate(twin))
            found[twin.parameter.path] = twin.slopes(row)
        self.times["measures"] += time.perf_counter() - started
        return Slopes(found)
