"""The table of key figures: by step and, where a step changes the load, at round loads of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.report import labels
from softact.report.curves import measures, round_loads
from softact.results.folder import Results, is_pressure, load, load_name, load_text
from softact.verdict.reached import reached

if TYPE_CHECKING:
    from softact.results.folder import Results

# Columns that still fit; at least one round load is told of each step that changes the load.
MOST_STOPS = 9


@dataclass(frozen=True)
class Stop:
    """A state of the table. row: of the curve; with a fraction, linear between two. step: its name.
    text: what its column is called."""

    row: float
    step: str
    text: str


def stops(results: Results) -> list[Stop]:
    """The states of the table: the first one, of each step round loads and the end, and the largest
    stable load where the path has a limit."""
    rows = len(load(results))
    if not rows:
        return []
    parts = _steps(results, rows)
    drivers = [_driver(results, begin, end) for _, begin, end in parts]
    loaded = sum(driver is not None for driver in drivers)
    each = max(1, (MOST_STOPS - len(parts) - 1) // max(loaded, 1))
    name = load_name(results)
    found = [Stop(0.0, parts[0][0], _text(results, drivers[0] or name, 0, "start"))]
    for (step, begin, end), driver in zip(parts, drivers, strict=True):
        if end == begin:
            continue
        if driver is not None:
            found += _round_stops(results, step, begin, end, driver, each)
        found.append(Stop(float(end), step, _text(results, driver or name, end, "end")))
    last = found[-1]
    found[-1] = Stop(last.row, last.step, f"{last.text} (last)")
    return _with_limit(results, found)


def _steps(results: Results, rows: int) -> list[tuple[str, int, int]]:
    """Name, first and last row of each step; it begins with the last row of the one before."""
    names = [str(name) for name in results.curve.get("step", [""] * rows)]
    ends = [n for n in range(rows) if n + 1 == rows or names[n + 1] != names[n]]
    begins = [0, *ends[:-1]]
    return [(names[end], begin, end) for begin, end in zip(begins, ends, strict=True)]


def _driver(results: Results, begin: int, end: int) -> str | None:
    """The pressure that changes most in a step, if any does."""
    best, span = None, 1e-9
    for name, values in results.curve.items():
        if is_pressure(name) and values.dtype == float:
            width = float(np.ptp(np.nan_to_num(values[begin : end + 1])))
            if width > span:
                best, span = name, width
    return best


def _text(results: Results, driver: str | None, row: int, without: str) -> str:
    if driver is None:
        return without
    label = labels.column(driver)
    return f"{labels.number(float(results.curve[driver][row]))} {label.unit}"


def _round_stops(
    results: Results, step: str, begin: int, end: int, driver: str, most: int
) -> list[Stop]:
    """Where a step first reaches round loads."""
    values = results.curve[driver]
    far = begin + int(np.argmax(np.abs(values[begin : end + 1] - values[begin])))
    aims = round_loads(float(values[begin]), float(values[far]))
    if len(aims) > most:
        kept = np.unique(np.linspace(0, len(aims) - 1, most + 1).round().astype(int)[1:])
        aims = [aims[n] for n in kept]
    found = []
    for aim in aims:
        row = _first(values, begin, end, aim)
        if row is not None:
            found.append(Stop(row, step, f"{labels.number(aim)} {labels.column(driver).unit}"))
    return found


def _first(values: np.ndarray, begin: int, end: int, aim: float) -> float | None:
    for row in range(begin, end):
        one, other = values[row], values[row + 1]
        if one != other and (one - aim) * (other - aim) <= 0:
            return row + float((aim - one) / (other - one))
    return None


def _with_limit(results: Results, found: list[Stop]) -> list[Stop]:
    """The same with the largest stable load, where that is not the end of a step."""
    far = reached(results)
    if not far.limit or far.largest is None or any(s.row == far.largest for s in found):
        return found
    row = far.largest
    step = str(results.curve["step"][row]) if "step" in results.curve else found[0].step
    new = Stop(float(row), step, f"{load_text(results, row)} (largest stable)")
    place = sum(stop.row < row for stop in found)
    return [*found[:place], new, *found[place:]]


def at(values: np.ndarray, row: float) -> float:
    """A column's value at a row, linear between two; NaN where one of these is not there."""
    low = int(row)
    part = row - low
    return float(values[low] if part == 0 else (1 - part) * values[low] + part * values[low + 1])


def table(
    results: Results, errors: Mapping[str, str] | None = None
) -> tuple[list[Stop], list[tuple[str, str, list[str]]]]:
    """The states, and rows (column, unit, texts). errors: column -> what is put behind its figure
    at the last state."""
    states, rows = stops(results), []
    parts = _steps(results, len(load(results))) if states else []
    drivers = {_driver(results, begin, end) for _, begin, end in parts}
    in_heads = {load_name(results)} if drivers <= {load_name(results), None} else set()
    for name in measures(results) if states else []:
        if name in in_heads:
            continue
        label = labels.column(name)
        values = results.curve[name] * label.factor
        shown = np.array([at(values, stop.row) for stop in states])
        largest = np.abs(shown).max(initial=0.0, where=np.isfinite(shown))
        texts = [labels.number(value, largest=largest) for value in shown]
        if errors and name in errors:
            texts[-1] += f" {errors[name]}"
        rows.append((name, label.unit, texts))
    return states, rows
