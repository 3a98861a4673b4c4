"""Whether points of surfaces went through other surfaces that move, too."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softact.contact.facets import PIECES

# A point has gone through a facet where it ends so far behind it, of the element size; while
# surfaces touch, points are behind by less than the second.
BEHIND, OVERLAPPING = 0.05, 0.025
# Places on the way at which it is compared with the facet.
TIMES = np.linspace(0.0, 1.0, 9)


def crossed(
    before: np.ndarray,
    after: np.ndarray,
    values: np.ndarray,
    start: np.ndarray,
    candidate: np.ndarray,
    size: np.ndarray,
) -> bool:
    """Whether a point of a facet went from the front of a candidate to its back, through it.

    before, after: nodes (k, n, 3) of the facets, which go straight from one to the other: a body
    that turns is then sheared and stretched, but as a whole. values: (q, n) shape functions of the
    points. start, candidate: see ``closest.candidates``. size: (k,) mm. A quadratic facet counts as
    four flat triangles.
    """
    i = np.repeat(np.arange(len(before)), np.diff(start))
    pieces = PIECES if before.shape[1] == 6 else ((0, 1, 2),)
    points = [np.einsum("qn,knc->kqc", values, nodes) for nodes in (before, after)]
    for piece in pieces:
        corners = [nodes[:, piece] for nodes in (before, after)]
        pair, point = _from_front_to_back(points, corners, i, candidate, size)
        first = [p[i[pair], point] for p in points]
        second = [c[candidate[pair]] for c in corners]
        if _through(first, second, OVERLAPPING * size[candidate[pair]]).any():
            return True
    return False


def _from_front_to_back(
    points: Sequence[np.ndarray],
    corners: Sequence[np.ndarray],
    i: np.ndarray,
    j: np.ndarray,
    size: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers (m,) of pairs (i, j) and of points that begin before the plane of the triangle and
    end behind it, near it."""
    heights = []
    for p, c in zip(points, corners, strict=True):
        normal = np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        heights.append(np.einsum("mqc,mc->mq", p[i] - c[j][:, :1], normal[j]))
    h = size[j][:, None]
    change = (heights[0] >= -OVERLAPPING * h) & (heights[1] < -BEHIND * h)
    pair, point = np.nonzero(change)
    away = points[1][i[pair], point] - corners[1][j[pair]].mean(axis=1)
    way = np.linalg.norm(points[1][i[pair], point] - points[0][i[pair], point], axis=1)
    moved = np.linalg.norm(corners[1][j[pair]] - corners[0][j[pair]], axis=2).max(axis=1)
    near = np.linalg.norm(away, axis=1) < 2 * size[j[pair]] + way + moved
    return pair[near], point[near]


def _through(
    points: Sequence[np.ndarray], corners: Sequence[np.ndarray], depth: np.ndarray
) -> np.ndarray:
    """Whether (m,) points cross the inside of triangles, ``depth`` (m,) behind them, both on
    straight ways: (m, 3), (m, 3, 3) at the beginning and at the end."""
    heights, inside = [], []
    for t in TIMES:
        p, c = ((1 - t) * one + t * other for one, other in (points, corners))
        a, b, r = c[:, 1] - c[:, 0], c[:, 2] - c[:, 0], p - c[:, 0]
        normal = np.cross(a, b)
        square = np.einsum("mc,mc->m", normal, normal)
        heights.append(np.einsum("mc,mc->m", r, normal) / np.sqrt(square) + depth)
        u = np.einsum("mc,mc->m", np.cross(r, b), normal) / square
        v = np.einsum("mc,mc->m", np.cross(a, r), normal) / square
        inside.append(np.minimum(np.minimum(u, v), 1 - u - v))
    found = np.zeros(len(points[0]), dtype=bool)
    for k in range(len(TIMES) - 1):
        h, g = heights[k], heights[k + 1]
        change = (h >= 0) & (g < 0)
        share = np.where(change, h / np.where(change, h - g, 1.0), 0.0)
        found |= change & ((1 - share) * inside[k] + share * inside[k + 1] > 0)
    return found
