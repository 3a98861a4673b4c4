"""Where deformed sheets pass through each other or through themselves.

Sides of their flat pieces (four for each quadratic triangle) that pierce another piece: a tree of
places finds those that may (broad phase), a line through a triangle decides (Möller and Trumbore
1997, J. Graphics Tools 2:21). Neighbours share nodes and do not count, nor does a triangle whose
pieces lie folded on each other: it is slack, and nothing decides where its nodes are. A sheet has
no inside: how far a side sticks out of the piece that it pierces is told, a lower bound of the
depth.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from softact.mesh.boundary import flat
from softact.results.folder import Results

# Parts of a side's length below which it does not stick out: contact is allowed less than half of
# it (docs/contact.md), and flat pieces stand for curved sheets.
NOTHING = 0.05
_CHUNK = 20_000  # sides looked at together, which bounds the memory

#: depth (mm), undeformed places (3,) of the side and of the piece, place (3,) in the state, and the
#: two sheets' names.
Crossing = tuple[float, np.ndarray, np.ndarray, np.ndarray, tuple[str, str]]


def deepest_crossing(results: Results, moved: np.ndarray) -> Crossing | None:
    """The deepest crossing of the sheets in a state, None where there is none.

    moved: (n, 3) mm, displacements of all nodes.
    """
    sheets = results.layout.sheets
    before, after = results.points, results.points + moved
    pieces = [_unfolded(after, results.surfaces[name]) for name in sheets]
    owner = np.repeat(np.arange(len(sheets)), [len(part) for part in pieces])
    triangles = np.vstack(pieces)
    all_sides = np.sort(triangles[:, ((0, 1), (1, 2), (2, 0))].reshape(-1, 2), axis=1)
    sides, first = np.unique(all_sides, axis=0, return_index=True)
    found: Crossing | None = None
    for mirrors in _mirrors(results):
        signs = np.ones(3)
        signs[list(mirrors)] = -1.0
        # A node in a plane is its own image: there the two parts are neighbours.
        kept = (np.abs(before[:, list(mirrors)]) < 1e-9 * np.ptp(before)).all(axis=1)
        depth, side, piece, place = _pierced(after, signs, sides, triangles, kept)
        if not len(depth):
            continue
        at = int(np.argmax(depth))
        if found is None or depth[at] > found[0]:
            names = sheets[owner[first[side[at]] // 3]], sheets[owner[piece[at]]]
            ends, corners = before[sides[side[at]]], before[triangles[piece[at]]]
            found = (
                float(depth[at]), ends.mean(axis=0), corners.mean(axis=0), place[at] * signs, names
            )  # fmt: skip
    return found


def _unfolded(after: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(k, 3) the flat pieces of the triangles that are not folded on themselves."""
    pieces = flat(triangles)
    a, b, c = np.moveaxis(after[pieces], 1, 0)
    normals = np.cross(b - a, c - a).reshape(len(triangles), -1, 3)
    whole = normals.sum(axis=1, keepdims=True)
    kept = ((normals * whole).sum(axis=2) > 0).all(axis=1)
    return pieces.reshape(len(triangles), -1, 3)[kept].reshape(-1, 3)


def _mirrors(results: Results) -> list[tuple[int, ...]]:
    """The planes across which each part of the whole lies from the meshed one."""
    axes = sorted(set(results.layout.symmetry.values()))
    return [chosen for count in range(len(axes) + 1) for chosen in combinations(axes, count)]


def _pierced(
    after: np.ndarray,
    signs: np.ndarray,
    sides: np.ndarray,
    triangles: np.ndarray,
    kept: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Depths (k,), numbers of the sides and of the triangles, and the places (k, 3) where images of
    the sides pierce the triangles."""
    from scipy.spatial import cKDTree

    ends, corners = after[sides] * signs, after[triangles]
    middle = corners.mean(axis=1)
    tree = cKDTree(middle)
    widest = np.linalg.norm(corners - middle[:, None], axis=2).max(initial=0.0)
    half = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / 2
    parts = [(np.zeros(0), np.zeros(0, int), np.zeros(0, int), np.zeros((0, 3)))]
    for start in range(0, len(sides), _CHUNK):
        part = slice(start, start + _CHUNK)
        centres = ends[part].mean(axis=1)
        near = tree.query_ball_point(centres, half[part] + widest, return_sorted=False)
        side = np.repeat(start + np.arange(len(near)), [len(some) for some in near])
        if not len(side):
            continue
        piece = np.concatenate([some for some in near if some]).astype(int)
        same = sides[side][:, :, None] == triangles[piece][:, None, :]
        neighbours = (same & kept[sides[side]][:, :, None]).any(axis=(1, 2))
        side, piece = side[~neighbours], piece[~neighbours]
        depth, place = _through(ends[side], corners[piece])
        deep = depth > NOTHING * 2 * half[side]
        parts.append((depth[deep], side[deep], piece[deep], place[deep]))
    depth, side, piece, place = (np.concatenate(part) for part in zip(*parts, strict=True))
    return depth, side, piece, place


def _through(ends: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far lines (n, 2, 3) stick out of triangles (n, 3, 3) that they pierce, 0 where they do
    not, and where (n, 3)."""
    one, other = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(one, other)
    twice = np.linalg.norm(normal, axis=1)
    normal = normal / np.maximum(twice, 1e-300)[:, None]
    heights = np.einsum("nei,ni->ne", ends - corners[:, :1], normal)
    apart = heights[:, 0] - heights[:, 1]
    crosses = (heights[:, 0] * heights[:, 1] < 0) & (twice > 0)
    part = np.where(crosses, heights[:, 0] / np.where(crosses, apart, 1.0), 0.0)
    place = ends[:, 0] + part[:, None] * (ends[:, 1] - ends[:, 0])
    away = place - corners[:, 0]
    # Barycentrics of the place in the triangle.
    second = np.einsum("ni,ni->n", np.cross(away, other), normal) / np.maximum(twice, 1e-300)
    third = np.einsum("ni,ni->n", np.cross(one, away), normal) / np.maximum(twice, 1e-300)
    inside = crosses & (second > 0) & (third > 0) & (second + third < 1)
    return np.where(inside, np.abs(heights).min(axis=1), 0.0), place
