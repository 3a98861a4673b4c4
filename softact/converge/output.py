"""The outcome of a convergence study as files, and its error bars in a result folder."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

from softact.converge.study import Convergence
from softact.errors import SpecError
from softact.report import base, labels
from softact.report.base import Section
from softact.results import csv_text, json_text, write_atomic

MESH_ERROR = "mesh_error.json"


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


def write(study: Convergence, name: str, directory: Path) -> Path:
    """Write converge.csv, converge.json and converge.html; returns the page's path."""
    table = rows(study)
    write_atomic(directory / "converge.csv", csv_text(table))
    write_atomic(directory / "converge.json", json_text(summary(study)))
    page = directory / "converge.html"
    write_atomic(page, html(study, name, table))
    return page


def advice(study: Convergence) -> str:
    """One line: which mesh to use."""
    level = study.recommended
    within = f"within {study.tolerance:.3g} of the limit".replace("0.05 ", "5 % ")
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
        ["Measure", "Mesh of the spec", "Error bar", "Limit (Richardson)", "Order", "Note"],
        [
            (str(labels.column(m)), study.values(m)[0] * f, e.errors[0] * f, e.limit * f,
             "none" if e.order is None else f"{e.order:.2f}", e.note)
            for m in study.measures
            for e, f in [(study.estimate(m), labels.column(m).factor)]
        ],
    )  # fmt: skip
    heads = list(dict.fromkeys(head for row in table for head in row))
    meshes = base.table(heads, [[row[h] for h in heads] for row in table], file="converge.csv")
    sections = [
        Section("estimates", "What the mesh of the spec is worth", estimates),
        Section("plots", "Measures over the mesh", base.figures(plots)),
        Section("meshes", "Meshes", meshes),
    ]
    lead = base.banner(kind, "Mesh:", f"{advice(study)}.")
    return base.page(
        name, sections, kicker="Mesh convergence of a soft actuator", kind="convergence", lead=lead
    )


def _plot(study: Convergence, measure: str) -> base.Plot:
    label, e = labels.column(measure), study.estimate(measure)
    edges = [level.edge for level in study.levels]
    values = [value * label.factor for value in study.values(measure)]
    bars = {"type": "data", "array": [error * label.factor for error in e.errors]}
    limit = e.limit * label.factor
    name = "limit (Richardson)" if e.order is not None else "finest mesh"
    traces = [
        base.xy("computed", edges, values, error_y=bars),
        base.xy(name, [0, max(edges)], [limit, limit], mode="lines", line={"dash": "dash"}),
    ]
    layout = {"xaxis": {"rangemode": "tozero"}}
    return base.lines(label.name, "Edge of a tetrahedron's cube (mm)", str(label), traces,
                      layout=layout)  # fmt: skip


def carry_into(study: Convergence, directory: Path) -> str:
    """Write the error bars of the mesh that a result folder was computed on into that folder.

    summary.csv gets a column ``<measure>_mesh_error`` for each measure, mesh_error.json the whole
    story. Returns a line that says so. Raises SpecError where the folder is of another spec.
    """
    path = directory / "run.json"
    try:
        spec_hash = json.loads(path.read_text())["spec_hash"]
    except (OSError, ValueError, KeyError):
        raise SpecError(f"{directory}: no result folder of softact") from None
    hashes = [level.spec.hash for level in study.levels]
    if spec_hash not in hashes:
        raise SpecError(f"{directory}: computed from another spec than the meshes of this study")
    level = hashes.index(spec_hash)
    bars = {m: study.estimate(m).errors[level] for m in study.measures}
    summary_file = directory / "summary.csv"
    with io.StringIO(summary_file.read_text()) as file:
        row = next(csv.DictReader(file))
    row |= {f"{measure}_mesh_error": bar for measure, bar in bars.items()}
    write_atomic(summary_file, csv_text([row]))
    write_atomic(directory / MESH_ERROR, json_text({"error_bars": bars, **summary(study)}))
    return f"error bars: {summary_file}"
