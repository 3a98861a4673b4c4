"""The air between sheets: follower pressure and enclosed volume."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softact.mesh.triangles import VOLUME_RULE, Triangles, shape_gradients
from softact.system.term import Origin, State


class SheetCavity:
    """Follower pressure on the sheets that wall a cavity: potential −p V(u).

    V = ∫ (W x) · (∂x/∂r × ∂x/∂s) dr ds with normals out of the cavity, integrated exactly; W is
    diagonal with trace 1. A wall in a symmetry plane through the origin adds nothing and may be
    left out; with W = diag(0, 0, 1), any wall along z, such as the ends of a long strip.
    """

    def __init__(
        self, name: str, walls: list[Triangles], flux: Sequence[float] = (1 / 3, 1 / 3, 1 / 3)
    ):
        self.name, self._walls = name, walls
        self._flux = np.asarray(flux, dtype=float)
        points, weights = VOLUME_RULE
        self._weights = weights / 2  # area of the reference triangle
        self._values = walls[0].values(points)
        gradients = shape_gradients(points, walls[0].nodes.shape[1])
        self._values_r, self._values_s = gradients[..., 0], gradients[..., 1]
        # Values and both derivatives at all points in one matrix product: (3 q, n).
        self._tables = np.concatenate([self._values, self._values_r, self._values_s])

    def _pressure(self, state: State) -> float:
        return float(state["pressure"].get(self.name, 0.0))

    def _places(self, wall: Triangles, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """W x and the tangents ∂x/∂r and ∂x/∂s at the quadrature points, each (k, q, 3)."""
        place, r, s = np.split(self._tables @ wall.current(x), 3, axis=1)
        return place * self._flux, r, s

    def volume(self, x: np.ndarray) -> float:
        """The enclosed volume, mm³."""
        total = 0.0
        for wall in self._walls:
            place, r, s = self._places(wall, x)
            total += float(np.einsum("q,kqc,kqc->", self._weights, place, np.cross(r, s)))
        return total

    def add_volume_gradient(self, x: np.ndarray, factor: float, out: np.ndarray) -> None:
        """Add ``factor`` times the derivative of the volume with respect to the unknowns to ``out``
        (local,)."""
        for wall in self._walls:
            place, r, s = self._places(wall, x)
            vectors = [self._flux * np.cross(r, s), np.cross(s, place), np.cross(place, r)]
            weighted = factor * np.tile(self._weights, 3)[:, None] * self._tables
            wall.add_force(weighted.T @ np.concatenate(vectors, axis=1), out)

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        if pressure := self._pressure(state):
            self.add_volume_gradient(state.x, -pressure, out)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        pressure = self._pressure(state)
        if not pressure:
            return
        weight = -pressure * self._weights
        n, r = (table * weight[:, None] for table in (self._values, self._values_r))

        def cross(one: np.ndarray, two: np.ndarray, vectors: np.ndarray) -> np.ndarray:
            """Σ one_a two_b [v]× over the quadrature points: (k, a, b, 3, 3)."""
            n = one.shape[1]
            pairs = (one[:, :, None] * two[:, None, :]).reshape(-1, n * n)
            axial = (pairs.T @ vectors).reshape(-1, n, n, 3)
            return np.tensordot(axial, _CROSS, 1)

        for wall in self._walls:
            place, along_r, along_s = self._places(wall, state.x)
            half = (
                self._flux[:, None] * cross(n, self._values_s, along_r)
                - self._flux[:, None] * cross(n, self._values_r, along_s)
                - cross(r, self._values_s, place)
            )
            matrices = half + half.transpose(0, 2, 1, 4, 3)
            wall.table.add(np.moveaxis(matrices, 3, 2))

    def energy(self, state: State) -> float:
        """See ``Term``."""
        return -self._pressure(state) * self.volume(state.x)


# v · _CROSS is the matrix of w -> v × w.
_CROSS = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _CROSS[_i, _k, _j], _CROSS[_i, _j, _k] = 1.0, -1.0
