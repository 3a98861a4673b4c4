"""A closed surface of triangles: what it encloses, and its signed distance."""

from __future__ import annotations

import ctypes
import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softact.errors import SpecError
from softact.system.kernels import pointer

SAME = 1e-6  # of its size: corners that are nearer are one
LEAF = 4  # triangles of a box of the tree at most


@dataclass(frozen=True, eq=False)
class ClosedSurface:
    """points: (n, 3) mm. triangles: (m, 3) of these, seen from outside against the clock."""

    points: np.ndarray
    triangles: np.ndarray

    @functools.cached_property
    def _edges(self) -> np.ndarray:
        """(m, 3, 2) corners of each triangle's edges, from each corner to the next."""
        return np.stack([self.triangles, np.roll(self.triangles, -1, axis=1)], axis=2)

    @functools.cached_property
    def areas(self) -> np.ndarray:
        """(m,) mm²."""
        return np.linalg.norm(self._cross, axis=1) / 2

    @functools.cached_property
    def _cross(self) -> np.ndarray:
        a, b, c = (self.points[self.triangles[:, i]] for i in range(3))
        return np.cross(b - a, c - a)

    @functools.cached_property
    def normals(self) -> np.ndarray:
        """(m, 3) of the triangles, outward."""
        return self._cross / (2 * self.areas)[:, None]

    @functools.cached_property
    def corner_normals(self) -> np.ndarray:
        """(n, 3) of the corners: those of the triangles, weighted by their angles there. With these
        and the ones of the edges the sign of a distance is right everywhere (Bærentzen and Aanæs,
        IEEE Trans. Vis. Comput. Graph. 11 (2005) 243)."""
        found = np.zeros_like(self.points)
        for corner, angles in enumerate(self._angles.T):
            np.add.at(found, self.triangles[:, corner], angles[:, None] * self.normals)
        return found / np.linalg.norm(found, axis=1)[:, None]

    @functools.cached_property
    def _angles(self) -> np.ndarray:
        """(m, 3) at the corners of each triangle."""
        corners = self.points[self.triangles]
        ahead, back = (np.roll(corners, -k, axis=1) - corners for k in (1, 2))
        cosine = np.sum(ahead * back, axis=2)
        return np.arctan2(np.linalg.norm(np.cross(ahead, back), axis=2), cosine)

    @functools.cached_property
    def edge_normals(self) -> np.ndarray:
        """(m, 3, 3) of the edges of each triangle: the sum of both triangles'."""
        count = len(self.points)
        one, other = (self._edges[..., list(k)].reshape(-1, 2) for k in ((0, 1), (1, 0)))
        keys, back = (e[:, 0].astype(np.int64) * count + e[:, 1] for e in (one, other))
        order = np.argsort(keys)
        partner = order[np.searchsorted(keys[order], back)] // 3
        sums = self.normals[:, None] + self.normals[partner].reshape(-1, 3, 3)
        return sums / np.maximum(np.linalg.norm(sums, axis=2), 1e-300)[..., None]

    # --- what it encloses -----------------------------------------------------------------------

    @functools.cached_property
    def volume(self) -> float:
        """mm³; below zero where the normals point inward."""
        return float(np.sum(self.points[self.triangles[:, 0]] * self._cross) / 6)

    @functools.cached_property
    def centre(self) -> np.ndarray:
        """(3,) of the volume, mm."""
        corners = self.points[self.triangles]
        volumes = np.sum(corners[:, 0] * self._cross, axis=1) / 6
        return volumes @ corners.sum(axis=1) / 4 / volumes.sum()

    @property
    def gyration(self) -> np.ndarray:
        """(3, 3) mm², moments of inertia of the volume about its centre, by its mass."""
        corners = self.points[self.triangles] - self.centre
        volumes = np.linalg.det(corners) / 6
        # ∫ x xᵀ over a tetrahedron with one corner at the origin.
        sums = corners.sum(axis=1)
        second = np.einsum("mka,mkb->mab", corners, corners) + sums[:, :, None] * sums[:, None]
        moments = np.einsum("m,mab->ab", volumes, second) / 20 / volumes.sum()
        return np.trace(moments) * np.eye(3) - moments

    def inside(self, depth: float) -> ClosedSurface:
        """The surface so far (mm) inside of it, whose triangles are parallel to these.

        Raises SpecError where there is none.
        """
        pull, offsets = np.zeros((len(self.points), 3, 3)), np.zeros_like(self.points)
        for corner, angles in enumerate(self._angles.T):
            weighted = angles[:, None] * self.normals
            np.add.at(pull, self.triangles[:, corner], weighted[:, :, None] * self.normals[:, None])
            np.add.at(offsets, self.triangles[:, corner], weighted)
        moves = np.einsum("nab,nb->na", np.linalg.pinv(pull, 1e-3, hermitian=True), offsets)
        inner = ClosedSurface(self.points - depth * moves, self.triangles)
        before, after = (np.diff(s.points[s._edges], axis=2) for s in (self, inner))
        turned = np.sum(inner.normals * self.normals, axis=1) < 0.5
        if turned.any() or (np.sum(before * after, axis=3) <= 0.0).any():
            raise SpecError(
                f"rounding: there are features that edges round to {depth:.3g} mm leave nothing "
                "of; write less"
            )
        return inner

    # --- distance -------------------------------------------------------------------------------

    @functools.cached_property
    def _tree(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Order of the triangles in a tree of boxes, its boxes and links; see ``_nearest.c``."""
        corners = self.points[self.triangles]
        low, high, middle = corners.min(axis=1), corners.max(axis=1), corners.mean(axis=1)
        order, boxes = np.arange(len(corners)), list[np.ndarray]()
        links: list[tuple[int, int]] = []
        waiting: list[tuple[int, int, int, int]] = [(0, len(corners), -1, 0)]
        while waiting:
            start, end, parent, side = waiting.pop()
            here, number = order[start:end], len(boxes)
            boxes.append(np.append(low[here].min(axis=0), high[here].max(axis=0)))
            links.append((-1 - start, end - start))
            if parent >= 0:
                pair = list(links[parent])
                pair[side] = number
                links[parent] = pair[0], pair[1]
            if end - start > LEAF:
                axis = int(np.argmax(np.ptp(middle[here], axis=0)))
                order[start:end] = here[np.argsort(middle[here, axis], kind="stable")]
                half = (start + end) // 2
                waiting += [(start, half, number, 0), (half, end, number, 1)]
        return order, np.array(boxes), np.array(links, np.int32)

    def nearest(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of points (k, 3): the nearest triangle (k,), where on it (k,) and the place (k, 3)."""
        from mpi4py import MPI

        from softact.system import jit

        library = jit.load_library(MPI.COMM_SELF, Path(__file__).with_name("_nearest.c"))
        order, boxes, links = self._tree
        corners = np.ascontiguousarray(self.points[self.triangles[order]])
        x = np.ascontiguousarray(x, float)
        which, where = np.zeros((2, len(x)), np.int32)
        places = np.zeros_like(x)
        library.nearest(
            ctypes.c_int64(len(x)),
            *map(pointer, (x, corners, boxes, links, which, where, places)),
        )
        return order[which], where, places

    def distance(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Signed distance (k,), its gradient (k, 3) and second derivatives (k, 3, 3) at points
        (k, 3) mm."""
        triangle, where, place = self.nearest(x)
        corner, edge = where - 1, where - 4  # numbers in the triangle, where it is one
        at_corner, at_edge = (where > 0) & (where < 4), where > 3
        normal = self.normals[triangle]
        normal = np.where(
            at_corner[:, None],
            self.corner_normals[self.triangles[triangle, np.clip(corner, 0, 2)]],
            normal,
        )
        normal = np.where(
            at_edge[:, None], self.edge_normals[triangle, np.clip(edge, 0, 2)], normal
        )
        arm = x - place
        far = np.linalg.norm(arm, axis=1)
        sign = np.where(np.sum(arm * normal, axis=1) < 0, -1.0, 1.0)
        there = far > 1e-12
        n = np.where(there[:, None], (sign / np.where(there, far, 1.0))[:, None] * arm, normal)
        ends = self.points[self._edges[triangle, np.clip(edge, 0, 2)]]
        along = ends[:, 1] - ends[:, 0]
        along /= np.linalg.norm(along, axis=1)[:, None]
        span = np.eye(3) - n[:, :, None] * n[:, None]
        span -= at_edge[:, None, None] * along[:, :, None] * along[:, None]
        round_it = (at_corner | at_edge) & there
        curvature = np.where(round_it, sign / np.where(there, far, 1.0), 0.0)
        return sign * far, n, curvature[:, None, None] * span

    @functools.cached_property
    def room(self) -> float:
        """How deep a point may be inside before the nearest surface is that of another side, mm:
        in the mean over the surface."""
        middles = self.points[self.triangles].mean(axis=1)
        size = float(np.ptp(self.points, axis=0).max())
        room = np.zeros(len(middles))
        for depth in np.geomspace(size / 500, size, 40):
            found = self.distance(middles - depth * self.normals)[0]
            room = np.where((room >= 0) & (found < -0.9 * depth), depth, -np.abs(room))
        order = np.argsort(np.abs(room))
        half = np.searchsorted(np.cumsum(self.areas[order]), self.areas.sum() / 2)
        return float(np.abs(room[order][half]))


def closed(corners: np.ndarray, name: str) -> ClosedSurface:
    """The surface of triangles with corners (m, 3, 3), mm, in any order. name: for messages.

    Raises SpecError where it is not closed.
    """
    size = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    if not size > 0.0:
        raise SpecError(f"{name}: its triangles have no area")
    rounded = np.round(corners.reshape(-1, 3) / (SAME * size)).astype(np.int64)
    _, first, number = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    triangles = number.reshape(-1, 3)
    apart = [triangles[:, i] != triangles[:, (i + 1) % 3] for i in range(3)]
    surface = ClosedSurface(corners.reshape(-1, 3)[first], triangles[np.logical_and.reduce(apart)])
    surface = ClosedSurface(surface.points, surface.triangles[surface.areas > 0.0])
    edges = surface._edges.reshape(-1, 2)
    once, count = np.unique(edges, axis=0, return_counts=True)
    back = np.unique(edges[:, ::-1], axis=0)
    pairs = len(np.unique(np.vstack([once, back]), axis=0))
    open_edges = pairs - len(once) + int((count > 1).sum())
    if open_edges:
        raise SpecError(
            f"{name}: its triangles do not close it: {open_edges} edges are not those of two "
            "triangles that face the same side; mend it where it was drawn"
        )
    if surface.volume < 0.0:
        surface = ClosedSurface(surface.points, surface.triangles[:, ::-1])
    return surface
