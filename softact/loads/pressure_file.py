"""Pressures in time out of a CSV file: ``time (s),pressure (kPa)`` and a row for each moment."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softact.errors import SpecError
from softact.fields import ALL_CAVITIES
from softact.files import headed
from softact.nearest import nearest
from softact.units import PRESSURE, TIME, show

EXAMPLE = "time (s),pressure (kPa)"
TIMES = ("time", "t")


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
    rows = headed.rows(path, EXAMPLE)
    columns = [_column(path, cell) for cell in rows[0]]
    names = [name for name, _ in columns]
    if names.count("time") != 1 or len(names) < 2 or len(set(names)) < len(names):
        raise SpecError(f"{path.name}: one time and pressures are wanted; write '{EXAMPLE}'")
    numbers = headed.numbers(path, rows)
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


def columns_of(
    path: Path, example: str, without: re.Pattern[str] | None = None
) -> dict[str, np.ndarray]:
    """Columns of a file by their names in small letters, "time" in s, others in their own units.

    without: headings of columns that are left out, with or without a unit. Raises SpecError where
    it cannot be read.
    """
    rows = headed.rows(path, example)
    kept = [i for i, heading in enumerate(rows[0]) if not (without and without.match(heading))]
    rows = [[row[i] for i in kept if i < len(row)] for row in rows]
    names, factors = [], []
    for heading in rows[0]:
        name, unit = headed.named(path, heading, example)
        names.append("time" if name in TIMES else name)
        factors.append(headed.factor(path, heading, unit, TIME.internal) if name in TIMES else 1.0)
    numbers = headed.numbers(path, rows)
    return dict(zip(names, (numbers * factors).T, strict=True))


def _column(path: Path, heading: str) -> tuple[str, float]:
    """What a column is, "time" or a cavity, and the factor to s or MPa."""
    name, unit = headed.named(path, heading, EXAMPLE)
    if name in TIMES:
        return "time", headed.factor(path, heading, unit, TIME.internal)
    if not re.fullmatch(r"(pressure|p)(?:[\s_]+(.+))?", name):
        raise SpecError(f"{path.name}: {show(heading)} is neither; write '{EXAMPLE}'")
    cavity = re.sub(r"^(pressure|p)[\s_]*", "", name)
    return cavity or ALL_CAVITIES, headed.factor(path, heading, unit, PRESSURE.internal)
