"""Several runs beside published requirements: each figure over the load, with what is asked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from markupsafe import Markup

from softact.report import base, labels, targets
from softact.report.base import Plot, Section
from softact.report.base.templates import macros
from softact.report.targets import Requirement
from softact.results.folder import Results, load, load_name

if TYPE_CHECKING:
    from softact.results.folder import Results

#: Figures of an actuator that nothing stops; a run with a load cell does not tell them.
FREE = {
    "bending_angle_deg",
    "whole_bending_deg",
    "elongation_mm",
    "extension_percent",
    "contraction_percent",
}
FORCE = "blocked_force_N"


def tells(run: Results, asked: Requirement, runs: Sequence[Results]) -> bool:
    """Whether a run is one to judge a requirement by: free motion only by runs without a load cell,
    where there are such."""
    if not asked.figure or targets.figure_values(run, asked.figure) is None:
        return False
    if asked.figure not in FREE or FORCE not in run.curve:
        return True
    return all(FORCE in other.curve for other in runs)


def section(names: Sequence[str], runs: Sequence[Results], wanted: Sequence[str]) -> Section:
    """The part of a comparison that sets the runs among published requirements.

    names: of the runs; wanted: names of applications, see ``targets``.
    """
    runs = [settled(run) for run in runs]
    parts = []
    for name in wanted:
        asked = [r for r in targets.requirements(name) if any(tells(run, r, runs) for run in runs)]
        drawn = base.figures(plots(names, runs, asked))
        parts.append((targets.title(name), drawn, _table(name, names, runs)))
    body = macros("report/sections.html").requirements(
        "What published applications ask for, and what the runs show up to the end of each. Runs "
        "that press on a load cell are not asked how far they move freely, and the first inflation "
        "of sheets, a motion, is left out up to where it has come to rest.",
        parts,
    )
    return Section("targets", "Published requirements", body, "Requirements")


def settled(run: Results) -> Results:
    """The run without the states of a motion (see ``softact.solve.rungs.inflation``), but those at
    the end of a step whose load no equilibrium of the run has; as it is where its history does not
    tell them, as after a run was resumed."""
    accepted = [item for item in run.run.get("history") or [] if item.get("converged")]
    loads = load(run)
    rows = len(loads)
    if len(accepted) != rows:
        return run
    last = [n + 1 == rows or accepted[n + 1].get("step") != item.get("step")
            for n, item in enumerate(accepted)]  # fmt: skip
    moving = np.array([item.get("control") == "motion" for item in accepted], dtype=bool)
    found = loads[1:][~moving[1:]]  # the first row is the unloaded body
    passed = (loads >= found.min(initial=np.inf)) & (loads <= found.max(initial=-np.inf))
    keep = ~moving | (np.array(last, dtype=bool) & ~passed)
    return replace(run, curve={name: values[keep] for name, values in run.curve.items()})


def _table(name: str, names: Sequence[str], runs: Sequence[Results]) -> Markup:
    all_asked = targets.requirements(name)
    rows = [
        [asked.text, *row, asked.source]
        for asked, row in zip(all_asked, cells(name, runs), strict=True)
    ]
    return base.table(["Requirement", *names, "Source"], rows, file=f"targets_{name}.csv")


def cells(name: str, runs: Sequence[Results]) -> list[list[str]]:
    """For each requirement of an application what each run says of it."""
    return [
        [_cell(run, asked) if tells(run, asked, runs) else "–" for run in runs]
        for asked in targets.requirements(name)
    ]


def _cell(run: Results, asked: Requirement) -> str:
    verdict = targets.judge(run, asked)
    found = targets.found_text(verdict) if np.isfinite(verdict.found) else ""
    return ": ".join(part for part in (verdict.verdict, found) if part)


def plots(
    names: Sequence[str], runs: Sequence[Results], asked: Sequence[Requirement]
) -> list[Plot]:
    """A plot for each figure of a state that is asked for, with a line at what is asked."""
    figures = dict.fromkeys(r.figure for r in asked)
    made = [_plot(names, runs, [r for r in asked if r.figure == figure]) for figure in figures]
    return [plot for plot in made if plot]


def _plot(
    names: Sequence[str], runs: Sequence[Results], asked: Sequence[Requirement]
) -> Plot | None:
    figure = asked[0].figure
    label, shown = targets.label(figure), []
    for name, run in zip(names, runs, strict=True):
        values = targets.figure_values(run, figure)
        if isinstance(values, np.ndarray) and values.ndim and tells(run, asked[0], runs):
            shown.append((name, run, values))
    if not shown:
        return None
    traces = [base.xy(name, *_parted(run, values * label.factor)) for name, run, values in shown]
    ends = [end for _, run, _ in shown for end in (float(load(run).min()), float(load(run).max()))]
    for requirement in asked:
        bound = requirement.bound * label.factor
        line = {"dash": "dot", "width": 2}
        traces.append(
            base.xy(f"asked: {requirement.text}", [min(ends), max(ends)], [bound, bound],
                    colour="@ink", mode="lines", line=line)
        )  # fmt: skip
    drivers = {load_name(run) for _, run, _ in shown}
    x = drivers.pop() if len(drivers) == 1 else None
    across = str(labels.column(x)) if x else "Load (kPa, or finished steps)"
    return base.lines(f"{label.name} and what is asked", across, str(label), traces, wide=True)


def _parted(run: Results, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Load and values of a trace, with a gap where states between two rows are left out."""
    number = run.curve.get("increment", np.arange(len(values)))
    left_out = np.flatnonzero(np.diff(number) > 1) + 1
    loads, parted = (np.insert(v.astype(float), left_out, np.nan) for v in (load(run), values))
    return loads, parted
