"""Rows and cells of a table: which mark separates them, and what is a number in them."""

import csv
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softact.errors import SpecError
from softact.measured.encoding import read_text
from softact.units import show

MOST_CELLS = 1000
#: No test measures more, in any unit; squares and plots of it would overflow.
LARGEST = 1e100
SEPARATORS = (";", "\t", ",", "|", None)  # None: blanks
# What machines and spreadsheets write where they have no value.
MISSING = {
    "", "-", "--", "---", "----", "\N{EN DASH}", "\N{EM DASH}", "*", "***", "?",
    "n/a", "na", "n.a.", "nan", "-nan", "+nan", "null", "none", "1.#qnan", "1.#ind", "-1.#ind",
    "#n/a", "#na", "#nv", "#value!", "#wert!", "#valeur!", "#div/0!", "#ref!", "#num!", "#zahl!",
}  # fmt: skip
# Each of them takes a time that grows with the length of the cell, no faster.
_POINT = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_COMMA = re.compile(r"[+-]?(?:[0-9]+(?:,[0-9]*)?|,[0-9]+)(?:[eE][+-]?[0-9]+)?")
_GROUPED_BY_COMMA = re.compile(r"[+-]?[0-9]{1,3}(?:,[0-9]{3})+(?:\.[0-9]*)?")
_GROUPED_BY_POINT = re.compile(r"[+-]?[0-9]{1,3}(?:\.[0-9]{3})+(?:,[0-9]*)?")
_BLANKS = "[ \u00a0\u2009\u202f'’]"
_GROUPED_BY_BLANK = re.compile(rf"[+-]?[0-9]{{1,3}}(?:{_BLANKS}[0-9]{{3}})+(?:[.,][0-9]*)?")
_CLOCK = re.compile(r"[0-9]+(?::[0-9]+)+(?:[.,][0-9]+)?")
_NOT_FINITE = re.compile(r"[+-]?inf(?:inity)?", re.IGNORECASE)
_COMMENT = re.compile(r"\s*#(?!(?:n/?a|nv|value|wert|valeur|div|ref|num|zahl)\b)", re.IGNORECASE)
_SAMPLE = 200  # lines by which the separator is judged


