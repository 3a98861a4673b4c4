"""Rigid shapes: signed distance of points, its gradient and its second derivatives.

Each shape has ``distance(x)``: points (n, 3) in mm -> (g (n,), normal (n, 3), curvature (n, 3, 3)):
the distance to the surface, below zero inside; its gradient, which points out of the shape; and
the matrix of its second derivatives, 1/mm. ``room``: how deep a point may be inside before the
nearest surface is that of another side, mm. ``surface(extent, about)``: (points, triangles) to
draw; endless ones are ``extent`` mm long and have their middle near ``about``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

TINY = 1e-300


def _unit(vector) -> np.ndarray:
    vector = np.asarray(vector, float)
    return vector / np.linalg.norm(vector)


@dataclass(frozen=True)
class Plane:
    """All that lies below a plane through ``point``; ``normal`` points to the free side."""

    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    @property
    def room(self) -> float:
        """See the module."""
        return np.inf

    def distance(self, x):
        """See the module."""
        n = _unit(self.normal)
        return (
            (x - self.point) @ n,
            np.broadcast_to(n, x.shape),
            np.broadcast_to(np.zeros((3, 3)), (len(x), 3, 3)),
        )

    def surface(self, extent, about):
        """A square of side ``extent``."""
        n = _unit(self.normal)
        middle = about - (about - np.asarray(self.point)) @ n * n
        a = _unit(np.cross(n, np.eye(3)[np.argmin(np.abs(n))]))
        b = np.cross(n, a)
        corners = [middle + extent / 2 * (s * a + t * b) for s in (-1, 1) for t in (-1, 1)]
        return np.array(corners), np.array([[0, 2, 3], [0, 3, 1]])


@dataclass(frozen=True)
class Sphere:
    """A ball."""

    center: tuple[float, float, float]
    radius: float

    @property
    def room(self) -> float:
        """See the module."""
        return self.radius

    def distance(self, x):
        """See the module."""
        arm = x - self.center
        r = np.maximum(np.linalg.norm(arm, axis=1), TINY)
        n = arm / r[:, None]
        curvature = (np.eye(3) - n[:, :, None] * n[:, None]) / r[:, None, None]
        return r - self.radius, n, curvature

    def surface(self, extent, about):
        """Triangles between meridians and parallels."""
        polar, around = np.meshgrid(np.linspace(0, np.pi, 25), np.linspace(0, 2 * np.pi, 49))
        points = np.stack(
            [np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], -1
        )
        return self.center + self.radius * points.reshape(-1, 3), _grid_triangles(49, 25)


@dataclass(frozen=True)
class Cylinder:
    """A round bar about ``axis`` through ``center``; ``length`` None: endless."""

    center: tuple[float, float, float]
    axis: tuple[float, float, float]
    radius: float
    length: float | None = None

    @property
    def room(self) -> float:
        """See the module."""
        return self.radius if self.length is None else min(self.radius, self.length / 2)

    def distance(self, x):
        """See the module."""
        e = _unit(self.axis)
        arm = x - self.center
        along = arm @ e
        radial = arm - along[:, None] * e
        r = np.maximum(np.linalg.norm(radial, axis=1), TINY)
        out = radial / r[:, None]
        end = np.where(along < 0, -1.0, 1.0)[:, None] * e
        half = np.inf if self.length is None else self.length / 2
        # In the half plane of radius and height the cylinder is a rectangle.
        across, above = r - self.radius, np.abs(along) - half
        rim = (across > 0) & (above > 0)
        corner = np.hypot(np.where(rim, across, 1.0), np.where(rim, above, 0.0))
        on_side = across > above
        g = np.where(rim, corner, np.where(on_side, across, above))
        c = np.where(rim, across / corner, on_side.astype(float))
        s = np.where(rim, np.where(rim, above, 0.0) / corner, (~on_side).astype(float))
        n = c[:, None] * out + s[:, None] * end
        around = np.cross(e, out)
        turned = -s[:, None] * out + c[:, None] * end
        curvature = (c / r)[:, None, None] * around[:, :, None] * around[:, None]
        bend = np.where(rim, 1 / corner, 0.0)[:, None, None]
        return g, n, curvature + bend * turned[:, :, None] * turned[:, None]

    def surface(self, extent, about):
        """The side and both ends."""
        e = _unit(self.axis)
        a = _unit(np.cross(e, np.eye(3)[np.argmin(np.abs(e))]))
        b = np.cross(e, a)
        half, middle = extent / 2, self.center + (np.asarray(about) - self.center) @ e * e
        if self.length is not None:
            half, middle = self.length / 2, np.asarray(self.center)
        profile = [(0.0, -half), (self.radius, -half), (self.radius, half), (0.0, half)]
        angles = np.linspace(0, 2 * np.pi, 49)
        points = [
            middle + r * (np.cos(t) * a + np.sin(t) * b) + z * e for t in angles for r, z in profile
        ]
        return np.array(points), _grid_triangles(49, 4)


@dataclass(frozen=True)
class Block:
    """A box of edge lengths ``size`` about ``center``; the rows of ``axes`` are its directions."""

    center: tuple[float, float, float]
    size: tuple[float, float, float]
    axes: tuple[tuple[float, float, float], ...] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))

    @property
    def room(self) -> float:
        """See the module."""
        return min(self.size) / 2

    def distance(self, x):
        """See the module."""
        axes = np.asarray(self.axes, float)
        local = (x - self.center) @ axes.T
        sign = np.where(local < 0, -1.0, 1.0)
        over = np.abs(local) - np.asarray(self.size) / 2
        beyond = np.maximum(over, 0.0)
        nearest = np.eye(3)[np.argmax(over, axis=1)]
        sides = (over > 0).sum(axis=1)
        far = np.linalg.norm(beyond, axis=1)
        outer = sides > 1  # an edge or a corner is nearest
        g = np.where(outer, far, over.max(axis=1))
        direction = np.where(outer[:, None], beyond / np.maximum(far, TINY)[:, None], nearest)
        n = (sign * direction) @ axes
        # The distance to an edge is curved across the edge, that to a corner in all directions.
        signed = sign * (over > 0)
        span = signed[:, :, None] * signed[:, None] * np.eye(3)
        span = np.abs(span) - (sign * direction)[:, :, None] * (sign * direction)[:, None]
        local_curvature = np.where(outer, 1 / np.maximum(far, TINY), 0.0)[:, None, None] * span
        return g, n, axes.T @ local_curvature @ axes

    def surface(self, extent, about):
        """Twelve triangles."""
        signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
        points = self.center + (signs * np.asarray(self.size) / 2) @ np.asarray(self.axes, float)
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        return points, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])


def _grid_triangles(rows: int, columns: int) -> np.ndarray:
    first = (columns * np.arange(rows - 1)[:, None] + np.arange(columns - 1)).ravel()
    a, b, c, d = first, first + 1, first + columns + 1, first + columns
    return np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
