"""A line that the actuator is to follow, as a spec says it: a CSV file of points."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, field_validator

from softact.errors import SpecError
from softact.fields import Part, Point, fault
from softact.files import headed
from softact.files.text import NAMES_A_FILE
from softact.units import LENGTH, show

EXAMPLE = "x (mm),z (mm)"


class TargetLine(Part):
    """Points that a line of the actuator is to pass; how far it is from them is a measure."""

    file: Annotated[str, NAMES_A_FILE] = Field(
        description=f"a CSV file of points in order, with units in its header: `{EXAMPLE}`, or "
        "with y; counted as the actuator's own places, from the clamp"
    )
    through: Point = Field(
        (0.0, 0.0, 0.0),
        strict=False,
        description="a point of the undeformed line, which goes from end to end along the actuator",
    )

    @field_validator("file")
    @classmethod
    def _can_be_read(cls, name: str) -> str:
        try:
            read_line(Path(name))
        except SpecError as error:
            raise fault("; ".join(error.lines)) from None
        return name

    @property
    def points(self) -> np.ndarray:
        """The points (n, 3), mm."""
        return read_line(Path(self.file))


def read_line(path: Path) -> np.ndarray:
    """Points (n, 3), mm, of a CSV file. Raises SpecError where it cannot be read, in one line."""
    rows = headed.rows(path, EXAMPLE)
    columns = [_column(path, heading) for heading in rows[0]]
    axes = [axis for axis, _ in columns]
    if sorted(axes) not in ([0, 2], [0, 1, 2]):
        raise SpecError(f"{path.name}: a header such as '{EXAMPLE}' is wanted, once for each axis")
    numbers = headed.numbers(path, rows)
    points = np.zeros((len(numbers), 3))
    points[:, axes] = numbers * [factor for _, factor in columns]
    return points


def _column(path: Path, heading: str) -> tuple[int, float]:
    """The axis of a column, and the factor to mm."""
    name, unit = headed.named(path, heading, EXAMPLE)
    if name not in ("x", "y", "z"):
        raise SpecError(f"{path.name}: {show(heading)} is no axis; write '{EXAMPLE}'")
    return "xyz".index(name), headed.factor(path, heading, unit, LENGTH.internal)