@dataclass(frozen=True)
class Row:
    """A line that is not empty. text: without the mark of a comment. comment: it began with '#'."""

    line: int
    text: str
    cells: tuple[str, ...]
    comment: bool = False


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a file. Raises SpecError where it is no text or holds nothing."""
    lines = list(_lines(read_text(path)))
    separator = _separator([text for _, text, comment in lines if not comment])
    rows = [Row(n, text, split(text, separator), comment) for n, text, comment in lines]
    if all(row.comment for row in rows):
        raise SpecError(f"{path}: holds no data")
    if wide := next((row for row in rows if len(row.cells) > MOST_CELLS), None):
        raise SpecError(
            f"{path}:{wide.line}: {len(wide.cells)} cells in a row; a table of data has at most "
            f"{MOST_CELLS}, each row of them one moment of the test"
        )
    return rows


def split(text: str, separator: str | None) -> tuple[str, ...]:
    """Return the cells of a line; those within quotes may hold the separator."""
    if separator is None:
        return tuple(text.split())
    try:
        cells = next(csv.reader([text], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:  # a cell of more than 131,072 characters
        return (text.strip(),)
    return tuple(" ".join(cell.split()) for cell in cells)


def _lines(text: str) -> Iterable[tuple[int, str, bool]]:
    """Line number, text and whether it is a comment; a heading within quotes may take lines."""
    lines = re.split(r"\r\n|\r|\n", text)
    number = 0
    while number < len(lines):
        first, line = number + 1, lines[number]
        number += 1
        if line.count('"') % 2:
            for more in range(1, 3):
                joined = " ".join([line, *lines[number : number + more]])
                if joined.count('"') % 2 == 0:
                    line, number = joined, number + more
                    break
        comment = bool(_COMMENT.match(line))
        line = line.lstrip(" \t#") if comment else line
        if line.strip(' \t;,|"'):
            yield first, line, comment


def _separator(lines: list[str]) -> str | None:
    """The mark at which most cells of the lines with numbers are numbers."""
    several = [line for line in lines if sum(map(line.count, "0123456789")) > 1]
    sample = several[:: max(len(several) // _SAMPLE, 1)]
    best, most = None, 0
    for mark in SEPARATORS:
        total = 0
        for line in sample:
            kinds = [cell_kind(cell) for cell in split(line, mark)]
            if kinds.count("number") > 1:
                total += kinds.count("number") - 2 * kinds.count("text")
        if total > most:
            best, most = mark, total
    if most:
        return best
    return next((mark for mark in SEPARATORS if mark and lines and mark in lines[-1]), None)


def cell_kind(cell: str) -> str:
    """Return 'number', 'missing' or 'text'. A time such as 12:30:01 counts as a number."""
    cell = _bare(cell)
    if cell.lower() in MISSING:
        return "missing"
    forms = (_POINT, _COMMA, _GROUPED_BY_COMMA, _GROUPED_BY_POINT, _CLOCK, _NOT_FINITE)
    return "number" if any(form.fullmatch(cell) for form in forms) else "text"


def decimal_mark(cells: Iterable[str]) -> str:
    """Return '.' or ',': the decimal mark of a table's cells, or '?' where it has both.

    '1,234' may be either; other cells decide, and where none does it is a decimal comma.
    """
    point = comma = maybe_comma = False
    for cell in map(_bare, cells):
        if cell.count(",") > 1 and _GROUPED_BY_COMMA.fullmatch(cell):
            point = True
        elif cell.count(".") > 1 and _GROUPED_BY_POINT.fullmatch(cell):
            comma = True
        elif "," in cell and (_COMMA.fullmatch(cell) or _GROUPED_BY_POINT.fullmatch(cell)):
            unsure = _GROUPED_BY_COMMA.fullmatch(cell) and not cell.lstrip("+-").startswith("0")
            maybe_comma, comma = maybe_comma or bool(unsure), comma or not unsure
        elif "." in cell and (_POINT.fullmatch(cell) or _GROUPED_BY_COMMA.fullmatch(cell)):
            grouped = _GROUPED_BY_POINT.fullmatch(cell)
            point = point or not (grouped and not cell.lstrip("+-").startswith("0"))
    if comma:
        return "?" if point else ","
    return "," if maybe_comma and not point else "."


def value(cell: str, mark: str) -> float | None:
    """Return the number in a cell with the decimal mark ``mark``, None where there is none."""
    cell = _bare(cell)
    plain, grouped, other = (
        (_COMMA, _GROUPED_BY_POINT, ".") if mark == "," else (_POINT, _GROUPED_BY_COMMA, ",")
    )
    if grouped.fullmatch(cell):
        cell = cell.replace(other, "")
    elif not plain.fullmatch(cell):
        return None
    return float(cell.replace(",", "."))


Faults = dict[int, list[tuple[int, str | None]]]


def numbers(rows: Sequence[Row], places: Iterable[int]) -> tuple[dict[int, np.ndarray], Faults]:
    """Return the numbers of columns and the faults of their cells.

    Numbers: place -> (rows,), NaN where a cell is empty or none. Faults: place -> list of line and
    what is wrong there. The cells of all columns tell the decimal mark, or those of each.
    """
    cells = {i: [row.cells[i] if i < len(row.cells) else "" for row in rows] for i in places}
    common = decimal_mark(cell for column in cells.values() for cell in column)
    found: dict[int, np.ndarray] = {}
    faults: Faults = {}
    for i, column in cells.items():
        mark = decimal_mark(column) if common == "?" else common
        found[i] = np.full(len(rows), math.nan)
        faults[i] = []
        for r, cell in enumerate(column):
            number = value(cell, mark)
            if number is not None and abs(number) <= LARGEST:
                found[i][r] = number
            elif cell_kind(cell) != "missing":
                faults[i].append((rows[r].line, cell_fault(cell, mark)))
    return found, faults


def cell_fault(cell: str, mark: str = ".") -> str | None:
    """Return what is wrong with a cell that should hold a number, None where it does."""
    number = value(cell, mark)
    if number is not None and abs(number) <= LARGEST:
        return None
    if number is not None and math.isfinite(number):
        return f"{show(cell)} is larger than anything that a test measures"
    if number is not None or _NOT_FINITE.fullmatch(_bare(cell)):
        return f"{show(cell)} is not a finite number"
    if mark == "?" and cell_kind(cell) == "number":
        return f"{show(cell)}: the table has decimal points and decimal commas; write one of them"
    return f"{show(cell)} is not a number" if cell else "there is no value"


def _bare(cell: str) -> str:
    """A cell without what is written around a number: ="1.2", a long minus, blanks in it."""
    cell = cell.strip()
    if cell.startswith('="') and cell.endswith('"'):
        cell = cell[2:-1]
    cell = cell.strip("\"'").replace("\N{MINUS SIGN}", "-").strip()
    if _GROUPED_BY_BLANK.fullmatch(cell):
        cell = re.sub(_BLANKS, "", cell)
    return cell
