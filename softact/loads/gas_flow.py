"""Flow of an ideal gas through a valve, choked or not, as pressure times volume per time (mJ/s).

An orifice of area A passes C A p₁ √(R T) φ(p₂/p₁) with φ² = 2γ/(γ−1) (r^(2/γ) − r^((γ+1)/γ)), and
no more than at the critical ratio r = (2/(γ+1))^(γ/(γ−1)) (Saint-Venant and Wantzel 1839), as in
ISO 6358. A conductance G passes G p₁ (p₁ − p₂)/p₀, the laminar law. A tube behind them is one of
``tube_flow``; what is between the two holds no air. The supply is at 20 °C.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from softact.loads.tube_flow import Flow, Tube

AMBIENT = 0.101325  # MPa, from which pressures count
GAMMA = 1.4
#: √(R T) of air at 20 °C, mm/s.
SPEED = 1e3 * float(np.sqrt(287.05 * 293.15))
#: p V at 20 °C (mJ) of a litre of air at 0 °C and 101.325 kPa (DIN 1343).
NORMAL_LITRE = AMBIENT * 1e6 * 293.15 / 273.15
CRITICAL = (2 / (GAMMA + 1)) ** (GAMMA / (GAMMA - 1))
# Beyond this ratio the flow of an orifice goes to zero along a line: its slope would be infinite.
LAMINAR = 0.999


@dataclass(frozen=True)
class Valve:
    """A supply behind a valve, a tube, or both in a row. pressure: of the supply, MPa above
    ambient. area: of the orifice times its discharge coefficient, mm², or conductance: mm³/s at
    standard pressure by MPa; 0 where there is none. copies: of the meshed part, which gets one
    share of the flow."""

    pressure: float
    area: float = 0.0
    conductance: float = 0.0
    tube: Tube | None = None
    copies: float = 1.0

    def flow(self, pressure: float, ambient: float = AMBIENT) -> tuple[float, float]:
        """Into a cavity at a pressure (MPa above ambient), and its derivative in that."""
        supply, here = self.pressure + ambient, max(pressure + ambient, 1e-9)
        if supply >= here:
            flow, _, slope = self._through(self._parts, supply, here)
            return flow / self.copies, slope / self.copies
        flow, slope, _ = self._through(self._parts[::-1], here, supply)
        return -flow / self.copies, -slope / self.copies

    @property
    def _parts(self) -> list[Callable[[float, float], Flow]]:
        """What air passes on its way in: flow from an absolute pressure to a lower one."""
        valve = [self._valve] if self.area or self.conductance or self.tube is None else []
        return [*valve, *([self.tube.between] if self.tube is not None else [])]

    @staticmethod
    def _through(parts: Sequence[Callable[[float, float], Flow]], up: float, down: float) -> Flow:
        """One part, or two in a row with the pressure between them at which they pass the same."""
        if len(parts) == 1:
            return parts[0](up, down)
        from scipy.optimize import brentq  # not while loads are listed

        first, then = parts
        between = up
        if up - down > 1e-12 * up:
            between = brentq(
                lambda p: first(up, p)[0] - then(p, down)[0], down, up, xtol=1e-15, rtol=1e-14
            )
        flow, first_up, first_down = first(up, between)
        _, then_up, then_down = then(between, down)
        stiff = then_up - first_down  # above zero: more comes out and less goes in as it rises
        return flow, first_up * then_up / stiff, -first_down * then_down / stiff

    def _valve(self, up: float, down: float) -> Flow:
        ratio = down / up
        phi, slope = _phi(ratio)
        orifice, laminar = self.area * SPEED, self.conductance / AMBIENT
        return (
            orifice * up * phi + laminar * up * (up - down),
            orifice * (phi - ratio * slope) + laminar * (2 * up - down),
            orifice * slope - laminar * up,
        )


def _phi(ratio: float) -> tuple[float, float]:
    """φ and its derivative with respect to the ratio of pressures."""
    if ratio <= CRITICAL:
        return _orifice(CRITICAL)[0], 0.0
    if ratio < LAMINAR:
        return _orifice(ratio)
    slope = -_orifice(LAMINAR)[0] / (1 - LAMINAR)
    return slope * (ratio - 1), slope


def _orifice(ratio: float) -> tuple[float, float]:
    one, two = 2 / GAMMA, (GAMMA + 1) / GAMMA
    square = 2 * GAMMA / (GAMMA - 1) * (ratio**one - ratio**two)
    rate = 2 * GAMMA / (GAMMA - 1) * (one * ratio ** (one - 1) - two * ratio ** (two - 1))
    root = float(np.sqrt(square))
    return root, rate / (2 * root)
