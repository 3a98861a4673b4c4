"""Several result folders in one page: curves over each other, measures, and what was different."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from softact.errors import SpecError
from softact.files.text import csv_text, write_atomic
from softact.report import base, curves, labels, requirements, targets
from softact.report.base import Plot, Section
from softact.results.folder import Results, load, load_name, read
from softact.results.own_folder import Output
from softact.spec.kinds import expect_results
from softact.spec.path import joined, leaves
from softact.verdict.judge import AMBER, GREEN, RED, WORDS, Verdict, judge
from softact.verdict.reached import reached

if TYPE_CHECKING:
    from softact.results.folder import Results


@dataclass(frozen=True)
class Row:
    """A measure of all runs. values: in the column's unit, NaN where a run has none."""

    name: str
    values: tuple[float, ...]

    def differences(self) -> list[float]:
        """Of the runs after the first, each minus the first."""
        return [value - self.values[0] for value in self.values[1:]]

    def percents(self) -> list[float]:
        """The differences in percent of the first run's value; NaN where that is nothing."""
        first = self.values[0]
        if not abs(first) > 1e-9:
            return [float("nan")] * (len(self.values) - 1)
        return [100 * difference / abs(first) for difference in self.differences()]


def write_comparison(
    folders: Sequence[Path],
    directory: Path,
    wanted: Sequence[str] = (),
    force: bool = False,
    warn: Callable[[str], None] = lambda line: None,
) -> Path:
    """Write compare.html, measures.csv and curves.csv into a folder; returns the page's path.

    wanted: names of the applications whose requirements stand beside the runs, see ``targets``.
    force: write whatever the folder holds. warn: called with each line on what is damaged in the
    folders. Raises SpecError where a folder holds no results, or results without a single state,
    for an application that is not known, and where the outcome may not be written there.
    """
    targets.check(wanted)
    runs = _read_all(folders)
    for line in _damages(runs):
        warn(line)
    names = _names(folders)
    aim, rows = measures(runs)
    texts = {
        "measures.csv": lambda: _measures_csv(names, aim, rows),
        "curves.csv": lambda: _curves_csv(names, runs),
        "compare.html": lambda: html(names, runs, wanted),
    }
    output = Output(directory, "compare", force)
    with output.opened(list(texts)):
        for name, text in texts.items():
            write_atomic(output.file(name), text())
    return directory / "compare.html"


def _read_all(folders: Sequence[Path]) -> list[Results]:
    runs, faults = [], []
    for folder in folders:
        try:
            expect_results(folder)
            run = read(folder)
        except SpecError as error:
            faults += error.lines
            continue
        if not len(load(run)):
            faults.append(f"{folder}: the run has no state; there is nothing to compare")
        runs.append(run)
    if len(folders) < 2:
        faults.append("two result folders or more are wanted, such as: softact compare A B")
    if faults:
        raise SpecError(*faults)
    return runs


def _damages(runs: Sequence[Results]) -> list[str]:
    return [line for run in runs for line in (*run.faults, *run.spec_faults)]


def _names(folders: Sequence[Path]) -> list[str]:
    """Names of folders, with as much of their paths as tells them apart."""
    parts = [Path(folder).absolute().parts for folder in folders]
    for depth in range(1, max(map(len, parts)) + 1):
        names = ["/".join(part[-depth:]) for part in parts]
        if len(set(names)) == len(names):
            return names
    return [f"{name} ({number})" for number, name in enumerate(names, 1)]


def measures(runs: Sequence[Results]) -> tuple[float | None, list[Row]]:
    """The load at which the runs are compared, and their measures there.

    The load is the largest that all reach in a stable state; None where they have no pressure in
    common: then the states that stand for them (``reached``) are compared.
    """
    drivers = {load_name(run) for run in runs}
    ends = [float(load(run)[reached(run).main]) for run in runs]
    same = len(drivers) == 1 and None not in drivers and len({np.sign(end) for end in ends}) == 1
    aim = min(ends, key=abs) if same else None
    names = dict.fromkeys(name for run in runs for name in curves.measures(run))
    rows = [
        Row(name, tuple(_value(run, name, aim) for run in runs))
        for name in names
        if not (same and name in drivers)
    ]
    return aim, rows


def _value(run: Results, name: str, aim: float | None) -> float:
    values = run.curve.get(name)
    if values is None or values.dtype != float:
        return float("nan")
    main = reached(run).main
    if aim is None or aim == load(run)[main]:
        return float(values[main])
    return curves.at_load(run, values, aim)


def spec_differences(runs: Sequence[Results]) -> list[tuple[str, list[str]]]:
    """Paths in the resolved specs whose values are not all the same, and the values."""
    flat = [{joined(p): str(value) for p, value in leaves(run.spec)} for run in runs]
    paths = dict.fromkeys(path for spec in flat for path in spec)
    rows = [(path, [spec.get(path, "–") for spec in flat]) for path in paths]
    return [(path, values) for path, values in rows if len(set(values)) > 1]


def html(names: Sequence[str], runs: Sequence[Results], wanted: Sequence[str] = ()) -> str:
    """The page. wanted: see ``write_comparison``."""
    aim, rows = measures(runs)
    verdicts, shapes = [judge(run) for run in runs], _shapes(names, runs)
    sections = [
        *([requirements.section(names, runs, wanted)] if wanted else []),
        Section("measures", "Measures"),
        Section("spec", "What is different in the specs", nav="Specs"),
        Section("curves", "Curves"),
        *([Section("shapes", "Last states")] if shapes else []),
        Section("runs", "Runs"),
    ]
    damages = _damages(runs)
    return base.page(
        "Comparison",
        sections,
        kicker=f"{len(runs)} runs of softact",
        template="report/compare_page.html",
        names=names,
        verdicts=_verdicts(names, verdicts),
        damages=base.banner("warn", "Files are damaged.", "", damages) if damages else "",
        at=_at(runs, aim),
        measures=_measures(names, rows),
        download=base.download("measures.csv", _measures_csv(names, aim, rows).encode()),
        differences=_differences(names, runs),
        curves=base.figures(_plots(names, runs)),
        shapes=shapes,
        runs=_runs(names, runs, verdicts),
    )


