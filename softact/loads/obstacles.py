"""Obstacles that are moved, turned, put there or removed, and free bodies that are held or let go.
Their terms are the model's contacts and free bodies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from pydantic import Field, model_validator

from softact.fields import Direction, Fault, Name, Part, Place, Point, fault
from softact.loads.base import Load
from softact.mesh.layout import Layout
from softact.system.term import Value
from softact.units import Angle

if TYPE_CHECKING:
    from softact.contact.rigid import Obstacle
    from softact.model import Model


class ObstacleTurn(Part):
    """A rotation of an obstacle."""

    axis: Direction = Field(description="direction of the axis: [0, 1, 0]")
    angle: Angle = Field(description="counted from how it was placed; whole turns count")
    about: Point | None = Field(
        None,
        description="a point of the axis, where the obstacle was placed; default: its middle",
    )


class ObstacleChange(Part):
    """What a step does with an obstacle."""

    move: Point | None = Field(
        None, description="where to, counted from where it was placed: [0 mm, 0 mm, 3 mm]"
    )
    turn: ObstacleTurn | None = Field(
        None, description="how it is turned before it is moved: {axis: [0, 1, 0], angle: 20 deg}"
    )
    active: bool | None = Field(
        None, description="true puts it there, false removes it: its force fades over the step"
    )
    held: bool | None = Field(
        None,
        description="of a free body: true holds it where it is, false lets it go: what held it "
        "fades over the step",
    )

    @model_validator(mode="after")
    def _changes_something(self) -> Self:
        if all(value is None for value in (self.move, self.turn, self.active, self.held)):
            raise fault("changes nothing; give it move, turn, active or held")
        return self

    def turned(self, obstacle: Obstacle) -> np.ndarray:
        """Value of the field ``turn`` of an obstacle that this turns."""
        assert self.turn is not None
        axis = np.asarray(self.turn.axis, float)
        about = obstacle.shape.center if self.turn.about is None else self.turn.about
        return np.append(self.turn.angle * axis / np.linalg.norm(axis), about)


class Obstacles(Load):
    """shift: how far an obstacle was moved from where it was placed, (3,) mm. turn: how it was
    turned before, (6,): rotation vector (degrees) and a point of its axis (mm). presence: 1 where
    it is there, 0 where not; between, it was removed and the force of the last equilibrium fades.
    hold: of a free body, 1 where it is held in place, 0 where not; between, what held it fades."""

    key = "obstacles"
    annotation = dict[Name, ObstacleChange]
    description = (
        "obstacles moved, turned, put there or removed, free bodies held or let go: "
        "{name: {move: ...}}"
    )
    fields = ("shift", "turn", "presence", "hold")

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        for name, change in written.items() if isinstance(written, dict) else ():
            turn = change.get("turn") if isinstance(change, dict) else None
            yield from _turned_across(turn, (*place, name, "turn", "axis"), layout)

    def ends(
        self, value: Mapping[str, ObstacleChange], model: Model
    ) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        rigid = {c.obstacle.name: c.obstacle for c in model.contacts if c.obstacle is not None}
        return {
            "shift": {n: np.asarray(o.move) for n, o in value.items() if o.move is not None},
            "turn": {n: o.turned(rigid[n]) for n, o in value.items() if o.turn is not None},
            "presence": {n: float(o.active) for n, o in value.items() if o.active is not None},
            "hold": {n: float(o.held) for n, o in value.items() if o.held is not None},
        }

    def initial(self, model: Model) -> dict[str, dict[str, Value]]:
        """See ``Load.initial``."""
        rigid = [c.obstacle for c in model.contacts if c.obstacle is not None]
        return {
            "shift": {obstacle.name: np.zeros(3) for obstacle in rigid},
            "turn": {},
            "presence": {obstacle.name: float(obstacle.active) for obstacle in rigid},
            "hold": {o.name: float(o.held) for o in rigid if o.mass},
        }

    def start(self, field: str, before: Value | None, end: Value) -> Value:
        """See ``Load.start``: what is put there, or held, is so from the start; an axis of a turn
        is there from the start, too."""
        if field in ("presence", "hold") and end == 1.0:
            return end
        if field == "turn" and (before is None or not np.any(np.asarray(before)[:3])):
            return np.append(np.zeros(3), np.asarray(end)[3:])
        return super().start(field, before, end)


def _turned_across(turn: Any, place: Place, layout: Layout) -> Iterator[Fault]:
    """Yield what is wrong with the axis of a turn beside the symmetry planes."""
    axis = turn.get("axis") if isinstance(turn, dict) else None
    if not isinstance(axis, list | tuple) or len(axis) != 3:
        return
    for plane, normal in layout.symmetry.items():
        if any(axis[c] not in (0, 0.0) for c in range(3) if c != normal):
            yield (
                place,
                f"an obstacle that turns about an axis that is not normal to the symmetry plane "
                f"'{plane}' is not its own mirror image; model the whole actuator",
            )
            return
