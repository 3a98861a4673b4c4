"""What is asked of a run: a measure at one of its states, to be made large or small."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from softact.sweep.record import Record


class Part(BaseModel):
    """A measure of a run, at one of its states."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    measure: str = Field(description="column of curve.csv, such as bending_angle_deg")
    take: Literal["last", "largest", "smallest"] = Field(
        "last", description="which of the states: the last, or the extreme one of all"
    )

    @property
    def title(self) -> str:
        """The measure in words."""
        return self.measure if self.take == "last" else f"{self.take} {self.measure}"

    def value(self, record: Record) -> float | None:
        """The measure of a run, None where it has none: no such column, or no number in it, such
        as a failure pressure that was not reached."""
        if self.measure not in record.columns or not len(record.table):
            return None
        values = record.curve(self.measure)
        if self.take == "last":
            values = values[-1:]
        values = values[np.isfinite(values)]
        if not len(values):
            return None
        return float(values.min() if self.take == "smallest" else values.max())

    def row(self, record: Record) -> int:
        """The state at which a run that has the measure has this value of it."""
        values = record.curve(self.measure)
        if self.take == "last":
            return len(values) - 1
        return int(np.nanargmin(values) if self.take == "smallest" else np.nanargmax(values))


class Objective(Part):
    """A measure to be made as large or as small as can be."""

    goal: Literal["maximise", "minimise"] = Field(description="maximise or minimise")

    @property
    def direction(self) -> Literal["minimize", "maximize"]:
        """The goal as Optuna spells it."""
        return "minimize" if self.goal == "minimise" else "maximize"

    @property
    def sign(self) -> int:
        """What makes more of the measure better."""
        return -1 if self.goal == "minimise" else 1
