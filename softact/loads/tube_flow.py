"""Flow of air along a straight smooth tube, as pressure times volume per time (mJ/s).

Isothermal flow with friction: G² R T (f L/D + 2 ln(p₁/p₂)) = p₁² − p₂², G the mass flow per area
(Shapiro 1953, The Dynamics and Thermodynamics of Compressible Fluid Flow, chapter 6), and no more
than at the outlet pressure where the Mach number is 1/√γ. f is Darcy's factor of Churchill 1977
(Chem. Eng. 84(24):91) for a smooth wall; it is 64/Re where the flow is laminar, and slow flow is
Hagen-Poiseuille's. Losses at the ends are left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

#: Dynamic viscosity of air at 20 °C, MPa s.
VISCOSITY = 1.82e-11
# Reynolds number below which friction is all, and Poiseuille's closed form is taken.
CREEPING = 1.0
# Steps of the logarithm in which slopes of f are taken.
STEP = 1e-6

#: Flow from an absolute pressure to a lower one, and its derivatives in both.
Flow = tuple[float, float, float]


def friction_factor(reynolds: float) -> float:
    """Darcy's friction factor of a smooth tube (Churchill 1977)."""
    smooth = (2.457 * np.log((reynolds / 7) ** 0.9)) ** 16 if reynolds > 7 else 0.0
    rough = (37530 / reynolds) ** 16
    laminar = (8 / reynolds) ** 12
    return float(8 * (laminar + (smooth + rough) ** -1.5) ** (1 / 12))


@dataclass(frozen=True)
class Tube:
    """length, diameter: mm. speed: √(R T) of the gas, mm/s."""

    length: float
    diameter: float
    speed: float

    def between(self, up: float, down: float) -> Flow:
        """See ``Flow``; MPa."""
        slow = np.pi * self.diameter**4 / (256 * VISCOSITY * self.length)
        flow = slow * (up**2 - down**2)
        if self.reynolds(flow) < CREEPING:
            return flow, 2 * slow * up, -2 * slow * down
        return self._fast(up, down, flow)

    def reynolds(self, flow: float) -> float:
        """Reynolds number of a flow in mJ/s."""
        return 4 * flow / (np.pi * self.diameter * VISCOSITY * self.speed**2)

    def _fast(self, up: float, down: float, slow: float) -> Flow:
        """Flow of which the friction factor is one of the unknowns."""
        scale = np.pi / 4 * self.diameter**2 * self.speed * up
        ratio = down / up

        def off(log: float) -> float:
            flow = float(np.exp(log))
            return scale * _share(self._losses(flow), ratio)[0] / flow - 1

        from scipy.optimize import brentq  # not while loads are listed

        low = np.log(0.1 * CREEPING / self.reynolds(1.0))
        high = np.log(max(slow, scale)) + 1
        log = float(brentq(off, low, high, xtol=1e-14, rtol=1e-14))
        flow = float(np.exp(log))
        losses = self._losses(flow)
        part, by_losses, by_ratio = _share(losses, ratio)
        ends = [self._losses(float(np.exp(log + step))) for step in (STEP, -STEP)]
        # flow = scale part(losses(flow), ratio), differentiated on both sides.
        answer = 1 - scale * by_losses * (ends[0] - ends[1]) / (2 * STEP * flow)
        up_slope = (scale * part - scale * by_ratio * ratio) / up
        return flow, up_slope / answer, scale * by_ratio / up / answer

    def _losses(self, flow: float) -> float:
        """f L/D."""
        return friction_factor(self.reynolds(flow)) * self.length / self.diameter


def _share(losses: float, ratio: float) -> tuple[float, float, float]:
    """G √(R T)/p₁ of f L/D and p₂/p₁, and its derivatives in them; choked below a ratio."""
    least = _choked(losses)
    r = max(ratio, least)
    whole = losses - 2 * np.log(r)
    part = float(np.sqrt((1 - r * r) / whole))
    by_losses = -part / (2 * whole)
    if ratio <= least:
        return part, by_losses, 0.0  # at its largest: its slope by the ratio is none
    by_ratio = (-r / whole + (1 - r * r) / (r * whole**2)) / part
    return part, by_losses, float(by_ratio)


def _choked(losses: float) -> float:
    """The ratio r of the largest flow: r² (f L/D − 2 ln r) = 1 − r², where the Mach number is
    1/√γ."""

    def off(log: float) -> float:
        square = float(np.exp(2 * log))
        return square * (losses - 2 * log) - (1 - square)

    from scipy.optimize import brentq  # not while loads are listed

    low = -0.5 * np.log1p(losses) - 5.0
    return float(np.exp(brentq(off, low, -1e-15, xtol=1e-14, rtol=1e-14)))
