"""What holds an actuator, and the lines on which that and forces may act, as a spec writes it."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from softact.fields import Component, Direction, Part, Point, fault
from softact.mesh.layout import Line
from softact.units import Angle, Length, Stiffness

PositiveStiffness = Annotated[Stiffness, Field(gt=0)]


class TurnSpec(Part, title="Turn"):
    """A rotation of a surface as a rigid plate."""

    axis: Direction = Field(description="direction of the axis: [1, 0, 0]")
    angle: Angle = Field(description="counted from the undeformed state; whole turns count")
    about: Point | None = Field(
        None, description="a point of the axis; default: the middle of the surface"
    )


class SupportSpec(Part, title="Support"):
    """Components of the displacement of a surface, line or point that are held or prescribed."""

    surface: str = Field(description="surface of the geometry, line or point")
    fix: tuple[Component, ...] = Field(
        (), strict=False, description="components held where they are when the support begins"
    )
    move: dict[Component, Length] = Field(
        {}, description="components moved, counted from the undeformed state: {x: 2 mm}"
    )
    turn: TurnSpec | None = Field(None, description="a rotation, which prescribes all components")
    spring: dict[Component, PositiveStiffness] | None = Field(
        None,
        description="components held by springs from the undeformed state on: {x: 2 N/mm} of the "
        "whole surface, spread over its area; not in a step's supports, which leave springs as "
        "they are",
    )

    @model_validator(mode="after")
    def _holds_something(self) -> Self:
        if not self.fix and not self.move and not self.turn and not self.spring:
            raise fault("neither fixes nor moves anything; write for example fix: [x, y, z]")
        if self.turn and (self.fix or self.move or self.spring):
            raise fault("turn prescribes x, y and z; leave fix, move and spring out")
        for component in self.spring or {}:
            if component in self.fix or component in self.move:
                raise fault(f"'{component}' has a spring and is prescribed too; keep one")
        for component in self.fix:
            if component in self.move:
                raise fault(f"'{component}' is both fixed and moved; keep one")
            if self.fix.count(component) > 1:
                raise fault(f"'{component}' is fixed twice")
        return self

    @property
    def values(self) -> dict[int, float | None]:
        """Component (0, 1, 2) -> prescribed displacement in mm, None: held where it is."""
        fixed: dict[int, float | None] = {"xyz".index(component): None for component in self.fix}
        return fixed | {"xyz".index(component): value for component, value in self.move.items()}

    @property
    def held(self) -> tuple[int, ...]:
        """Components (0, 1, 2) that are prescribed or held by springs."""
        springs = ("xyz".index(component) for component in self.spring or {})
        return (0, 1, 2) if self.turn else (*self.values, *springs)


class LineSpec(Part, title="Line"):
    """A line on the actuator: straight between two points, or where two surfaces meet."""

    ends: tuple[Point, Point] | None = Field(
        None, strict=False, description="its ends; edges of the mesh have to lie on it"
    )
    between: tuple[str, str] | None = Field(
        None, strict=False, description="two surfaces, on the edge between which it is"
    )

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        if (self.ends is None) == (self.between is None):
            raise fault("write one of ends: [[...], [...]] and between: [surface, surface]")
        if self.ends is not None and self.ends[0] == self.ends[1]:
            raise fault("both ends are the same point; name it under points")
        return self

    @property
    def where(self) -> Line:
        """As a layout has it."""
        line = self.between if self.ends is None else self.ends
        assert line is not None  # one of them is given
        return line
