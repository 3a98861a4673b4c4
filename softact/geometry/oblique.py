"""A rectangle of sheet under oblique lines that its triangles follow, and the pillow of two."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import Delaunay, cKDTree

from softact.errors import MeshError
from softact.geometry.steps import steps

SAME = 1e-7  # of the size: nearer points are one
NO_AREA = 1e-9  # of the size squared: corners on one straight side


@dataclass(frozen=True)
class Oblique:
    """Lines at ``angle`` (degrees, |angle| ≤ 90) to the width of [0, length] × [−width/2, width/2].

    The level c (mm) of a line is its distance from the corner that lines reach first, c = x cos α −
    y sin α + ½ width |sin α|, up to ``extent``. angle > 0: x grows with y along a line.
    """

    length: float
    width: float
    angle: float

    @property
    def _direction(self) -> tuple[float, float]:
        turn = np.radians(self.angle)
        return float(np.cos(turn)), float(np.sin(turn))

    @property
    def extent(self) -> float:
        """Largest level: the rectangle's size at right angles to the lines."""
        cos, sin = self._direction
        return self.length * cos + self.width * abs(sin)

    def levels(self, points: np.ndarray) -> np.ndarray:
        """Levels (n,) of points (n, 2 or more)."""
        cos, sin = self._direction
        return points[:, 0] * cos - points[:, 1] * sin + self.width / 2 * abs(sin)

    def area_below(self, level: np.ndarray) -> np.ndarray:
        """Area (mm²) of the part of the rectangle under each level."""
        cos, sin = self._direction
        level = np.clip(level, 0.0, self.extent)
        p, q = self.length * cos, self.width * abs(sin)
        if q < SAME * p or p < SAME * q:  # along one side of the rectangle
            return level * (self.width if q < p else self.length)
        squares = [np.maximum(level - start, 0.0) ** 2 for start in (0.0, p, q, p + q)]
        return (squares[0] - squares[1] - squares[2] + squares[3]) / (2 * abs(sin) * cos)

    def ends(self, level: float) -> np.ndarray:
        """The two ends (2, 2) of a line, in the direction in which y (at 0°) or ±x grows."""
        cos, sin = self._direction
        along, half = np.array([sin, cos]), np.array([self.length, self.width]) / 2
        middle = [self.length / 2, 0.0]
        foot = (level - self.extent / 2) * np.array([cos, -sin])  # from the middle
        crossed = np.abs(along) > SAME
        ways = np.array([-half - foot, half - foot])[:, crossed] / along[crossed]
        low, high = ways.min(axis=0).max(), ways.max(axis=0).min()
        ends = foot + np.array([[low], [high]]) * along
        return middle + np.clip(ends, -half, half)

    def triangles(
        self, levels: np.ndarray, size: float, stop: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Points (n, 2) and triangles (m, 3), normals up, of a mesh that all lines are edges of.

        levels: ascending, between 0 and ``extent``. The points on the rim are those of the
        rectangle that is turned round (y to −y) too, so that the two can be joined there. size:
        longest side on the lines and on the rim, mm. stop: distance from x = 0 at which both sides
        of the rim have a point.
        """
        ends = [self.ends(level) for level in levels]
        stops = np.array([[stop, self.width / 2]])
        rim = self._rim(np.vstack([*ends, stops]), size)
        lines = [_along(one, other, size, 2) for one, other in ends]
        points = _distinct(np.vstack([rim, *lines]), SAME * size)
        at = self.levels(points)
        found = []
        bounds = np.concatenate([[0.0], levels, [self.extent]])
        for below, above in pairwise(bounds):
            band = np.flatnonzero((at > below - SAME * size) & (at < above + SAME * size))
            if len(band) >= 3:
                found.append(band[_delaunay(points[band], size)])
        return self._apart(points, np.vstack(found))

    def _apart(self, points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points and triangles with a point on each side from rim to rim that the turned rectangle
        has too, as across a corner: the sheets of a pillow would be one there."""
        rim = np.flatnonzero(self.on_rim(points))
        turned = np.arange(len(points))
        turned[rim] = rim[cKDTree(points[rim]).query(points[rim] * [1, -1])[1]]
        sides, count = np.unique(np.sort(_sides(triangles), axis=1), axis=0, return_counts=True)
        across = sides[(count == 2) & np.isin(sides, rim).all(axis=1)]
        both = {tuple(side) for side in np.sort(turned[across], axis=1).tolist()}
        for one, other in [side for side in across.tolist() if tuple(side) in both]:
            middle = len(points)
            points = np.vstack([points, (points[one] + points[other]) / 2])
            has = (np.isin(triangles, (one, other)).sum(axis=1)) == 2
            cut = triangles[has]
            halves = [np.where(cut == end, middle, cut) for end in (one, other)]
            triangles = np.vstack([triangles[~has], *halves])
        return points, triangles

    def _rim(self, ends: np.ndarray, size: float) -> np.ndarray:
        half, length = self.width / 2, self.length
        corners = np.array([[0, -half], [length, -half], [length, half], [0, half]])
        stops = _distinct(np.vstack([corners, ends, ends * [1, -1]]), SAME * size)
        parts = []
        for axis, value in ((1, -half), (0, length), (1, half), (0, 0.0)):
            on = stops[np.abs(stops[:, axis] - value) < SAME * size]
            on = on[np.argsort(on[:, 1 - axis])]
            parts += [_along(a, b, size) for a, b in pairwise(on)]
        return _distinct(np.vstack(parts), SAME * size)

    def on_rim(self, points: np.ndarray) -> np.ndarray:
        """Which points (n, 2 or more) lie on the rim (n,)."""
        x, y = points[:, 0], points[:, 1]
        small = SAME * self.width
        return (np.minimum(x, self.length - x) < small) | (self.width / 2 - np.abs(y) < small)


def pillow(
    rectangle: Oblique, points: np.ndarray, triangles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and triangles (2 m, 3) of a sheet and the same turned by half a turn about x,
    which are joined along the rim; normals point out. Lines keep their sense seen from outside.

    Raises MeshError where the points on the rim are not those of the turned sheet.
    """
    rim = rectangle.on_rim(points)
    below = np.arange(len(points))
    below[~rim] = len(points) + np.arange(int((~rim).sum()))
    turned = points * [1, -1]
    gaps, nearest = cKDTree(points[rim]).query(turned[rim])
    if gaps.max() > 10 * SAME * rectangle.width:
        raise MeshError("the rims of the two sheets do not fit; give another mesh_size")
    below[rim] = np.flatnonzero(rim)[nearest]
    flat = np.vstack([points, turned[~rim]])
    both = np.vstack([triangles, below[triangles]])
    return np.column_stack([flat, np.zeros(len(flat))]), both


def _sides(triangles: np.ndarray) -> np.ndarray:
    return triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)


def _along(one: np.ndarray, other: np.ndarray, size: float, least: int = 1) -> np.ndarray:
    """Points from one to the other, at most ``size`` apart, in at least ``least`` parts."""
    parts = steps(float(np.linalg.norm(other - one)), size, least)
    return one + np.linspace(0, 1, parts + 1)[:, None] * (other - one)


def _distinct(points: np.ndarray, small: float) -> np.ndarray:
    """The points without those nearer than ``small`` to one before."""
    pairs = cKDTree(points).query_pairs(small, output_type="ndarray")
    keep = np.ones(len(points), dtype=bool)
    keep[pairs.max(axis=1)] = False
    return points[keep]


def _delaunay(points: np.ndarray, size: float) -> np.ndarray:
    """Triangles (m, 3), normals up, of a convex polygon of points."""
    triangles = Delaunay(points).simplices
    a, b, c = (points[triangles[:, i]] for i in range(3))
    double = np.cross(b - a, c - a)
    triangles = np.where(double[:, None] < 0, triangles[:, [0, 2, 1]], triangles)
    return triangles[np.abs(double) > NO_AREA * size**2]
