"""Pressures in time out of a CSV file: ``time (s),pressure (kPa)`` and a row for each moment."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softact.errors import SpecError
from softact.fields import ALL_CAVITIES
from softact.nearest import nearest
from softact.units import PRESSURE, TIME, conversion, show

EXAMPLE = "time (s),pressure (kPa)"
TIMES = ("time", "t")
_HEADING = re.compile(r"(?P<name>.*?)[\s_]*[(\[](?P<unit>[^)\]]*)[)\]]|(?P<n>.*)[\s_](?P<u>\S+)")


@dataclass(frozen=True, eq=False)
class PressureFile:
    """times: (n,) s, rising. pressures: cavity, or "*" for all -> (n,) MPa."""

    times: np.ndarray
    pressures: Mapping[str, np.ndarray]

    @property
    def duration(self) -> float:
        """From the first row to the last, s."""
        return float(self.times[-1] - self.times[0])

    @property
    def parts(self) -> np.ndarray:
        """Times as parts of the duration."""
        return (self.times - self.times[0]) / self.duration

    def for_cavities(self, cavities: Sequence[str]) -> dict[str, np.ndarray]:
        """Cavity -> pressures (n,)."""
        if ALL_CAVITIES in self.pressures:
            return dict.fromkeys(cavities, self.pressures[ALL_CAVITIES])
        return dict(self.pressures)

    def faults(self, cavities: Sequence[str]) -> Iterator[str]:
        """What does not fit a geometry with these cavities."""
        if not cavities:
            yield "the geometry has no cavity that could hold a pressure"
            return
        for name in self.pressures:
            if name != ALL_CAVITIES and name not in cavities:
                yield f"the geometry has no cavity {show(name)}; {nearest(name, cavities)}"


def read(path: Path) -> PressureFile:
    """Read a file. Raises SpecError where it cannot be read, in one line."""
    rows = _rows(path, EXAMPLE)
    columns = [_column(path, cell) for cell in rows[0]]
    names = [name for name, _ in columns]
    if names.count("time") != 1 or len(names) < 2 or len(set(names)) < len(names):
        raise SpecError(f"{path.name}: one time and pressures are wanted; write '{EXAMPLE}'")
    numbers = np.array([_numbers(path, i, row, len(names)) for i, row in enumerate(rows[1:], 2)])
    values = dict(zip(names, (numbers * [factor for _, factor in columns]).T, strict=True))
    times = values.pop("time")
    back = np.flatnonzero(np.diff(times) <= 0)
    if len(back):
        row = int(back[0])
        raise SpecError(
            f"{path.name}: time runs back from {times[row]:g} s to {times[row + 1]:g} s at row "
            f"{row + 3}; each row is later than the one before"
        )
    return PressureFile(times, values)


def columns_of(path: Path, example: str) -> dict[str, np.ndarray]:
    """Columns of a file by their names in small letters, "time" in s, others in their own units.

    Raises SpecError where it cannot be read.
    """
    rows = _rows(path, example)
    names, factors = [], []
    for heading in rows[0]:
        name, unit = _named(path, heading, example)
        names.append("time" if name in TIMES else name)
        factors.append(_factor(path, heading, unit, TIME.internal) if name in TIMES else 1.0)
    numbers = np.array([_numbers(path, i, row, len(names)) for i, row in enumerate(rows[1:], 2)])
    return dict(zip(names, (numbers * factors).T, strict=True))


def _rows(path: Path, example: str) -> list[list[str]]:
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            rows = [row for row in csv.reader(file) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is no text of UTF-8"
        raise SpecError(f"{path.name}: cannot be read ({why})") from None
    if len(rows) < 3:
        raise SpecError(f"{path.name}: a header such as '{example}' and two rows are wanted")
    return rows


def _named(path: Path, heading: str, example: str) -> tuple[str, str]:
    """Name in small letters and unit of a heading."""
    match = _HEADING.fullmatch(heading.strip())
    if match is None:
        raise SpecError(f"{path.name}: {show(heading)} has no unit; write '{example}'")
    if match["unit"] is not None:
        return match["name"].strip().lower(), match["unit"].strip()
    return match["n"].strip().lower(), match["u"].strip()


def _factor(path: Path, heading: str, unit: str, internal: str) -> float:
    try:
        return conversion(unit, internal)
    except ValueError as error:
        raise SpecError(f"{path.name}: {show(heading)}: {error}") from None


def _column(path: Path, heading: str) -> tuple[str, float]:
    """What a column is, "time" or a cavity, and the factor to s or MPa."""
    name, unit = _named(path, heading, EXAMPLE)
    if name in TIMES:
        return "time", _factor(path, heading, unit, TIME.internal)
    if not re.fullmatch(r"(pressure|p)(?:[\s_]+(.+))?", name):
        raise SpecError(f"{path.name}: {show(heading)} is neither; write '{EXAMPLE}'")
    cavity = re.sub(r"^(pressure|p)[\s_]*", "", name)
    return cavity or ALL_CAVITIES, _factor(path, heading, unit, PRESSURE.internal)


def _numbers(path: Path, number: int, row: Sequence[str], count: int) -> list[float]:
    if len(row) != count:
        raise SpecError(f"{path.name}: row {number} has {len(row)} cells, and the header {count}")
    try:
        values = [float(cell) for cell in row]
    except ValueError:
        raise SpecError(
            f"{path.name}: row {number} holds {show(','.join(row))}, no numbers"
        ) from None
    if not all(map(math.isfinite, values)):
        raise SpecError(f"{path.name}: row {number} holds a number that is not finite")
    return values
