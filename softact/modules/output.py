"""What ``softact module`` writes: a table, a picture, a page."""

from __future__ import annotations

from pathlib import Path

from markupsafe import Markup

from softact.files.text import csv_text, write_atomic
from softact.measures.longer_waves import NAME as WAVES
from softact.modules import picture
from softact.modules.study import BEFORE, Row, Study
from softact.report import base, labels
from softact.report.base import Plot, Section
from softact.report.frames import DrawingError
from softact.results.folder import load, load_name, load_text
from softact.results.own_folder import Output
from softact.verdict.judge import AMBER, from_data

FILES = ("module.csv", "module.html", "chain.png")
PLOTS = {  # title -> beginnings of the columns that it shows
    "Angle of a module": ("module_angle_",),
    "Stretch of a module": ("module_stretch_",),
    "Air of a module": ("module_cavity_volume",),
    "Moment of a blocked module": ("blocked_moment_",),
    "Force of a blocked module": ("blocked_force_",),
    "Stiffness against bending and twist": ("module_stiffness_curvature_{0}_curvature_{0}",),
    "Stiffness against stretch and shear": ("module_stiffness_stretch_{0}_stretch_{0}",),
}
NO_CONTACT = "Without contact in the spec a module passes through its neighbours, unseen."
NOTHING = 1e-9  # a column of less shows rounding


def write(study: Study, name: str, output: Output) -> Path:
    """Write ``FILES``; returns the page's path."""
    table = study.rows()
    csv, page, png = map(output.file, FILES)
    write_atomic(csv, csv_text(table))
    shown = Markup("")
    try:
        drawn = max(1, min(round(study.modules) or 6, picture.MOST_DRAWN))
        data = picture.chain(study.free, len(table) - 1, drawn)
        write_atomic(png, data)
        title = f"{drawn} modules at {load_text(study.free, len(table) - 1)}"
        shown = base.image(data, title)
    except DrawingError as error:
        shown = base.note(f"There is no picture: {error}.")
    write_atomic(page, html(study, name, table, shown))
    return page


def html(study: Study, name: str, table: list[Row], shown: Markup) -> str:
    """The page: what a module does over the pressure, its cross-section, a chain of them."""
    sections = [
        Section("plots", "A module over the load", base.figures(_plots(study, table)), "Plots"),
        Section("table", "All states", _table(table), "Table"),
        Section("limits", "What this leaves out", base.note(_limits(study)), "Limits"),
    ]
    return base.page(
        name,
        [Section("chain", "A chain of modules", shown, "Chain"), *sections],
        kicker="One module of a soft actuator",
        kind="module",
        lead=_verdict(study) + _cards(table[-1]),
    )


def _verdict(study: Study) -> Markup:
    """What is to be thought of the free module's run, where that is anything."""
    verdict = from_data(study.free.run.get("verdict"))
    if verdict is None or not verdict.reasons:
        return Markup("")
    kind = "warn" if verdict.colour == AMBER else "bad"
    reasons = [reason.text for reason in verdict.reasons]
    said = "" if study.free.spec.get("contact") else NO_CONTACT
    return base.banner(kind, f"The free module: {verdict.words}", said, reasons)


def _cards(last: Row) -> Markup:
    """The figures of the last state."""
    names = [
        name
        for name, value in last.items()
        if name.startswith(("module_angle_", "actuator_angle_", "module_stretch_", "blocked_"))
        and _counts(value)
    ]
    cards = [base.card(*_shown(name, float(last[name]))) for name in names]
    return Markup("<div class='cards'>{}</div>").format(Markup("").join(cards))


def _shown(name: str, value: float) -> tuple[str, str, str]:
    label = labels.column(name)
    return label.name, labels.number(value * label.factor), label.unit


def _plots(study: Study, table: list[Row]) -> list[Plot]:
    axis, over = load_name(study.free), load(study.free)
    x = str(labels.column(axis)) if axis else "Part of the step"
    found = []
    for title, beginnings in PLOTS.items():
        starts = tuple(b.format(c) for b in beginnings for c in ("xyz" if "{0}" in b else "x"))
        names = [name for name in table[0] if name.startswith(starts) and _seen(name, table)]
        if not names:
            continue
        unit = labels.column(names[0])
        traces = [
            base.xy(str(labels.column(name).name), over, _values(name, table)) for name in names
        ]
        found.append(base.lines(title, x, f"{title} ({unit.unit})" if unit.unit else title, traces))
    return found


def _values(name: str, table: list[Row]) -> list[float]:
    factor = labels.column(name).factor
    return [float(row[name]) * factor if row[name] != "" else float("nan") for row in table]


def _seen(name: str, table: list[Row]) -> bool:
    return any(abs(value) > NOTHING for value in _values(name, table))


def _table(table: list[Row]) -> Markup:
    names = [n for n in table[0] if n in BEFORE or _seen(n, table)]
    heads = [str(labels.column(name)) for name in names]
    rows = [[_scaled(name, row[name]) for name in names] for row in table]
    return base.table(heads, rows, file="module.csv")


def _scaled(name: str, value: float | str) -> float | str:
    return value if isinstance(value, str) else value * labels.column(name).factor


def _limits(study: Study) -> str:
    whole = (
        f"The angle of the whole actuator is that of {study.modules:g} equal modules: its two ends "
        "bend a little otherwise, and what they add is not in it. "
        if study.modules
        else ""
    )
    asked = any(name.startswith(WAVES) for name in study.free.curve)
    longest = "three modules" if asked else "a module"
    return (
        f"{whole}A module stands for the inner ones of a chain without weight and tip "
        "loads. The stiffness is that at constant pressure, in the frame of the left face; a "
        f"buckle longer than {longest} is not seen."
    )


def lines(study: Study) -> list[str]:
    """What the last state says, in a few lines."""
    last = study.rows()[-1]
    wanted = ("module_angle_", "module_stretch_", "module_cavity_volume", "blocked_", "actuator_")
    shown = [_shown(n, float(v)) for n, v in last.items() if n.startswith(wanted) and _counts(v)]
    at = load_text(study.free, len(study.free.curve["step"]) - 1)
    verdict = from_data(study.free.run.get("verdict"))
    said = [] if verdict is None else [f"free module: {line}" for line in verdict.lines[:2]]
    figures = [f"  {name}: {value} {unit}".rstrip() for name, value, unit in shown]
    return [*said, f"at {at}:", *figures]


def _counts(value: float | str) -> bool:
    return isinstance(value, float) and abs(value) > NOTHING
