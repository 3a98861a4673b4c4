"""Linear and quadratic triangles: shape functions, quadrature, frames in the flat sheet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

# Barycentric points and weights (sum 1): exact to degree 2 (as on the facet layers) and 4
# (Dunavant, IJNME 21 (1985) 1129), which integrates an enclosed volume exactly.
MEMBRANE_RULE = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6, np.full(3, 1 / 3)
_A, _B = 0.445948490915965, 0.091576213509771
VOLUME_RULE = (
    np.array([np.roll([1 - 2 * t, t, t], k) for t in (_A, _B) for k in range(3)]),
    np.repeat([0.223381589678011, 0.109951743655322], 3),
)
MIDDLE = np.full((1, 3), 1 / 3)


def shape_functions(barycentric: np.ndarray, nodes: int) -> np.ndarray:
    """Values (..., nodes) at barycentric coordinates (..., 3); corners, then middles 01 12 20."""
    if nodes == 3:
        return barycentric
    a, b, c = np.moveaxis(barycentric, -1, 0)
    return np.stack(
        [a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a],
        axis=-1,
    )


def shape_gradients(barycentric: np.ndarray, nodes: int) -> np.ndarray:
    """Derivatives (q, nodes, 2) by the coordinates that run from corner 0 to 1 and to 2."""
    by_corner = np.zeros((len(barycentric), nodes, 3))
    if nodes == 3:
        by_corner[:] = np.eye(3)
    else:
        for i in range(3):
            by_corner[:, i, i] = 4 * barycentric[:, i] - 1
            j = (i + 1) % 3
            by_corner[:, 3 + i, i] = 4 * barycentric[:, j]
            by_corner[:, 3 + i, j] = 4 * barycentric[:, i]
    return by_corner[:, :, 1:] - by_corner[:, :, :1]


def tangents(places: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Derivatives (k, q, 3, 2) of the places of triangles (k, n, 3) with respect to the coordinates
    that run from corner 0 to 1 and to 2, at barycentric points (q, 3)."""
    gradients = shape_gradients(points, places.shape[1])
    return np.einsum("qna,knc->kqca", gradients, places, optimize=True)


def areas_at(places: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Half of the area element (k, q) of triangles (k, n, 3) at barycentric points (q, 3): their
    area, where they are flat."""
    one, other = np.moveaxis(tangents(places, points), -1, 0)
    return np.linalg.norm(np.cross(one, other), axis=-1) / 2


@dataclass(frozen=True)
class Triangles:
    """Elements of one sheet in the global system.

    nodes: (k, n) displacement nodes of the model. places: (k, n, 3) undeformed, mm. dofs: (k, n, 3)
    local unknowns. table: the assembler's places of their matrices.
    """

    nodes: np.ndarray
    places: np.ndarray
    dofs: np.ndarray
    table: Any

    @property
    def areas(self) -> np.ndarray:
        """Undeformed areas (k,), mm²."""
        points, weights = VOLUME_RULE
        return areas_at(self.places, points) @ weights

    @property
    def normals(self) -> np.ndarray:
        """Undeformed unit normals (k, 3) in the middles."""
        return self._normals(MIDDLE)[:, 0]

    def _normals(self, points: np.ndarray) -> np.ndarray:
        normal = np.cross(*np.moveaxis(tangents(self.places, points), -1, 0))
        return normal / np.linalg.norm(normal, axis=-1)[..., None]

    def frames(self, along: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Orthonormal frames (k, q, 2, 3) at barycentric points (q, 3): ``along`` (3,) put into the
        tangent plane, and normal × that. Where it is normal to the sheet, the direction of the
        first side takes its place."""
        normal = self._normals(points)
        first = along - (normal @ along)[..., None] * normal
        lost = np.linalg.norm(first, axis=-1) < 1e-6 * np.linalg.norm(along)
        first = np.where(lost[..., None], tangents(self.places, points)[..., 0], first)
        first = first / np.linalg.norm(first, axis=-1)[..., None]
        return np.stack([first, np.cross(normal, first)], axis=-2)

    def gradients(self, frames: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Derivatives (k, q, n, 2) of the shape functions along the frames (k, q, 2, 3)."""
        # (k, q, 2, 2): derivatives of frame coordinates with respect to reference coordinates
        jacobian = frames @ tangents(self.places, points)
        reference = shape_gradients(points, self.nodes.shape[1])
        return np.einsum("qna,kqai->kqni", reference, np.linalg.inv(jacobian))

    def current(self, x: np.ndarray) -> np.ndarray:
        """Deformed places (k, n, 3)."""
        return self.places + x[self.dofs]

    def add_force(self, forces: np.ndarray, out: np.ndarray) -> None:
        """Add nodal forces (k, n, 3)."""
        out += np.bincount(self.dofs.ravel(), forces.ravel(), len(out))

    def values(self, points: np.ndarray) -> np.ndarray:
        """Shape functions (q, n)."""
        return shape_functions(points, self.nodes.shape[1])

    def mass(self) -> np.ndarray:
        """∫ N N dA (k, n, n), mm²."""
        points, weights = VOLUME_RULE
        value, areas = self.values(points), areas_at(self.places, points)
        return np.einsum("kq,q,qn,qm->knm", areas, weights, value, value)


def average(
    nodes: np.ndarray, weights: np.ndarray, values: np.ndarray, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Sums (count, ...) of weighted element values (k, n, ...) at the nodes, and of the weights."""
    from scipy.sparse import csr_matrix  # takes its time, and a table has no mesh

    k, n = nodes.shape
    add = csr_matrix(
        (np.repeat(weights, n), (nodes.ravel(), np.arange(k * n))), shape=(count, k * n)
    )
    flat = values.reshape(k * n, -1)
    return add @ flat, np.asarray(add.sum(axis=1)).ravel()
