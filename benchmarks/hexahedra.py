"""Quadratic bricks (CalculiX's C3D20R) on the grid of a geometry of boxes.

softact cuts each cell of such a grid into five tetrahedra. As a brick with reduced integration the
cell does not lock near incompressibility, so CalculiX gives a second opinion on softact's P2/P1
that its C3D10 on the tetrahedra cannot give. Node and face numbers after the manual 'CalculiX
CrunchiX User's Manual version 2.20', 'Twenty-node brick element'.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from benchmarks.ccx import gauss
from softact.geometry.boxes import BoxMesh

# Corners 1 to 8 of a cell, then the ends of the edges that carry nodes 9 to 20.
CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)]
EDGES += [(0, 4), (1, 5), (2, 6), (3, 7)]
# Faces 1 to 6 with their normals out of the cell, and (axis, side) of each.
FACES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
FACE_OF = {(2, 0): 1, (2, 1): 2, (1, 0): 3, (0, 1): 4, (1, 1): 5, (0, 0): 6}


@dataclass(frozen=True)
class HexahedralMesh:
    """Bricks of 20 nodes with straight edges; numbers start at 0.

    points: (n, 3) mm. cells: (m, 20). surfaces: name -> (k, 2) cell and face number 1 to 6.
    """

    points: np.ndarray
    cells: np.ndarray
    surfaces: dict[str, np.ndarray]
    element: ClassVar[str] = "C3D20R"

    def faces(self, surface: str) -> np.ndarray:
        """Nodes (k, 8) of the faces: corners with the normal out of the cell, then middles."""
        cell, face = self.surfaces[surface].T
        return self.cells[cell[:, None], FACE_NODES[face - 1]]

    def nodes(self, surface: str) -> np.ndarray:
        """Numbers of all nodes on a surface, each once."""
        return np.unique(self.faces(surface))

    def loaded_faces(self, surface: str) -> np.ndarray:
        """Element (from 1) and CalculiX's number of each face of a surface, (k, 2)."""
        return self.surfaces[surface] + [1, 0]

    @staticmethod
    def face_quadrature():
        """Weight, shape functions (8,) and their derivatives at the points of a rule on a face."""
        s, weights = gauss(4)
        for r, wr in zip(2 * s - 1, 2 * weights, strict=True):
            for t, wt in zip(2 * s - 1, 2 * weights, strict=True):
                yield wr * wt, *_serendipity(r, t)


def _face_nodes() -> np.ndarray:
    middle = {frozenset(edge): 8 + i for i, edge in enumerate(EDGES)}
    return np.array(
        [[*f, *(middle[frozenset((f[i], f[(i + 1) % 4]))] for i in range(4))] for f in FACES]
    )


FACE_NODES = _face_nodes()


def _serendipity(r: float, s: float):
    """Shape functions of the eight-node quadrilateral and their derivatives by r and s."""
    values, by_r, by_s = [], [], []
    for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        values.append((1 + a * r) * (1 + b * s) * (a * r + b * s - 1) / 4)
        by_r.append(a * (1 + b * s) * (2 * a * r + b * s) / 4)
        by_s.append(b * (1 + a * r) * (2 * b * s + a * r) / 4)
    for a, b in ((0, -1), (1, 0), (0, 1), (-1, 0)):
        if a == 0:
            values.append((1 - r * r) * (1 + b * s) / 2)
            by_r.append(-r * (1 + b * s))
            by_s.append(b * (1 - r * r) / 2)
        else:
            values.append((1 + a * r) * (1 - s * s) / 2)
            by_r.append(a * (1 - s * s) / 2)
            by_s.append(-s * (1 + a * r))
    return np.array(values), np.array(by_r), np.array(by_s)


def bricks(grid: BoxMesh) -> HexahedralMesh:
    """The solid cells of a grid as bricks."""
    count = len(grid.solid.regions)
    inside = (grid.label > 0) & (grid.label <= count)
    number = np.full(inside.shape, -1)
    number[inside] = np.arange(inside.sum())
    corners = grid._number(np.argwhere(inside)[:, None] + CORNERS)
    used, corners = np.unique(corners, return_inverse=True)
    corners = corners.reshape(-1, 8)
    points = grid.points()[used]
    ends, middle = np.unique(
        np.sort(corners[:, EDGES], axis=2).reshape(-1, 2), axis=0, return_inverse=True
    )
    cells = np.hstack([corners, len(points) + middle.reshape(-1, len(EDGES))])
    return HexahedralMesh(
        np.vstack([points, points[ends].mean(axis=1)]), cells, _surfaces(grid, inside, number)
    )


def _surfaces(grid: BoxMesh, inside: np.ndarray, number: np.ndarray) -> dict[str, np.ndarray]:
    """Cell and face number of every surface; a face belongs to the solid cell beside it."""
    found: dict[str, list[np.ndarray]] = {}
    for axis in range(3):
        padded = np.pad(grid.label, [(int(a == axis), int(a == axis)) for a in range(3)])
        below, above = np.delete(padded, -1, axis=axis), np.delete(padded, 0, axis=axis)
        for names, faces in grid._faces(axis, below, above):
            if not len(faces):
                continue
            back = faces - np.eye(3, dtype=int)[axis]
            has_back = (back[:, axis] >= 0) & inside[tuple(np.maximum(back, 0).T)]
            cell = np.where(has_back[:, None], back, faces)
            face = np.where(has_back, FACE_OF[axis, 1], FACE_OF[axis, 0])
            for name in names:
                found.setdefault(name, []).append(np.column_stack([number[tuple(cell.T)], face]))
    return {name: np.vstack(parts) for name, parts in found.items()}
