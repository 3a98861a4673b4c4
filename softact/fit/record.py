"""Tests in the order in which they were made: loading and unloading, with or without a clock."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from softact.errors import SpecError
from softact.fit.advise import advice
from softact.fit.choose import choose
from softact.fit.convert import Reading, stress_of, stretch_of
from softact.fit.modes import MODES
from softact.fit.sheet import TestSheet
from softact.fit.trimming import turning_points
from softact.measured.cells import numbers, read_rows
from softact.measured.headings import plain_words
from softact.measured.tables import Table, UnreadableError, read_table
from softact.units import TIME, conversion, show

# Points that a record needs.
FEWEST = 12
_TIME = re.compile(r"\b(time|zeit|temps)\b")
_UNIT = re.compile(r"[(\[](?P<inside>[^)\]]+)[)\]]|[\s_/](?P<end>[^\s_/()\[\]]+)\s*$")
# What a sheet may say that would tear a record apart.
_TEARING = ("loading", "cycle", "toe", "stretch_from", "stretch_to", "whole", "smooth", "points")


@dataclass(frozen=True)
class Record:
    """Nominal stress (n,) in MPa and stretch (n,) of one specimen, in their order.

    mode: a key of ``MODES``. times: (n,) s, rising; None where the test has no clock.
    """

    name: str
    mode: str
    stretch: np.ndarray
    stress: np.ndarray
    times: np.ndarray | None = None
    messages: tuple[str, ...] = ()

    @property
    def turns(self) -> list[int]:
        """Rows of the first point, each reversal of the stretch, and the last."""
        return turning_points(self.stretch)

    @property
    def peaks(self) -> list[int]:
        """Rows at which the stretch turns back, or ends, farther from 1 than before and after."""
        far, turns = np.abs(np.log(self.stretch)), self.turns
        sides = [[far[t] for t in turns[max(i - 1, 0) : i + 2]] for i in range(len(turns))]
        return [t for t, near in zip(turns, sides, strict=True) if far[t] == max(near) and t]


def read_records(sheet: TestSheet, timed: bool) -> list[Record]:
    """The tests of a file, whole. timed: a column of time is needed.

    Raises SpecError for what cannot be read, and for a time that is negative or runs back.
    """
    _check(sheet)
    try:
        table = read_table(sheet.file, sheet.columns)
        labels: Sequence[str | None] = table.specimens or [None] * len(table.rows)
        return [
            _record(
                sheet, table, np.array([i for i, one in enumerate(labels) if one == label]), timed
            )
            for label in dict.fromkeys(labels)
        ]
    except UnreadableError as error:
        times = {
            i: column.heading
            for i, column in enumerate(error.columns)
            if _TIME.search(plain_words(column.heading))
        }
        command = advice(sheet, error.columns, error.values, {}, {**times, **error.renamed})
        raise SpecError(f"{sheet.file}: {error}{command}") from None


def _check(sheet: TestSheet) -> None:
    torn = [name for name in _TEARING if getattr(sheet, name)]
    if torn:
        option = {"stretch_from": "from", "stretch_to": "to"}.get(torn[0], torn[0])
        raise SpecError(
            f"{sheet.file}: --{option} would tear the record; a test with memory is read whole"
        )
    if sheet.mode == "biaxial" or sheet.direction:
        raise SpecError(
            f"{sheet.file}: memory is fitted to uniaxial, compression, equibiaxial and planar "
            "tests of materials without fibres"
        )


def _record(sheet: TestSheet, table: Table, rows: np.ndarray, timed: bool) -> Record:
    choice = choose(sheet, table, rows, None)
    times = _times(sheet, table, timed)
    used = [choice.x, choice.y]
    for place in used:
        if table.faults.get(place):
            raise SpecError(f"{sheet.file}:{table.faults[place][0]}")
    full = np.isfinite(table.values[rows][:, used]).all(axis=1)
    if times is not None:
        full &= np.isfinite(times[rows])
    rows = rows[full]
    label = f":{table.specimens[rows[0]]}" if table.specimens and len(rows) else ""
    name = f"{sheet.name}{label}"
    if len(rows) < FEWEST:
        raise SpecError(f"{sheet.file}: {len(rows)} points; a test with memory needs {FEWEST}")
    reading = Reading(sheet, table, choice, rows, [*table.messages, *choice.messages])
    stretch = stretch_of(reading, choice.x)
    stress = stress_of(reading, stretch)
    if sheet.zero:
        stress = stress - stress[0]
    mode = "uniaxial" if sheet.mode == "compression" else sheet.mode
    assert mode in MODES
    clock = None if times is None else _risen(sheet, table, rows, times[rows])
    return Record(name, mode, stretch, stress, clock, tuple(dict.fromkeys(reading.messages)))


def _times(sheet: TestSheet, table: Table, wanted: bool) -> np.ndarray | None:
    """Time in s at each row of the table; None where it has none."""
    places = [i for i, c in enumerate(table.columns) if _TIME.search(plain_words(c.heading))]
    if not places and not wanted:
        return None
    if not places:
        raise SpecError(f"{sheet.file}: there is no column of time; head one 'time (s)'")
    heading = table.columns[places[0]].heading
    unit = _UNIT.search(heading)
    text = (unit["inside"] or unit["end"]).strip() if unit else ""
    if not text:
        raise SpecError(f"{sheet.file}: {show(heading)} has no unit; write 'time (s)'")
    try:
        factor = conversion(text, TIME.internal)
    except ValueError as error:
        raise SpecError(f"{sheet.file}: {show(heading)}: {error}") from None
    lines = {row.line: row for row in read_rows(sheet.file)}
    found, faults = numbers([lines[line] for line in table.rows], places[:1])
    if wrong := faults[places[0]]:
        line, fault = wrong[0]
        raise SpecError(f"{sheet.file}:{line}: column {show(heading)}: {fault}")
    return found[places[0]] * factor


def _risen(sheet: TestSheet, table: Table, rows: np.ndarray, times: np.ndarray) -> np.ndarray:
    """The times (n,), that begin at zero or later and rise."""
    if times.min() < 0:
        row = int(np.argmin(times >= 0))
        raise SpecError(
            f"{sheet.file}:{table.rows[rows[row]]}: time {times[row]:g} s is below zero; a test "
            "begins at 0 s or later"
        )
    back = np.flatnonzero(np.diff(times) <= 0)
    if len(back):
        row = int(back[0])
        raise SpecError(
            f"{sheet.file}:{table.rows[rows[row + 1]]}: time runs back from {times[row]:g} s to "
            f"{times[row + 1]:g} s; each row is later than the one before"
        )
    return times
