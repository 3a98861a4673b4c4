"""From a table to tests: stretch and nominal stress, and whether they can be right."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from softact.errors import SpecError
from softact.fit.advise import advice
from softact.fit.broken import Broken, broken
from softact.fit.choose import choose, contradictions, pick
from softact.fit.convert import Reading, size_of, stress_of, stretch_of
from softact.fit.sheet import TestSheet
from softact.fit.trimming import (
    MIN_POINTS,
    CyclesError,
    branch,
    prepare,
    without_break,
    without_hold,
)
from softact.measured.tables import MANY, Table, UnreadableError, read_table


@dataclass(frozen=True)
class Test:
    """Nominal stress (n,) in MPa over stretch (n,) of one specimen in one mode.

    mode: a key of ``modes.MODES`` or 'biaxial'. direction: of the load in a sheet with fibres.
    other: stretch across it, in the mode 'biaxial'. messages: what was done and what looks odd.
    broken: where the specimen broke, if it did and somebody says so.
    """

    __test__ = False  # not a test of pytest's

    name: str
    mode: str
    stretch: np.ndarray
    stress: np.ndarray
    direction: str | None = None
    other: np.ndarray | None = None
    messages: tuple[str, ...] = ()
    broken: Broken | None = None

    @property
    def label(self) -> str:
        """Name, mode and direction for people."""
        return f"{self.name} ({self.mode}{' ' + self.direction if self.direction else ''})"

    @property
    def across(self) -> np.ndarray:
        """Stretch across the load of a biaxial test. Raises ValueError for another."""
        if self.other is None:
            raise ValueError(f"{self.label}: no stretch across the load is given")
        return self.other


def read_tests(sheet: TestSheet) -> list[Test]:
    """Return the tests of a file: one per specimen and measured direction.

    Raises SpecError for data that cannot be right, saying what it looks like, and for a table that
    cannot be read as it is, with the command that would read it.
    """
    sizes: dict[str, float] = {}
    try:
        table = read_table(sheet.file, sheet.columns)
        sizes = table.sizes
        sheet, lines = _in_its_mode(sheet, table)
        return _specimens(sheet, table, lines)
    except UnreadableError as error:
        command = advice(sheet, error.columns, error.values, sizes, error.renamed)
        raise SpecError(f"{sheet.file}: {error}{command}") from None


def _in_its_mode(sheet: TestSheet, table: Table) -> tuple[TestSheet, list[str]]:
    """Take a test for compression where its headings say so; ask where the file's name does."""
    if "mode" in sheet.model_fields_set:
        return sheet, []
    if any(column.compressive and column.quantity.role for column in table.columns):
        line = f"the headings say compression ({sheet.file.name}:uniaxial if it is tension)"
        return sheet.model_copy(update={"mode": "compression"}), [line]
    if sheet.named_mode is None:
        return sheet, []
    other = f"{sheet.file.name}:{sheet.named_mode}"
    return sheet, [f"attention: read as uniaxial tension; {other} if it is not"]


def _specimens(sheet: TestSheet, table: Table, lines: list[str]) -> list[Test]:
    every: Sequence[str | None] = [None] * len(table.rows)
    labels: Sequence[str | None] = [None]
    if table.specimens:
        every, labels = table.specimens, sorted(set(table.specimens))
    tests = []
    for label in labels:
        rows = np.array([i for i, specimen in enumerate(every) if specimen == label], dtype=int)
        name = sheet.name if label is None else f"{sheet.name}:{label}"
        for direction in _directions(sheet, table):
            tests.append(_read_one(sheet, table, rows, name, direction, lines))
    return tests


def _directions(sheet: TestSheet, table: Table) -> list[str | None]:
    measured = [c.direction for c in table.columns if c.quantity.role == "y" and c.direction]
    if measured:
        return list(dict.fromkeys(measured))
    return [sheet.direction]


