"""The air between sheets: follower pressure and enclosed volume."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softact.mesh.triangles import Triangles
from softact.system.term import Origin, State
from softact.system.triangle_loops import VolumeLoops


class SheetCavity:
    """Follower pressure on the sheets that wall a cavity: potential −p V(u).

    V = ∫ (W x) · (∂x/∂r × ∂x/∂s) dr ds with normals out of the cavity, integrated exactly; W is
    diagonal with trace 1. A wall in a symmetry plane through the origin adds nothing and may be
    left out; with W = diag(0, 0, 1), any wall along z, such as the ends of a long strip.
    """

    def __init__(
        self, name: str, walls: list[Triangles], flux: Sequence[float] = (1 / 3, 1 / 3, 1 / 3)
    ):
        self.name = name
        weights = np.asarray(flux, dtype=float)
        self._walls = [(wall, VolumeLoops(wall, weights)) for wall in walls]

    def _pressure(self, state: State) -> float:
        return float(state["pressure"].get(self.name, 0.0))

    def volume(self, x: np.ndarray) -> float:
        """The enclosed volume, mm³."""
        return sum(loops.volume(x) for _, loops in self._walls)

    def add_volume_gradient(self, x: np.ndarray, factor: float, out: np.ndarray) -> None:
        """Add ``factor`` times the derivative of the volume with respect to the unknowns to ``out``
        (local,)."""
        for _, loops in self._walls:
            loops.add_gradient(x, factor, out)

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        if pressure := self._pressure(state):
            self.add_volume_gradient(state.x, -pressure, out)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        if pressure := self._pressure(state):
            for wall, loops in self._walls:
                wall.table.add(loops.second(state.x, -pressure))

    def energy(self, state: State) -> float:
        """See ``Term``."""
        return -self._pressure(state) * self.volume(state.x)
