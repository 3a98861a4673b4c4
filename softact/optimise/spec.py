"""The optimisation file: a base spec, parameters, objectives, constraints."""

from __future__ import annotations

from typing import Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from softact.geometry import is_of_mesh
from softact.spec.choice import fault, fault_at
from softact.sweep.axes import Axis
from softact.sweep.record import Record
from softact.sweep.spec import Model, check_axes
from softact.units import Dimensionless


class _Measure(BaseModel):
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
        """The measure of a run, None where it has none."""
        if self.measure not in record.columns or not len(record.table):
            return None
        values = record.curve(self.measure)
        pick = {"last": lambda v: v[-1], "largest": max, "smallest": min}[self.take]
        return float(pick(values))


class Objective(_Measure):
    """A measure to be made as large or as small as can be."""

    goal: Literal["maximise", "minimise"] = Field(description="maximise or minimise")

    @property
    def direction(self) -> str:
        """The goal as Optuna spells it."""
        return self.goal.replace("ise", "ize")


class Constraint(_Measure):
    """A measure that has to stay within bounds, in the column's unit."""

    above: Dimensionless | None = Field(None, description="smallest value allowed")
    below: Dimensionless | None = Field(None, description="largest value allowed")

    @model_validator(mode="after")
    def _has_a_bound(self) -> Self:
        if self.above is None and self.below is None:
            raise fault("a constraint needs 'above', 'below' or both")
        return self

    def violation(self, record: Record) -> float:
        """By how much a run breaks it, relative to the bound; at most 0 where it holds.

        The run has the measure.
        """
        value = self.value(record)
        parts = []
        if self.below is not None:
            parts.append((value - self.below) / max(abs(self.below), 1e-12))
        if self.above is not None:
            parts.append((self.above - value) / max(abs(self.above), 1e-12))
        return max(parts)


class Optimisation(Model):
    """What is varied, what is wanted, and what must hold."""

    parameters: tuple[Axis, ...] = Field(strict=False, description="as the axes of a sweep")
    objectives: tuple[Objective, ...] = Field(strict=False, description="one or several")
    constraints: tuple[Constraint, ...] = Field((), strict=False, description="on measures")
    trials: int = Field(40, ge=1, le=100_000, description="runs in all, failed ones included")
    seed: int = Field(0, ge=0, description="of the sampler")
    reference: dict[str, Any] = Field(
        {}, description="parameter: value of a design to be beaten; it is the first trial"
    )

    @model_validator(mode="after")
    def _parts_agree(self) -> Self:
        check_axes(self.parameters)
        for number, axis in enumerate(self.parameters):
            if any(map(is_of_mesh, axis.path)):
                raise fault_at(
                    ("parameters", number, "path"),
                    "says how fine the mesh is: the best mesh would be the one with the largest "
                    "error; 'softact converge' finds a mesh, and 'set' fixes it",
                )
        if not self.objectives:
            raise fault_at(("objectives",), "empty; write - {measure: ..., goal: maximise}")
        titles = [axis.title for axis in self.parameters]
        if self.reference and sorted(self.reference) != sorted(titles):
            raise fault_at(("reference",), f"give a value for each of: {', '.join(titles)}")
        return self
