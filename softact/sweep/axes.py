"""Axes of a sweep: paths of a spec and the values that they take, in the unit as written."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Sequence
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    WithJsonSchema,
    model_validator,
)

from softact.fields import NAMES_SCHEMA, fault, fault_at, one_or_more
from softact.units import conversion, show, split

MOST_STEPS = 100_000
LARGEST_WHOLE = 10**9


def quantity(value: Any) -> tuple[float, str] | None:
    """Number and unit of a value as a spec has it ('1.5 mm', 4, '30'), None of anything else."""
    if isinstance(value, bool):
        return None
    if isinstance(value, int | float):
        return float(value), ""
    parts = split(value) if isinstance(value, str) else None
    return (float(parts[0]), parts[1]) if parts else None


def known_quantity(value: Any) -> tuple[float, str]:
    """As ``quantity``, of a value that has been validated."""
    found = quantity(value)
    if found is None:
        raise ValueError(f"{show(value)} is no number with its unit")
    return found


def written(number: float, unit: str, whole: bool) -> str | int | float:
    """The value of a spec for a number and its unit, to 9 digits."""
    if whole:
        return round(number)
    number = float(f"{number:.9g}")
    return f"{number:.9g} {unit}" if unit else number


def unit_in_name(unit: str) -> str:
    """A unit as it stands in the name of a column: kg/m^3 becomes kg_m3."""
    return re.sub(r"[^A-Za-z0-9]+", "_", unit.replace("^", "").replace("°", "deg")).strip("_")


class Axis(BaseModel):
    """Values for one path of the spec, or for several paths that go together."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    path: Annotated[tuple[str, ...], BeforeValidator(one_or_more), WithJsonSchema(NAMES_SCHEMA)] = (
        Field(
            strict=False,
            description="dotted path of the spec as for --set, or a list of paths with one value",
        )
    )
    name: str | None = Field(None, description="heading of the column; default: the first path")
    values: tuple[Any, ...] | None = Field(
        None, strict=False, description="the values, with their units"
    )
    from_: Any = Field(None, alias="from", description="first value of a range")
    to: Any = Field(None, description="last value of a range, in the same unit")
    count: int = Field(5, ge=2, le=MOST_STEPS, description="points of the range, ends included")
    scale: Literal["linear", "log"] = Field("linear", description="spacing of the range")

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if self.name is not None and not (self.name.strip() and self.name.isprintable()):
            raise fault_at(("name",), f"{show(self.name)} is no heading: write words on one line")
        if not self.path:
            raise fault_at(("path",), "no path is given; write for example geometry.roof")
        ranged = self.from_ is not None or self.to is not None
        if ranged == (self.values is not None):
            raise fault("write either 'values', or 'from', 'to' and 'count'")
        if self.values is not None:
            self._check_values()
        else:
            self._check_range()
        return self

    def _check_values(self) -> None:
        if not self.values:
            raise fault_at(("values",), "no value is given")
        seen = set()
        for number, value in enumerate(self.values):
            plain = not isinstance(value, dict | list | bool)
            name = value if plain else json.dumps(value, sort_keys=True)
            if name in seen:
                raise fault_at(("values", number), f"{show(value)} is given twice")
            seen.add(name)

    def _check_range(self) -> None:
        for key, given in (("from", self.from_), ("to", self.to)):
            end = quantity(given)
            if end is None or not math.isfinite(end[0]):
                raise fault_at((key,), f"{show(given)} is no number with its unit")
            if self._whole and abs(given) > LARGEST_WHOLE:
                raise fault_at((key,), f"{show(given)}: whole numbers go to {LARGEST_WHOLE} here")
        (low, unit), (high, other) = known_quantity(self.from_), known_quantity(self.to)
        if unit != other:
            raise fault_at(("to",), f"{show(self.to)} has another unit than 'from': {show(unit)}")
        if low == high:
            raise fault_at(("to",), f"{show(self.to)} is where the range begins")
        if self.scale == "log" and min(low, high) <= 0:
            raise fault_at(("scale",), "a logarithmic range has to be above 0")

    @property
    def title(self) -> str:
        """Name of the axis without its unit."""
        return self.name or self.path[0]

    @property
    def unit(self) -> str:
        """The unit that all numbers of the axis are written in, "" where there is none."""
        if self.values is None:
            return known_quantity(self.from_)[1]
        found = {parts[1] for value in self.values if (parts := quantity(value))}
        same = len(found) == 1 and all(quantity(value) for value in self.values)
        return found.pop() if same else ""

    @property
    def column(self) -> str:
        """Heading of the axis in a table: its name and unit."""
        return f"{self.title}_{unit_in_name(self.unit)}" if self.unit else self.title

    @property
    def is_number(self) -> bool:
        """Whether all values are numbers in one unit."""
        if self.values is None:
            return True
        parts = [quantity(value) for value in self.values]
        return None not in parts and len({part[1] for part in parts if part}) == 1

    @property
    def continuous(self) -> bool:
        """Whether any value between two ends will do."""
        return self.values is None and not self._whole

    @property
    def _whole(self) -> bool:
        return isinstance(self.from_, int) and isinstance(self.to, int)

    @property
    def ends(self) -> tuple[float, float]:
        """Its first and its last value, in its unit, where it is no list."""
        return known_quantity(self.from_)[0], known_quantity(self.to)[0]

    def steps(self) -> list[Any]:
        """The values in order, for a grid or one at a time."""
        if self.values is not None:
            return list(self.values)
        low, high = self.ends
        space = np.geomspace if self.scale == "log" else np.linspace
        numbers = space(low, high, self.count)
        values = [written(number, self.unit, self._whole) for number in numbers]
        return list(dict.fromkeys(values))

    @property
    def size(self) -> int:
        """The number of ``steps``, or a little more where whole numbers are fewer."""
        return self.count if self.values is None else len(self.values)

    def at(self, fractions: Sequence[float]) -> list[Any]:
        """Values at fractions (0 to 1) of the axis: of its range, or of its list."""
        if self.values is not None or self._whole:
            steps = self._all_whole() if self.values is None else self.values
            return [steps[min(int(f * len(steps)), len(steps) - 1)] for f in fractions]
        low, high = self.ends
        if self.scale == "log":
            low, high = math.log(low), math.log(high)
        straight = math.exp if self.scale == "log" else float
        numbers = (straight(low + f * (high - low)) for f in fractions)
        return [written(number, self.unit, False) for number in numbers]

    def changes(self, value: Any) -> list[tuple[str, Any]]:
        """What one of its values is in a spec: a value for each path."""
        return [(path, value) for path in self.path]

    def _all_whole(self) -> range:
        low, high = sorted((self.from_, self.to))
        return range(low, high + 1)

    def number(self, value: Any) -> float | str:
        """A value that may be written in another unit, as a number in the axis's, else its text."""
        parts = quantity(value)
        if parts is None:
            return str(value)
        if parts[1] == self.unit:
            return parts[0]
        try:
            return parts[0] * conversion(parts[1], self.unit)
        except ValueError:
            return str(value)

    def cell(self, value: Any) -> float | str:
        """What stands in the axis's column for a value: its number in ``unit``, or text."""
        parts = quantity(value)
        return parts[0] if self.is_number and parts else str(value)