def _read_one(
    sheet: TestSheet,
    table: Table,
    rows: np.ndarray,
    name: str,
    direction: str | None,
    lines: list[str],
) -> Test:
    if not table.faults:
        _check_count(sheet, len(rows))
    choice = choose(sheet, table, rows, direction)
    across = _across(sheet, table, rows, direction)
    used = [choice.x, choice.y, *([] if across is None else [across])]
    _check_cells(sheet, table, used)
    full, messages = _full_rows(table, rows, used)
    _check_count(sheet, len(full))
    reading = Reading(sheet, table, choice, full, [*lines, *table.messages, *choice.messages])
    x = stretch_of(reading, choice.x)
    other = None if across is None else stretch_of(reading, across)
    y = stress_of(reading, x)
    sizes = {name: size_of(reading, name) for name in ("area", "length")}
    messages = [*reading.messages, *messages, *contradictions(table, full, choice, sizes)]
    mode = "uniaxial" if sheet.mode == "compression" else sheet.mode
    test = Test(name, mode, x, y, direction, other, ())
    test = _elastic(reading, test, messages)
    end = broken(sheet, test) if sheet.broke else None
    test = replace(prepare(sheet, test), broken=end)
    if end is not None:
        test = replace(test, messages=(*test.messages, end.text))
    _check_count(sheet, len(test.stretch))
    if np.max(np.abs(test.stretch - 1.0)) < 1e-6:
        raise SpecError(f"{sheet.file}: the stretch is 1 throughout; there is no deformation")
    _check_sense(reading, test)
    return test


def _across(sheet: TestSheet, table: Table, rows: np.ndarray, direction: str | None) -> int | None:
    """The column of the stretch across a biaxial test."""
    if sheet.mode != "biaxial":
        return None
    if direction is None:
        raise UnreadableError(
            "biaxial data need columns named 'course' and 'wale'", table.columns, table.values
        )
    return pick(sheet, table, rows, "x", "wale" if direction == "course" else "course")


def _check_cells(sheet: TestSheet, table: Table, used: list[int]) -> None:
    """Refuse cells of the columns that are read which hold no number, line by line."""
    faults = [fault for i in used for fault in table.faults.get(i, ())]
    if faults:
        more = len(faults) - MANY
        lines = [f"{sheet.file}:{fault}" for fault in faults[:MANY]]
        last = [f"{sheet.file}: and {more} more faults of this kind"] if more > 0 else []
        raise SpecError(*lines, *last)


def _full_rows(table: Table, rows: np.ndarray, used: list[int]) -> tuple[np.ndarray, list[str]]:
    """Rows with a value in every column that is read, and what to say of the others."""
    full = rows[np.isfinite(table.values[rows][:, used]).all(axis=1)]
    lost = len(rows) - len(full)
    if not lost:
        return full, []
    first = table.rows[np.setdiff1d(rows, full)[0]]
    return full, [f"{lost} of {len(rows)} rows lack a value and are left out, first line {first}"]


def _elastic(reading: Reading, test: Test, messages: list[str]) -> Test:
    """The test without its break, the branches that were not asked for, and a hold at its end."""
    sheet = reading.sheet
    if test.mode != "biaxial":
        test = _kept(test, without_break(sheet, test.stretch, test.stress, messages))
    try:
        test = _kept(test, branch(sheet, test.stretch, messages))
    except CyclesError as error:
        raise reading.refuse(str(error)) from None
    if test.mode != "biaxial":
        test = _kept(test, without_hold(sheet, test.stretch, test.stress, messages))
    return replace(test, messages=tuple(dict.fromkeys(messages)))


def _kept(test: Test, rows: slice) -> Test:
    other = None if test.other is None else test.other[rows]
    return replace(test, stretch=test.stretch[rows], stress=test.stress[rows], other=other)


def _check_count(sheet: TestSheet, count: int) -> None:
    if count < MIN_POINTS:
        raise SpecError(f"{sheet.file}: {count} points are left; a fit needs at least {MIN_POINTS}")


def _check_sense(reading: Reading, test: Test) -> None:
    """The load must have the sense of the deformation."""
    if test.mode == "biaxial":
        return
    x, y = test.stretch, test.stress
    largest = np.max(np.abs(y))
    squeezed = (x < 0.97) & (y > 0.05 * largest)
    if np.any(squeezed):
        raise reading.refuse(
            f"the stress is tensile at a stretch of {x[squeezed][0]:.3g}. This looks "
            "like engineering strain given as stretch (name the column 'strain'), or a wrong sign",
            x="strain",
        )
    pulled = (x > 1.03) & (y < -0.05 * largest)
    if np.mean(pulled) > 0.3:
        raise SpecError(
            f"{reading.sheet.file}: the stress is compressive at a stretch of {x[pulled][0]:.3g}: "
            "a wrong sign, or an offset of the load cell (--zero subtracts the first value)"
        )
