"""A table of test data: separators, headings, comments and specimen sizes, every cell checked."""

import csv
import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softact.errors import SpecError
from softact.files import read_file
from softact.fit.columns import Column, read_heading
from softact.units import LENGTH, show

SIZES = ("thickness", "width", "length")
MAX_BYTES = 200_000_000


@dataclass(frozen=True)
class Table:
    """Columns and their numbers.

    values: (rows, columns); ignored columns hold NaN. sizes: specimen dimensions in mm that stand
    above the table. specimens: label per row or None. rows: line numbers in the file.
    """

    columns: tuple[Column, ...]
    values: np.ndarray
    sizes: dict[str, float]
    specimens: list[str] | None
    rows: list[int]


def read_table(path: Path, headings: tuple[str, ...] | None) -> Table:
    """Read a CSV, semicolon, tab or blank separated file.

    headings: used in place of the file's own. Raises SpecError naming file, line and column.
    """
    cells = read_rows(path)
    sizes: dict[str, float] = {}
    if headings is not None:
        columns = _columns(path, headings)
        start = next((i for i, (_, row) in enumerate(cells) if _is_number(row[0])), 0)
    else:
        start, columns = _find_headings(path, cells, sizes)
    return _numbers(path, columns, cells[start:], sizes)


def read_rows(path: Path) -> list[tuple[int, list[str]]]:
    """Return line number and cells of each line that is neither empty nor a comment (#).

    Raises SpecError where the file is no text or holds nothing.
    """
    lines = _lines(path)
    separator = _separator(lines)
    return [(number, _split(line, separator)) for number, line in lines]


def cell_fault(cell: str) -> str | None:
    """Return what is wrong with a cell that should hold a number, None where it does."""
    try:
        value = float(cell)
    except ValueError:
        hint = "; write a decimal point" if re.fullmatch(r"-?\d+,\d+", cell) else ""
        return f"{show(cell)} is not a number{hint}" if cell else "there is no value"
    return None if math.isfinite(value) else f"'{cell}' is not a finite number"


def _lines(path: Path) -> list[tuple[int, str]]:
    text = read_file(path, MAX_BYTES, "a table of test data")
    if b"\0" in text[:4096]:
        raise SpecError(f"{path}: is not a text file; save the table as CSV")
    lines = text.decode("utf-8-sig", errors="replace").splitlines()
    kept = [
        (n, line)
        for n, line in enumerate(lines, start=1)
        if line.strip(" \t;,") and not line.lstrip().startswith("#")
    ]
    if not kept:
        raise SpecError(f"{path}: holds no data")
    return kept


def _separator(lines: list[tuple[int, str]]) -> str | None:
    """The separator of the last line: by then the table has certainly begun."""
    last = lines[-1][1]
    return next((mark for mark in (";", "\t", ",") if mark in last), None)


def _split(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.split()
    return [cell.strip() for cell in next(csv.reader([line], delimiter=separator))]


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return bool(re.fullmatch(r"\d+(:\d+)+(\.\d+)?", cell))
    return True


def _columns(path: Path, headings) -> tuple[Column, ...]:
    try:
        columns = tuple(read_heading(heading) for heading in headings)
    except ValueError as error:
        raise SpecError(f"{path}: column {error}") from None
    return columns


def _find_headings(path: Path, cells, sizes: dict[str, float]) -> tuple[int, tuple[Column, ...]]:
    """Return where the data begin and the columns, and collect specimen sizes on the way."""
    for i, (_, row) in enumerate(cells):
        if _is_number(row[0]) and len(row) > 1:
            break
        if _read_size(row, sizes):
            continue
        roles = set()
        if len(row) > 1:
            try:
                roles = {column.quantity.role for column in _columns(path, row)}
            except SpecError:
                if i + 1 < len(cells) and _is_number(cells[i + 1][1][0]):
                    raise
        if {"x", "y"} <= roles:
            return i + 1, _columns(path, row)
    found = show(", ".join(cells[0][1]))
    raise SpecError(
        f"{path}: no headings that name a deformation and a load (the first line is {found}); "
        "give --columns, for example --columns 'stretch, nominal_stress MPa'"
    )


def _read_size(row: list[str], sizes: dict[str, float]) -> bool:
    """Take a line such as ``Specimen Thickness (mm);3`` as a dimension."""
    if len(row) < 2 or not _is_number(row[1]):
        return False
    words = re.sub(r"[_():\[\]]+", " ", row[0]).lower().split()
    name = next((size for size in SIZES if size in words), None)
    if name is None:
        return False
    try:
        sizes[name] = float(row[1]) * LENGTH.parse(f"1 {words[-1]}")
    except ValueError:
        return False
    return True


def _numbers(path: Path, columns, cells, sizes: dict[str, float]) -> Table:
    used = [i for i, column in enumerate(columns) if column.quantity.role]
    labels = [i for i, column in enumerate(columns) if column.quantity.name == "specimen"]
    values = np.full((len(cells), len(columns)), math.nan)
    faults = []
    for r, (number, row) in enumerate(cells):
        for i in used:
            cell = row[i] if i < len(row) else ""
            if fault := cell_fault(cell):
                faults.append(f"{path}:{number}: column '{columns[i].heading}': {fault}")
            else:
                values[r, i] = float(cell)
    if faults:
        more = (
            [f"{path}: and {len(faults) - 5} more faults of this kind"] if len(faults) > 5 else []
        )
        raise SpecError(*faults[:5], *more)
    specimens = None
    if labels:
        specimens = [row[labels[0]] if labels[0] < len(row) else "" for _, row in cells]
    return Table(columns, values, sizes, specimens, [number for number, _ in cells])
