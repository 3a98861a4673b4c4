"""Mean and standard deviation of every figure at every state, from its derivatives.

With independent causes c of the standard deviations σ of parameters θ that scatter together:

    σ² = Σ_c (Σ_θ ∂m/∂θ σ_θ)²,   mean = m + Σ ∂m/∂θ (mean of θ − θ)

the first terms of the series (JCGM 100:2008, eq. 10 and 16).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from softact.files.text import csv_rows, csv_text, write_atomic
from softact.results.folder import TOLERANCES, Results, read
from softact.sensitivities import stored
from softact.sensitivities.table import STATE, pressures, unit_of
from softact.tolerances.causes import Cause

#: Half width of the band by the standard deviation: 95 % of all, where they scatter normally.
BAND = 1.96
#: Heading of a column with a cause's part of the variance, before and after the cause's name.
SHARE = ("share_", "_percent")
COLUMNS = ("measure", "value", "mean", "standard_deviation", "low", "high", "unit")


@dataclass(frozen=True)
class Scatter:
    """Of one measure at one state. row: of curve.csv; value: of the actuator as its spec has it;
    mean: of all; effects: cause's name -> change of the measure by one standard deviation of it,
    without its sign where it was read from a table."""

    row: int
    measure: str
    value: float
    mean: float
    effects: dict[str, float]

    @property
    def deviation(self) -> float:
        """Standard deviation of all causes together."""
        return math.sqrt(sum(effect**2 for effect in self.effects.values()))

    @property
    def half(self) -> float:
        """Half the width of the band."""
        return BAND * self.deviation

    def share(self, cause: str) -> float:
        """Part of the variance that a cause makes; 0 where there is none."""
        whole = self.deviation**2
        return self.effects[cause] ** 2 / whole if whole else 0.0


def scatter(results: Results, some: Sequence[Cause]) -> list[Scatter]:
    """Of all measures and states that have all derivatives; in the order of sensitivities.csv.

    Raises ValueError or KeyError where that is damaged.
    """
    slopes: dict[tuple[int, str], dict[str, float]] = {}
    wanted = {p.path for cause in some for p in cause.parameters}
    for slope in stored.read(results.directory):
        if slope.parameter in wanted:
            of = slopes.setdefault((slope.row, slope.measure), {})
            of[slope.parameter] = slope.derivative
    return [
        _scatter(row, measure, float(results.curve[measure][row]), of, some)
        for (row, measure), of in slopes.items()
        if len(of) == len(wanted) and row < len(results.curve[measure])
    ]


def _scatter(
    row: int, measure: str, value: float, slopes: dict[str, float], some: Sequence[Cause]
) -> Scatter:
    """slopes: by the parameters in the units in which they are told."""
    effects, mean = {}, value
    for cause in some:
        by = [slopes[p.path] / p.factor for p in cause.parameters]
        effects[cause.name] = sum(s * d for s, d in zip(by, cause.deviations, strict=True))
        mean += sum(s * d for s, d in zip(by, cause.shifts, strict=True))
    return Scatter(row, measure, value, mean, effects)


def write(directory: Path, some: Sequence[Cause]) -> None:
    """Write the table of a result folder. Raises ValueError or KeyError where it is damaged."""
    results = read(directory)
    text = csv_text([_line(results, found) for found in scatter(results, some)])
    write_atomic(directory / TOLERANCES, text)


def stored_scatter(directory: Path) -> list[Scatter]:
    """What ``write`` has written; nothing where there is no table. Raises ValueError or KeyError
    where it is damaged."""
    path = directory / TOLERANCES
    if not path.is_file():
        return []
    head, *lines = csv_rows(path)
    return [_read(dict(zip(head, line, strict=True))) for line in lines]


def _read(line: dict[str, Any]) -> Scatter:
    names = [n for n in line if n.startswith(SHARE[0]) and n.endswith(SHARE[1])]
    deviation = float(line["standard_deviation"])
    effects = {
        n.removeprefix(SHARE[0]).removesuffix(SHARE[1]):
        deviation * math.sqrt(float(line[n]) / 100) for n in names
    }  # fmt: skip
    row, value, mean = int(line["increment"]), float(line["value"]), float(line["mean"])
    return Scatter(row, line["measure"], value, mean, effects)


def share_column(cause: str) -> str:
    """Heading of the column with a cause's part of the variance."""
    return cause.join(SHARE)


def _line(results: Results, found: Scatter) -> dict[str, Any]:
    curve, row = results.curve, found.row
    names = [*STATE, *pressures(curve)]
    state = {n: str(curve[n][row]) if n == "step" else float(curve[n][row]) for n in names}
    state["increment"] = row
    unit = unit_of(found.measure)
    ends = found.mean - found.half, found.mean + found.half
    numbers = (found.measure, found.value, found.mean, found.deviation, *ends, unit)
    shares = {share_column(name): 100 * found.share(name) for name in found.effects}
    return {**state, **dict(zip(COLUMNS, numbers, strict=True)), **shares}
