"""A ball."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.contact.obstacles.base import TINY, Filled, SpecObstacle, grid_triangles
from softact.fields import Point
from softact.units import Length


class SphereObstacle(SpecObstacle):
    """A ball."""

    kind: ClassVar[str] = "sphere"

    type: Literal["sphere"]
    center: Point = Field(description="its middle")
    radius: Length = Field(gt=0, description="its radius")

    def shape(self) -> Sphere:
        """See ``SpecObstacle``."""
        return Sphere(self.center, self.radius)


@dataclass(frozen=True)
class Sphere:
    """A ball."""

    center: tuple[float, float, float]
    radius: float

    @property
    def filled(self) -> Filled:
        """See ``Shape``: a ball about its middle."""
        return Filled(0.4 * self.radius**2 * np.eye(3), np.array([self.center]), self.radius)

    @property
    def room(self) -> float:
        """See ``Shape``."""
        return self.radius

    def gap(self, x: np.ndarray) -> np.ndarray:
        """See ``Shape``."""
        return np.linalg.norm(x - self.center, axis=1) - self.radius

    def distance(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See ``Shape``."""
        arm = x - self.center
        r = np.maximum(np.linalg.norm(arm, axis=1), TINY)
        n = arm / r[:, None]
        curvature = (np.eye(3) - n[:, :, None] * n[:, None]) / r[:, None, None]
        return r - self.radius, n, curvature

    def surface(self, extent: float, about: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Triangles between meridians and parallels."""
        polar, around = np.meshgrid(np.linspace(0, np.pi, 25), np.linspace(0, 2 * np.pi, 49))
        points = np.stack(
            [np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], -1
        )
        return self.center + self.radius * points.reshape(-1, 3), grid_triangles(49, 25)
