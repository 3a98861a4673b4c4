"""The air between sheets: follower pressure and enclosed volume."""

from __future__ import annotations

import numpy as np

from softact.sheets.triangles import VOLUME_RULE, Triangles, shape_gradients


class SheetCavity:
    """Follower pressure on the sheets that wall a cavity: potential −p V(u).

    V = ⅓ ∫ x · (∂x/∂r × ∂x/∂s) dr ds with normals out of the cavity, integrated exactly; a wall in
    a symmetry plane through the origin adds nothing and may be left out.
    """

    def __init__(self, name: str, walls: list[Triangles]):
        self.name, self._walls = name, walls
        points, weights = VOLUME_RULE
        nodes = walls[0].nodes.shape[1]
        self._weights = weights / 6  # the reference triangle's area ½ and the third
        self._values = walls[0].values(points)
        gradients = shape_gradients(points, nodes)
        self._by_r, self._by_s = gradients[..., 0], gradients[..., 1]

    def _places(self, wall, x):
        current = wall.current(x)
        return [
            np.einsum("qn,knc->kqc", table, current)
            for table in (self._values, self._by_r, self._by_s)
        ]

    def volume(self, x) -> float:
        """The enclosed volume, mm³."""
        total = 0.0
        for wall in self._walls:
            place, r, s = self._places(wall, x)
            total += float(np.einsum("q,kqc,kqc->", self._weights, place, np.cross(r, s)))
        return total

    def add_volume_gradient(self, x, factor: float, out: np.ndarray) -> None:
        """Add ``factor`` times the derivative of the volume by the unknowns to ``out`` (local,)."""
        for wall in self._walls:
            place, r, s = self._places(wall, x)
            weight = factor * self._weights[:, None]
            forces = sum(
                np.einsum("qn,kqc->knc", weight * table, vector)
                for table, vector in (
                    (self._values, np.cross(r, s)),
                    (self._by_r, np.cross(s, place)),
                    (self._by_s, np.cross(place, r)),
                )
            )
            wall.add_force(forces, out)

    def add_force(self, state, out):
        if pressure := state.pressure.get(self.name, 0.0):
            self.add_volume_gradient(state.x, -pressure, out)

    def add_tangent(self, state, origin):
        pressure = state.pressure.get(self.name, 0.0)
        if not pressure:
            return
        n, r, s = self._values, self._by_r, self._by_s

        def antisymmetric(one, two):
            product = np.einsum("q,qa,qb->qab", -pressure * self._weights, one, two)
            return product - product.transpose(0, 2, 1)

        pairs = antisymmetric(s, r), antisymmetric(n, s), antisymmetric(r, n)
        for wall in self._walls:
            vectors = self._places(wall, state.x)
            axial = sum(
                np.einsum("qab,kqc->kabc", pair, vector, optimize=True)
                for pair, vector in zip(pairs, vectors, strict=True)
            )
            wall.table.add(np.moveaxis(np.tensordot(axial, _CROSS, 1), 3, 2))

    def energy(self, state):
        return -state.pressure.get(self.name, 0.0) * self.volume(state.x)


# v · _CROSS is the matrix of w -> v × w.
_CROSS = np.zeros((3, 3, 3))
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    _CROSS[_i, _k, _j], _CROSS[_i, _j, _k] = 1.0, -1.0
