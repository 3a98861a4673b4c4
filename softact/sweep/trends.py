"""Whether the trends that a sweep names are seen in its rows."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from pathlib import Path

from softact.errors import SpecError
from softact.files import document
from softact.results.folder import COMPLETE
from softact.sweep.axes import Axis
from softact.sweep.spec import Trend
from softact.sweep.study import Study
from softact.sweep.table import Row
from softact.units import show


@dataclass(frozen=True)
class TrendFound:
    """holds: None where it cannot be told. text: the trend and what was seen, in words."""

    trend: Trend
    holds: bool | None
    text: str


def check(file: Path, study: Study) -> None:
    """Raise SpecError for a trend or an objective of a measure that the runs cannot have, before
    any is computed.

    The first and the last point that can be built stand for all.
    """
    sweep = study.sweep
    if not (sweep.trends or sweep.objectives):
        return
    from softact.sweep.measure_names import measure_fault  # scipy, which takes its time

    points = [point for point in study.points if point.key]
    ends = points[:1] + points[-1:]
    specs = [sweep.spec_at(study.base, point.changes) for point in ends]
    source, faults = document.read(file), []
    for key in ("trends", "objectives"):
        for number, asked in enumerate(getattr(sweep, key)):
            found = [measure_fault(asked.measure, spec, sweep.kinds) for spec in specs]
            if all(found):
                where = source.where((key, number, "measure"))
                at = f"{where}: {key}.{number}.measure: {show(asked.measure)}"
                faults.append(f"{at}: {found[0]}")
    if faults:
        raise SpecError(*faults)


def verdicts(study: Study, table: list[Row]) -> list[TrendFound]:
    """A verdict for each trend of the sweep."""
    return [_verdict(study, table, trend) for trend in study.sweep.trends]


def _verdict(study: Study, table: list[Row], trend: Trend) -> TrendFound:
    axis = next(a for a in study.sweep.axes if a.title == trend.axis)
    words = {"rise": "rises with", "fall": "falls with", "peak": "peaks inside the range of",
             "dip": "has its lowest value inside the range of"}  # fmt: skip
    said = f"{trend.measure} {words[trend.does]} {trend.axis}"
    lines = [line for line in _lines(study, table, axis, trend.measure) if len(line) > 1]
    if not lines:
        return TrendFound(
            trend, None, f"{said}: cannot be told, fewer than two complete runs have it"
        )
    wrong = [line for line in lines if not _does(trend.does, [y for _, y in line])]
    shown = ", ".join(f"{x:g}: {y:.4g}" for x, y in (wrong or lines)[0])
    if wrong:
        many = f" in {len(wrong)} of {len(lines)} series" if len(lines) > 1 else ""
        return TrendFound(trend, False, f"{said}: not so{many} ({shown})")
    return TrendFound(trend, True, f"{said}: so it is ({shown})")


def _lines(
    study: Study, table: list[Row], axis: Axis, measure: str
) -> list[list[tuple[float, float]]]:
    """(value, measure) along an axis, all other axes the same, for each setting of the others."""
    others = [a.column for a in study.sweep.axes if a is not axis]
    found: dict[tuple, list[tuple[float, float]]] = {}
    for row in table:
        x, y = row.get(axis.column), row.get(measure)
        if row["status"] != COMPLETE or not isinstance(x, float) or not isinstance(y, float):
            continue
        if not math.isnan(y):
            found.setdefault(tuple(row.get(name, "") for name in others), []).append((x, y))
    # The base of one_at_a_time stands in every axis once more: the same run, the same point.
    return [sorted(set(line)) for line in found.values()]


def _does(what: str, y: list[float]) -> bool:
    pairs = list(itertools.pairwise(y))
    if what == "rise":
        return all(a < b for a, b in pairs)
    if what == "fall":
        return all(a > b for a, b in pairs)
    best = max(y) if what == "peak" else min(y)
    return best not in (y[0], y[-1])
