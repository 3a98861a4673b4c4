"""The actuator with one number a little changed, carried along beside a run to first order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from softact.contact.memory import stiffness_key
from softact.loads.load_step import LoadStep
from softact.loads.support import Held, Support
from softact.model import Model
from softact.sensitivities.parameters import Parameter
from softact.solve.ramp import Ramp
from softact.system.term import State

#: Of two numbers of a row: what of their size may be between them. More is a jump, as where the
#: largest value changes its place.
MOST_ELASTIC = 1e4


@dataclass(frozen=True)
class Case:
    """A spec as the solver takes it: its model, its supports at the start and its steps."""

    model: Model
    supports: Sequence[Support]
    steps: Sequence[LoadStep]


class Twin:
    """One parameter, and the actuator with ``parameter.step`` more of it.

    state: its equilibrium beside the last accepted one. row: its measures there. begun: its state
    at the start of the present step.
    """

    def __init__(self, parameter: Parameter, case: Case):
        self.parameter, self.case, self.model = parameter, case, case.model
        for step in case.steps:
            self.model.make_room(step.loads)
        self.state = self.model.initial_state()
        self.begun = self.state
        self._diagonal = self.model.diagonal
        self.row: dict[str, Any] = {}
        self._supported: int | None = None  # number of a step whose supports are set already
        self.held: Held = self.model.set_supports(case.supports, self.state)

    @property
    def path(self) -> str:
        """Its parameter's."""
        return self.parameter.path

    # --- steps ----------------------------------------------------------------------------------

    def begin(self, number: int) -> None:
        """Begin a step, of this number in the spec, at the state as it is."""
        supports = self.case.steps[number].supports
        if supports is not None and number != self._supported:
            self.held = self.model.set_supports(supports, self.state)
        self._begin(number)

    def _begin(self, number: int) -> None:
        state = self.state
        self.begun = replace(state, x=state.x.copy())
        held = self.held.seen_from(state.x)
        self.ramp = Ramp(state, self.case.steps[number], held, self.model.cavity_volume)

    def pass_over(self, number: int) -> None:
        """Take the loads of a step as they are at its end, without any equilibrium."""
        self.begin(number)
        self.ramp.apply(self.state, 1.0)
        self.end()

    def end(self) -> None:
        """Take what supports prescribe as reached, at the end of a step."""
        self.held = self.held.arrived()

    def restore(
        self, first: int, inside: bool, begun: State, now: State, row: Mapping[str, Any]
    ) -> None:
        """Stand where an earlier run stood: before the step of this number, or inside of it. See
        ``softact.solve.stepping.Stepper.run``, which does the same."""
        self.state = replace(begun if inside else now)
        last = 0
        for number, step in enumerate(self.case.steps[: first + 1]):
            if step.supports is not None:
                self.held, last = self.model.set_supports(step.supports, self.state), number
        if first > last:
            self.end()
        self._supported, self.row = first, dict(row)
        if inside:
            self._begin(first)
            self.state = replace(now)
        self.model.contacts.resume(self.state)

    # --- states ---------------------------------------------------------------------------------

    def place(self, model: Model, state: State, before: np.ndarray, fraction: float) -> None:
        """Put the twin as far from the actuator (``model``) at ``state`` as it was from that at its
        last unknowns (local,), under its own loads and supports."""
        for name, solid in self.model.solids.items():
            solid.stand_beside(model.solids[name], state)
        self.look_beside(model, state)
        mine = self.state
        if self.ramp.injected:
            free = {name: state["pressure"].get(name, 0.0) for name in self.ramp.injected}
            mine.put("pressure", {**mine["pressure"], **free})
        held = self.ramp.apply(mine, fraction)
        mine.x = state.x + (mine.x - before)
        mine.x[self.held.dofs] = held
        mine.memory = {**mine.memory, **self._stiffness(state)}

    def look_beside(self, model: Model, state: State) -> None:
        """Let contact look where it matters in the actuator (``model``) at ``state``."""
        for contact, other in zip(self.model.contacts, model.contacts, strict=True):
            contact.stand_beside(other, state)

    def _stiffness(self, state: State) -> dict[str, Any]:
        """Factors of contact's penalties, which are raised in steps and no matter of the twin."""
        keys = [stiffness_key(contact.name) for contact in self.model.contacts]
        return {key: state.memory[key] for key in keys if key in state.memory}

    def out_of_balance(self) -> np.ndarray:
        """Force (local,) N that is out of balance there."""
        return self.model.force(self.state)[0]

    def move(self, change: np.ndarray, pressures: Mapping[str, float]) -> None:
        """Add changes to the unknowns (local,) and to pressures (MPa)."""
        self.state.x = self.state.x + change
        if pressures:
            known = self.state["pressure"]
            more = {name: known.get(name, 0.0) + q for name, q in pressures.items()}
            self.state.put("pressure", {**known, **more})

    def settle(self, row: dict[str, Any]) -> None:
        """Take the state as an equilibrium, with these measures."""
        self.row = row
        self.model.contacts.remember(self.state)
        for solid in self.model.solids.values():
            solid.forget()

    def slopes(self, row: Mapping[str, Any]) -> dict[str, float]:
        """Derivatives of the measures in a row of the actuator itself, by the parameter in internal
        units; without those that jump."""
        step, size = self.parameter.step, max(abs(self.parameter.value), 1e-300)
        found = {}
        for name, value in row.items():
            there = self.row.get(name)
            if not isinstance(value, float) or not isinstance(there, float):
                continue
            change = there - value
            least = self._diagonal if name.endswith("_mm") else 0.0
            most = MOST_ELASTIC * step / size * max(abs(value), abs(there), least)
            if abs(change) <= most or self.parameter.value == 0.0:
                found[name] = change / step
        return found
