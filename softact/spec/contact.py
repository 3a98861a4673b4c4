"""Rigid obstacles and contact between surfaces, as a spec writes them."""

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, Tag
from pydantic import Discriminator as ByKey

from softact.spec.choice import fault
from softact.spec.fields import Name, three
from softact.units import Angle, Dimensionless, Length


def _direction(value: tuple[float, float, float]) -> tuple[float, float, float]:
    if math.hypot(*value) < 1e-9:
        raise fault("all three are zero; write a direction such as [0, 0, 1]")
    return value


Point = Annotated[tuple[Length, Length, Length], BeforeValidator(three)]
Direction = Annotated[
    tuple[Dimensionless, Dimensionless, Dimensionless],
    BeforeValidator(three),
    AfterValidator(_direction),
]
Turns = Annotated[tuple[Angle, Angle, Angle], BeforeValidator(three)]
MOST_FRICTION = 10.0


def _coefficient(value: Any) -> Any:
    if isinstance(value, int | float) and not isinstance(value, bool) and value < 0:
        raise fault(f"{value:g} is below zero; write a Coulomb coefficient such as 0.3, or 0")
    return value


Friction = Annotated[Dimensionless, BeforeValidator(_coefficient), Field(le=MOST_FRICTION)]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)


class _Obstacle(_Part):
    """What all obstacles have."""

    friction: Friction = Field(0.0, description="Coulomb coefficient")
    active: bool = Field(True, description="false: a step puts it there later")
    load_cell: bool = Field(False, description="its force is the column blocked_force_N")
    surfaces: tuple[str, ...] | None = Field(
        None, strict=False, description="surfaces that may touch it; default: the whole outside"
    )

    def shape(self):
        """The shape of ``softact.contact.shapes``."""
        raise NotImplementedError


class PlaneObstacle(_Obstacle):
    """A half space: all that lies behind a plane."""

    type: Literal["plane"]
    point: Point = Field(description="a point of the plane")
    normal: Direction = Field(description="direction of the free side: [0, 0, 1]")

    def shape(self):
        """See ``_Obstacle.shape``."""
        from softact.contact.shapes import Plane

        return Plane(self.point, self.normal)


class BlockObstacle(_Obstacle):
    """A box."""

    type: Literal["block"]
    center: Point = Field(description="its middle")
    size: Point = Field(description="edge lengths along its own axes")
    rotation: Turns = Field(
        (0.0, 0.0, 0.0), description="turned about x, then about y, then about z"
    )

    def shape(self):
        """See ``_Obstacle.shape``."""
        from softact.contact.shapes import Block

        return Block(self.center, self.size, tuple(map(tuple, _rotation(self.rotation).T)))


class CylinderObstacle(_Obstacle):
    """A round bar."""

    type: Literal["cylinder"]
    center: Point = Field(description="its middle")
    axis: Direction = Field(description="direction of its axis: [0, 1, 0]")
    radius: Length = Field(gt=0)
    length: Length | None = Field(None, gt=0, description="default: endless")

    def shape(self):
        """See ``_Obstacle.shape``."""
        from softact.contact.shapes import Cylinder

        return Cylinder(self.center, self.axis, self.radius, self.length)


class SphereObstacle(_Obstacle):
    """A ball."""

    type: Literal["sphere"]
    center: Point = Field(description="its middle")
    radius: Length = Field(gt=0)

    def shape(self):
        """See ``_Obstacle.shape``."""
        from softact.contact.shapes import Sphere

        return Sphere(self.center, self.radius)


OBSTACLES = {
    "plane": PlaneObstacle,
    "block": BlockObstacle,
    "cylinder": CylinderObstacle,
    "sphere": SphereObstacle,
}


def _known_type(value: Any) -> Any:
    from softact.spec.choice import fault_at, nearest

    if isinstance(value, dict):
        kind = value.get("type")
        if kind is None:
            raise fault_at(("type",), f"missing; write one of: {', '.join(OBSTACLES)}")
        if kind not in OBSTACLES:
            raise fault_at(("type",), f"there is no obstacle {kind!r}; {nearest(kind, OBSTACLES)}")
    return value


def _kind(value: Any) -> str:
    kind = value.get("type") if isinstance(value, dict) else getattr(value, "type", None)
    return kind if kind in OBSTACLES else "plane"
