"""What ``softact rod`` writes: the curve and a page."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from markupsafe import Markup

from softact.files.text import csv_text, write_atomic
from softact.modules.chain import Row
from softact.modules.rod_run import RodRun
from softact.modules.table import GOOD, Table
from softact.report import base, labels
from softact.report.base import Plot, Section
from softact.results.own_folder import Output

FILES = ("curve.csv", "rod.html")
SHAPES = 6  # at most, in the picture
FLAT = 1e-3  # mm: a line in one plane
STEEP = 25.0  # % of change of curvature by module; 23% was compared with whole runs
SAID = ("bending_angle_deg", "tip_x_mm", "tip_z_mm", "blocked_force_N", "cavity_volume_mm3")


def write(found: RodRun, table: Table, name: str, output: Output) -> Path:
    """Write ``FILES``; returns the page's path. A rod without any state has no curve."""
    csv, page = map(output.file, FILES)
    write_atomic(csv, csv_text(found.rows))
    write_atomic(page, html(found, table, name))
    return page


def html(found: RodRun, table: Table, name: str) -> str:
    """The page: how the rod stands, what it does over the load, what the law is worth."""
    sections = [
        Section("shapes", "How it stands", base.figures(_shapes(found)), "Shapes"),
        Section("plots", "Over the load", base.figures(_plots(found)), "Plots"),
        Section("table", "All states", _table(found.rows), "Table"),
        Section("law", "The law of the rod", base.note(law(table)), "Law"),
    ]
    return base.page(
        name, sections, kicker="A rod of modules", kind="rod", lead=_lead(found, table)
    )


def _lead(found: RodRun, table: Table) -> Markup:
    said = warnings(found, table)
    if not said:
        return Markup("")
    return base.banner("bad" if found.stopped else "warn", "Look at this first", "", said)


def warnings(found: RodRun, table: Table) -> list[str]:
    """What is to be thought of it, where that is anything."""
    said = [found.stopped] if found.stopped else []
    worst = int(table.errors.argmax())
    if table.errors[worst] > GOOD:
        what = labels_of(table.energy.names[worst])
        said.append(
            "at states of the module that were held out the law is off by up to "
            f"{100 * table.errors[worst]:.2g}% of the largest ({what})"
        )
    if not table.ends.known:
        said.append(
            "what the two ends of the actuator take from its bending is not known for this "
            "geometry: they count as modules, and the angle may be some percent too large"
        )
    steepest = max((float(row["curvature_change_percent"]) for row in found.rows), default=0.0)
    if steepest > STEEP:
        said.append(
            f"the curvature changes by up to {steepest:.0f}% of its largest from module to module; "
            f"above {STEEP:.0f}% a module no longer stands for its place: solve the whole actuator"
        )
    return said


def law(table: Table) -> str:
    """What the law was made from, and its errors."""
    walked = table.walked
    ends = "What the two ends take from the bending is not known here. "
    if table.ends.known:
        idle = table.ends.idle
        ends = (
            f"By a short actuator the two ends are as {table.ends.stiff:.2f} modules that do not "
            f"bend under a force, and {idle.min():.2f} to {idle.max():.2f} under the pressure. "
        )
    names = [labels_of(name) for name in table.energy.names]
    off = ", ".join(
        f"{100 * value:.2g}% ({name})" for name, value in zip(names, table.errors, strict=True)
    )
    return (
        f"An energy of degree {table.degree} over {len(names)} variables, fitted to the first and "
        f"second derivatives at {len(walked.samples.places)} states of one module ({walked.lost} "
        "more had no equilibrium). At states that were held out its derivatives were off by at "
        f"most, of their largest values: {off}. {ends}Where the spec has contact, a "
        "module touches the next ones; nothing else of the rod meets itself."
    )


def labels_of(name: str) -> str:
    """The conjugate of a variable of the energy: what is written for its derivative."""
    kind, _, which = name.partition("_")
    said = {"curvature": "moment about", "force": "stretch along", "pressure": "air"}[kind]
    return f"{said} {which}".strip()


def _shapes(found: RodRun) -> list[Plot]:
    if not found.rows:
        return []
    chosen = np.unique(np.linspace(0, len(found.rows) - 1, SHAPES).round().astype(int))
    traces, beside, bent = [], [], []
    for number in chosen:
        row, line = found.rows[number], found.lines[number]
        title = f"{row['step']}, {labels.number(pressure(row))} kPa"
        traces.append(base.xy(title, line[:, 0], line[:, 2], mode="lines"))
        beside.append(base.xy(title, line[:, 0], line[:, 1], mode="lines"))
        curved = np.linalg.norm(found.strains[number][:, :3], axis=1)
        parts = (np.arange(len(curved)) + 0.5) / len(curved)
        bent.append(base.xy(title, parts, 1e3 * curved, mode="lines"))
    shown = [base.lines("Line of the rod", "x (mm)", "z (mm)", traces, equal=True)]
    if max(np.ptp(line[:, 1]) for line in found.lines) > FLAT:
        shown.append(base.lines("The same from above", "x (mm)", "y (mm)", beside, equal=True))
    curvature = base.lines("Curvature along it", "Part of the length", "Curvature (1/m)", bent)
    return [*shown, curvature]


def pressure(row: Row) -> float:
    """The largest of a state, kPa."""
    found = [float(v) for n, v in row.items() if n.startswith("pressure")]
    return max(found, key=abs)


def _plots(found: RodRun) -> list[Plot]:
    if not found.rows:
        return []
    timed = "time_s" in found.rows[0]
    along = [float(row["time_s"]) if timed else pressure(row) for row in found.rows]
    below = "Time (s)" if timed else "Pressure (kPa)"
    plots = []
    for name in SAID:
        if name in found.rows[0]:
            label = labels.column(name)
            values = [float(row[name]) * label.factor for row in found.rows]
            trace = base.xy(str(label.name), along, values)
            plots.append(base.lines(str(label.name), below, str(label), [trace]))
    return plots


def _table(rows: list[Row]) -> Markup:
    if not rows:
        return base.note("There is no state.")
    heads = [str(labels.column(name)) for name in rows[0]]
    shown = [
        [v if isinstance(v, str) else v * labels.column(n).factor for n, v in row.items()]
        for row in rows
    ]
    return base.table(heads, shown, file="curve.csv")


def lines(found: RodRun, table: Table) -> list[str]:
    """What the last state says, in a few lines."""
    if not found.rows:
        return warnings(found, table)
    last, said = found.rows[-1], []
    for name in SAID:
        if name in last:
            label = labels.column(name)
            value = labels.number(float(last[name]) * label.factor)
            said.append(f"  {label.name}: {value} {label.unit}".rstrip())
    at = f"at {labels.number(pressure(last))} kPa:"
    return [*(f"rod: {text}" for text in warnings(found, table)), at, *said]
