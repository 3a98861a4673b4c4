"""How thick the walls of cavities are, along a line from a facet straight through the solid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softact.mesh.boundary import face_keys
from softact.mesh.components import FACES
from softact.mesh.layout import Layout
from softact.mesh.msh_file import Tetrahedra
from softact.mesh.percentile import percentile

_MOST_FACETS, _MOST_CELLS = 4000, 500
#: Part of a step by which a line may miss a face at an edge and still pass it.
_SLACK = 1e-9


@dataclass(frozen=True)
class Thickness:
    """Of the walls of a cavity, mm: the thinnest place that is not a corner (1 % of the area is
    thinner), the median; elements through the thinnest, as the way there over the mean edge."""

    cavity: str
    thinnest: float
    median: float
    elements: float


def thicknesses(mesh: Tetrahedra, layout: Layout) -> list[Thickness]:
    """Of each cavity's walls; facets through which a line leaves at a symmetry plane do not
    count."""
    walk = _Walk(mesh, layout)
    found = []
    for name, walls in layout.cavities.items():
        facets = np.vstack([mesh.surfaces[wall] for wall in walls])
        facets = facets[:: -(-len(facets) // _MOST_FACETS)]
        area, way, edge = walk.through(facets)
        inside = np.isfinite(way)
        if inside.any():
            thin = percentile(way[inside], area[inside], 0.01)
            there = inside & (way <= thin * 1.05)
            elements = float(np.mean(way[there] / edge[there]))
            median = percentile(way[inside], area[inside], 0.5)
            found.append(Thickness(name, thin, median, elements))
    return found


class _Walk:
    """Straight lines through tetrahedra, from face to face."""

    def __init__(self, mesh: Tetrahedra, layout: Layout):
        self.points, self.cells = mesh.points, mesh.cells
        count = len(mesh.points)
        self._keys = face_keys(mesh.cells[:, FACES].reshape(-1, 3), count)
        order = np.argsort(self._keys, kind="stable")
        same = np.flatnonzero(np.diff(self._keys[order]) == 0)
        self.next = np.full(len(self._keys), -1)
        self.next[order[same]], self.next[order[same + 1]] = order[same + 1], order[same]
        self._order, self._count = order, count
        planes = [mesh.surfaces[name] for name in layout.symmetry]
        self.plane = np.zeros(len(self._keys), bool)
        if planes:
            self.plane = np.isin(self._keys, face_keys(np.vstack(planes), count))
        corners = mesh.points[mesh.cells]
        x = corners[:, FACES]  # (m, 4 faces, 3 corners, 3)
        self._normal = np.cross(x[:, :, 1] - x[:, :, 0], x[:, :, 2] - x[:, :, 0])
        inward = np.einsum("mfi,mfi->mf", self._normal, corners - x[:, :, 0]) > 0
        self._normal[inward] *= -1
        self._origin = x[:, :, 0]
        edges = [corners[:, i] - corners[:, j] for i in range(4) for j in range(i)]
        self._edge = np.mean([np.linalg.norm(edge, axis=1) for edge in edges], axis=0)

    def through(self, facets: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Area (k,), way (k,) to the other side in mm, nan where there is none, and the mean edge
        of the elements on it, of facets (k, 3)."""
        keys = face_keys(facets, self._count)
        face = self._order[np.searchsorted(self._keys[self._order], keys)]
        cell = face // 4
        normal = self._normal[cell, face % 4]
        area = np.linalg.norm(normal, axis=1) / 2
        direction = -normal / (2 * area)[:, None]
        start = self.points[facets].mean(axis=1)
        way, edges, passed = (
            np.full(len(facets), np.nan),
            np.zeros(len(facets)),
            np.zeros(len(facets)),
        )
        here = np.arange(len(facets))
        entered = face % 4
        for _ in range(_MOST_CELLS):
            edges[here] += self._edge[cell]
            passed[here] += 1
            t, out = self._leave(cell, entered, start[here], direction[here])
            behind = 4 * cell + out
            following = self.next[behind]
            ended = following < 0
            good = ended & ~self.plane[behind]
            way[here[good]] = t[good]
            here, cell, entered = here[~ended], following[~ended] // 4, following[~ended] % 4
            if not len(here):
                break
        return area, way, edges / passed

    def _leave(
        self, cell: np.ndarray, entered: np.ndarray, start: np.ndarray, direction: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """How far along its line each leaves its cell, and through which of its faces."""
        normal, origin = self._normal[cell], self._origin[cell]
        towards = np.einsum("kfi,ki->kf", normal, direction)
        gap = np.einsum("kfi,kfi->kf", normal, origin - start[:, None])
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.where(towards > _SLACK * np.abs(towards).max(axis=1, keepdims=True),
                         gap / towards, np.inf)  # fmt: skip
        t[np.arange(len(cell)), entered] = np.inf
        out = t.argmin(axis=1)
        return t[np.arange(len(cell)), out], out
