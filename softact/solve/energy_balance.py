"""Where the work of the loads goes while backward Euler carries a body along.

On the straight line from each accepted state to the next, along which the loads change linearly,
M Δv/Δt + α M v₁ + R₁ = 0 with R the internal less the external force, multiplied by Δx = v₁ Δt, is

    work = Δ(strain energy) + Δ(½ v·M v) + α Δt v₁·M v₁ + loss,
    loss = ½ Δv·M Δv + ∫ (R₁ − R)·dx,

the loss that of the time step: with a quadratic energy U and constant loads its second part is half
of Δx·∇∇U Δx. Each term is computed by itself, the pressure's work from volumes, the strain energy
from the laws, the loss from forces; what is left is the error of Newton's tolerance and of the
quadrature, and tells whether forces, energies and volumes belong together. On the way from a motion
to the equilibrium nearby, R₁ = 0 and v₁ = 0, all that is lost counts as loss.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from softact.model import Model
from softact.solve.newton import Newton
from softact.solve.path import Drive
from softact.system.term import State

# Nodes (as shares of the way) and weights of Boole's rule: exact to degree 5.
NODES = np.linspace(0.0, 1.0, 5)
WEIGHTS = np.array([7.0, 32.0, 12.0, 32.0, 7.0]) / 90


@dataclass(frozen=True)
class _Place:
    """Forces and volumes at a place of the way: out of balance and those of loads other than
    pressures (local,), cavities' volumes (mm³) and pressures (MPa)."""

    unbalanced: np.ndarray
    others: np.ndarray
    volumes: np.ndarray
    pressures: np.ndarray


class EnergyBalance:
    """Energies of the meshed part since the start, mJ: work of all loads and of moving supports;
    stored and kinetic, which they are now; damped; lost in the time steps.

    To be used while no inertia acts in the model. For one process.
    """

    def __init__(
        self, model: Model, newton: Newton, drive: Drive, state: State, s: float, q: np.ndarray
    ):
        self._model, self._newton, self._drive, self._state = model, newton, drive, state
        self._s, self._q, self._x = s, q, state.x.copy()
        self._velocity = np.zeros_like(state.x)
        self._begun = model.strain_energy(state)
        self._last = self._at(s, q, self._x)
        self.work = self.stored = self.kinetic = self.damped = self.lost = 0.0

    @property
    def unexplained(self) -> float:
        """Part of the work that is in none of the terms."""
        rest = self.work - self.stored - self.kinetic - self.damped - self.lost
        return abs(rest) / max(abs(self.work), 1e-300)

    def move(
        self,
        s: float,
        q: np.ndarray,
        velocity: np.ndarray | None = None,
        time_step: float = 1.0,
        damping: float = 0.0,
    ) -> None:
        """Go on to the state as it is, with the loads of s; no velocity: an equilibrium."""
        x, at_rest = self._state.x.copy(), velocity is None
        velocity = np.zeros_like(x) if velocity is None else velocity
        way, change = x - self._x, velocity - self._velocity
        momentum = self._model.momentum(velocity)
        places = [self._last]
        for share in NODES[1:]:
            rest = 1 - share
            there = rest * self._s + share * s, rest * self._q + share * q
            places.append(self._at(*there, rest * self._x + share * x))
        end = places[-1]
        mean = sum(w * place.unbalanced for w, place in zip(WEIGHTS, places, strict=True))
        brought = end.unbalanced + damping * momentum
        if not at_rest:
            brought = brought + self._model.momentum(change) / time_step
        self.work += self._pressures(places) + float(self._held(way) @ self._held(brought))
        self.work += sum(w * float(p.others @ way) for w, p in zip(WEIGHTS, places, strict=True))
        self.stored = self._model.strain_energy(self._state) - self._begun
        self.kinetic = float(velocity @ momentum) / 2
        self.damped += 2 * damping * self.kinetic * time_step
        self.lost += float(change @ self._model.momentum(change)) / 2
        self.lost += float((end.unbalanced - mean) @ way)
        self._s, self._q, self._x, self._velocity, self._last = s, q, x, velocity, end

    @staticmethod
    def _pressures(places: list[_Place]) -> float:
        """∫ p dV = Δ(p V) − ∫ V dp."""
        first, last = places[0], places[-1]
        mean = sum(w * place.volumes for w, place in zip(WEIGHTS, places, strict=True))
        total = last.pressures * last.volumes - first.pressures * first.volumes
        return float((total - (last.pressures - first.pressures) * mean).sum())

    def _held(self, vector: np.ndarray) -> np.ndarray:
        """Its values at the supported unknowns."""
        return self._newton.held(replace(self._state, x=vector)).start

    def _at(self, s: float, q: np.ndarray, x: np.ndarray) -> _Place:
        model, state = self._model, replace(self._state, x=x)
        self._drive.set(state, s, q)
        unbalanced, internal = model.force(state)
        of_pressure = np.zeros_like(x)
        for cavity in model.cavities.values():
            cavity.add_force(state, of_pressure)
        names = list(model.cavities)
        return _Place(
            unbalanced,
            internal - unbalanced + of_pressure,
            np.array([model.cavity_volume(state, name) for name in names]),
            np.array([state["pressure"].get(name, 0.0) for name in names]),
        )
