"""A half space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.contact.obstacles.base import SpecObstacle, unit
from softact.fields import Direction, Point


class PlaneObstacle(SpecObstacle):
    """A half space: all that lies behind a plane."""

    kind: ClassVar[str] = "plane"

    type: Literal["plane"]
    point: Point = Field(description="a point of the plane")
    normal: Direction = Field(description="direction of the free side: [0, 0, 1]")

    def shape(self) -> Plane:
        """See ``SpecObstacle``."""
        return Plane(self.point, self.normal)


@dataclass(frozen=True)
class Plane:
    """All that lies below a plane through ``point``; ``normal`` points to the free side."""

    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    @property
    def center(self) -> tuple[float, float, float]:
        """See ``Shape``."""
        return self.point

    @property
    def filled(self) -> None:
        """See ``Shape``: it is endless."""

    @property
    def room(self) -> float:
        """See ``Shape``."""
        return np.inf

    def gap(self, x: np.ndarray) -> np.ndarray:
        """See ``Shape``."""
        return (x - self.point) @ unit(self.normal)

    def distance(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See ``Shape``."""
        n = unit(self.normal)
        return (
            self.gap(x),
            np.broadcast_to(n, x.shape),
            np.broadcast_to(np.zeros((3, 3)), (len(x), 3, 3)),
        )

    def surface(self, extent: float, about: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """A square of side ``extent``."""
        n = unit(self.normal)
        middle = about - (about - np.asarray(self.point)) @ n * n
        a = unit(np.cross(n, np.eye(3)[np.argmin(np.abs(n))]))
        b = np.cross(n, a)
        corners = [middle + extent / 2 * (s * a + t * b) for s in (-1, 1) for t in (-1, 1)]
        return np.array(corners), np.array([[0, 2, 3], [0, 3, 1]])
