"""Quadratic tetrahedra and triangles in VTK's order: shape functions, and the way back from a place
to its barycentric coordinates."""

from __future__ import annotations

import numpy as np

_NEWTON_STEPS = 6
_EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))


def invert(
    ten: np.ndarray, places: np.ndarray, bary: np.ndarray, least: float
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers (k,) of the places (n, 3) whose barycentrics in their quadratic elements (n, 10, 3)
    are all above ``least``, and these (k, 4); from a guess (n, 4), by Newton's method."""
    number = np.arange(len(ten))
    for _ in range(_NEWTON_STEPS):
        missing = places - np.einsum("nk,nki->ni", shapes(bary), ten)
        gradient = np.einsum("nkj,nki->nij", slopes(bary), ten)
        step = np.einsum("nij,nj->ni", inverse(gradient), missing)
        bary = barycentrics(bary[:, 1:] + np.clip(step, -0.5, 0.5))
        # Most are soon seen to be outside.
        near = bary.min(axis=1) > -2 * np.abs(step).max(axis=1, initial=0.0)
        number, ten, places, bary = number[near], ten[near], places[near], bary[near]
    missing = places - np.einsum("nk,nki->ni", shapes(bary), ten)
    size = np.ptp(ten, axis=1).max(axis=1)
    found = np.abs(missing).max(axis=1, initial=0.0) < 1e-6 * size
    found &= bary.min(axis=1) > least
    return number[found], bary[found]


def inverse(matrices: np.ndarray) -> np.ndarray:
    """(n, 3, 3) inverse matrices; zero for those without."""
    a, b, c = np.moveaxis(matrices, 2, 0)
    rows = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    determinant = np.einsum("ni,ni->n", a, rows[:, 0])
    sound = np.abs(determinant) > 1e-14 * np.abs(matrices).max(axis=(1, 2), initial=1e-300) ** 3
    rows[~sound], determinant[~sound] = 0.0, 1.0
    return rows / determinant[:, None, None]


def barycentrics(three: np.ndarray) -> np.ndarray:
    """(n, 4) barycentrics from the last three."""
    return np.column_stack([1 - three.sum(axis=1), three])


def ten_nodes(places: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """(m, 10, 3) places of the elements' nodes; elements with straight edges get theirs."""
    there = places[cells]
    if cells.shape[1] == 10:
        return there
    return np.concatenate([there, there[:, _EDGES].mean(axis=2)], axis=1)


def six_nodes(places: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(f, 6, 3) places of the faces' nodes."""
    there = places[faces]
    if faces.shape[1] == 6:
        return there
    return np.concatenate([there, there[:, ((0, 1), (1, 2), (2, 0))].mean(axis=2)], axis=1)


def shapes(bary: np.ndarray) -> np.ndarray:
    """(n, 10) quadratic shape functions of an element, in VTK's order."""
    a, b = np.transpose(_EDGES)
    return np.hstack([bary * (2 * bary - 1), 4 * bary[:, a] * bary[:, b]])


def slopes(bary: np.ndarray) -> np.ndarray:
    """(n, 10, 3) their derivatives with respect to the last three barycentrics."""
    derivative = np.zeros((len(bary), 10, 4))
    corner = np.arange(4)
    derivative[:, corner, corner] = 4 * bary - 1
    a, b = np.transpose(_EDGES)
    edge = np.arange(4, 10)
    derivative[:, edge, a], derivative[:, edge, b] = 4 * bary[:, b], 4 * bary[:, a]
    return derivative[:, :, 1:] - derivative[:, :, :1]


def face_shapes(bary: np.ndarray) -> np.ndarray:
    """(p, 6) quadratic shape functions of a face."""
    following = bary[:, [1, 2, 0]]
    return np.hstack([bary * (2 * bary - 1), 4 * bary * following])


def face_slopes(bary: np.ndarray) -> np.ndarray:
    """(p, 6, 2) their derivatives with respect to the last two barycentrics."""
    derivative = np.zeros((len(bary), 6, 3))
    for corner in range(3):
        following = (corner + 1) % 3
        derivative[:, corner, corner] = 4 * bary[:, corner] - 1
        derivative[:, 3 + corner, corner] = 4 * bary[:, following]
        derivative[:, 3 + corner, following] = 4 * bary[:, corner]
    return derivative[:, :, 1:] - derivative[:, :, :1]
