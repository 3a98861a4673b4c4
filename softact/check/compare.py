"""Runs cases and says in words where they differ from what is stored."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softact.check.cases import Case, Value, in_tolerance
from softact.errors import SoftactError
from softact.results.folder import COMPLETE, Results, read
from softact.run.start import run


@dataclass(frozen=True)
class Difference:
    """A value that is not as stored; found is NaN where there is none."""

    value: Value
    found: float
    why: str = ""

    def text(self) -> str:
        """One line: what was found, what is stored, and where that is from."""
        stored = self.value
        found = "is not there" if math.isnan(self.found) else f"{self.found:.7g}"
        off = ""
        if math.isfinite(self.found):
            off = f", off by {abs(self.found - stored.value) / stored.tolerance:.3g} tolerances"
        why = f" ({self.why})" if self.why else ""
        return (
            f"{stored.title} {found}{why}, stored {stored.value:.7g} ± {stored.tolerance:g}{off} "
            f"[{stored.kind}: {stored.source}]"
        )


@dataclass(frozen=True)
class Outcome:
    """A case that was run. fault: why it did not even run to its end, "" where it did."""

    case: Case
    seconds: float
    found: tuple[float, ...]
    differences: tuple[Difference, ...]
    fault: str = ""

    @property
    def passed(self) -> bool:
        """Whether everything is as stored."""
        return not self.fault and not self.differences

    def lines(self) -> list[str]:
        """What is wrong, a line each."""
        return [*([self.fault] if self.fault else []), *(d.text() for d in self.differences)]


def check_all(cases: Sequence[Case], jobs: int) -> Iterator[Outcome]:
    """Run the cases anew, ``jobs`` at a time with one thread each; yields them as they end."""
    pool = ThreadPoolExecutor(jobs)
    try:
        for future in as_completed([pool.submit(check, case) for case in cases]):
            yield future.result()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def check(case: Case) -> Outcome:
    """Run one case, in a folder that is thrown away."""
    started = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="softact-check-") as folder:
        try:
            outcome = run(case.spec, Path(folder) / "run", report=False, threads=1)
            results = read(outcome.directory)
        except SoftactError as error:
            seconds = time.perf_counter() - started
            return Outcome(case, seconds, (), (), "; ".join(error.lines))
        values = case.content.values
        found = tuple(figure(results, value) for value in values)
    fault = "" if outcome.status == COMPLETE else str(outcome.message)
    different = [
        Difference(value, number, why)
        for value, (number, why) in zip(values, found, strict=True)
        if not in_tolerance(value, number)
    ]
    numbers = tuple(number for number, _ in found)
    return Outcome(case, time.perf_counter() - started, numbers, tuple(different), fault)


def figure(results: Results, value: Value) -> tuple[float, str]:
    """The column's value in a run, and why it is NaN where it is."""
    curve = results.curve
    column = curve.get(value.measure)
    if column is None or column.dtype != float or not len(column):
        return math.nan, "the run has no such column"
    if value.at is None:
        return float(column[-1]), ""
    where = curve.get(value.at.column)
    if where is None or where.dtype != float:
        return math.nan, f"the run has no column {value.at.column}"
    for left in range(len(where) - 1):
        low, high = where[left], where[left + 1]
        if low != high and min(low, high) <= value.at.value <= max(low, high):
            fraction = (value.at.value - low) / (high - low)
            return float(column[left] + fraction * (column[left + 1] - column[left])), ""
    reach = f"{np.nanmin(where):g} to {np.nanmax(where):g}"
    return math.nan, f"{value.at.column} goes from {reach}"
