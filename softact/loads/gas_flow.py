"""Flow of an ideal gas through a valve, choked or not, as pressure times volume per time (mJ/s).

An orifice of area A passes C A p₁ √(R T) φ(p₂/p₁) with φ² = 2γ/(γ−1) (r^(2/γ) − r^((γ+1)/γ)), and
no more than at the critical ratio r = (2/(γ+1))^(γ/(γ−1)) (Saint-Venant and Wantzel 1839; ISO 6358
has the same limit). A conductance G passes G p₁ (p₁ − p₂)/p₀, the laminar law. Temperature stays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

AMBIENT = 0.101325  # MPa, from which pressures count
GAMMA = 1.4
#: √(R T) of air at 20 °C, mm/s.
SPEED = 1e3 * float(np.sqrt(287.05 * 293.15))
CRITICAL = (2 / (GAMMA + 1)) ** (GAMMA / (GAMMA - 1))
# Beyond this ratio the flow of an orifice goes to zero along a line: its slope would be infinite.
LAMINAR = 0.999


@dataclass(frozen=True)
class Valve:
    """A supply behind a valve. pressure: of the supply, MPa above ambient. area: of the orifice
    times its discharge coefficient, mm², or conductance: mm³/s at ambient pressure by MPa; 0 where
    there is none."""

    pressure: float
    area: float = 0.0
    conductance: float = 0.0

    def flow(self, pressure: float) -> tuple[float, float]:
        """Into a cavity at a pressure (MPa above ambient), and its derivative in that."""
        supply, here = self.pressure + AMBIENT, max(pressure + AMBIENT, 1e-9)
        if supply >= here:
            flow, _, slope = self._between(supply, here)
            return flow, slope
        flow, slope, _ = self._between(here, supply)
        return -flow, -slope

    def _between(self, up: float, down: float) -> tuple[float, float, float]:
        """Flow from an absolute pressure to a lower one, and its derivatives in both."""
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
