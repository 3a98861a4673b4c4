"""Friction of a rod's points on an obstacle: Coulomb's law, with the pressing forces of before.

Each point hangs on an anchor on the obstacle. Up to ``SLIP`` it sticks by a stiff spring, beyond it
the anchor follows. With the pressing forces held, what friction takes is a potential, so the rod's
equilibrium is still a least energy; they are then found anew, until they change no more.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
SLIP = 0.02  # mm: a point's way at which all of the friction acts


@dataclass(frozen=True)
class Grip:
    """friction: Coulomb's coefficient. anchors (m, 3): mm; normals (m, 3), pressing (m,): N, of the
    points as they were."""

    friction: float
    anchors: Array
    normals: Array
    pressing: Array

    @classmethod
    def none(cls, friction: float, places: Array) -> Grip:
        """Nothing is touched yet."""
        return cls(friction, places, np.zeros_like(places), np.zeros(len(places)))

    def _slid(self, places: Array) -> tuple[Array, Array]:
        """Ways along the obstacle (m, 3) from the anchors, and their lengths (m,)."""
        way = places - self.anchors
        way = way - np.einsum("ni,ni->n", way, self.normals)[:, None] * self.normals
        return way, np.linalg.norm(way, axis=1)

    def energy(self, places: Array) -> float:
        """What friction takes on the way from the anchors, mJ."""
        far = self._slid(places)[1]
        part = np.where(far < SLIP, far**2 / (2 * SLIP), far - SLIP / 2)
        return float((self.friction * self.pressing * part).sum())

    def derivatives(self, places: Array) -> tuple[Array, Array]:
        """Of the energy by the places: (m, 3), which is minus the friction in N, and (m, 3, 3)."""
        way, far = self._slid(places)
        most = self.friction * self.pressing
        reach = np.maximum(far, SLIP)
        flat = np.eye(3) - self.normals[:, :, None] * self.normals[:, None]
        along = way / np.maximum(far, np.finfo(float).tiny)[:, None]
        slides = (far > SLIP)[:, None, None]
        stiff = flat - slides * along[:, :, None] * along[:, None]
        return (most / reach)[:, None] * way, (most / reach)[:, None, None] * stiff

    def pressed(self, normals: Array, pressing: Array) -> Grip:
        """With other normals (m, 3) and pressing forces (m,)."""
        return replace(self, normals=normals, pressing=pressing)

    def followed(self, places: Array, touching: NDArray[np.bool_]) -> Grip:
        """With the anchors where they are after points came to places; what touches nothing has
        its anchor where it is."""
        way, far = self._slid(places)
        left = way * np.minimum(1.0, SLIP / np.maximum(far, np.finfo(float).tiny))[:, None]
        return replace(self, anchors=np.where(touching[:, None], places - left, places))
