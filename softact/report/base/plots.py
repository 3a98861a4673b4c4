"""Plots of a page: plotly's traces, names with units, and the data as CSV."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from softact.report.base.parts import parts

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


@dataclass(frozen=True)
class Plot:
    """One plot.

    traces, layout: as plotly has them; colours may be tokens ("@c1", see the package). x, y: names
    of the axes with their units, also the heads of the CSV. table: head -> column of the CSV; where
    it is None, the CSV is made from x and y of the traces. id: of the element, for scripts and
    links. wide: takes a row of its own. scroll: no narrower than 44rem, so that a phone scrolls it
    (parallel coordinates). note: a text below the plot.
    """

    title: str
    traces: Sequence[Mapping]
    x: str = ""
    y: str = ""
    layout: Mapping = field(default_factory=dict)
    table: Mapping[str, Sequence] | None = None
    id: str = ""
    wide: bool = False
    scroll: bool = False
    note: str = ""


def numbers(values: ArrayLike) -> list[float | None]:
    """Values for JSON with seven digits; None where one is not finite."""
    return [
        float(f"{v:.7g}") if np.isfinite(v) else None for v in np.asarray(values, float).ravel()
    ]


def xy(
    name: str,
    x: ArrayLike,
    y: ArrayLike,
    *,
    colour: str = "",
    mode: str = "lines+markers",
    **more: Any,
) -> dict:
    """A trace for ``lines``: name, abscissae and ordinates of equal length.

    mode: "lines", "markers" or both. more: further keys of plotly's scatter trace.
    """
    line = {"width": 2, **({"color": colour} if colour else {}), **more.pop("line", {})}
    marker = {"size": 5, **({"color": colour} if colour else {}), **more.pop("marker", {})}
    trace = {"type": "scatter", "mode": mode, "name": name, "x": numbers(x), "y": numbers(y)}
    return {**trace, "line": line, "marker": marker, **more}


def lines(title: str, x: str, y: str, traces: Sequence[Mapping], **more: Any) -> Plot:
    """Curves over one abscissa. traces: of ``xy``, coloured in turn where they name no colour.

    more: equal=True for the same scale on both axes; layout; the other fields of ``Plot``.
    """
    layout = dict(more.pop("layout", {}))
    if more.pop("equal", False):
        layout["yaxis"] = {"scaleanchor": "x", **layout.get("yaxis", {})}
    coloured = [_coloured(trace, number) for number, trace in enumerate(traces)]
    return Plot(title, coloured, x, y, layout, **more)


def _coloured(trace: Mapping, number: int) -> dict:
    colour = f"@c{number % 8 + 1}"
    keys = {key: {"color": colour, **trace.get(key, {})} for key in ("line", "marker")}
    return {**trace, **keys}


def bars(
    title: str,
    x: str,
    y: str,
    names: Sequence[str],
    values: ArrayLike,
    *,
    colours: str | Sequence[str] = "@c1",
    **more: Any,
) -> Plot:
    """One bar for each name, drawn sideways so that long names can be read; x is its value.

    colours: of all bars, or of each.
    """
    trace = {
        "type": "bar", "orientation": "h", "name": x, "x": numbers(values), "y": list(names),
        "marker": {"color": colours}, "hovertemplate": "%{y}: %{x:.4~g}<extra></extra>",
    }  # fmt: skip
    layout = {"yaxis": {"autorange": "reversed", "type": "category"}, **more.pop("layout", {})}
    head = {y: list(names), x: trace["x"]}
    return Plot(title, [trace], x, y, layout, table=more.pop("table", head), **more)


def figures(plots: Iterable[Plot]) -> Markup:
    """HTML of the plots, in a grid of as many columns as there is room for."""
    return parts().figures([(plot, _data(plot)) for plot in plots])


def file_stem(text: str) -> str:
    """A name for a file from a title."""
    return re.sub(r"[^\w.-]+", "_", text).strip("_").lower() or "data"


def _data(plot: Plot) -> dict:
    """What base.js draws."""
    return {
        "title": plot.title, "x": plot.x, "y": plot.y, "traces": plot.traces,
        "layout": plot.layout, "table": plot.table, "file": f"{file_stem(plot.title)}.csv",
    }  # fmt: skip


def frame(title: str, id: str = "", *, wide: bool = False, scroll: bool = False) -> Markup:
    """HTML of a figure with a link for its CSV, without a plot: the page's script draws into the
    element ``id`` and tells the link what is there, with ``describe``."""
    return parts().frame(title, id, wide, scroll)
