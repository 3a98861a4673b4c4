"""Obstacles that are moved, put there or removed. Their terms are the model's contacts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Self

import numpy as np
from pydantic import Field, model_validator

from softact.fields import Name, Part, Point, fault
from softact.loads.base import Load
from softact.system.term import Value

if TYPE_CHECKING:
    from softact.model import Model


class ObstacleChange(Part):
    """What a step does with an obstacle."""

    move: Point | None = Field(
        None, description="where to, counted from where it was placed: [0 mm, 0 mm, 3 mm]"
    )
    active: bool | None = Field(
        None, description="true puts it there, false removes it: its force fades over the step"
    )

    @model_validator(mode="after")
    def _changes_something(self) -> Self:
        if self.move is None and self.active is None:
            raise fault("changes nothing; give it move or active")
        return self


class Obstacles(Load):
    """shift: how far an obstacle was moved from where it was placed, (3,) mm. presence: 1 where it
    is there, 0 where not; between, it was removed and the force of the last equilibrium fades."""

    key = "obstacles"
    annotation = dict[Name, ObstacleChange]
    description = "obstacles moved, put there or removed: {name: {move: ...}}"
    fields = ("shift", "presence")

    def ends(
        self, value: Mapping[str, ObstacleChange], model: Model
    ) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        return {
            "shift": {n: np.asarray(o.move) for n, o in value.items() if o.move is not None},
            "presence": {n: float(o.active) for n, o in value.items() if o.active is not None},
        }

    def initial(self, model: Model) -> dict[str, dict[str, Value]]:
        """See ``Load.initial``."""
        rigid = [c.obstacle for c in model.contacts if c.obstacle is not None]
        return {
            "shift": {obstacle.name: np.zeros(3) for obstacle in rigid},
            "presence": {obstacle.name: float(obstacle.active) for obstacle in rigid},
        }

    def start(self, field: str, before: Value | None, end: Value) -> Value:
        """See ``Load.start``: what is put there is there from the start."""
        return end if field == "presence" and end == 1.0 else super().start(field, before, end)
