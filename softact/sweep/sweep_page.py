"""sweep.html: the results of a study on one page that needs no network."""

from __future__ import annotations

import base64
import gzip
import json
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from softact.report import base, labels
from softact.report.base import Section
from softact.report.curves import is_place
from softact.results.folder import COMPLETE
from softact.sweep import force_map, shape, workspace
from softact.sweep.record import Record
from softact.sweep.study import Study
from softact.sweep.table import Row, measure_columns
from softact.sweep.trends import TrendFound

MOST_CURVES = 300
MOST_SHAPES = 150
MOST_FAILURES = 200


def html(
    study: Study, table: list[Row], csv: bytes, verdicts: list[TrendFound], more: Sequence[Section]
) -> str:
    """The page. table: ``table.rows``, csv: the same as a file; more: further sections, such as
    indices."""
    sweep = study.sweep
    sections = [
        *trends(verdicts),
        *more,
        *workspace.sections(table),
        *force_map.sections(_records(study)),
        Section("pareto", "Two measures, and the points that none beats", nav="Pareto front"),
        Section("curvesection", "Curves"),
        Section("effectsection", "Main effects"),
        Section("parallelsection", "Parallel coordinates"),
        *failures(table),
    ]
    return base.page(
        sweep.name,
        sections,
        kicker="Sweep over the spec of a soft actuator",
        kind="sweep",
        data={"packed": packed(page_data(study, table))},
        template="sweep/sweep_page.html",
        study=sweep,
        points=points_banner(table),
        download=base.download("sweep.csv", csv, text="All rows as CSV"),
    )


def _records(study: Study) -> list[Record]:
    answers = {point.key: study.answer(point) for point in study.points}
    return [answer.record for answer in answers.values() if answer and answer.record]


def packed(data: Any) -> str:
    """Base64 of gzip of JSON, for data that are large."""
    raw = json.dumps(data, separators=(",", ":"), allow_nan=False).encode()
    return base64.b64encode(gzip.compress(raw, 6, mtime=0)).decode()


def points_banner(table: list[Row]) -> Markup:
    """How many points ended how."""
    counts = Counter(str(row["status"]) for row in table)
    words = {"complete": "complete", "no_equilibrium": "without equilibrium before the last load",
             "failed": "failed", "invalid_spec": "with a spec that cannot be built",
             "missing": "not computed yet"}  # fmt: skip
    said = ", ".join(f"{counts[name]} {text}" for name, text in words.items() if counts[name])
    kind = "good" if set(counts) == {COMPLETE} else "warn"
    doubted = [row for row in table if str(row.get("verdict", "")).startswith("amber")]
    lists = [str(row["verdict"]).partition(": ")[2].split(", ") for row in doubted]
    kinds = Counter(kind for some in lists for kind in some)
    items = [
        f"{len(doubted)} of them are solved, but not simply to be trusted "
        f"({', '.join(f'{kind}: {count}' for kind, count in kinds.most_common())}): the column "
        "verdict of sweep.csv says which"
    ]
    kind = "warn" if doubted else kind
    return base.banner(kind, f"{len(table)} points:", f"{said}.", items if doubted else ())


def trends(verdicts: list[TrendFound]) -> list[Section]:
    """The expected trends and what was seen; no section where none is named."""
    marks = {True: "holds", False: "does not hold", None: "cannot be told"}
    rows = [(v.text, marks[v.holds], v.trend.source) for v in verdicts]
    body = base.table(["Trend", "Verdict", "Source"], rows)
    return [Section("trends", "Expected trends", body)] if rows else []


def failures(table: list[Row]) -> list[Section]:
    """The points that are not complete, with their causes; no section where there is none."""
    bad = [row for row in table if row["status"] != COMPLETE]
    rows = [
        (f"{row['point']}", str(row["status"]).replace("_", " "), str(row["cause"]))
        for row in bad[:MOST_FAILURES]
    ]
    body = base.table(["Point", "Status", "Cause"], rows)
    if len(bad) > MOST_FAILURES:
        body += base.note(f"The first {MOST_FAILURES} of {len(bad)}.")
    return [Section("failures", "Points that are not complete", body)] if rows else []


