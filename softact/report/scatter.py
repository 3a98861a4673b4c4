"""Tolerances: how far a run's figures scatter, to first order, and what makes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from markupsafe import Markup

from softact.report import base, headline, labels
from softact.report.base import Plot, Section
from softact.report.base.templates import macros
from softact.report.curves import Chart, measures
from softact.results.folder import TOLERANCES, Results, load, load_name, load_text
from softact.tolerances.first_order import Scatter, stored_scatter

FIGURES = 3  # with a bar chart


@dataclass(frozen=True)
class Bands:
    """of: column of curve.csv -> row -> scatter. fault: why the table is there and cannot be used,
    "" otherwise."""

    of: Mapping[str, Mapping[int, Scatter]] = field(default_factory=dict)
    fault: str = ""

    def text(self, column: str, row: int) -> str:
        """What is put behind a figure: "± 3.2 (95 %)"; "" where nothing scatters."""
        found = self.of.get(column, {}).get(row)
        if found is None or not found.half:
            return ""
        return f"tolerances: {_both(found, labels.column(column))}"


def read(results: Results) -> Bands:
    """The bands of a result folder; none where its spec had no tolerances."""
    try:
        of: dict[str, dict[int, Scatter]] = {}
        for found in stored_scatter(results.directory):
            if found.row < len(load(results)):
                of.setdefault(found.measure, {})[found.row] = found
        return Bands(of)
    except (OSError, ValueError, KeyError):
        return Bands(fault=f"{TOLERANCES} cannot be read: softact run writes it")


def traces(chart: Chart, bands: Bands) -> list[dict[str, Any]]:
    """The bands of a chart's lines, to be drawn behind them."""
    found = []
    for number, (column, (_, x, _)) in enumerate(zip(chart.columns, chart.series, strict=False)):
        rows = bands.of.get(column, {})
        if any(s.half for s in rows.values()):
            found += _band(number, np.asarray(x, float), rows, labels.column(column).factor)
    return found


def _band(
    number: int, x: np.ndarray, rows: Mapping[int, Scatter], factor: float
) -> list[dict[str, Any]]:
    """Two edges without a line, the second filled to the first."""
    at = [float(x[n]) for n in rows]
    colour = f"@c{number % 8 + 1}"
    more: dict[str, Any] = {
        "mode": "lines", "line": {"width": 0}, "showlegend": False, "hoverinfo": "skip",
        "colour": colour,
    }  # fmt: skip
    low = base.xy("95 % low", at, [factor * (s.mean - s.half) for s in rows.values()], **more)
    high = base.xy("95 % high", at, [factor * (s.mean + s.half) for s in rows.values()], **more)
    return [low, {**high, "fill": "tonexty"}]


def section(results: Results, bands: Bands) -> list[Section]:
    """The section of the report, if there is one."""
    last = max((row for of in bands.of.values() for row in of), default=-1)
    now = {name: of[last] for name in _shown(results, bands) if (of := bands.of[name]).get(last)}
    now = {name: found for name, found in now.items() if found.half}
    if not now:
        return []
    body = macros("report/sections.html").tolerances(
        state=load_text(results, last),
        plots=base.figures([_causes(name, now[name]) for name in list(now)[:FIGURES]]),
        table=_table(now),
        file=TOLERANCES,
    )
    return [Section("tolerances", "How far actuators differ", body, "Tolerances")]


def _shown(results: Results, bands: Bands) -> list[str]:
    """The figures that tell most first, then all others that are results."""
    first = [name for name in headline.told(results) if name in bands.of]
    rest = [name for name in measures(results) if name in bands.of and name != load_name(results)]
    return list(dict.fromkeys([*first, *rest]))


def _both(found: Scatter, label: labels.Label) -> str:
    """Half the band with its unit."""
    unit = f"{'' if label.unit == '°' else ' '}{label.unit}" if label.unit else ""
    return f"± {labels.number(found.half * label.factor, 2)}{unit} (95 %)"


def _causes(name: str, found: Scatter) -> Plot:
    label = labels.column(name)
    ranked = sorted(found.effects, key=lambda cause: -abs(found.effects[cause]))
    return base.bars(
        f"{label.name}: what makes it differ", "% of the variance", "tolerance", ranked,
        [100 * found.share(cause) for cause in ranked],
    )  # fmt: skip


def _table(now: Mapping[str, Scatter]) -> Markup:
    some = list(next(iter(now.values())).effects)
    heads = ["Figure", "Unit", "As in the spec", "Mean", "Standard deviation", "95 % from", "to"]
    heads += [f"% from {cause}" for cause in some]
    rows: list[Sequence[str | float | None]] = []
    for name, found in now.items():
        label = labels.column(name)
        ends = found.mean - found.half, found.mean + found.half
        numbers = [v * label.factor for v in (found.value, found.mean, found.deviation, *ends)]
        rows.append([label.name, label.unit, *numbers, *(100 * found.share(c) for c in some)])
    return base.table(heads, rows, file="tolerances_last_state.csv")
