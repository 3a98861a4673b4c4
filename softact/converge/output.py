"""The outcome of a convergence study as files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

from markupsafe import Markup

from softact.converge.richardson import FINER, SAFETY
from softact.converge.study import NOT_CONVERGED, Convergence
from softact.files.text import csv_text, json_text, write_atomic
from softact.report import base, labels, mesh_error
from softact.report.base import Section
from softact.results.own_folder import Output

Row: TypeAlias = dict[str, float | str]
_UNKNOWN = "not known"


def rows(study: Convergence) -> list[Row]:
    """A row for each mesh: sizes, cells, unknowns, seconds, whether it counts, the measures and
    their error bars and changes, empty where they are not known."""
    estimates = {measure: study.estimate(measure) for measure in study.measures}
    found = []
    for number, level in enumerate(study.levels):
        row: Row = {f"{name}_mm": size for name, size in level.sizes.items()}
        row |= level.steps
        row |= {"cells": level.record.cells, "unknowns": level.record.unknowns}
        row |= {"edge_mm": level.edge, "seconds": level.record.seconds, "run": level.record.key}
        row["counts"] = "yes" if number in study.counting else "no"
        for measure, e in estimates.items():
            row[measure] = level.record.measures[measure]
            row[f"{measure}_error"] = _or_empty(e.errors[number])
            row[f"{measure}_change"] = _or_empty(e.changes[number])
        found.append(row)
    return found


def _or_empty(value: float | None) -> float | str:
    return "" if value is None else value


def summary(study: Convergence) -> dict[str, Any]:
    """The study in plain data: what converge.json holds, and mesh_error.json under the same
    names. docs/sweeps.md says what they mean."""
    advice = study.recommended
    return {
        "tolerance": study.tolerance,
        "verdict": study.verdict(),
        "converged": study.converged,
        "stopped": study.stopped,
        "recommended": study.levels.index(advice) if advice else None,
        "recommended_mm": advice.sizes if advice else None,
        "levels": [
            {
                "mesh": str(level),
                "sizes_mm": level.sizes,
                "steps": level.steps,
                "spec_hash": level.spec.hash,
                "cells": level.record.cells,
                "edge_mm": level.edge,
                "counts": number in study.counting,
            }
            for number, level in enumerate(study.levels)
        ],
        "measures": {
            measure: {
                "values": study.values(measure),
                "verdict": study.verdict_of(measure),
                "limit": e.limit,
                "order": e.order,
                "note": e.note,
                "error_bars": list(e.errors),
                "changes": list(e.changes),
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


def advice(study: Convergence, called: Callable[[str], str] = str) -> str:
    """One line: which mesh to use, or what is known instead. called: what a measure's column is
    called in it."""
    within = f"within {100 * study.tolerance:.3g} % of the limit"
    level, verdict = study.recommended, study.verdict()
    if level is not None:
        return f"use {level}: {within} for every measure, {level.record.seconds:.1f} s a run"
    measures = [m for m in study.measures if study.verdict_of(m) == verdict]
    said = "; ".join(f"{called(m)}: {_why(study, m)}" for m in measures)
    if study.stopped:
        return f"{verdict}: {said}; the next mesh was not solved: {study.stopped}"
    return (
        f"{verdict}: no mesh here is known to be {within} for every measure ({said}); allow more "
        f"meshes (--most) or {_tolerance(verdict)}"
    )


def _tolerance(verdict: str) -> str:
    """What to do about the tolerance: a smaller one asks for finer meshes."""
    return f"a {'larger' if verdict == NOT_CONVERGED else 'smaller'} --tolerance"


def _why(study: Convergence, measure: str) -> str:
    """Why the finest mesh is not known to be good enough for a measure."""
    e = study.estimate(measure)
    if e.errors[-1] is not None and e.limit:
        return f"error bar {e.errors[-1] / abs(e.limit):.2g} of the limit on the finest mesh"
    moved = "" if e.last_change is None else f"{100 * e.last_change:.2g} % in the last step, "
    return f"{moved}{e.note}"


def limit_lines(study: Convergence) -> list[str]:
    """One line for each measure: limit, order, error bar of the coarsest mesh."""
    lines = []
    for measure in study.measures:
        e, coarse = study.estimate(measure), study.values(measure)[0]
        if e.limit is None:
            lines.append(
                f"{measure}: {coarse:.5g} on the mesh of the spec; error and limit not known "
                f"({e.note})"
            )
            continue
        order = f"order {e.order:.2f}" if e.order is not None else e.note
        lines.append(
            f"{measure}: {coarse:.5g} ± {e.errors[0]:.2g} on the mesh of the spec; limit "
            f"{e.limit:.5g} ({order})"
        )
    return lines


def html(study: Convergence, name: str, table: list[Row]) -> str:
    """The page: a plot with error bars for each measure, the estimates and all meshes."""
    heads = ["Measure", "Mesh of the spec", "Error bar", "Limit", "Order", "Finest mesh", "Note"]
    sections = [
        Section("estimates", "What the mesh of the spec is worth", nav="Error bars"),
        Section("plots", "Measures over the mesh", nav="Plots"),
        Section("meshes", "Meshes"),
    ]
    kind, head = mesh_error.HEADS[study.verdict()]
    return base.page(
        name,
        sections,
        kicker="Mesh convergence of a soft actuator",
        kind="convergence",
        template="converge/converge_page.html",
        verdict=base.banner(kind, head, f"{_sentence(study)}."),
        estimates=base.table(heads, [_estimates(study, measure) for measure in study.measures]),
        error_bar=mesh_error.note(SAFETY),
        plots=base.figures(_plot(study, measure) for measure in study.measures),
        finer=f"{FINER:g}",
        meshes=_meshes(study, table),
        download=base.download("converge.csv", csv_text(table).encode()),
    )


def _sentence(study: Convergence) -> str:
    said = advice(study, mesh_error.spoken)
    said = said.removeprefix(f"{study.verdict()}: ")
    return said[0].upper() + said[1:]


def _estimates(study: Convergence, measure: str) -> tuple[str | float, ...]:
    label, e = labels.column(measure), study.estimate(measure)
    bar, limit = (_UNKNOWN if x is None else x * label.factor for x in (e.errors[0], e.limit))
    order = "none" if e.order is None else f"{e.order:.2f}"
    verdict = mesh_error.words(study.verdict_of(measure), study.tolerance)
    return str(label), study.values(measure)[0] * label.factor, bar, limit, order, verdict, e.note


def _meshes(study: Convergence, table: list[Row]) -> Markup:
    shown = {"edge_mm": "Mean cell size (mm)", "cells": "Elements", "seconds": "Run (s)"}
    shown |= {"counts": "Counts"} | {
        n: n.replace("_", " ").capitalize() for n in study.levels[0].steps
    }
    heads = {name: shown.get(name, str(labels.column(name))) for name in table[0]}
    factors = {name: 1.0 for name in heads}
    for measure in study.measures:
        label = labels.column(measure)
        heads |= {measure: str(label), f"{measure}_error": "±", f"{measure}_change": "Change (%)"}
        factors |= {measure: label.factor, f"{measure}_error": label.factor}
        factors[f"{measure}_change"] = 100.0
    names = [*(name for name in heads if name != "run"), "run"]
    rows = [[_scaled(row[n], factors[n]) for n in names] for row in table]
    return base.table([heads[n] for n in names], rows)


def _scaled(value: float | str, factor: float) -> float | str:
    return value if isinstance(value, str) else value * factor


def _plot(study: Convergence, measure: str) -> base.Plot:
    label, e = labels.column(measure), study.estimate(measure)
    edges = [level.edge for level in study.levels]
    values = [value * label.factor for value in study.values(measure)]
    x, layout = "Mean cell size (mm)", {"xaxis": {"rangemode": "tozero"}}
    table: dict[str, list[float]] = {x: edges, str(label): values}
    if e.limit is None:
        traces = [base.xy("computed", edges, values)]
        note = f"No error bars: {e.note}."
        return base.lines(label.name, x, str(label), traces, layout=layout, table=table, note=note)
    bars = [error * label.factor for error in e.errors if error is not None]
    limit = e.limit * label.factor
    name = "limit (Richardson)" if e.order is not None else "value of all meshes"
    traces = [
        base.xy("computed", edges, values, error_y={"type": "data", "array": bars}),
        base.xy(name, [0, max(edges)], [limit, limit], mode="lines", line={"dash": "dash"}),
    ]
    table |= {f"Error bar of {label}": bars, name: [limit] * len(edges)}
    return base.lines(label.name, x, str(label), traces, layout=layout, table=table)
