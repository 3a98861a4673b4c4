"""A line that the actuator is to follow, as a spec says it: a CSV file of points."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field, field_validator

from softact.errors import SpecError
from softact.fields import Part, Point, fault
from softact.files.text import NAMES_A_FILE
from softact.units import LENGTH, conversion, show

EXAMPLE = "x (mm),z (mm)"
_HEADING = re.compile(r"([xyz])[\s_]*[(\[]?([a-zA-Zµ]+)[)\]]?")


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
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            rows = [row for row in csv.reader(file) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is no text of UTF-8"
        raise SpecError(f"{path.name}: cannot be read ({why})") from None
    if len(rows) < 3:
        raise SpecError(f"{path.name}: a header such as '{EXAMPLE}' and two points are wanted")
    columns = [_column(path, heading) for heading in rows[0]]
    axes = [axis for axis, _ in columns]
    if sorted(axes) not in ([0, 2], [0, 1, 2]):
        raise SpecError(f"{path.name}: a header such as '{EXAMPLE}' is wanted, once for each axis")
    points = np.zeros((len(rows) - 1, 3))
    for number, row in enumerate(rows[1:]):
        values = _numbers(path, number + 2, row, len(columns))
        for value, (axis, factor) in zip(values, columns, strict=True):
            points[number, axis] = factor * value
    return points


def _column(path: Path, heading: str) -> tuple[int, float]:
    """The axis of a column, and the factor to mm."""
    match = _HEADING.fullmatch(heading.strip())
    if match is None:
        raise SpecError(f"{path.name}: {show(heading)} is no axis with a unit; write '{EXAMPLE}'")
    try:
        return "xyz".index(match[1]), conversion(match[2], LENGTH.internal)
    except ValueError as error:
        raise SpecError(f"{path.name}: {show(heading)}: {error}") from None


def _numbers(path: Path, number: int, row: list[str], count: int) -> list[float]:
    try:
        values = [float(cell) for cell in row]
    except ValueError:
        values = []
    if len(values) != count or not np.isfinite(values).all():
        raise SpecError(
            f"{path.name}: row {number} holds {show(','.join(row))}; {count} numbers are wanted"
        )
    return values
