"""Pressures of cavities that follow from the air in them, one bordered row for each.

The air of a cavity keeps p Vⁿ, but for what flows: d(p Vⁿ)/dt = n Vⁿ⁻¹ q, where q = ṁ R T is of
what comes in or goes out (Richer and Hurmuzlu 2000, ASME J. Dyn. Syst. 122:416). With n = 1 the
temperature stays and p V = n R T; n = 1.4 is the balance of energy of air that exchanges no heat.
Amounts are p V of absolute pressures, mJ, of the meshed part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from softact.loads.gas_flow import AMBIENT, Valve
from softact.model import Model
from softact.system.term import State

LEAST = 1e-9  # MPa, of an absolute pressure that Newton's method may try
ENOUGH, MOST = 1e-14, 50  # relative, of a volume; tries


@dataclass(frozen=True)
class Filling:
    """Air of a cavity on the way to the next equilibrium.

    amount: at the last one, mJ, times how much hotter it has become. valve: through which more
    comes in ``elapsed`` s, at the flow of the end of that time (backward Euler); None: closed.
    exponent, volume: n, and mm³ at the last equilibrium. warmth: absolute temperature there by that
    of the ambient, of air that goes out. ambient: absolute pressure outside at the end, MPa.
    """

    cavity: str
    amount: float
    valve: Valve | None = None
    elapsed: float = 0.0
    exponent: float = 1.0
    volume: float = 1.0
    warmth: float = 1.0
    ambient: float = AMBIENT

    def mass_in(self, pressure: float) -> float:
        """What comes in, as p V at ambient temperature, mJ; the flow of an orifice goes with the
        root of the temperature before it (ISO 6358)."""
        if self.valve is None:
            return 0.0
        flow, _ = self.valve.flow(pressure, self.ambient)
        return self.elapsed * flow / (1.0 if flow > 0 else self.warmth**0.5)

    def at(self, pressure: float) -> tuple[float, float]:
        """Volume that the air has at a pressure at the end, and its derivative by that."""
        brought, slope = self._brought(pressure)
        absolute = max(pressure + self.ambient, LEAST)
        if self.exponent == 1.0:
            now = self.amount + brought
            return now / absolute, (slope - now / absolute) / absolute
        volume = self._volume(absolute, brought)
        kept = (self.exponent - 1) * self.amount * (self.volume / volume) ** (self.exponent - 1)
        return volume, (slope - volume) / (absolute + kept / volume)

    def _brought(self, pressure: float) -> tuple[float, float]:
        """n q Δt, and its derivative by the pressure."""
        if self.valve is None:
            return 0.0, 0.0
        flow, slope = self.valve.flow(pressure, self.ambient)
        factor = self.exponent * self.elapsed * (1.0 if flow > 0 else self.warmth**0.5)
        return factor * flow, factor * slope

    def _volume(self, absolute: float, brought: float) -> float:
        """The root of p V = n q Δt + p₀ V₀ (V₀/V)ⁿ⁻¹, by Newton's method in log V."""
        log, power = np.log(self.volume), self.exponent - 1
        for _ in range(MOST):
            volume = np.exp(log)
            kept = self.amount * np.exp(power * (np.log(self.volume) - log))
            change = (absolute * volume - brought - kept) / (absolute * volume + power * kept)
            log -= np.clip(change, -1.0, 1.0)
            if abs(change) < ENOUGH:
                break
        return float(np.exp(log))


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
        return filling.at(float(state["pressure"].get(filling.cavity, 0.0)))
