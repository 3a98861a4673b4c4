"""CSV files whose header says what a column is and in which unit.

All functions raise SpecError, in one line.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from softact.errors import SpecError
from softact.units import conversion, show

_HEADING = re.compile(r"(?P<name>.*?)[\s_]*[(\[](?P<unit>[^)\]]*)[)\]]|(?P<n>.*)[\s_](?P<u>\S+)")


def rows(path: Path, example: str) -> list[list[str]]:
    """The header and two rows at least, empty ones left out. example: of a header."""
    try:
        with open(path, encoding="utf-8-sig", newline="") as file:
            rows = [row for row in csv.reader(file) if any(cell.strip() for cell in row)]
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is no text of UTF-8"
        raise SpecError(f"{path.name}: cannot be read ({why})") from None
    if len(rows) < 3:
        raise SpecError(f"{path.name}: a header such as '{example}' and two rows are wanted")
    return rows


def named(path: Path, heading: str, example: str) -> tuple[str, str]:
    """Name in small letters and unit of a heading."""
    match = _HEADING.fullmatch(heading.strip())
    if match is None:
        raise SpecError(f"{path.name}: {show(heading)} has no unit; write '{example}'")
    if match["unit"] is not None:
        return match["name"].strip().lower(), match["unit"].strip()
    return match["n"].strip().lower(), match["u"].strip()


def factor(path: Path, heading: str, unit: str, internal: str) -> float:
    """From the unit of a heading to the internal one."""
    try:
        return conversion(unit, internal)
    except ValueError as error:
        raise SpecError(f"{path.name}: {show(heading)}: {error}") from None


def numbers(path: Path, rows: Sequence[Sequence[str]]) -> np.ndarray:
    """The numbers (n, columns) of the rows below the header, the first of them."""
    count = len(rows[0])
    return np.array([_row(path, i, row, count) for i, row in enumerate(rows[1:], 2)])


def _row(path: Path, number: int, row: Sequence[str], count: int) -> list[float]:
    """The numbers of a row; number: of it, from 1, the header being the first."""
    if len(row) != count:
        raise SpecError(f"{path.name}: row {number} has {len(row)} cells, and the header {count}")
    try:
        values = [float(cell) for cell in row]
    except ValueError:
        raise SpecError(
            f"{path.name}: row {number} holds {show(','.join(row))}, no numbers"
        ) from None
    if not all(map(math.isfinite, values)):
        raise SpecError(f"{path.name}: row {number} holds a number that is not finite")
    return values
