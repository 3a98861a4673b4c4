"""What a material remembers at its points: overstress of Maxwell elements and Mullins' softening,
on top of the stress of its law.

Memory of a state, by key after the name: peak (n,) largest energy; stress S (n, c), overstress
h (k, n, c), rate of S (n, c) and the time step before; scale: largest root mean square of S. What
lacks them has not been loaded. A stress has c components: six, or three in the plane of a layer.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from mpi4py import MPI

from softact.materials.base import Elastic, Law
from softact.materials.viscoelastic import Step
from softact.system.term import State

NOTHING = 1e-6  # strain below which nothing is said to be strained
# What is of no use beyond a turn of the loads.
RATE = ".rate"


class Memory:
    """The memory of one material. name: of what is made of it, with which its keys begin. weights:
    (n,) volumes or areas of its points, on this process."""

    def __init__(self, name: str, law: Law, weights: np.ndarray, comm: MPI.Comm):
        self._name, self._law, self._weights, self._comm = name, law, weights, comm
        self.mullins = law.mullins
        self.prony = law.viscoelastic.prony if law.viscoelastic else None
        self._counts_on: tuple[Any, Any] = (None, None)
        self._past: tuple[float, np.ndarray] | None = None  # see ``_history``

    def name_of(self, what: str) -> str:
        """Key of a state's memory."""
        return f"{self._name}.{what}"

    def _kept(self, state: State, what: str) -> Any:
        return state.memory.get(self.name_of(what))

    def _peak(self, state: State) -> np.ndarray:
        kept = self._kept(state, "peak")
        return np.zeros(len(self._weights)) if kept is None else np.asarray(kept)

    # --- stress ---------------------------------------------------------------------------------

    def has_changed(self, state: State) -> bool:
        """Whether ``state`` has another memory than the one that was asked about before."""
        now = self._kept(state, "stress"), self._kept(state, "peak")
        if all(a is b for a, b in zip(now, self._counts_on, strict=True)):
            return False
        self._counts_on, self._past = now, None
        return True

    def response(self, elastic: Elastic, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Stress and moduli with softening and overstress."""
        stress, moduli = self._softened(elastic, state)
        if self.prony is None:
            return stress, moduli
        step = self.prony.over(state.clock.elapsed)
        return step.total * stress + self._history(state, step), step.total * moduli

    def _softened(self, elastic: Elastic, state: State) -> tuple[np.ndarray, np.ndarray]:
        stress, moduli, energy = elastic
        if self.mullins is None or energy is None:
            return stress, moduli
        part, slope = self.mullins.softening(energy, np.maximum(self._peak(state), energy))
        outer = slope[:, None, None] * stress[:, :, None] * stress[:, None]
        return part[:, None] * stress, part[:, None, None] * moduli + outer

    def _history(self, state: State, step: Step) -> np.ndarray:
        """What a time step takes over from the one before: Σ b (decay h₀ − growth S₀), (n, c)."""
        assert self.prony is not None
        kept = self._kept(state, "stress")
        if kept is None or not step.decay.any():
            return np.zeros(1)
        self.has_changed(state)
        if self._past is None or self._past[0] != state.clock.elapsed:
            shares = self.prony.shares
            before = np.asarray(self._kept(state, "overstress"))
            past = np.einsum("k,kni->ni", shares * step.decay, before)
            self._past = state.clock.elapsed, past - float(shares @ step.growth) * kept
        return self._past[1]

    # --- what is kept ---------------------------------------------------------------------------

    def remember(self, elastic: Elastic, state: State) -> dict[str, np.ndarray | float]:
        """What is to be kept of a new equilibrium. Collective."""
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
        kept = self._kept(state, "stress")
        before = np.zeros_like(stress) if kept is None else np.asarray(kept)
        overstress = self._kept(state, "overstress")
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
        before = self._kept(state, "scale")
        return max(self._mean_square(stress) ** 0.5, 0.0 if before is None else float(before))

    def _mean_square(self, stress: np.ndarray) -> float:
        """Of stresses (n, c), over all points by their weights, MPa². Collective."""
        sums = self._weights @ (stress**2).sum(axis=1), self._weights.sum()
        whole = self._comm.allreduce(np.array(sums))
        return float(whole[0] / whole[1])

    def time_error(self, elastic: Elastic, state: State, modulus: float) -> float:
        """Error of the overstress in the time step that ends with ``state``, by the largest stress
        so far: S is taken to go at a constant rate, and has a second one. modulus: MPa, of which a
        strain of ``NOTHING`` makes the least stress that counts. Collective."""
        elapsed = state.clock.elapsed
        if self.prony is None or not 0.0 < elapsed < np.inf:
            return 0.0
        stress, _ = self._softened(elastic, state)
        kept = self._kept(state, "stress")
        change = stress if kept is None else stress - np.asarray(kept)
        rate = self._kept(state, "rate")
        if rate is None:
            error = self.prony.sudden(elapsed) * self._mean_square(change) ** 0.5
        else:
            between = (elapsed + float(np.asarray(self._kept(state, "step")))) / 2
            second = (change / elapsed - np.asarray(rate)) / between
            error = self.prony.curved(elapsed) * self._mean_square(second) ** 0.5
        return error / max(self._scale(state, stress), NOTHING * modulus)

    # --- energy ---------------------------------------------------------------------------------

    def stored(self, energy: np.ndarray, state: State) -> np.ndarray:
        """Of the law's energy (n,), what it gives back in the long run; overstress is not in it."""
        if self.mullins is not None:
            energy = self.mullins.recoverable(energy, np.maximum(self._peak(state), energy))
        return energy if self.prony is None else self.prony.elastic * energy

    def softened_away(self, energy: np.ndarray, state: State) -> float:
        """Energy that softening has taken for good, mJ, of this process. energy: (n,), of the law
        in ``state``."""
        if self.mullins is None:
            return 0.0
        lost = self.mullins.lost(np.maximum(self._peak(state), energy))
        elastic = 1.0 if self.prony is None else self.prony.elastic
        return elastic * float(lost @ self._weights)


def without_rates(state: State) -> None:
    """Forget the rates of stresses, where loads turn."""
    state.memory = {name: v for name, v in state.memory.items() if not name.endswith(RATE)}
