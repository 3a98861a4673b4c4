"""Tolerances to first order beside runs that are sampled from them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from softact.report import base, labels
from softact.report.base import Section
from softact.report.base.templates import macros
from softact.results.folder import COMPLETE, read
from softact.spec import spec_at
from softact.sweep.compute import Answer, compute
from softact.sweep.study import Study
from softact.sweep.sweep_page import shown_measures
from softact.sweep.table import Row
from softact.sweep.version import run_key
from softact.tolerances.causes import Cause, causes, paths
from softact.tolerances.first_order import Scatter, scatter

#: By what of the standard deviation to first order the two may differ.
FIFTH = 0.2
MOST_LINES = 6


@dataclass(frozen=True)
class Compared:
    """One measure at the last state. first: to first order; mean, deviation: of the samples."""

    first: Scatter
    mean: float
    deviation: float

    @property
    def apart(self) -> float:
        """By how much the two differ, mean or standard deviation, by that to first order."""
        of = self.first.deviation
        return max(abs(self.deviation - of), abs(self.mean - self.first.mean)) / of

    @property
    def line(self) -> str:
        """The two in words."""
        name = self.first.measure
        return (
            f"{name}: {self.mean:.5g} with a standard deviation of {self.deviation:.3g} in the "
            f"samples, {self.first.mean:.5g} with {self.first.deviation:.3g} to first order"
        )


@dataclass(frozen=True)
class Comparison:
    """of: a line for each measure that varies. samples: that are complete; lost: that are not."""

    of: Sequence[Compared]
    samples: int
    lost: int

    @property
    def notes(self) -> list[str]:
        """What a user has to know: where second order matters, and how far samples tell."""
        far = sorted((c for c in self.of if c.apart > FIFTH), key=lambda c: -c.apart)
        notes = [f"second order matters: {c.line}" for c in far[:MOST_LINES]]
        if len(far) > MOST_LINES:
            notes.append(f"second order matters for {len(far) - MOST_LINES} more measures")
        if far:
            notes.append(f"{self.samples} samples alone tell a standard deviation to {self.error}")
        if self.lost:
            notes.append(f"{self.lost} samples are not complete and are left out of the comparison")
        return notes

    @property
    def error(self) -> str:
        """Standard error of a standard deviation from so many normal samples."""
        return f"± {100 / math.sqrt(2 * (self.samples - 1)):.0f} %"


def nominal(study: Study) -> tuple[Answer, list[Cause]]:
    """The run of the actuator as its spec has it, with its derivatives, and the causes. Raises
    SoftactError where there is none."""
    spec = spec_at(study.base)
    some = causes(spec)
    key = run_key(spec, slopes=paths(some))
    answer = compute(spec, key, study.cache, slopes=paths(some))
    if answer.record is None:
        raise answer.error()
    return answer, some


def compare(study: Study, table: list[Row], answer: Answer, some: Sequence[Cause]) -> Comparison:
    """The measures of the last state that vary. answer, some: see ``nominal``."""
    results = read(study.cache.folder(answer.key))
    found = scatter(results, some)
    last = len(results.increments) - 1
    first = {s.measure: s for s in found if s.row == last}
    return compared(first, table, [name for name in shown_measures(table, study) if name in first])


def compared(
    first: Mapping[str, Scatter], table: Sequence[Row], names: Sequence[str]
) -> Comparison:
    """first: measure -> to first order; table: a row for each sample."""
    good = [row for row in table if row["status"] == COMPLETE]
    lost = len(table) - len(good)
    if len(good) < 2:
        return Comparison([], len(good), lost)
    lines = []
    for name in names:
        values = np.array([row.get(name, np.nan) for row in good], dtype=float)
        if np.isfinite(values).all() and first[name].deviation:
            mean, deviation = float(values.mean()), float(values.std(ddof=1))
            lines.append(Compared(first[name], mean, deviation))
    return Comparison(lines, len(good), lost)


def rows(found: Comparison) -> list[Row]:
    """As a table."""
    return [
        {
            "measure": c.first.measure, "value": c.first.value, "mean_first_order": c.first.mean,
            "standard_deviation_first_order": c.first.deviation, "mean_samples": c.mean,
            "standard_deviation_samples": c.deviation, "samples": float(found.samples),
        }
        for c in found.of
    ]  # fmt: skip


def section(found: Comparison) -> list[Section]:
    """The comparison as a section of the page, none where there is nothing to compare."""
    if not found.of:
        return []
    heads = ["Figure", "Unit", "As in the spec", "Mean, first order", "Mean, samples",
             "Standard deviation, first order", "Standard deviation, samples"]  # fmt: skip
    lines: list[list[str | float | None]] = []
    for c in found.of:
        label = labels.column(c.first.measure)
        numbers = (c.first.value, c.first.mean, c.mean, c.first.deviation, c.deviation)
        lines.append([label.name, label.unit, *(label.factor * n for n in numbers)])
    body = macros("report/sections.html").sampled(
        samples=found.samples, error=found.error, notes=found.notes, table=base.table(heads, lines)
    )
    return [Section("tolerances", "Tolerances: first order and samples", body, "Tolerances")]
