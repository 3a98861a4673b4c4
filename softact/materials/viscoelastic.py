"""Materials that creep and relax: Maxwell elements beside a law's isochoric stress.

Each element i has a stress bᵢ hᵢ with ḣᵢ + hᵢ/τᵢ = Ṡ, S the law's isochoric second Piola-Kirchhoff
stress, so that no rotation changes it (Holzapfel 2000, Nonlinear Solid Mechanics, section 6.10;
Simo 1987, CMAME 60:153). Over a time step in which S goes from S₀ to S₁ at a constant rate,

    h₁ = exp(−Δt/τ) h₀ + γ (S₁ − S₀),  γ = (1 − exp(−Δt/τ))/(Δt/τ)

is exact (Taylor, Pister and Goudreau 1970, IJNME 2:45), and stable for steps of any length.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from softact.fields import Part, fault
from softact.units import Dimensionless, Time

Share = Annotated[Dimensionless, Field(ge=0, lt=1)]
RelaxationTime = Annotated[Time, Field(gt=0)]


class Shift(Part, title="WLF shift"):
    """Relaxation times at another temperature: log₁₀ a = −C1 (T − Tr)/(C2 + T − Tr)
    (Williams, Landel and Ferry 1955). Temperatures in °C, as bare numbers."""

    c1: Dimensionless = Field(description="C1; 17.44 where nothing better is known, with Tr = Tg")
    c2: Dimensionless = Field(gt=0, description="C2, in K")
    reference: Dimensionless = Field(description="temperature of the test in °C, Tr")
    temperature: Dimensionless = Field(description="temperature of the run in °C, T")

    @model_validator(mode="after")
    def _above_the_pole(self) -> Self:
        if self.c2 + self.temperature - self.reference <= 0:
            lowest = self.reference - self.c2
            raise fault(f"the shift has no value at or below {lowest:g} °C (reference − c2)")
        return self

    @property
    def factor(self) -> float:
        """By which relaxation times grow."""
        warmer = self.temperature - self.reference
        return float(10 ** (-self.c1 * warmer / (self.c2 + warmer)))


class Viscoelastic(Part, title="Viscoelastic"):
    """A Prony series of the shear modulus, G(t) = G₀ (1 − Σ gᵢ (1 − exp(−t/τᵢ)))."""

    g: tuple[Share, ...] = Field(
        strict=False, description="parts of the instantaneous modulus that relax"
    )
    tau: tuple[RelaxationTime, ...] = Field(
        strict=False, description="relaxation time of each of them"
    )
    constants: Literal["long_time", "instantaneous"] = Field(
        description="of which state the law's own constants are: of a slow test (long_time), or of "
        "one too fast for anything to relax (instantaneous)"
    )
    wlf: Shift | None = Field(None, description="shift of the times to another temperature")

    @model_validator(mode="after")
    def _is_a_series(self) -> Self:
        if len(self.g) != len(self.tau):
            raise fault(f"{len(self.g)} g and {len(self.tau)} tau; each g has a tau")
        if sum(self.g) >= 1:
            raise fault(
                f"the g add up to {sum(self.g):g}: nothing would be left in the long run; they are "
                "parts of the instantaneous modulus, with a sum below 1"
            )
        return self

    @property
    def prony(self) -> Prony | None:
        """What the solver takes; None where nothing relaxes."""
        pairs = [(g, tau) for g, tau in zip(self.g, self.tau, strict=True) if g > 0]
        if not pairs:
            return None
        rest = 1 - sum(self.g)
        scale = 1.0 if self.constants == "instantaneous" else 1 / rest
        shift = self.wlf.factor if self.wlf else 1.0
        shares, times = np.array(pairs).T
        return Prony(rest * scale, scale * shares, shift * times)


@dataclass(frozen=True)
class Step:
    """What a time step makes of stresses: S₁ counts ``total`` times; the stress h₀ of each element
    counts ``decay`` (k,) times, S₁ − S₀ in it ``growth`` (k,) times."""

    total: float
    decay: np.ndarray
    growth: np.ndarray


@dataclass(frozen=True)
class Prony:
    """elastic: part of the law's stress that stays for ever. shares b, times τ (s): (k,) of the
    Maxwell elements, seen from the law's stress."""

    elastic: float
    shares: np.ndarray
    times: np.ndarray

    def over(self, elapsed: float) -> Step:
        """A time step of so many s; inf: everything has relaxed."""
        x = elapsed / self.times
        growth = _mean_decay(x)
        total = self.elastic + float(self.shares @ growth)
        return Step(total, np.exp(-x), growth)

    def curved(self, elapsed: float) -> float:
        """Error of the stress, in MPa by MPa/s² of S, after many time steps of so many s in which S
        has a second rate.

        One adds b τ² (x/2 − 1 + exp(−x) (1 + x/2)) with x = Δt/τ, and what one has added decays:
        Σ b τ² ((x/2) coth(x/2) − 1), which is b Δt²/12 in short steps.
        """
        half = elapsed / self.times / 2
        short = half < 1e-2
        safe = np.where(short, 1.0, half)
        each = np.where(short, half**2 / 3, safe / np.tanh(safe) - 1)
        return float(self.shares * self.times**2 @ each)

    def sudden(self, elapsed: float) -> float:
        """Error of the stress after one time step, by the change of S in it, where S goes to rest
        as fast as each element relaxes: Σ b ((1 − exp(−x))/x − x/(exp(x) − 1))."""
        x = elapsed / self.times
        short = x < 1e-2
        safe = np.where(short, 1.0, x)
        with np.errstate(over="ignore"):
            whole = _mean_decay(safe) - safe / np.expm1(safe)
        return float(self.shares @ np.where(short, x**2 / 12, whole))


def _mean_decay(x: np.ndarray) -> np.ndarray:
    """(1 − exp(−x))/x: 1 at 0, 0 at infinity."""
    safe = np.where(x == 0.0, 1.0, x)
    return np.where(x == 0.0, 1.0, -np.expm1(-safe) / safe)
