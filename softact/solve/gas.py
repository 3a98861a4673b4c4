"""Pressures of cavities that follow from the air in them: p V = n R T, one bordered row for each.

Amounts are n R T (mJ, absolute pressure times volume), of the meshed part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from softact.loads.gas_flow import AMBIENT, Valve
from softact.model import Model
from softact.system.term import State

LEAST = 1e-9  # MPa, of an absolute pressure that Newton's method may try


@dataclass(frozen=True)
class Filling:
    """Air of a cavity on the way to the next equilibrium.

    amount: at the last one, mJ, times how much hotter it has become. valve: through which more
    comes in ``elapsed`` s, at the flow of the end of that time (backward Euler); None: closed.
    """

    cavity: str
    amount: float
    valve: Valve | None = None
    elapsed: float = 0.0

    def at(self, pressure: float) -> tuple[float, float]:
        """Amount at a pressure at the end, and its derivative with respect to that."""
        if self.valve is None:
            return self.amount, 0.0
        flow, slope = self.valve.flow(pressure)
        return self.amount + self.elapsed * flow, self.elapsed * slope


@dataclass(frozen=True)
class GasControl:
    """Volumes that the gas law asks for. sizes: (k,) mm³ by which errors are told."""

    fillings: Sequence[Filling]
    sizes: np.ndarray

    @property
    def directions(self) -> list[dict[str, float]]:
        """See ``VolumeControl``."""
        return [{filling.cavity: 1.0} for filling in self.fillings]

    @property
    def targets(self) -> np.ndarray:
        """See ``VolumeControl``."""
        return self.sizes

    def values(self, model: Model, state: State) -> np.ndarray:
        """Size of each, plus the volume, less the one that its air has at its pressure (k,)."""
        volumes = [model.cavity_volume(state, f.cavity) for f in self.fillings]
        wanted = [self._volume(f, state)[0] for f in self.fillings]
        return self.sizes + np.array(volumes) - np.array(wanted)

    def rows(self, pushes: np.ndarray) -> np.ndarray:
        """See ``VolumeControl``."""
        return pushes

    def slopes(self, state: State) -> np.ndarray:
        """Derivatives of the values with respect to the pressures themselves (k,)."""
        return -np.array([self._volume(f, state)[1] for f in self.fillings])

    @staticmethod
    def _volume(filling: Filling, state: State) -> tuple[float, float]:
        """Volume of the air at its pressure, and its derivative."""
        pressure = float(state["pressure"].get(filling.cavity, 0.0))
        amount, slope = filling.at(pressure)
        absolute = max(pressure + AMBIENT, LEAST)
        return amount / absolute, (slope - amount / absolute) / absolute