def _verdicts(names: Sequence[str], verdicts: Sequence[Verdict]) -> list[Markup]:
    """What is to be thought of the runs that are not simply trusted, the worst colour first."""
    parts = []
    for colour, kind in ((RED, "bad"), (AMBER, "warn")):
        some = [(n, v) for n, v in zip(names, verdicts, strict=True) if v.colour == colour]
        if some:
            words = WORDS[colour]
            items = [(f"{name}:", reason.text) for name, v in some for reason in v.reasons]
            listed = ", ".join(name for name, _ in some)
            head = f"{words[:1].upper()}{words[1:]}:"
            parts.append(base.banner(kind, head, listed, items))
    return parts


def _at(runs: Sequence[Results], aim: float | None) -> str:
    if aim is None:
        return "at the state that stands for each (they have no pressure in common)"
    driver = load_name(runs[0])
    assert driver is not None  # they have a pressure in common
    label = labels.column(driver)
    return f"at {labels.number(aim)} {label.unit}, the largest load that all reach"


def _measures(names: Sequence[str], rows: Sequence[Row]) -> Markup:
    heads = ["Figure", "Unit", *names]
    for name in names[1:]:
        heads += [f"{name} − {names[0]}", "%"]
    shown = []
    for row in rows:
        label = labels.column(row.name)
        scaled = [value * label.factor for value in row.values]
        line = [label.name, label.unit, *(labels.number(value) for value in scaled)]
        for difference, percent in zip(row.differences(), row.percents(), strict=True):
            line += [labels.number(difference * label.factor), _percent(percent)]
        shown.append(line)
    return base.table(heads, shown, numbers=True)


def _percent(value: float) -> str:
    return f"{value:+.1f}".replace("-", "−") if np.isfinite(value) else "–"


def _differences(names: Sequence[str], runs: Sequence[Results]) -> str:
    """A table of what is not the same in the specs; "" where there is nothing."""
    rows = [[path, *values] for path, values in spec_differences(runs)]
    return base.table(["Path", *names], rows, file="spec.csv") if rows else ""


def _plots(names: Sequence[str], runs: Sequence[Results]) -> list[Plot]:
    columns = dict.fromkeys(name for run in runs for name in curves.measures(run))
    drivers = [load_name(run) for run in runs]
    known = {driver for driver in drivers if driver}
    x = str(labels.column(known.pop())) if len(known) == 1 else "Load (kPa, or finished steps)"
    plots = []
    for column in columns:
        if column in drivers:
            continue
        label = labels.column(column)
        traces = [
            base.xy(name, load(run), run.curve[column] * label.factor)
            for name, run in zip(names, runs, strict=True)
            if column in run.curve and run.curve[column].dtype == float
        ]
        plots.append(base.lines(label.name, x, str(label), traces))
    return plots


def _shapes(names: Sequence[str], runs: Sequence[Results]) -> list[tuple[str, Markup]]:
    """The pictures of the runs that have one, with their names."""
    paths = [(name, run.directory / "shape.png") for name, run in zip(names, runs, strict=True)]
    return [(name, base.image(p.read_bytes(), name)) for name, p in paths if p.is_file()]


def _runs(names: Sequence[str], runs: Sequence[Results], verdicts: Sequence[Verdict]) -> Markup:
    heads = [
        "Run",
        "Verdict",
        "Load",
        "Cells",
        "Unknowns",
        "Iterations",
        "Solve (s)",
        "softact",
    ]
    rows = []
    for name, run, verdict in zip(names, runs, verdicts, strict=True):
        facts, driver = run.run, load_name(run)
        at = float(load(run)[reached(run).main])
        unit = labels.column(driver).unit if driver else ""
        rows.append([
            name, verdict.words, f"{labels.number(at)} {unit}".strip(),
            (facts.get("mesh") or {}).get("cells"), (facts.get("mesh") or {}).get("unknowns"),
            sum(int(item.get("iterations") or 0) for item in facts.get("history") or []),
            (facts.get("times_s") or {}).get("solve"), str(facts.get("softact") or ""),
        ])  # fmt: skip
    marks = [{GREEN: "good", AMBER: "warn", RED: "bad"}[verdict.colour] for verdict in verdicts]
    return base.table(heads, rows, marks=marks)


def _measures_csv(names: Sequence[str], aim: float | None, rows: Sequence[Row]) -> str:
    table = []
    for row in rows:
        line = {"measure": row.name, "load_kPa": "" if aim is None else aim}
        line |= dict(zip(names, row.values, strict=True))
        extras = zip(names[1:], row.differences(), row.percents(), strict=True)
        for name, difference, percent in extras:
            line |= {f"{name} minus {names[0]}": difference, f"{name} difference_%": percent}
        table.append(line)
    return csv_text(table)


def _curves_csv(names: Sequence[str], runs: Sequence[Results]) -> str:
    table = []
    for name, run in zip(names, runs, strict=True):
        count = len(load(run))
        table += [{"run": name} | {k: v[n] for k, v in run.curve.items()} for n in range(count)]
    return csv_text(table)
