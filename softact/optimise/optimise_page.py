"""optimise.html and trials.csv: history, Pareto front, the best design's data sheet."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from markupsafe import Markup

from softact.files.text import csv_text, write_atomic
from softact.optimise.store import DATABASE
from softact.optimise.study import Trials, feasible
from softact.report import base, labels, write_report
from softact.report.base import Section
from softact.results.own_folder import Output
from softact.sweep import confirm, shape
from softact.sweep.confirm import CONFIRMED
from softact.sweep.parts import Part
from softact.sweep.record import DamagedError, load
from softact.sweep.sweep_page import MOST_SHAPES, packed, thinned

if TYPE_CHECKING:
    from optuna.trial import FrozenTrial

TABLE, PAGE, BEST = "trials.csv", "optimise.html", "best"
FILES = (DATABASE, TABLE, CONFIRMED, PAGE, BEST)
Row: TypeAlias = dict[str, Any]


def rows(trials: Trials) -> list[Row]:
    """A row for each trial: parameters, objectives, constraints, status and cause."""
    found = []
    for trial in trials.done:
        values = trials.coordinates(trial)
        row: Row = {"trial": trial.number, "status": trial.user_attrs["status"]}
        row |= {"feasible": feasible(trial), "cause": trial.user_attrs["cause"]}
        row |= {axis.column: axis.cell(values[title]) for title, axis in trials.axes.items()}
        row |= {part.title: trial.user_attrs.get(part.title, "") for part in trials.parts}
        found.append(row | {"run": trial.user_attrs["run"]})
    return found


def write(trials: Trials, output: Output) -> Path:
    """Write trials.csv, the best design's folder and the page; returns the page's path."""
    table = rows(trials)
    write_atomic(output.file(TABLE), csv_text(table))
    if trials.confirmed:
        found = confirm.rows(trials.confirmed, trials.compared, trials.wanted.parameters)
        write_atomic(output.file(CONFIRMED), csv_text(found))
    best = trials.best()
    if best:
        _data_sheet(trials, best[-1], output)
    page = output.file(PAGE)
    write_atomic(page, html(trials, table))
    return page


def _data_sheet(trials: Trials, trial: FrozenTrial, output: Output) -> None:
    """The result folder of a trial with its report; left alone where it is that run already, which
    may have got error bars of the mesh since."""
    target = output.directory / BEST
    with suppress(DamagedError):
        if load(trials.sheet_key(trial), target) and (target / "report.html").is_file():
            return
    trials.folder(trial)
    write_report(output.results(BEST, trials.cache.folder(trials.sheet_key(trial))))


def html(trials: Trials, table: list[Row]) -> str:
    """The page."""
    wanted, best, front = trials.wanted, trials.best(), _front(trials)
    solved = any(trial.values is not None for trial in trials.done)
    sections = [
        *([Section("best", "Best designs")] if best else []),
        *confirm.section(trials.confirmed, trials.compared, wanted.objectives),
        Section("history", "History"),
        *([Section("tradeoff", "Objectives and constraints")] if front else []),
        *([Section("design", "One design")] if solved else []),
        Section("trials", "Trials"),
    ]
    return base.page(
        wanted.name,
        sections,
        kicker="Optimisation of a soft actuator",
        kind="optimisation",
        data={"packed": packed(_designs(trials))},
        template="optimise/optimise_page.html",
        study=wanted,
        count=_count(table),
        best=_best(trials, best) if best else "",
        number=best[-1].number if best else None,
        folder=BEST,
        history=base.figures([_history(trials, n) for n in range(len(wanted.objectives))]),
        tradeoff=base.figures([front]) if front else "",
        trials=_trials(table),
    )


def _designs(trials: Trials) -> dict[str, Any]:
    """What optimise.js shows of the trials that have values, by their numbers; ``first``: the one
    that is shown before any click. Of many trials, some have their shapes on the page."""
    best, solved = trials.best(), [t for t in trials.done if t.values is not None]
    some = [solved[n] for n in thinned(range(len(solved)), MOST_SHAPES)]
    shapes = {
        trial.number: found
        for trial in {t.number: t for t in (*best, *solved[:1], *some)}.values()
        if (found := shape.load(trials.cache.folder(trial.user_attrs["run"])))
    }
    candidates = best or solved
    return {
        "first": candidates[-1].number if candidates else None,
        "of": {t.number: _design(trials, t, shapes.get(t.number)) for t in solved},
    }


def _design(trials: Trials, trial: FrozenTrial, shown: dict[str, Any] | None) -> dict[str, Any]:
    """Arguments of ``showRun``."""
    values = trials.coordinates(trial)
    rows = [("constraints", "all hold" if feasible(trial) else "one is broken")]
    rows += [(title, str(value)) for title, value in values.items()]
    for part in trials.parts:
        unit = labels.column(part.measure).unit
        text = labels.number(_shown(part, trial))
        rows.append((part.title, f"{text} {unit}".strip()))
    folder = trials.cache.folder(trial.user_attrs["run"])
    return {
        "number": trial.number, "title": f"Trial {trial.number}", "rows": rows, "solved": True,
        "shape": shown, "command": f"softact report {folder}",
    }  # fmt: skip


def _cell(value: object) -> str | float:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return value if isinstance(value, float) else str(value)


def _trials(table: list[Row]) -> Markup:
    heads = [name for name in table[0] if name != "run"] if table else []
    return base.table(heads, [[_cell(row[h]) for h in heads] for row in table], file="trials.csv")


def _count(table: list[Row]) -> Markup:
    failed = sum(row["status"] != "complete" for row in table)
    good = sum(row["feasible"] for row in table)
    said = f"{good} hold all constraints, {failed} failed."
    return base.banner("good" if good else "warn", f"{len(table)} trials:", said)


def _best(trials: Trials, best: list[FrozenTrial]) -> Markup:
    parts = trials.parts
    heads = ["Trial", *(axis.column for axis in trials.axes.values()), *(p.title for p in parts)]
    chosen, marks = list(best), [""] * len(best)
    reference = trials.reference
    if reference is not None and reference not in chosen:
        chosen.append(reference)
        marks.append("soft")
    body = []
    for trial in chosen:
        values = trials.coordinates(trial)
        name = f"{trial.number}" + ("" if trial in best else " (reference)")
        cells = [axis.cell(values[title]) for title, axis in trials.axes.items()]
        body.append([name, *cells, *(trial.user_attrs.get(p.title, "") for p in parts)])
    return base.table(heads, body, marks=marks)


def _history(trials: Trials, number: int) -> base.Plot:
    objective = trials.wanted.objectives[number]
    sign = 1 if objective.goal == "maximise" else -1
    good = [t for t in trials.done if feasible(t)]
    other = [t for t in trials.done if t.values is not None and not feasible(t)]
    label = labels.column(objective.measure)

    def shown(some: Sequence[FrozenTrial]) -> list[float]:
        return [t.values[number] * label.factor for t in some]

    steps: list[int] = []
    so_far: list[float] = []
    for trial, value in zip(good, shown(good), strict=True):
        so_far.append(value if not so_far else sign * max(sign * so_far[-1], sign * value))
        steps.append(trial.number)
    traces = [
        base.xy("holds all constraints", _numbers(good), shown(good), mode="markers",
                colour="@c1", customdata=_numbers(good)),
        base.xy("breaks one", _numbers(other), shown(other), mode="markers",
                colour="@c8", marker={"symbol": "x"}, customdata=_numbers(other)),
        base.xy("best so far", steps, so_far, mode="lines", colour="@c2", line={"shape": "hv"}),
    ]  # fmt: skip
    title = f"{objective.goal} {objective.title}"
    return base.lines(title, "Trial", str(label), traces, wide=True)


def _numbers(some: Sequence[FrozenTrial]) -> list[int]:
    return [trial.number for trial in some]


def _front(trials: Trials) -> base.Plot | None:
    """Two objectives, or the objective over the first constraint."""
    parts = trials.parts
    if len(parts) < 2:
        return None
    x, y = parts[1], parts[0]

    def trace(name: str, some: Sequence[FrozenTrial], **more: Any) -> dict[str, Any]:
        xs, ys = ([_shown(p, t) for t in some] for p in (x, y))
        texts = [f"trial {t.number}" for t in some]
        return base.xy(name, xs, ys, mode="markers", text=texts, customdata=_numbers(some), **more,
                       hovertemplate="%{text}: %{x:.4~g}, %{y:.4~g}<extra></extra>")  # fmt: skip

    done = [t for t in trials.done if t.values is not None]
    best = trials.best()
    traces = [
        trace("breaks a constraint", [t for t in done if not feasible(t)], colour="@c8"),
        trace("holds all", [t for t in done if feasible(t)], colour="@c1"),
        trace("best", best, colour="@c2", marker={"size": 10}),
    ]
    reference = trials.reference
    if reference is not None and reference.values is not None:
        traces.append(trace("reference", [reference], colour="@c3", marker={"size": 10}))
    xs, ys = (str(labels.column(p.measure)) for p in (x, y))
    title = f"{y.title} and {x.title}"
    return base.lines(title, xs, ys, traces, wide=True, id="front")


def _shown(part: Part, trial: FrozenTrial) -> float:
    """A trial's objective or constraint in the unit in which its measure is shown."""
    value = trial.user_attrs.get(part.title)
    return float("nan") if value is None else value * labels.column(part.measure).factor
