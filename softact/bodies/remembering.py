"""Regions of tetrahedra whose material remembers: what creeps, and what softens.

What it has to know of the last equilibrium stands in ``State.memory``, at the quadrature points,
under keys that begin with "solid" and the region's name.
"""

from __future__ import annotations

import hashlib
from typing import Any

import numpy as np

from softact.bodies.solid import KEPT, Solid
from softact.materials.viscoelastic import Step
from softact.system.term import State

#: Isochoric stress (n, 6), moduli (n, 6, 6) and energy (n,) of the law alone; the energy is None
#: where it is not wanted.
Elastic = tuple[np.ndarray, np.ndarray, np.ndarray | None]
NOTHING = 1e-6  # strain below which nothing is said to be strained
# What is of no use beyond a turn of the loads.
RATE = ".rate"


class RememberingSolid(Solid):
    """A region with Maxwell elements or Mullins' softening on top of its law.

    Memory of a state, by key after the name: peak (n,) largest energy; stress S (n, 6), overstress
    h (k, n, 6), rate of S (n, 6) and the time step before; scale: largest root mean square of S. A
    region that lacks them has not been loaded.
    """

    def __init__(self, *args: Any, **more: Any):
        super().__init__(*args, **more)
        law = self.material.law
        self.mullins = law.mullins
        self.prony = law.viscoelastic.prony if law.viscoelastic else None
        self._points = self.volumes.size
        self._of_law: dict[bytes, Elastic] = {}
        self._counts_on: tuple[Any, Any] = (None, None)
        self._past: tuple[float, np.ndarray] | None = None  # see ``_history``

    # --- stress ---------------------------------------------------------------------------------

    def _isochoric(self, c: np.ndarray, state: State) -> tuple[np.ndarray, np.ndarray]:
        """See ``Solid``: with softening and overstress."""
        stress, moduli = self._softened(self._law(c, state.x), state)
        if self.prony is None:
            return stress, moduli
        step = self.prony.over(state.clock.elapsed)
        return step.total * stress + self._history(state, step), step.total * moduli

    def _law(self, c: np.ndarray, x: np.ndarray) -> Elastic:
        """The law alone, kept for the last few states whenever they were."""
        key = hashlib.blake2b(x.data, digest_size=16).digest()
        found = self._of_law.pop(key, None)
        if found is None:
            energy = self.material.energy(c, self.fibres) if self.mullins else None
            found = *self.material.stress_tangent(c, self.fibres), energy
        self._of_law[key] = found
        while len(self._of_law) > KEPT:
            del self._of_law[next(iter(self._of_law))]
        return found

    def _softened(self, elastic: Elastic, state: State) -> tuple[np.ndarray, np.ndarray]:
        stress, moduli, energy = elastic
        if self.mullins is None or energy is None:
            return stress, moduli
        part, slope = self.mullins.softening(energy, np.maximum(self._peak(state), energy))
        outer = slope[:, None, None] * stress[:, :, None] * stress[:, None]
        return part[:, None] * stress, part[:, None, None] * moduli + outer

    def _history(self, state: State, step: Step) -> np.ndarray:
        """What a time step takes over from the one before: Σ b (decay h₀ − growth S₀), (n, 6)."""
        assert self.prony is not None
        kept = self._kept_of(state, "stress")
        if kept is None or not step.decay.any():
            return np.zeros(6)
        self._forget_other(state)
        if self._past is None or self._past[0] != state.clock.elapsed:
            shares = self.prony.shares
            before = self._known(state, "overstress")
            past = np.einsum("k,kni->ni", shares * step.decay, before)
            self._past = state.clock.elapsed, past - float(shares @ step.growth) * kept
        return self._past[1]

    def _key(self, state: State) -> bytes:
        """See ``Solid``."""
        self._forget_other(state)
        return super()._key(state) + repr(state.clock.elapsed).encode()

    def _forget_other(self, state: State) -> None:
        """Forget what was computed for another memory than that of ``state``."""
        now = self._kept_of(state, "stress"), self._kept_of(state, "peak")
        if any(a is not b for a, b in zip(now, self._counts_on, strict=True)):
            self._counts_on, self._past = now, None
            self._kept.clear()

    # --- memory ---------------------------------------------------------------------------------

    def name_of(self, what: str) -> str:
        """Key of a state's memory."""
        return f"solid {self.name}.{what}"

    def _kept_of(self, state: State, what: str) -> Any:
        return state.memory.get(self.name_of(what))

    def _known(self, state: State, what: str) -> np.ndarray:
        return np.asarray(self._kept_of(state, what))

    def _peak(self, state: State) -> np.ndarray:
        kept = self._kept_of(state, "peak")
        return np.zeros(self._points) if kept is None else np.asarray(kept)

    def remember(self, state: State) -> dict[str, np.ndarray | float]:
        """What is to be kept of a new equilibrium. Collective."""
        elastic = self._law(self._right_cauchy_green(state.x), state.x)
        found: dict[str, np.ndarray | float] = {}
        if elastic[2] is not None:
            found["peak"] = np.maximum(self._peak(state), elastic[2])
        if self.prony is not None:
            found |= self._strained(state, self._softened(elastic, state)[0])
        return {self.name_of(what): value for what, value in found.items()}

    def _strained(self, state: State, stress: np.ndarray) -> dict[str, np.ndarray | float]:
        assert self.prony is not None
        elapsed = state.clock.elapsed
        step = self.prony.over(elapsed)
        count = len(self.prony.shares)
        kept = self._kept_of(state, "stress")
        before = np.zeros_like(stress) if kept is None else np.asarray(kept)
        overstress = self._kept_of(state, "overstress")
        if overstress is None or not step.decay.any():
            overstress = np.zeros((count, *stress.shape))
        change = stress - before
        grown = step.decay[:, None, None] * np.asarray(overstress)
        grown += step.growth[:, None, None] * change
        found: dict[str, np.ndarray | float] = {
            "stress": stress,
            "overstress": grown,
            "scale": self._scale(state, stress),
        }
        if 0.0 < elapsed < np.inf:
            found |= {"rate": change / elapsed, "step": elapsed}
        return found

    def _scale(self, state: State, stress: np.ndarray) -> float:
        before = self._kept_of(state, "scale")
        return max(self._mean_square(stress) ** 0.5, 0.0 if before is None else float(before))

    def _mean_square(self, stress: np.ndarray) -> float:
        """Of stresses (n, 6), over the region's volume, MPa². Collective."""
        sums = self.volumes.ravel() @ (stress**2).sum(axis=1), self.volumes.sum()
        whole = self.assembler.unknowns.comm.allreduce(np.array(sums))
        return float(whole[0] / whole[1])

    def time_error(self, state: State) -> float:
        """Error of the overstress in the time step that ends with ``state``, by the largest stress
        so far: S is taken to go at a constant rate, and has a second one. Collective."""
        elapsed = state.clock.elapsed
        if self.prony is None or not 0.0 < elapsed < np.inf:
            return 0.0
        elastic = self._law(self._right_cauchy_green(state.x), state.x)
        stress, _ = self._softened(elastic, state)
        kept = self._kept_of(state, "stress")
        change = stress if kept is None else stress - np.asarray(kept)
        rate = self._kept_of(state, "rate")
        if rate is None:
            error = self.prony.sudden(elapsed) * self._mean_square(change) ** 0.5
        else:
            between = (elapsed + float(self._known(state, "step"))) / 2
            second = (change / elapsed - np.asarray(rate)) / between
            error = self.prony.curved(elapsed) * self._mean_square(second) ** 0.5
        least = NOTHING * self.material.shear_modulus
        return error / max(self._scale(state, stress), least)

    # --- energy ---------------------------------------------------------------------------------

    def _stored(self, c: np.ndarray, state: State) -> np.ndarray:
        """See ``Solid``: what the law gives back in the long run; overstress is not in it."""
        energy = super()._stored(c, state)
        if self.mullins is not None:
            energy = self.mullins.recoverable(energy, np.maximum(self._peak(state), energy))
        return energy if self.prony is None else self.prony.elastic * energy

    def softened_away(self, state: State) -> float:
        """Energy that softening has taken for good, mJ, of this process."""
        if self.mullins is None:
            return 0.0
        energy = super()._stored(self._right_cauchy_green(state.x), state)
        lost = self.mullins.lost(np.maximum(self._peak(state), energy))
        elastic = 1.0 if self.prony is None else self.prony.elastic
        return elastic * float(lost @ self.volumes.ravel())


def without_rates(state: State) -> None:
    """Forget the rates of stresses, where loads turn."""
    state.memory = {name: v for name, v in state.memory.items() if not name.endswith(RATE)}
