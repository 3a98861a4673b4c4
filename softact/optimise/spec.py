"""The optimisation file: a base spec, parameters, objectives, constraints."""

from __future__ import annotations

from typing import Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from softact.fields import fault, fault_at
from softact.geometry.base import is_of_mesh
from softact.sweep.axes import Axis
from softact.sweep.design import Coordinates, Design
from softact.sweep.parts import Objective, Part
from softact.sweep.record import Record
from softact.sweep.spec import FULL, StudyFile, check_axes
from softact.units import Dimensionless, show

GRADIENT = "gradient"
_TRIED = Design(kind="latin_hypercube", samples=64)


class Constraint(Part):
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
        assert value is not None
        parts = []
        if self.below is not None:
            parts.append((value - self.below) / max(abs(self.below), 1e-12))
        if self.above is not None:
            parts.append((self.above - value) / max(abs(self.above), 1e-12))
        return max(parts)


class Optimisation(StudyFile):
    """What is varied, what is wanted, and what must hold."""

    kind: ClassVar[str] = "optimise"
    of_axes: ClassVar[str] = "parameters"

    parameters: tuple[Axis, ...] = Field(strict=False, description="as the axes of a sweep")
    objectives: tuple[Objective, ...] = Field(strict=False, description="one or several")
    constraints: tuple[Constraint, ...] = Field((), strict=False, description="on measures")
    trials: int = Field(40, ge=1, le=100_000, description="runs in all, failed ones included")
    method: Literal["optuna", "gradient"] = Field(
        "optuna",
        description="gradient: SLSQP with the derivatives of each run, from starts",
    )
    starts: int = Field(3, ge=1, le=1000, description="of the method gradient, the reference first")
    seed: int = Field(0, ge=0, lt=2**32, description="of the sampler, or of the starts")
    reference: dict[str, Any] = Field(
        {}, description="parameter: value of a design to be beaten; it is the first trial"
    )

    def tried(self) -> list[Coordinates]:
        """See ``StudyFile.tried``: the reference, or some designs between the ends."""
        return [self.reference] if self.reference else _TRIED.points(self.parameters)

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
        if self.method == GRADIENT:
            self._check_gradient()
        titles = [axis.title for axis in self.parameters]
        if self.reference and sorted(self.reference) != sorted(titles):
            raise fault_at(("reference",), f"give a value for each of: {', '.join(titles)}")
        for axis in self.parameters if self.reference else ():
            if why := _not_on(axis, self.reference[axis.title]):
                raise fault_at(("reference", axis.title), why)
        return self

    def _check_gradient(self) -> None:
        """Raise a fault where there is nothing to descend along."""
        if self.model != FULL:
            why = "a module has no derivatives yet: leave 'method: gradient' out, or write full"
            raise fault_at(("model",), why)
        if len(self.objectives) > 1:
            why = "the method gradient has one objective: write the others as constraints"
            raise fault_at(("objectives",), why)
        for number, axis in enumerate(self.parameters):
            if not axis.continuous:
                why = (
                    "the method gradient varies ranges from ... to ... of numbers with a unit or a "
                    "point; for lists and whole numbers leave 'method: gradient' out"
                )
                raise fault_at(("parameters", number), why)


def place_of(axis: Axis, value: Any) -> int | None:
    """Where a value stands in an axis's list, None where it does not; 1 is not True there."""
    same = (n for n, v in enumerate(axis.values or ()) if type(v) is type(value) and v == value)
    return next(same, None)


def _not_on(axis: Axis, value: Any) -> str:
    """Why a value is none that the axis has, "" where it is one."""
    if axis.values is not None:
        known = ", ".join(show(entry) for entry in axis.values)
        there = place_of(axis, value) is not None
        return "" if there else f"{show(value)} is none of its values: {known}"
    number, ends = axis.number(value), sorted(axis.ends)
    if isinstance(number, str):
        return f"{show(value)} is no number in {axis.unit or 'a unit'} as its range is"
    if not ends[0] <= number <= ends[1]:
        return f"{show(value)} is outside of its range, {show(axis.from_)} to {show(axis.to)}"
    if not axis.continuous and number != round(number):
        return f"{show(value)} is no whole number, as its range is"
    return ""
