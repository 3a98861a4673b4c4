"""The best points of a study on modules once more, as whole actuators, and how far both differ."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from softact.files import document
from softact.report import base as page
from softact.report import labels
from softact.report.base import Plot, Section
from softact.results import chain
from softact.results.folder import COMPLETE
from softact.spec import spec_at
from softact.sweep.cache import Cache
from softact.sweep.compute import Answer, of_record
from softact.sweep.front import best, unbeaten
from softact.sweep.parts import Objective, Part
from softact.sweep.points import DesignPoint
from softact.sweep.record import Record
from softact.sweep.version import run_key

if TYPE_CHECKING:
    from softact.sweep.axes import Axis
    from softact.sweep.study import Runner

CONFIRMED = "confirmed.csv"
#: What is compared beside what was asked for, where both runs have it.
ALWAYS = chain.TIMES[:3]
NOTHING = 1e-6  # below it a figure is rounding, and a deviation from it means nothing

Row = dict[str, float | str]


@dataclass(frozen=True)
class Candidate:
    """A point, or a trial, whose run of a module is complete, by its number."""

    number: int
    point: DesignPoint
    module: Record


@dataclass(frozen=True)
class Confirmed:
    """whole: how the run of the whole actuator ended."""

    candidate: Candidate
    whole: Answer

    def pair(self, part: Part) -> tuple[float | None, float | None]:
        """A measure of so many modules and of the whole, None where there is none; a whole that
        stopped early has none, since its last state is at another load."""
        record = self.whole.record if self.whole.status == COMPLETE else None
        return part.value(self.candidate.module), part.value(record) if record else None


def deviation(module: float | None, whole: float | None) -> float | None:
    """How far so many modules are off, in percent of the whole; None where that means nothing."""
    if module is None or whole is None or abs(whole) < NOTHING:
        return None
    return 100 * (module - whole) / abs(whole)


def choose(
    some: Sequence[Candidate], objectives: Sequence[Objective], count: int
) -> list[Candidate]:
    """``count`` of the best, each run once: see ``front.best``."""
    runs = {c.module.key: c for c in reversed(some)}
    there, values = _judged([*reversed(runs.values())], objectives)
    return [there[number] for number in best(values, count)]


def front(some: Sequence[Candidate], objectives: Sequence[Objective]) -> list[Candidate]:
    """Those that none beats."""
    there, values = _judged(some, objectives)
    return [there[number] for number in unbeaten(values)]


def _judged(
    some: Sequence[Candidate], objectives: Sequence[Objective]
) -> tuple[list[Candidate], np.ndarray]:
    """Those that have all objectives, and these (n, m), more being better in each."""
    values = [(c, [o.value(c.module) for o in objectives]) for c in some]
    there = [(c, found) for c, found in values if None not in found]
    matrix = np.array([found for _, found in there], float).reshape(len(there), len(objectives))
    return [c for c, _ in there], matrix * [o.sign for o in objectives]


def confirm(
    chosen: Sequence[Candidate],
    source: document.Document,
    cache: Cache,
    runner: Runner,
    tell: Callable[[DesignPoint, Answer], None],
) -> list[Confirmed]:
    """Compute what is missing of the whole actuators, and keep it in the cache. tell: is called for
    each that was computed."""
    keys = [run_key(spec_at(source, each.point.changes)) for each in chosen]
    answers = {key: of_record(found, True) for key in keys if (found := cache.find(key))}
    points = {key: each.point for key, each in zip(keys, chosen, strict=True)}
    missing = {k: p for k, p in points.items() if k not in answers}
    jobs = {key: partial(spec_at, source, point.changes) for key, point in missing.items()}
    for answer in runner(jobs, cache, None) if jobs else ():
        answers[answer.key] = answer
        tell(points[answer.key], answer)
    return [Confirmed(c, answers[key]) for c, key in zip(chosen, keys, strict=True)]


def compared(found: Sequence[Confirmed], asked: Sequence[Part]) -> list[Part]:
    """The measures to be set beside each other: those that were asked for, angle, twist, air."""
    names = dict.fromkeys(
        name
        for each in found
        if each.whole.record
        for name in each.whole.record.columns
        if name.startswith(ALWAYS) and name in each.candidate.module.columns
    )
    parts = {part.title: part for part in asked}
    parts |= {name: Part(measure=name) for name in names if name not in parts}
    return [part for part in parts.values() if any(_counts(each, part) for each in found)]


def _counts(each: Confirmed, part: Part) -> bool:
    return any(value is not None and abs(value) > NOTHING for value in each.pair(part))


def rows(found: Sequence[Confirmed], parts: Sequence[Part], axes: Sequence[Axis]) -> list[Row]:
    """A row for each, as confirmed.csv has them: point, its parameters, how its run as a whole
    ended, seconds of both, and of each measure both values and the deviation."""
    table = []
    for each in found:
        candidate, record = each.candidate, each.whole.record
        row: Row = {"point": candidate.number, "status": each.whole.status}
        row |= {"cause": each.whole.cause, "verdict": record.verdict if record else ""}
        for axis in axes:
            value = candidate.point.coordinates.get(axis.title)
            row[axis.column] = "" if value is None else axis.cell(value)
        row["seconds_module"] = candidate.module.seconds
        row["seconds_whole"] = record.seconds if record else ""
        for part in parts:
            pair = each.pair(part)
            row[f"{part.title}_module"], row[f"{part.title}_whole"] = map(_cell, pair)
            row[f"{part.title}_deviation_percent"] = _cell(deviation(*pair))
        table.append(row)
    return table


def _cell(value: float | None) -> float | str:
    return "" if value is None else value


def lines(found: Sequence[Confirmed], parts: Sequence[Part]) -> list[str]:
    """The smallest and the largest deviation of each measure, in words."""
    said = []
    for part in parts:
        some = [d for each in found if (d := deviation(*each.pair(part))) is not None]
        if some:
            low, high = (f"{end:+.2g}" for end in (min(some), max(some)))
            span = low if low == high else f"{low} to {high}"
            said.append(f"{part.title} {span} %")
    return said


def section(
    found: Sequence[Confirmed], parts: Sequence[Part], objectives: Sequence[Objective]
) -> list[Section]:
    """The part of a study's page; none where nothing was confirmed."""
    if not found:
        return []
    heads = ["Point", "Figure", "Modules", "Whole", "Deviation %", "How the whole ended"]
    body: list[list[str | float | None]] = []
    for each in found:
        record = each.whole.record
        how = record.verdict if record and not each.whole.cause else each.whole.cause
        number = f"{each.candidate.number}"
        body += [[number, _name(part), *_shown(each, part), how] for part in parts]
    note = page.note(
        "The best points, computed once more as whole actuators with their ends. Deviation: how "
        "far so many equal modules are off, by the figure of the whole."
    )
    plots = [_plot(found, objectives[0], objectives[1])] if len(objectives) > 1 else []
    drawn = page.figures(plots) if plots else ""
    html = note + page.table(heads, body, file=CONFIRMED) + drawn
    return [Section("confirmed", "The best as whole actuators", html, "Confirmed")]


