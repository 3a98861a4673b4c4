"""How the loads of a step go from their last values to the new ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from softact.loads import BY_FIELD
from softact.loads.load_step import LoadStep
from softact.loads.support import Held
from softact.solve.border import VolumeControl
from softact.system.term import Clock, State, Value


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
        self._held, self._step, self._begun = held, step, state.clock.now
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
    def timed(self) -> bool:
        """Whether the step has a clock."""
        return self._step.timing is not None

    def _gone(self, fraction: float) -> float:
        """How far loads have gone, at a fraction of the step or of its duration."""
        timing = self._step.timing
        return fraction if timing is None else timing.amplitude.at(fraction)

    def _clock(self, before: Clock, fraction: float) -> Clock:
        timing = self._step.timing
        if timing is None:
            return replace(before, runs=False)
        return replace(before, now=self._begun + fraction * timing.duration, runs=True)

    def _given(self, fraction: float) -> Mapping[str, float]:
        """Pressures that are given in time; none at the start, which is as it was."""
        timing = self._step.timing
        return timing.amplitude.pressures(fraction) if timing and fraction > 0.0 else {}

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

        part = self._gone(fraction)

        def between(start: Value, end: Value) -> Value:
            return (1 - part) * start + part * end

        free = {name: state["pressure"].get(name, 0.0) for name in self.injected}
        state.loads = {
            field: {name: between(start[name], end[name]) for name in start}
            for field, (start, end) in self._ends.items()
        }
        free.update(self._given(fraction))
        if free:
            state.put("pressure", {**state["pressure"], **free})
        state.clock = self._clock(state.clock, fraction)
        return self._held.at(part)

    def control(self, fraction: float) -> VolumeControl | None:
        """The prescribed volumes; None where there are none."""
        if not self._volumes:
            return None
        part = self._gone(fraction)
        targets = [(1 - part) * now + part * then for now, then in self._volumes.values()]
        return VolumeControl([{name: 1.0} for name in self._volumes], np.array(targets))
