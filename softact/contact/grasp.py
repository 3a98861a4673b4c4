"""What contact of facets does to the free body that they touch: its share of force and tangent.

A point x of a facet is seen from the body as X = Rᵀ (x − c − u) + c. A traction T(X) in the body's
frame does the work −T · δX on the unknowns of both, whether it has a potential or not: what acts on
the one acts on the other, and its moment is that about where they touch.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.contact.facets import ContactFacets
from softact.contact.free_body import FreeBody, Motion
from softact.system.term import State

if TYPE_CHECKING:
    from softact.model import Model


class Grasp:
    """Facets that may touch a free body, coupled with its unknowns in the matrix."""

    def __init__(self, model: Model, facets: ContactFacets, body: FreeBody):
        self._facets, self._body, self._assembler = facets, body, model.assembler
        self._dofs, at = np.unique(facets.dofs, return_inverse=True)
        self._at = at.reshape(facets.dofs.shape)
        number = model.unknowns.number
        rows, columns = (
            np.repeat(number[self._dofs], 6),
            np.tile(number[body.dofs], len(self._dofs)),
        )
        self._slots = [
            model.assembler.couple(rows, columns),
            model.assembler.couple(columns, rows),
        ]

    def _arms(self, state: State, motion: Motion, on: np.ndarray) -> np.ndarray:
        """From the body's centre to the points of the facets ``on`` (m, 12, 3), mm."""
        return self._facets.places(state.x)[on] - self._body.centre - motion.shift

    def add_force(
        self, state: State, tractions: np.ndarray, out: np.ndarray, on: np.ndarray
    ) -> None:
        """Add what acts on the body; tractions (m, 12, 3) that it sees on the facets ``on``."""
        motion = self._body.motion(state)
        weighted = tractions * self._facets.areas[on][..., None]
        out[self._body.dofs[:3]] += motion.turn @ weighted.sum(axis=(0, 1))
        moment = np.tensordot(self._arms(state, motion, on), weighted, ((0, 1), (0, 1)))
        out[self._body.dofs[3:]] -= np.tensordot(motion.first, moment, 2)

    def add_tangent(
        self, state: State, tractions: np.ndarray, moduli: np.ndarray, on: np.ndarray
    ) -> None:
        """Add its derivatives, and those of the facets' force by its unknowns; moduli (m, 12, 3, 3)
        of the tractions by the places, both as the body sees them."""
        motion, body = self._body.motion(state), self._body
        arms, weight = self._arms(state, motion, on), self._facets.areas[on]
        values = self._facets.values
        # Derivatives of X by u and θ (m, 12, 3, 6).
        by_body = np.zeros((*arms.shape, 6))
        by_body[..., :3] = -motion.turn.T
        by_body[..., 3:] = np.einsum("jac,kqa->kqcj", motion.first, arms)
        # Of −T · ∂X/∂x by θ, and the same of u with the other sign.
        bent = np.zeros_like(by_body)
        bent[..., 3:] = np.einsum("jac,kqc->kqaj", motion.first, tractions)
        moved = np.einsum("kqab,kqbj->kqaj", moduli, by_body)
        facets_by_body = -(motion.turn @ moved + bent) * weight[..., None, None]
        back = motion.turn @ np.einsum("kqcj,kqcb->kqbj", by_body, moduli)
        body_by_facets = -(back + bent) * weight[..., None, None]
        for slots, part in zip(self._slots, (facets_by_body, body_by_facets), strict=True):
            self._add_border(slots, np.einsum("qn,kqaj->knaj", values, part), on)
        both = -np.einsum("kqci,kqcj,kq->ij", by_body, moved, weight)
        turned = np.einsum("kqaj,kq->aj", bent[..., 3:], weight)
        both[:3, 3:] += turned
        both[3:, :3] += turned.T
        pull = np.einsum("kqa,kqc,kq->ac", arms, tractions, weight)
        both[3:, 3:] -= np.tensordot(motion.second, pull, 2)
        body.add_to_matrix(both)

    def _add_border(self, slots: slice, parts: np.ndarray, on: np.ndarray) -> None:
        """Add parts (m, n, 3, 6) to the entries between the facets' unknowns and the body's."""
        at = (6 * self._at[on][..., None] + np.arange(6)).ravel()
        found = np.bincount(at, parts.ravel(), 6 * len(self._dofs)).reshape(-1, 6)
        fixed = self._assembler.fixed
        found *= (fixed[self._dofs] == 0)[:, None] & (fixed[self._body.dofs] == 0)
        self._assembler.extra_values[slots] += found.ravel()
