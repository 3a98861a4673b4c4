"""A box."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import BeforeValidator, Field

from softact.contact.obstacles.base import TINY, Filled, SpecObstacle, rotation_of
from softact.fields import Point, three
from softact.units import Angle, Length

Edge = Annotated[Length, Field(gt=0)]
Edges = Annotated[tuple[Edge, Edge, Edge], BeforeValidator(three)]
ACROSS = 7  # points across a face that touch other obstacles
Turns = Annotated[tuple[Angle, Angle, Angle], BeforeValidator(three)]


class BlockObstacle(SpecObstacle):
    """A box."""

    kind: ClassVar[str] = "block"

    type: Literal["block"]
    center: Point = Field(description="its middle")
    size: Edges = Field(description="edge lengths along its own axes")
    rotation: Turns = Field(
        (0.0, 0.0, 0.0), description="turned about x, then about y, then about z"
    )

    def shape(self) -> Block:
        """See ``SpecObstacle``."""
        axes = [(float(x), float(y), float(z)) for x, y, z in rotation_of(self.rotation).T]
        return Block(self.center, self.size, tuple(axes))


@dataclass(frozen=True)
class Block:
    """A box of edge lengths ``size`` about ``center``; the rows of ``axes`` are its directions."""

    center: tuple[float, float, float]
    size: tuple[float, float, float]
    axes: tuple[tuple[float, float, float], ...] = ((1, 0, 0), (0, 1, 0), (0, 0, 1))

    @property
    def filled(self) -> Filled:
        """See ``Shape``: points of a grid on its faces, corners and edges among them."""
        axes, squares = np.asarray(self.axes, float), np.square(self.size)
        gyration = axes.T @ np.diag(squares.sum() - squares) @ axes / 12
        places = np.linspace(-0.5, 0.5, ACROSS)
        grid = np.stack(np.meshgrid(places, places, places, indexing="ij"), -1).reshape(-1, 3)
        on_faces = grid[np.abs(grid).max(axis=1) == 0.5]
        return Filled(gyration, self.center + (on_faces * self.size) @ axes)

    @property
    def room(self) -> float:
        """See ``Shape``."""
        return min(self.size) / 2

    def _beyond(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places (3, n) along the axes, and how far beyond the sides (3, n), mm."""
        local = np.asarray(self.axes, float) @ (x - self.center).T
        return local, np.abs(local) - np.asarray(self.size)[:, None] / 2

    def gap(self, x: np.ndarray) -> np.ndarray:
        """See ``Shape``."""
        over = self._beyond(x)[1]
        highest, far = over.max(axis=0), np.maximum(over, 0.0)
        return np.where(highest > 0.0, np.sqrt((far * far).sum(axis=0)), highest)

    def distance(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See ``Shape``."""
        axes = np.asarray(self.axes, float)
        local, over = (part.T for part in self._beyond(x))
        sign = np.where(local < 0, -1.0, 1.0)
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

    def surface(self, extent: float, about: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Twelve triangles."""
        signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
        points = self.center + (signs * np.asarray(self.size) / 2) @ np.asarray(self.axes, float)
        quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        return points, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
