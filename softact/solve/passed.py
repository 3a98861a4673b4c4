"""Equilibria that a step has been at: after a limit of the load the way leads on, not back."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from softact.model import Model

# Nodes whose displacements stand for a state.
SAMPLE = 1000
# A state has returned where it is nearer than this to one that was passed under the same load, by
# how far the state before it is from that one.
RETURNED = 0.5


#: Fractions of a step's loads, rising, and the sampled displacements under them.
Branch = list[tuple[float, np.ndarray]]


class Passed:
    """The stable equilibria of a step under load control, in branches: within one the load grows.

    Where a limit ends a branch, ``leave`` it: another state under a load that it has carried must
    not be one of its states again. Collective.
    """

    def __init__(self, model: Model):
        self._model = model
        owned = model.nodes.owned
        whole = max(model.sum(owned), 1)
        every = max(1, whole // SAMPLE)
        self._dofs = model.displacement_dofs[:owned:every]
        self._here: Branch = []
        self._left: list[Branch] = []

    def add(self, fraction: float, x: np.ndarray) -> None:
        """Take a state, with the fraction of the step's loads, into the present branch."""
        if self._here and fraction <= self._here[-1][0]:
            self._here = [point for point in self._here if point[0] < fraction]
        self._here.append((fraction, x[self._dofs].copy()))

    def leave(self) -> None:
        """The present branch is passed from here on."""
        if len(self._here) > 1:
            self._left.append(self._here)
        self._here = []

    def kept(self) -> dict[str, np.ndarray]:
        """All that is known, of this process, as arrays by name; for ``take``."""
        branches = [*self._left, self._here]
        points = [(n, *point) for n, branch in enumerate(branches) for point in branch]
        numbers, fractions, states = zip(*points, strict=True)
        return {
            "branch": np.array(numbers),
            "fraction": np.array(fractions),
            "state": np.array(states, dtype=np.float32),  # a sample, to tell far from near
            "left": np.array(len(self._left)),
        }

    def take(self, kept: Mapping[str, np.ndarray]) -> None:
        """Know what ``kept`` gave, and nothing else."""
        branches: list[Branch] = [[] for _ in range(int(kept["left"]) + 1)]
        points = zip(kept["branch"], kept["fraction"], kept["state"], strict=True)
        for number, fraction, state in points:
            branches[number].append((float(fraction), state.astype(float)))
        *self._left, self._here = branches

    def returned(self, last: np.ndarray, x: np.ndarray, fraction: float) -> bool:
        """Whether a state x (local,), reached from ``last``, is on a branch that was left."""
        return any(
            self._distance(x[self._dofs], state)
            < RETURNED * self._distance(last[self._dofs], state)
            for state in (self._at(branch, fraction) for branch in self._left)
            if state is not None
        )

    @staticmethod
    def _at(branch: Branch, fraction: float) -> np.ndarray | None:
        """The branch's state under a load, between those that are known; None beyond its ends.

        It leads on to the limit beyond the last known state, which stands for that part: a state
        under the very same load may lie beyond it by rounding.
        """
        fractions = np.array([point[0] for point in branch])
        limit = 2 * fractions[-1] - fractions[-2]
        if not fractions[0] <= fraction <= limit:
            return None
        fraction = min(fraction, fractions[-1])
        after = int(np.clip(np.searchsorted(fractions, fraction), 1, len(branch) - 1))
        (s, one), (t, other) = branch[after - 1], branch[after]
        share = (fraction - s) / (t - s)
        return (1 - share) * one + share * other

    def _distance(self, one: np.ndarray, other: np.ndarray) -> float:
        return float(np.sqrt(self._model.sum(float(((one - other) ** 2).sum()))))
