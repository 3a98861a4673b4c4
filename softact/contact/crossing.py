"""Whether points of surfaces went through other surfaces that move, too."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.facets import PIECES
from softact.contact.rows import rows
from softact.system import jit

if TYPE_CHECKING:
    from mpi4py import MPI

# A point has gone through a facet where it ends so far behind it, of the element size; while
# surfaces touch, points are behind by less than the second.
BEHIND, OVERLAPPING = 0.05, 0.025
# Places on the way at which it is compared with the facet.
TIMES = np.linspace(0.0, 1.0, 9)


class Crossing:
    """The compiled search for points that changed sides; see ``_crossing.c``."""

    def __init__(self, comm: MPI.Comm):
        source = Path(__file__).with_name("_crossing.c")
        self._behind = jit.load_library(comm, source).behind
        self._behind.restype = ctypes.c_int64

    def __call__(
        self,
        before: np.ndarray,
        after: np.ndarray,
        values: np.ndarray,
        start: np.ndarray,
        candidate: np.ndarray,
        size: np.ndarray,
        touching: bool = True,
        is_open: np.ndarray | None = None,
    ) -> bool:
        """Whether a point of a facet went from the front of a candidate to its back, through it.

        before, after: nodes (k, n, 3) of the facets, which go straight from one to the other: a
        body that turns is then sheared and stretched, but as a whole. values: (q, n) shape
        functions of the points. start, candidate: see ``Looking``. size: (k,) mm.
        touching: whether they were known to each other, so that one may be as deep in the other as
        contact allows; else a point has passed as soon as it is behind. is_open: (k, 3) see
        ``open_edges``: what ends beyond such an edge has slid off; by default no edge is open. A
        quadratic facet counts as four flat triangles.
        """
        overlapping, deeper = (OVERLAPPING, BEHIND) if touching else (0.0, 0.0)
        pieces = np.array(PIECES if before.shape[1] == 6 else ((0, 1, 2),))
        points = [values @ nodes for nodes in (before, after)]
        corners = [nodes[:, pieces] for nodes in (before, after)]
        facet, other, piece, point = self._changed(
            points, corners, start, candidate, size, overlapping, deeper
        ).T
        first = [p[facet, point] for p in points]
        second = [c[other, piece] for c in corners]
        if is_open is None:
            is_open = np.zeros((len(size), 3), dtype=bool)
        through = _through(first, second, overlapping * size[other])
        return bool((through & ~_beyond(first[1], after[other], is_open[other])).any())

    def _changed(
        self,
        points: Sequence[np.ndarray],
        corners: Sequence[np.ndarray],
        start: np.ndarray,
        candidate: np.ndarray,
        size: np.ndarray,
        overlapping: float,
        deeper: float,
    ) -> np.ndarray:
        """(m, 4): facet, candidate, piece of that and point, of the points (k, q, 3) that begin
        before the plane of a piece (k, pieces, 3, 3) and end behind it, near it."""
        arrays: list[np.ndarray] = [
            np.ascontiguousarray(values, np.float64)
            for values in (
                *points,
                *(c[:, :, 0] for c in corners),
                *map(_normals, corners),
                corners[1].mean(axis=2),
                np.linalg.norm(corners[1] - corners[0], axis=3).max(axis=2),
                size,
            )
        ]
        arrays.insert(0, np.ascontiguousarray(candidate, np.int32))
        arrays.insert(0, np.ascontiguousarray(start, np.int64))
        pointers = [ctypes.c_void_p(a.ctypes.data) for a in arrays]
        counts = (
            ctypes.c_int64(len(size)),
            *map(ctypes.c_int32, (points[0].shape[1], corners[0].shape[1])),
        )
        limits = ctypes.c_double(overlapping), ctypes.c_double(deeper)
        return rows(partial(self._behind, *counts, *pointers, *limits), 4)


def _normals(corners: np.ndarray) -> np.ndarray:
    """Unit normals (k, pieces, 3) of triangles (k, pieces, 3, 3)."""
    sides = corners[:, :, 1:] - corners[:, :, :1]
    normal = np.cross(sides[:, :, 0], sides[:, :, 1])
    return normal / np.linalg.norm(normal, axis=2, keepdims=True)


def _beyond(points: np.ndarray, nodes: np.ndarray, is_open: np.ndarray) -> np.ndarray:
    """Whether points (m, 3) are beyond edges of facets (m, n, 3) that are open (m, 3)."""
    a, b, r = nodes[:, 1] - nodes[:, 0], nodes[:, 2] - nodes[:, 0], points - nodes[:, 0]
    normal = np.cross(a, b)
    s = np.einsum("mc,mc->m", np.cross(r, b), normal)
    t = np.einsum("mc,mc->m", np.cross(a, r), normal)
    whole = np.einsum("mc,mc->m", normal, normal)
    return ((np.stack([t, whole - s - t, s], axis=1) < 0) & is_open).any(axis=1)


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
