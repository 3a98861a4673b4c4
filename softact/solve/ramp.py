"""How the loads of a step go from their last values to the new ones."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from softact.model import Support
from softact.solve.border import VolumeControl
from softact.system.term import State


@dataclass(frozen=True)
class LoadStep:
    """Loads at the end of a step; they ramp linearly from the last ones. None: unchanged.

    pressure: cavity -> MPa. gravity: (3,) mm/s². traction: surface -> (3,) MPa.
    surface_pressure: surface -> MPa. inject: cavity -> mm³ added to the meshed part's volume; its
    pressure is then an unknown. supports: replace the ones before. shift: obstacle -> (3,) mm from
    where it was placed. presence: obstacle -> 1 (put there) or 0 (removed: its force fades over the
    step). max_increment: fraction of the step, None for the solver's.
    """

    name: str
    pressure: Mapping[str, float] | None = None
    gravity: Sequence[float] | None = None
    traction: Mapping[str, Sequence[float]] | None = None
    surface_pressure: Mapping[str, float] | None = None
    inject: Mapping[str, float] | None = None
    supports: Sequence[Support] | None = None
    shift: Mapping[str, Sequence[float]] | None = None
    presence: Mapping[str, float] | None = None
    max_increment: float | None = None


class Ramp:
    """Loads, volumes and prescribed displacements between the start and the end of a step.

    state: at the start. held: prescribed displacements (mm) at the start and at the end.
    volume: (state, cavity) -> mm³.
    """

    NAMED = ("pressure", "traction", "surface_pressure", "shift", "presence")

    def __init__(
        self,
        state: State,
        step: LoadStep,
        held: tuple[np.ndarray, np.ndarray],
        volume: Callable[[State, str], float],
    ):
        self._held = held
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
        self._step = step
        self._volumes = {
            name: (now := volume(state, name), now + added)
            for name, added in sorted((step.inject or {}).items())
        }

    @property
    def injected(self) -> tuple[str, ...]:
        """Cavities whose volume is prescribed."""
        return tuple(self._volumes)

    @property
    def pressures(self) -> dict[str, tuple[float, float]]:
        """Cavities whose pressure changes: (at the start, at the end), MPa."""
        start, end = self._named["pressure"]
        return {n: (float(start[n]), float(end[n])) for n in end if start[n] != end[n]}

    @property
    def only_pressures(self) -> bool:
        """Whether pressures, and no other loads, change in this step."""
        step = self._step
        others = (step.gravity, step.traction, step.surface_pressure, step.shift, step.presence)
        changed = any(load is not None and len(load) > 0 for load in others)
        return bool(self.pressures) and not self.injected and not changed

    @property
    def moves_supports(self) -> bool:
        """Whether supports that this process holds move in this step."""
        return not np.array_equal(*self._held)

    def apply(self, state: State, fraction: float) -> np.ndarray:
        """Set the loads of ``state``; returns the prescribed displacements (mm).

        The pressures of injected cavities stay as they are.
        """

        def between(start, end):
            return (1 - fraction) * start + fraction * end

        free = {name: state.pressure.get(name, 0.0) for name in self.injected}
        state.gravity = between(*self._gravity)
        for kind, (start, end) in self._named.items():
            setattr(state, kind, {name: between(start[name], end[name]) for name in start})
        state.pressure |= free
        return between(*self._held)

    def control(self, fraction: float) -> VolumeControl | None:
        """The prescribed volumes; None where there are none."""
        if not self._volumes:
            return None
        targets = [(1 - fraction) * now + fraction * then for now, then in self._volumes.values()]
        return VolumeControl([{name: 1.0} for name in self._volumes], np.array(targets))