def _name(part: Part) -> str:
    """The measure in words, with its unit."""
    taken = "" if part.take == "last" else f"{part.take} "
    return f"{taken}{labels.column(part.measure)}"


def _shown(each: Confirmed, part: Part) -> list[float | None]:
    factor = labels.column(part.measure).factor
    pair = each.pair(part)
    return [*(None if v is None else factor * v for v in pair), deviation(*pair)]


def _plot(found: Sequence[Confirmed], up: Part, across: Part) -> Plot:
    traces = []
    for number, (name, colour) in enumerate((("modules", "@c1"), ("whole", "@c2"))):
        pairs = [(each.pair(across)[number], each.pair(up)[number]) for each in found]
        factors = labels.column(across.measure).factor, labels.column(up.measure).factor
        xs, ys = (
            [math.nan if (value := pair[k]) is None else value * factors[k] for pair in pairs]
            for k in (0, 1)
        )
        texts = [f"point {each.candidate.number}" for each in found]
        traces.append(
            page.xy(name, xs, ys, mode="markers", text=texts, colour=colour, marker={"size": 9},
                    hovertemplate="%{text}: %{x:.4~g}, %{y:.4~g}<extra></extra>")
        )  # fmt: skip
    x, y = _name(across), _name(up)
    return page.lines(f"{y} and {x}", x, y, traces, wide=True)
