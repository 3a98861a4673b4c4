"""The outcome of a convergence study as files."""

from __future__ import annotations

from pathlib import Path

from softact.converge.richardson import SAFETY
from softact.converge.study import Convergence
from softact.files import csv_text, json_text, write_atomic
from softact.output import Output
from softact.report import base, labels, mesh_error
from softact.report.base import Section

_CELL_SIZE = (
    "<p class='note'>Mean cell size: edge of the cube that holds, on average, one tetrahedron. "
    "The order is measured over it.</p>"
)


def rows(study: Convergence) -> list[dict[str, float | str]]:
    """A row for each mesh: sizes, cells, unknowns, seconds, the measures and their error bars."""
    estimates = {measure: study.estimate(measure) for measure in study.measures}
    found = []
    for number, level in enumerate(study.levels):
        row: dict[str, float | str] = {f"{name}_mm": size for name, size in level.sizes.items()}
        row |= {"cells": level.record.cells, "unknowns": level.record.unknowns}
        row |= {"edge_mm": level.edge, "seconds": level.record.seconds, "run": level.record.key}
        for measure, e in estimates.items():
            row[measure] = level.record.measures[measure]
            row[f"{measure}_error"] = e.errors[number]
            row[f"{measure}_change"] = e.changes[number - 1] if number else ""
        found.append(row)
    return found


def summary(study: Convergence) -> dict:
    """The study in plain data: what converge.json holds."""
    advice = study.recommended
    return {
        "tolerance": study.tolerance,
        "converged": study.converged,
        "recommended_mm": dict(advice.sizes) if advice else None,
        "levels": [
            {"sizes_mm": dict(level.sizes), "spec_hash": level.spec.hash, "edge_mm": level.edge}
            for level in study.levels
        ],
        "measures": {
            measure: {
                "values": study.values(measure),
                "limit": e.limit,
                "order": e.order,
                "note": e.note,
                "error_bars": list(e.errors),
            }
            for measure in study.measures
            for e in [study.estimate(measure)]
        },
    }


FILES = ("converge.csv", "converge.json", "converge.html")


def write(study: Convergence, name: str, output: Output) -> Path:
    """Write ``FILES``; returns the page's path."""
    table = rows(study)
    csv, numbers, page = map(output.file, FILES)
    write_atomic(csv, csv_text(table))
    write_atomic(numbers, json_text(summary(study)))
    write_atomic(page, html(study, name, table))
    return page


def advice(study: Convergence) -> str:
    """One line: which mesh to use."""
    level = study.recommended
    within = f"within {100 * study.tolerance:.3g} % of the limit"
    if level is None:
        return (
            f"no mesh here is {within} for every measure; allow more meshes (--most) or a larger "
            "tolerance"
        )
    sizes = ", ".join(f"{name} {size:g} mm" for name, size in level.sizes.items())
    return f"use {sizes}: {within} for every measure, {level.record.seconds:.1f} s a run"


def told(study: Convergence) -> list[str]:
    """One line for each measure: limit, order, error bar of the coarsest mesh."""
    lines = []
    for measure in study.measures:
        e, coarse = study.estimate(measure), study.values(measure)[0]
        order = f"order {e.order:.2f}" if e.order is not None else f"no order: {e.note}"
        lines.append(
            f"{measure}: {coarse:.5g} ± {e.errors[0]:.2g} on the mesh of the spec; limit "
            f"{e.limit:.5g} ({order})"
        )
    return lines


def html(study: Convergence, name: str, table: list[dict]) -> str:
    """The page: a plot with error bars for each measure, the estimates and all meshes."""
    plots = [_plot(study, measure) for measure in study.measures]
    kind = "good" if study.recommended else "warn"
    estimates = base.table(
        ["Measure", "Mesh of the spec", "Error bar", "Limit", "Order", "Note"],
        [
            (str(labels.column(m)), study.values(m)[0] * f, e.errors[0] * f, e.limit * f,
             "none" if e.order is None else f"{e.order:.2f}", e.note)
            for m in study.measures
            for e, f in [(study.estimate(m), labels.column(m).factor)]
        ],
    )  # fmt: skip
    sections = [
        Section("estimates", "What the mesh of the spec is worth",
                estimates + mesh_error.note(SAFETY), "Error bars"),
        Section("plots", "Measures over the mesh", base.figures(plots) + _CELL_SIZE, "Plots"),
        Section("meshes", "Meshes", _meshes(study, table)),
    ]  # fmt: skip
    lead = base.banner(kind, "Mesh:", f"{advice(study)}.")
    return base.page(
        name, sections, kicker="Mesh convergence of a soft actuator", kind="convergence", lead=lead
    )


def _meshes(study: Convergence, table: list[dict]) -> str:
    shown = {"edge_mm": "Mean cell size (mm)", "cells": "Tetrahedra", "seconds": "Run (s)"}
    heads = {name: shown.get(name, str(labels.column(name))) for name in table[0]}
    factors = {name: 1.0 for name in heads}
    for measure in study.measures:
        label = labels.column(measure)
        heads |= {measure: str(label), f"{measure}_error": "±", f"{measure}_change": "Change (%)"}
        factors |= {measure: label.factor, f"{measure}_error": label.factor}
        factors[f"{measure}_change"] = 100.0
    names = [*(name for name in heads if name != "run"), "run"]
    rows = [
        [row[n] if isinstance(row[n], str) else row[n] * factors[n] for n in names] for row in table
    ]
    link = base.download("converge.csv", csv_text(table).encode())
    return f"{base.table([heads[n] for n in names], rows)}<p class='note'>{link}</p>"


def _plot(study: Convergence, measure: str) -> base.Plot:
    label, e = labels.column(measure), study.estimate(measure)
    edges = [level.edge for level in study.levels]
    values = [value * label.factor for value in study.values(measure)]
    bars = {"type": "data", "array": [error * label.factor for error in e.errors]}
    limits = [e.limit * label.factor] * len(edges)
    name = "limit (Richardson)" if e.order is not None else "finest mesh"
    traces = [
        base.xy("computed", edges, values, error_y=bars),
        base.xy(name, [0, max(edges)], limits[:2], mode="lines", line={"dash": "dash"}),
    ]
    x, layout = "Mean cell size (mm)", {"xaxis": {"rangemode": "tozero"}}
    table = {x: edges, str(label): values, f"Error bar of {label}": bars["array"], name: limits}
    return base.lines(label.name, x, str(label), traces, layout=layout, table=table)
