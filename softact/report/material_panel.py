"""The materials of a run: each law's curve, how far its card was tested, and where the run went."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from softact.errors import SpecError
from softact.materials import Law
from softact.materials.breaking import uniaxial
from softact.mesh.percentile import percentile
from softact.report import base, labels
from softact.report.base import Plot, Section
from softact.report.base.plots import numbers
from softact.report.hot_spots import STRETCH
from softact.results.folder import Results, load_text
from softact.verdict.reached import reached

_POINTS = 120
_BINS = 30
_ROOM = 1.15  # of the largest stretch of the run: how far the curve is drawn
_LEAST = 1.3


def sections(results: Results) -> list[Section]:
    """The section of the page; none of an actuator of sheets, or without states. Raises SpecError
    where the spec cannot be read any more."""
    row = reached(results).main
    if row is None or not results.region_names or STRETCH not in results.field_names(row):
        return []
    laws, stretch = _laws(results), results.field(row, STRETCH)
    plots, rows = [], []
    for number, region in enumerate(results.region_names):
        cells = results.cells[results.region == number]
        if not len(cells) or region not in laws:
            continue
        law = laws[region]
        at, part = _stretches(results, cells, stretch)
        largest = float(stretch[cells].max())
        rows.append(_row(region, law, at, part, largest))
        if not law.anisotropic:
            plots.append(_plot(region, law, at, part, largest))
    said = (
        f"At {load_text(results, row)}. Bars: how much of the volume is stretched so far, by the "
        "mean of each element. Line: the law in uniaxial tension. Pale: the tested stretches."
    )
    heads = ["Region", "Material", "Law", "Stretch, mean", "Exceeded in 1 % of the volume",
             "Highest node", "Tested up to"]  # fmt: skip
    body = base.figures(plots) + base.table(heads, rows) + base.note(said)
    return [Section("materials", "Materials", body)] if rows else []


def _laws(results: Results) -> Mapping[str, Law]:
    from softact.spec import loads

    try:
        spec = loads(results.spec_yaml, str(results.directory / "spec.yaml"))
    except SpecError as error:
        raise SpecError(f"The materials are missing: {error.lines[0]}") from None
    return spec.materials


def _stretches(
    results: Results, cells: np.ndarray, stretch: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(m,) the stretch of each cell, mean of its nodes, and its part of the region's volume."""
    corners = results.points[cells[:, :4]]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    return stretch[cells].mean(axis=1), volumes / volumes.sum()


def _row(
    region: str, law: Law, stretch: np.ndarray, part: np.ndarray, largest: float
) -> list[str | float | None]:
    card, tested = law.card, law.card.stretch_range
    return [
        region.replace("_", " "), card.name or "of the spec",
        str(getattr(law, "law", "")).replace("_", " "), float(stretch @ part),
        percentile(stretch, part, 0.99), largest, tested[1] if tested else "not known",
    ]  # fmt: skip


def _plot(region: str, law: Law, stretch: np.ndarray, part: np.ndarray, largest: float) -> Plot:
    end = max(_LEAST, 1 + _ROOM * (largest - 1))
    axis = np.linspace(1.0, end, _POINTS)
    nominal, _ = uniaxial(law.material(), axis)
    share, edges = np.histogram(stretch, bins=_BINS, range=(1.0, end), weights=100 * part)
    title = f"{region.replace('_', ' ').capitalize()}: {law.card.name or 'material of the spec'}"
    bars = {
        "type": "bar", "name": "share of the volume", "x": numbers((edges[1:] + edges[:-1]) / 2),
        "y": numbers(share), "marker": {"color": "@c5"}, "opacity": 0.6, "width": (end - 1) / _BINS,
        "hovertemplate": "%{x:.3~g}: %{y:.3~g} % of the volume<extra></extra>",
    }  # fmt: skip
    curve = base.xy("law, uniaxial", axis, nominal, colour="@c2", mode="lines", yaxis="y2")
    node = base.xy("highest node", [largest], [np.interp(largest, axis, nominal)], colour="@ink",
                   mode="markers", yaxis="y2", marker={"size": 8})  # fmt: skip
    stress, volume = "Nominal stress (MPa)", "Share of the volume (%)"
    layout = {
        "yaxis2": {"overlaying": "y", "side": "right", "title": {"text": stress}, "showgrid": False,
                   "rangemode": "tozero", "tickmode": "auto", "automargin": True},
        "yaxis": {"rangemode": "tozero"}, "margin": {"l": 56, "r": 56, "t": 12, "b": 46},
        **_tested(law, end),
    }  # fmt: skip
    table = {"Stretch": curve["x"], stress: curve["y"]}
    return Plot(title, [bars, curve, node], "Stretch", volume, layout, table)


def _tested(law: Law, end: float) -> dict:
    """The range of the test as a band, as far as it is in the picture."""
    tested = law.card.stretch_range
    if not tested:
        return {}
    band = {
        "type": "rect", "xref": "x", "yref": "paper", "x0": 1.0, "x1": min(tested[1], end),
        "y0": 0, "y1": 1, "fillcolor": "@goodpale", "line": {"width": 0}, "layer": "below",
    }  # fmt: skip
    said = {
        "x": min(tested[1], end), "xref": "x", "y": 1, "yref": "paper", "showarrow": False,
        "xanchor": "right", "yanchor": "top", "font": {"color": "@soft", "size": 11},
        "text": f"tested to {labels.number(tested[1])}",
    }  # fmt: skip
    return {"shapes": [band], "annotations": [said]}
