"""How the loads of a step go from their last values to the new ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from softact.loads import BY_FIELD
from softact.loads.air import exponent_of, sealed_of, valve_of
from softact.loads.air_account import account_of, at_rest
from softact.loads.gas_flow import AMBIENT
from softact.loads.load_step import LoadStep
from softact.loads.support import Held
from softact.solve.border import VolumeControl
from softact.solve.gas import Filling, GasControl
from softact.system.term import EVERYTHING, Clock, State, Value

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
            for name, added in sorted(step.loads.get("inject", {}).items())
        }
        self._volume, self._since = volume, 0.0
        self._supplies = {**step.loads.get("supply", {}), **step.loads.get("exhaust", {})}
        self._filled = sorted([*self._supplies, *step.loads.get("sealed", {})])
        self._sizes = np.array([max(volume(state, name), 1.0) for name in self._filled])
        self.arrived(state, 0.0)

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
        """Cavities whose pressure follows from a volume or from the air in them."""
        return (*self._volumes, *self._filled)

    def arrived(self, state: State, fraction: float) -> None:
        """Take a state as the last equilibrium, from which air flows on."""
        self._since = fraction
        self._before = {n: float(state["pressure"].get(n, 0.0)) for n in self._filled}
        self._room = {name: self._volume(state, name) for name in self._filled}
        self._amounts = {
            name: (pressure + self._outside(fraction)) * self._room[name]
            for name, pressure in self._before.items()
        }
        self._masses = {name: self._mass(state, name) for name in self._filled}

    def _mass(self, state: State, name: str) -> float:
        """The air of a cavity, as p V at ambient temperature, mJ; where nothing is known of it, or
        what flows is isothermal, it is as warm as the ambient."""
        known = account_of(state.memory, name).mass
        supply = self._supplies.get(name)
        isothermal = supply is not None and exponent_of(supply) == 1.0
        return self._amounts[name] if isothermal or known == 0.0 else known

    def _outside(self, fraction: float) -> float:
        """Absolute pressure of the ambient at a fraction of the step, MPa."""
        start, end = self._ends.get("ambient", ({}, {}))
        if EVERYTHING not in end:
            return AMBIENT
        part = self._gone(fraction)
        return float((1 - part) * start[EVERYTHING] + part * end[EVERYTHING])

    def accounted(self, state: State, fraction: float) -> dict[str, np.ndarray | float]:
        """The memory of ``state`` with what has become of the air since the last equilibrium."""
        memory = at_rest(state, self._filled)
        for name in self._filled:
            filling = self._filling(name, fraction)
            brought = filling.mass_in(float(state["pressure"].get(name, 0.0)))
            valve, before = filling.valve, account_of(memory, name)
            ratio = 1.0 if valve is None else valve.pressure / filling.ambient + 1
            now = before.after(self._masses[name] + brought, brought, filling.elapsed, ratio)
            memory |= now.named(name)
        return memory

    def _filling(self, name: str, fraction: float) -> Filling:
        """The air of a cavity from the last equilibrium to a fraction of the step."""
        supply, timing = self._supplies.get(name), self._step.timing
        outside, amount = self._outside(fraction), self._amounts[name]
        if supply is not None and timing is not None:
            elapsed, exponent = (fraction - self._since) * timing.duration, exponent_of(supply)
            warmth = 1.0 if exponent == 1.0 else amount / self._masses[name]
            room = self._room[name]
            return Filling(name, amount, valve_of(supply), elapsed, exponent, room, warmth, outside)
        heated, exponent = sealed_of(self._step.loads["sealed"][name])
        before, now = (1 + (heated - 1) * self._gone(at) for at in (self._since, fraction))
        room = self._room[name]
        return Filling(name, amount * now / before, exponent=exponent, volume=room, ambient=outside)

    def flow_error(self, state: State, fraction: float) -> float:
        """Error of the air that has flowed since the last equilibrium, by all that is there: half
        of what the flow has changed in that time."""
        worst = 0.0
        for name in self._supplies:
            filling = self._filling(name, fraction)
            assert filling.valve is not None
            now = filling.valve.flow(float(state["pressure"].get(name, 0.0)), filling.ambient)[0]
            before = filling.valve.flow(self._before[name], filling.ambient)[0]
            gone = filling.elapsed * abs(now - before) / 2
            worst = max(worst, gone / max(self._amounts[name], 1e-300))
        return worst

    @property
    def put_there(self) -> tuple[str, ...]:
        """Obstacles that the step puts there or leaves there."""
        return tuple(self._step.loads.get("presence", {}))

    @property
    def let_go(self) -> tuple[str, ...]:
        """Free bodies that nothing holds in place at the end of the step."""
        _, end = self._ends.get("hold", ({}, {}))
        return tuple(name for name, held in end.items() if held != 1.0)

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

    def control(self, fraction: float) -> VolumeControl | GasControl | None:
        """What unknown pressures follow from; None where there are none."""
        if self._filled:
            return GasControl([self._filling(n, fraction) for n in self._filled], self._sizes)
        if not self._volumes:
            return None
        part = self._gone(fraction)
        targets = [(1 - part) * now + part * then for now, then in self._volumes.values()]
        return VolumeControl([{name: 1.0} for name in self._volumes], np.array(targets))


def said(model: Model, loads: Iterable[tuple[str, str, Value]]) -> str:
    """Loads in words: field, name, value. Collective."""
    ordered = sorted(loads, key=lambda load: load[:2])
    parts = [BY_FIELD[field].said(name, value, model) for field, name, value in ordered]
    return ", ".join(part for part in parts if part) or "no load"
