"""Nodes of a module where the motion of its chain takes them, x₊ = c + R (x − c) + t, as functions
of their own unknowns, of ω and of t (``softact.bodies.repeat``)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from softact.bodies.repeat import Repeat

Triplets = tuple[np.ndarray, np.ndarray, np.ndarray]


class Images:
    """Images of nodes in the next module; for one process.

    rest: (n, 3) mm of the nodes, undeformed, from the middle c of the left face. dofs: (n, 3) their
    unknowns.
    """

    def __init__(self, repeat: Repeat, rest: np.ndarray, dofs: np.ndarray):
        self._repeat, self.rest, self.dofs = repeat, rest, dofs
        self.turns, self.shifts = repeat.dofs.reshape(2, 3)

    def _here(self, x: np.ndarray) -> np.ndarray:
        """Places (n, 3) from c of the nodes themselves."""
        return self.rest + x[self.dofs]

    def places(self, x: np.ndarray) -> np.ndarray:
        """Places (n, 3) mm from c."""
        _, shift = self._repeat.motion(x)
        return self._here(x) @ self._repeat.turned(x).matrix.T + shift

    def displacements(self, x: np.ndarray) -> np.ndarray:
        """Displacements (n, 3) mm from where the undeformed next module has its nodes."""
        return self.places(x) - self.rest - self._repeat.pitch

    def pull(self, x: np.ndarray, push: np.ndarray, out: np.ndarray) -> None:
        """Add to ``out`` (local,) what forces (n, 3) at the images are at the unknowns: Jᵀ push."""
        out[self.dofs] += push @ self._repeat.turned(x).matrix
        out[self.turns] += np.einsum("na,nai->i", push, self._by_turn(x))
        out[self.shifts] += push.sum(axis=0)

    def _by_turn(self, x: np.ndarray) -> np.ndarray:
        """Derivatives (n, 3, 3) of the places by the unknowns of ω."""
        first = self._repeat.turned(x).first
        return np.einsum("iab,nb->nai", first, self._here(x)) / self._repeat.length

    def jacobian(self, x: np.ndarray, rows: np.ndarray) -> Triplets:
        """J as rows, columns and values: of places with the numbers ``rows`` (n, 3) by unknowns.
        Which entries there are does not depend on ``x``."""
        n, flat = len(self.dofs), np.repeat(rows, 3, axis=1).ravel()
        columns = [np.tile(self.dofs, 3).ravel(), np.tile(self.turns, 3 * n)]
        values = [np.tile(self._repeat.turned(x).matrix.ravel(), n), self._by_turn(x).ravel()]
        return (
            np.concatenate([flat, flat, rows.ravel()]),
            np.concatenate([*columns, np.tile(self.shifts, n)]),
            np.concatenate([*values, np.ones(3 * n)]),
        )

    def second(self, x: np.ndarray, push: np.ndarray) -> Triplets:
        """Second derivatives of the sum of forces (n, 3) times places, as rows, columns and values.
        Which entries there are does not depend on ``x``."""
        turn, length = self._repeat.turned(x), self._repeat.length
        one = np.einsum("iab,na->inb", turn.first, push).ravel() / length
        two = np.einsum("na,ijab,nb->ij", push, turn.second, self._here(x)).ravel() / length**2
        dofs = self.dofs.ravel()
        turns, nodes = np.repeat(self.turns, len(dofs)), np.tile(dofs, 3)
        return (
            np.concatenate([turns, nodes, np.repeat(self.turns, 3)]),
            np.concatenate([nodes, turns, np.tile(self.turns, 3)]),
            np.concatenate([one, one, two]),
        )
