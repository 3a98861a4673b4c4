"""Nodes of a module where the motion of its chain takes them, x₊ = c + R (x − c) + t, as functions
of their own unknowns, of ω and of t (``softact.bodies.repeat``)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.system.motions import Motions

if TYPE_CHECKING:
    from softact.bodies.repeat import Repeat

Triplets = tuple[np.ndarray, np.ndarray, np.ndarray]


class Images:
    """Images of nodes in other modules; for one process.

    rest: (n, 3) mm of the nodes, undeformed, from the middle c of the left face. dofs: (n, 3) their
    unknowns. modules: (n,) how often the motion is done, −1: it is taken back once; by default
    once, to the next module.
    """

    def __init__(
        self, repeat: Repeat, rest: np.ndarray, dofs: np.ndarray, modules: np.ndarray | None = None
    ):
        self._repeat, self.rest, self.dofs = repeat, rest, dofs
        self.turns, self.shifts = repeat.dofs.reshape(2, 3)
        modules = np.ones(len(rest), dtype=int) if modules is None else modules
        self._times, self._which = np.unique(modules, return_inverse=True)
        self._beyond = modules[:, None] * repeat.pitch
        self._known: tuple[np.ndarray, Motions] | None = None

    def _motions(self, x: np.ndarray) -> Motions:
        """Kept, since they are asked for again and again."""
        turn, _ = self._repeat.motion(x)
        if self._known is None or not np.array_equal(self._known[0], turn):
            self._known = turn.copy(), Motions(turn, self._times)
        return self._known[1]

    def _here(self, x: np.ndarray) -> np.ndarray:
        """Places (n, 3) from c of the nodes themselves."""
        return self.rest + x[self.dofs]

    def places(self, x: np.ndarray) -> np.ndarray:
        """Places (n, 3) mm from c."""
        motions, (_, shift) = self._motions(x), self._repeat.motion(x)
        turned = np.einsum("nab,nb->na", motions.turns[0][self._which], self._here(x))
        return turned + (motions.sums[0] @ shift)[self._which]

    def displacements(self, x: np.ndarray) -> np.ndarray:
        """Displacements (n, 3) mm from where the undeformed modules have their nodes."""
        return self.places(x) - self.rest - self._beyond

    def pull(self, x: np.ndarray, push: np.ndarray, out: np.ndarray) -> None:
        """Add to ``out`` (local,) what forces (n, 3) at the images are at the unknowns: Jᵀ push."""
        motions = self._motions(x)
        back = np.einsum("na,nab->nb", push, motions.turns[0][self._which])
        out += np.bincount(self.dofs.ravel(), back.ravel(), len(out))
        out[self.turns] += np.einsum("na,nai->i", push, self._by_turn(x))
        out[self.shifts] += np.einsum("na,nab->b", push, motions.sums[0][self._which])

    def _by_turn(self, x: np.ndarray) -> np.ndarray:
        """Derivatives (n, 3, 3) of the places by the unknowns of ω."""
        motions, (_, shift) = self._motions(x), self._repeat.motion(x)
        found = np.einsum("niab,nb->nai", motions.turns[1][self._which], self._here(x))
        found += np.einsum("piab,b->pai", motions.sums[1], shift)[self._which]
        return found / self._repeat.length

    def jacobian(self, x: np.ndarray, rows: np.ndarray) -> Triplets:
        """J as rows, columns and values: of places with the numbers ``rows`` (n, 3) by unknowns.
        Which entries there are does not depend on ``x``."""
        motions, n = self._motions(x), len(self.dofs)
        flat = np.repeat(rows, 3, axis=1).ravel()
        columns = [np.tile(self.dofs, 3).ravel()]
        columns += [np.tile(each, 3 * n) for each in (self.turns, self.shifts)]
        values = motions.turns[0][self._which], self._by_turn(x), motions.sums[0][self._which]
        return np.tile(flat, 3), np.concatenate(columns), np.concatenate([*map(np.ravel, values)])

    def second(self, x: np.ndarray, push: np.ndarray) -> Triplets:
        """Second derivatives of the sum of forces (n, 3) times places, as rows, columns and values.
        Which entries there are does not depend on ``x``."""
        motions, (_, shift), length = self._motions(x), self._repeat.motion(x), self._repeat.length
        by_power = np.zeros((len(self._times), 3))
        np.add.at(by_power, self._which, push)
        one = np.einsum("niab,na->inb", motions.turns[1][self._which], push).ravel() / length
        moments = np.zeros((len(self._times), 3, 3))
        np.add.at(moments, self._which, push[:, :, None] * self._here(x)[:, None])
        two = np.einsum("pijab,pab->ij", motions.turns[2], moments)
        two += np.einsum("pijab,pa,b->ij", motions.sums[2], by_power, shift)
        mixed = np.einsum("piab,pa->ib", motions.sums[1], by_power).ravel() / length
        dofs = self.dofs.ravel()
        turns, nodes = np.repeat(self.turns, len(dofs)), np.tile(dofs, 3)
        down, across = np.repeat(self.turns, 3), np.tile(self.shifts, 3)
        return (
            np.concatenate([turns, nodes, down, down, across]),
            np.concatenate([nodes, turns, np.tile(self.turns, 3), across, down]),
            np.concatenate([one, one, two.ravel() / length**2, mixed, mixed]),
        )
