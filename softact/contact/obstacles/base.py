"""What an obstacle is: how a spec writes it, and its shape as contact sees it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Protocol, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from softact.fields import Part, fault, fault_at
from softact.system.rotation import rotation_about
from softact.units import Dimensionless, Mass

TINY = 1e-300
MOST_FRICTION = 10.0
EVENLY = 1e-3  # how far moments of inertia that are the same may differ: files are rounded


@dataclass(frozen=True)
class Filled:
    """A shape as a body of one density, for one that moves freely.

    gyration: (3, 3) mm², moments of inertia about its centre, by its mass. points: (k, 3) mm of
    its surface, as it was placed, that touch other obstacles; radius: mm, of balls about them,
    which do so.
    """

    gyration: np.ndarray
    points: np.ndarray
    radius: float = 0.0


class Shape(Protocol):
    """Signed distance of points, its gradient and its second derivatives."""

    @property
    def center(self) -> tuple[float, float, float]:
        """Its middle, mm, about which it turns."""

    @property
    def filled(self) -> Filled | None:
        """As a body of one density; None of an endless one."""

    @property
    def room(self) -> float:
        """How deep a point may be inside before the nearest surface is that of another side, mm."""

    def gap(self, x: np.ndarray) -> np.ndarray:
        """Distance (n,) of points (n, 3) to the surface, mm, below zero inside."""

    def distance(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of points (n, 3) mm: their ``gap``; its gradient
        (n, 3), which points out of the shape; the matrix of its second derivatives (n, 3, 3),
        1/mm."""

    def surface(self, extent: float, about: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points (k, 3) and triangles (m, 3) to draw; endless shapes are ``extent`` mm long and
        have their middle near ``about``."""


def _coefficient(value: Any) -> Any:
    if isinstance(value, int | float) and not isinstance(value, bool) and value < 0:
        raise fault(f"{value:g} is below zero; write a Coulomb coefficient such as 0.3, or 0")
    return value


Friction = Annotated[Dimensionless, BeforeValidator(_coefficient), Field(le=MOST_FRICTION)]


class SpecObstacle(Part):
    """What all obstacles have in a spec.

    kind: the word after ``type``. Subclasses add the fields of their shape.
    """

    kind: ClassVar[str]

    friction: Friction = Field(0.0, description="Coulomb coefficient")
    active: bool = Field(True, description="false: a step puts it there later")
    load_cell: bool = Field(False, description="its force is the column blocked_force_N")
    surfaces: tuple[str, ...] | None = Field(
        None,
        strict=False,
        description="surfaces and sheets that may touch it; default: the whole outside",
    )
    mass: Mass | None = Field(
        None,
        gt=0,
        description="makes it a free body, which moves and turns by what touches it and by its "
        "weight: 50 g",
    )
    held: bool = Field(
        False, description="true: a free body is held in place until a step lets it go"
    )

    @model_validator(mode="after")
    def _free_or_not(self) -> Self:
        if self.mass is None:
            if self.held:
                raise fault_at(
                    ("held",), "all obstacles stay in place but free bodies: give it a mass too"
                )
        elif self.shape().filled is None:
            raise fault_at(
                ("mass",), f"a {self.kind} without end has no mass; leave it out, or bound it"
            )
        elif not self.active:
            raise fault_at(
                ("active",), "a free body is there from the start; held: true keeps it in place"
            )
        return self

    def shape(self) -> Shape:
        """Its shape."""
        raise NotImplementedError

    @property
    def turns_evenly(self) -> bool:
        """Whether its moments of inertia are the same about all axes."""
        filled = self.shape().filled
        if filled is None:
            return False
        found = filled.gyration
        return bool(np.allclose(found, found[0, 0] * np.eye(3), atol=EVENLY * found[0, 0]))


def unit(vector: Any) -> np.ndarray:
    """A direction (3,) of length 1."""
    vector = np.asarray(vector, float)
    return vector / np.linalg.norm(vector)


def grid_triangles(rows: int, columns: int) -> np.ndarray:
    """Triangles (m, 3) between points that lie in rows of so many columns."""
    first = (columns * np.arange(rows - 1)[:, None] + np.arange(columns - 1)).ravel()
    a, b, c, d = first, first + 1, first + columns + 1, first + columns
    return np.vstack([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def rotation_of(turns: tuple[float, float, float]) -> np.ndarray:
    """Rotation matrix of turns (degrees) about x, then y, then z."""
    about_x, about_y, about_z = map(rotation_about, np.eye(3), turns)
    return about_z @ about_y @ about_x
