"""Curvature and twist along the axis: plots of a report, and ``curvature.csv``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from softact.errors import reason
from softact.files.text import csv_text, write_atomic
from softact.report import base
from softact.report.base import Plot
from softact.report.view import states
from softact.results.along import STRAIGHT_DEG, Along, along, rows
from softact.results.folder import CURVATURE, Results, load_text

PLACE = "Place on the undeformed axis (mm)"
#: Column of ``COLUMNS``, title, what stands at the axis, of which angle of ``turns_deg`` it is.
_PLOTS = (
    ("curvature_per_m", "Curvature along the axis", "Curvature (1/m)", 0),
    ("twist_deg_per_m", "Twist along the axis", "Twist (°/m)", 1),
)
_NOTE = (
    "From slice to slice of the actuator, by undeformed length, so that it adds up to the whole "
    f"angle; all states, the other curvature and the stretch are in {CURVATURE}."
)


@dataclass(frozen=True)
class Drawn:
    """plots: of the states that the pictures show. fault: why there are none, "" otherwise."""

    plots: Sequence[Plot] = field(default_factory=tuple)
    fault: str = ""


def write(results: Results, most_states: int) -> Drawn:
    """Write ``curvature.csv``, and the plots of what is bent or twisted by a degree at least.

    A run without an axis, or that keeps straight, has neither.
    """
    path = results.directory / CURVATURE
    path.unlink(missing_ok=True)
    try:
        found = along(results)
        if found is None or max(found.turns_deg) < STRAIGHT_DEG:
            return Drawn()
        write_atomic(path, csv_text(rows(results, found)))
        return Drawn(_plots(results, found, states(results, most_states)))
    except Exception as error:  # a report without a plot beats no report
        return Drawn(fault=f"{CURVATURE} is missing: {reason(error)}")


def _plots(results: Results, found: Along, some: Sequence[int]) -> list[Plot]:
    """Those of what is bent and twisted, the larger part and what is not small beside it."""
    return [
        base.lines(title, PLACE, y, [_trace(results, found, row, column) for row in some],
                   note=_NOTE, wide=True, id=column)
        for column, title, y, which in _PLOTS
        if found.turns_deg[which] >= max(STRAIGHT_DEG, 0.1 * max(found.turns_deg))
    ]  # fmt: skip


def _trace(results: Results, found: Along, row: int, column: str) -> dict:
    columns = found.columns(row)
    return base.xy(load_text(results, row), columns["axis_mm"], columns[column])
