"""A round bar."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.contact.obstacles.base import TINY, Filled, SpecObstacle, grid_triangles, unit
from softact.fields import Direction, Point
from softact.units import Length

AROUND, ALONG = 96, 5  # points around and along it that touch other obstacles


class CylinderObstacle(SpecObstacle):
    """A round bar."""

    kind: ClassVar[str] = "cylinder"

    type: Literal["cylinder"]
    center: Point = Field(description="its middle")
    axis: Direction = Field(description="direction of its axis: [0, 1, 0]")
    radius: Length = Field(gt=0, description="its radius")
    length: Length | None = Field(None, gt=0, description="default: endless")

    def shape(self) -> Cylinder:
        """See ``SpecObstacle``."""
        return Cylinder(self.center, self.axis, self.radius, self.length)


@dataclass(frozen=True)
class Cylinder:
    """A round bar about ``axis`` through ``center``; ``length`` None: endless."""

    center: tuple[float, float, float]
    axis: tuple[float, float, float]
    radius: float
    length: float | None = None

    @property
    def filled(self) -> Filled | None:
        """See ``Shape``: points on its side, the rims among them, and in the middle of the ends."""
        if self.length is None:
            return None
        e, a, b = self._frame()
        gyration = self.radius**2 / 4 * (np.eye(3) + np.outer(e, e))
        gyration += self.length**2 / 12 * (np.eye(3) - np.outer(e, e))
        angles = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)[:, None, None]
        heights = np.linspace(-0.5, 0.5, ALONG)[None, :, None] * self.length
        side = self.radius * (np.cos(angles) * a + np.sin(angles) * b) + heights * e
        ends = np.array([[-0.5], [0.5]]) * self.length * e
        return Filled(gyration, np.asarray(self.center) + np.vstack([side.reshape(-1, 3), ends]))

    def _frame(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Directions (3,) along it and two across."""
        e = unit(self.axis)
        a = unit(np.cross(e, np.eye(3)[np.argmin(np.abs(e))]))
        return e, a, np.cross(e, a)

    @property
    def room(self) -> float:
        """See ``Shape``."""
        return self.radius if self.length is None else min(self.radius, self.length / 2)

    def gap(self, x: np.ndarray) -> np.ndarray:
        """See ``Shape``."""
        e = unit(self.axis)
        arm = x - self.center
        along = arm @ e
        across = np.linalg.norm(arm - along[:, None] * e, axis=1) - self.radius
        above = np.abs(along) - (np.inf if self.length is None else self.length / 2)
        highest = np.maximum(across, above)
        far = np.hypot(np.maximum(across, 0.0), np.maximum(above, 0.0))
        return np.where(highest > 0.0, far, highest)

    def distance(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See ``Shape``."""
        e = unit(self.axis)
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

    def surface(self, extent: float, about: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The side and both ends."""
        e, a, b = self._frame()
        half, middle = extent / 2, self.center + (np.asarray(about) - self.center) @ e * e
        if self.length is not None:
            half, middle = self.length / 2, np.asarray(self.center)
        profile = [(0.0, -half), (self.radius, -half), (self.radius, half), (0.0, half)]
        angles = np.linspace(0, 2 * np.pi, 49)
        points = [
            middle + r * (np.cos(t) * a + np.sin(t) * b) + z * e for t in angles for r, z in profile
        ]
        return np.array(points), grid_triangles(49, 4)
