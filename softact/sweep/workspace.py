"""Where the tip gets to over the pressures of two cavities or more: a part of a sweep's page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from markupsafe import Markup

from softact.report import base, labels
from softact.report.base import Plot, Section
from softact.report.base.plots import numbers
from softact.results.folder import COMPLETE, NO_EQUILIBRIUM, is_pressure

TIP = ("tip_x_mm", "tip_y_mm", "tip_z_mm")
#: Spread of a coordinate or a pressure below which it is none, by the largest.
FLAT = 1e-3
#: And below which a third coordinate has no picture of its own.
NARROW = 0.1


@dataclass(frozen=True)
class Workspace:
    """Last states of the points. point, status (n,); tip (n, 3) mm; pressures: column -> (n,)
    kPa of each cavity whose pressure differs."""

    point: list[int]
    status: list[str]
    tip: np.ndarray
    pressures: Mapping[str, np.ndarray]

    @property
    def spans(self) -> np.ndarray:
        """(3,) mm from the lowest to the highest x, y and z."""
        return np.ptp(self.tip, axis=0)

    def hull(self) -> tuple[float, int]:
        """Size of the convex hull and its dimension: mm³ and 3, mm² and 2; 0 and 1 of a line."""
        _, sizes, directions = np.linalg.svd(self.tip - self.tip.mean(axis=0), full_matrices=False)
        rank = int((sizes > FLAT * sizes[0]).sum())
        if rank < 2 or len(self.tip) <= rank:
            return 0.0, 1
        from scipy.spatial import ConvexHull  # takes longer than all of a small page

        return float(ConvexHull(self.tip @ directions[:rank].T).volume), rank


def workspace(table: Sequence[Mapping[str, Any]]) -> Workspace | None:
    """That of the rows of a sweep; None where fewer than two pressures differ from each other, or
    there is no tip. Points that stopped early stand where they did, at the pressures there."""
    solved = [row for row in table if row["status"] in (COMPLETE, NO_EQUILIBRIUM)]
    names = _pressures(solved)
    wanted = [*TIP, *names]
    there = [row for row in solved if all(_is_number(row.get(name)) for name in wanted)]
    if len(there) < 3:
        return None
    values = {name: np.array([row[name] for row in there], float) for name in wanted}
    pressures = {name: values[name] for name in names}
    if _independent(list(pressures.values())) < 2:
        return None
    tip = np.column_stack([values[name] for name in TIP])
    if not np.ptp(tip, axis=0).max() > 0:
        return None
    return Workspace([int(row["point"]) for row in there], [str(row["status"]) for row in there],
                     tip, pressures)  # fmt: skip


def _is_number(value: object) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def _pressures(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Columns of cavities' pressures that are not the same in all rows."""
    columns = dict.fromkeys(name for row in rows for name in row)
    found = []
    for name in columns:
        if not is_pressure(name):
            continue
        values = [row[name] for row in rows if _is_number(row.get(name))]
        if values and np.ptp(values) > FLAT * np.abs(values).max():
            found.append(name)
    return found


def _independent(columns: Sequence[np.ndarray]) -> int:
    """How many pressures can be chosen freely: 1 where all go together."""
    if len(columns) < 2:
        return len(columns)
    sizes = np.linalg.svd(np.column_stack([c - c.mean() for c in columns]), compute_uv=False)
    return int((sizes > FLAT * sizes[0]).sum())


def sections(table: Sequence[Mapping[str, Any]]) -> list[Section]:
    """The part of a sweep's page; none where there is no workspace."""
    found = workspace(table)
    if found is None:
        return []
    said = base.note(
        "The tip at the last state of each run. The hull is the smallest convex one about them: "
        "where the cloud has a hollow side, it takes in places that the tip does not reach."
    )
    body = _cards(found) + said + base.figures(_plots(found))
    return [Section("workspace", "Workspace of the tip", body, "Workspace")]


def _cards(found: Workspace) -> Markup:
    cards = [
        base.card(f"Reach along {axis}", labels.number(span), "mm",
                  f"from {labels.number(low)} to {labels.number(high)} mm")
        for axis, span, low, high in zip(
            "xyz", found.spans, found.tip.min(axis=0), found.tip.max(axis=0), strict=True
        )
        if span > FLAT * found.spans.max()
    ]  # fmt: skip
    size, dimension = found.hull()
    if dimension == 3:
        cards.append(base.card("Convex hull", labels.number(size / 1e3), "mL"))
    elif dimension == 2:
        cards.append(base.card("Convex hull", labels.number(size), "mm²"))
    return Markup("<div class='cards'>") + Markup("").join(cards) + Markup("</div>")


def _plots(found: Workspace) -> list[Plot]:
    """The cloud in the plane of the two widest coordinates, coloured by each pressure; and along
    the third, where it is not narrow."""
    widest = np.argsort(-found.spans, kind="stable")
    pairs = [(min(pair), max(pair)) for pair in combinations(map(int, widest), 2)]
    plots = [_plot(found, pairs[0], name) for name in found.pressures]
    if found.spans[widest[2]] > NARROW * found.spans.max():
        first = next(iter(found.pressures))
        plots += [_plot(found, pair, first) for pair in pairs[1:]]
    return plots


def _plot(found: Workspace, pair: tuple[int, int], pressure: str) -> Plot:
    (x, y), shown = (str(labels.column(TIP[n])) for n in pair), labels.column(pressure)
    across, up = ("xyz"[n] for n in pair)
    traces = [trace for status in _SYMBOLS if (trace := _trace(found, pair, pressure, status))]
    if traces:
        traces[0]["marker"]["showscale"] = True
    title = f"Tip {up} over {across}, colour: {shown.name.lower()}"
    return base.lines(title, x, y, traces, equal=True, table=_columns(found))


_SYMBOLS = {COMPLETE: ("complete", "circle"), NO_EQUILIBRIUM: ("stopped early", "x")}


def _trace(
    found: Workspace, pair: tuple[int, int], pressure: str, status: str
) -> dict[str, Any] | None:
    some = [n for n, each in enumerate(found.status) if each == status]
    if not some:
        return None
    label, (name, symbol) = labels.column(pressure), _SYMBOLS[status]
    values = found.pressures[pressure] * label.factor
    marker = {
        "size": 8, "symbol": symbol, "color": numbers(values[some]),
        "cmin": float(values.min()), "cmax": float(values.max()), "colorscale": "Viridis",
        "colorbar": {"title": {"text": label.unit}, "thickness": 10, "outlinewidth": 0},
    }  # fmt: skip
    more: dict[str, Any] = {
        "marker": marker, "text": [_told(found, n) for n in some],
        "hovertemplate": "%{text}<br>%{x:.4~g}, %{y:.4~g} mm<extra></extra>",
    }  # fmt: skip
    x, y = found.tip[some][:, pair].T
    return base.xy(name, x, y, mode="markers", **more)


def _told(found: Workspace, number: int) -> str:
    pressures = (
        f"{labels.column(name).name} {labels.number(values[number] * labels.column(name).factor)} "
        f"{labels.column(name).unit}"
        for name, values in found.pressures.items()
    )
    return f"point {found.point[number]}<br>{'<br>'.join(pressures)}"


def _columns(found: Workspace) -> dict[str, Sequence]:
    """All that is known of each point, for its CSV."""
    pressures = {str(labels.column(name)): v.tolist() for name, v in found.pressures.items()}
    tip = {str(labels.column(name)): column.tolist()
           for name, column in zip(TIP, found.tip.T, strict=True)}  # fmt: skip
    return {"point": found.point, "status": found.status, **pressures, **tip}