def page_data(study: Study, table: list[Row]) -> dict:
    """What sweep.js draws: columns, curves and shapes."""
    measures = shown_measures(table, study)
    shapes, curves = {}, {}
    for number in chosen(table, MOST_SHAPES):
        if found := shape.load(study.cache.folder(str(table[number]["run"]))):
            shapes[number] = found
    names = curve_columns(study, measures)
    for number in chosen(table, MOST_CURVES):
        if (record := study.answers[str(table[number]["run"])].record) is None:
            continue  # it cannot be: only points with a run are chosen
        columns = [record.curve(n) if n in record.columns else None for n in names]
        curves[number] = [None if c is None else _numbers(c) for c in columns]
    return {
        "axes": [_column(table, axis.column, axis.title, axis.unit, axis.is_number)
                 for axis in study.sweep.axes],
        "measures": [_measure(table, name) for name in measures],
        "wanted": [[o.measure, o.sign] for o in study.sweep.objectives],
        "status": [row["status"] for row in table],
        "run": [row["run"] for row in table],
        "texts": [point.text() for point in study.points],
        "options": [" ".join(point.options()) for point in study.points] if len(table) < 2000
        else [],
        "cache": str(study.cache.directory),
        "curves": {"columns": [_label(name) for name in names], "names": names, "of": curves},
        "shapes": shapes,
    }  # fmt: skip


def shown_measures(table: list[Row], study: Study) -> list[str]:
    """Measures that are numbers and differ from point to point, places left out."""
    names = measure_columns(table, study)
    found = []
    for name in names:
        values = [row.get(name) for row in table]
        finite = [v for v in values if isinstance(v, float) and math.isfinite(v)]
        spread = max(finite, default=0.0) - min(finite, default=0.0)
        largest = max(map(abs, finite), default=0.0)
        if spread > 1e-9 * max(largest, 1.0) and not is_place(name, names):
            found.append(name)
    return sorted(found, key=_interest)


def _interest(name: str) -> int:
    first = ("efficiency", "bending_angle", "tip_", "elongation", "twist", "reaction", "blocked",
             "cavity_vol", "max_principal_stress", "max_principal_stretch")  # fmt: skip
    return next((n for n, start in enumerate(first) if name.startswith(start)), len(first))


def curve_columns(study: Study, measures: list[str]) -> list[str]:
    """Columns of the curves on the page: loads first, then the measures."""
    records = [a.record for a in study.answers.values() if a.record is not None]
    names = dict.fromkeys(name for record in records[:50] for name in record.columns)
    loads = [name for name in names if name.startswith("pressure") and name.endswith("_kPa")]
    loads = loads or [name for name in names if name == "step_fraction"]
    return [*loads, *(m for m in measures if m in names and m not in loads)][:24]


def chosen(table: list[Row], most: int) -> list[int]:
    """Points with a run, evenly thinned where there are more than ``most``."""
    there = [n for n, row in enumerate(table) if row["status"] in (COMPLETE, "no_equilibrium")]
    return thinned(there, most)


def thinned(some: Sequence[int], most: int) -> list[int]:
    """``most`` of the numbers, evenly chosen; all where there are no more."""
    if len(some) <= most:
        return list(some)
    places = np.unique(np.linspace(0, len(some) - 1, most).round().astype(int))
    return [some[place] for place in places]


def _numbers(values: Iterable[float]) -> list[float | None]:
    return [float(f"{v:.6g}") if math.isfinite(v) else None for v in values]


def _column(table: list[Row], name: str, title: str, unit: str, is_number: bool) -> dict:
    cells: list[float | str | None] = [row.get(name, "") for row in table]
    if is_number:
        cells = [c if isinstance(c, float) and math.isfinite(c) else None for c in cells]
    label = f"{title} ({unit})" if unit else title
    return {"name": name, "label": label, "number": is_number, "values": cells}


def _label(name: str) -> str:
    return str(labels.column(name))


def _measure(table: list[Row], name: str) -> dict:
    factor = labels.column(name).factor
    cells = [row.get(name) for row in table]
    numbers = [c if isinstance(c, float) and math.isfinite(c) else None for c in cells]
    values = [None if c is None else float(f"{c * factor:.7g}") for c in numbers]
    return {"name": name, "label": _label(name), "values": values}
