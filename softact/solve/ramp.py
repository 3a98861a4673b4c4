"""How the loads of a step go from their last values to the new ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

import numpy as np

from softact.loads import BY_FIELD
from softact.loads.load_step import LoadStep
from softact.loads.support import Held
from softact.solve.border import VolumeControl
from softact.system.term import State, Value

if TYPE_CHECKING:
    from softact.model import Model


class Ramp:
    """Loads, volumes and prescribed displacements between the start and the end of a step.

    state: at the start. held: displacements that the supports prescribe on the way.
    volume: (state, cavity) -> mm³.
    """

    def __init__(
        self,
        state: State,
        step: LoadStep,
        held: Held,
        volume: Callable[[State, str], float],
    ):
        self._held, self._step = held, step
        changes = {f: v for f, v in step.loads.items() if not BY_FIELD[f].holds_volume}
        self._ends: dict[str, tuple[dict[str, Value], dict[str, Value]]] = {}
        for field in {**state.loads, **changes}:
            before, load = state[field], BY_FIELD[field]
            end = {**before, **changes.get(field, {})}
            start = {name: load.start(field, before.get(name), v) for name, v in end.items()}
            self._ends[field] = start, end
        self._volumes = {
            name: (now := volume(state, name), now + float(added))
            for field, values in step.loads.items()
            if BY_FIELD[field].holds_volume
            for name, added in sorted(values.items())
        }

    @property
    def injected(self) -> tuple[str, ...]:
        """Cavities whose volume is prescribed."""
        return tuple(self._volumes)

    @property
    def put_there(self) -> tuple[str, ...]:
        """Obstacles that the step puts there or leaves there."""
        return tuple(self._step.loads.get("presence", {}))

    @property
    def pressures(self) -> dict[str, tuple[float, float]]:
        """Cavities whose pressure changes: (at the start, at the end), MPa."""
        start, end = self._ends.get("pressure", ({}, {}))
        return {n: (float(start[n]), float(end[n])) for n in end if start[n] != end[n]}

    def changing(self, fraction: float) -> list[tuple[str, str, Value]]:
        """Field, name and value, at a fraction of the step, of the loads that change in it."""
        return [
            (field, name, (1 - fraction) * start[name] + fraction * end[name])
            for field, (start, end) in self._ends.items()
            for name in end
            if np.any(start[name] != end[name])
        ]

    @property
    def only_pressures(self) -> bool:
        """Whether pressures, and no other loads, change in this step."""
        others = [values for field, values in self._step.loads.items() if field != "pressure"]
        return bool(self.pressures) and not any(others)

    @property
    def moves_supports(self) -> bool:
        """Whether supports that this process holds move in this step."""
        return self._held.moves

    def apply(self, state: State, fraction: float) -> np.ndarray:
        """Set the loads of ``state``; returns the prescribed displacements (mm).

        The pressures of injected cavities stay as they are.
        """

        def between(start: Value, end: Value) -> Value:
            return (1 - fraction) * start + fraction * end

        free = {name: state["pressure"].get(name, 0.0) for name in self.injected}
        state.loads = {
            field: {name: between(start[name], end[name]) for name in start}
            for field, (start, end) in self._ends.items()
        }
        if free:
            state.put("pressure", {**state["pressure"], **free})
        return self._held.at(fraction)

    def control(self, fraction: float) -> VolumeControl | None:
        """The prescribed volumes; None where there are none."""
        if not self._volumes:
            return None
        targets = [(1 - fraction) * now + fraction * then for now, then in self._volumes.values()]
        return VolumeControl([{name: 1.0} for name in self._volumes], np.array(targets))


def said(model: Model, loads: Iterable[tuple[str, str, Value]]) -> str:
    """Loads in words: field, name, value. Collective."""
    ordered = sorted(loads, key=lambda load: load[:2])
    parts = [BY_FIELD[field].said(name, value, model) for field, name, value in ordered]
    return ", ".join(part for part in parts if part) or "no load"
