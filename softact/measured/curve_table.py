"""A measured table whose headings name columns of a run: which they mean, and the numbers."""

import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from softact.errors import SpecError
from softact.measured.blocks import (
    Block,
    Heading,
    end_above,
    find_blocks,
    from_heading,
    headings,
    largest,
)
from softact.measured.cells import Row, numbers, read_rows
from softact.measured.headings import counts_only
from softact.measured.spelling import registry_unit
from softact.measured.tables import MANY
from softact.nearest import nearest
from softact.units import FORCE, LENGTH, PRESSURE, conversion, show

# How the endings of a run's columns, and shorthands of people, are written for the unit registry.
UNITS = {"mm3": "mm^3", "Nmm": "N*mm", "deg": "degree", "%": "percent", "ml": "mL", "°": "degree"}
ENDINGS = ("kPa", "MPa", "deg", "mm3", "mm", "mJ", "Nmm", "N")
SKIPPED = "-"
EXAMPLES = ("pressure_kPa", "bending_angle_deg", "tip_z_mm", "elongation_mm")
#: Place of a column of the table -> the run's column and the factor to its unit.
Used = dict[int, tuple[str, float]]


@dataclass(frozen=True)
class Columns:
    """Columns of a measured table in the run's units. line: of the headings in the file."""

    line: int
    values: Mapping[str, np.ndarray]
    messages: tuple[str, ...]


def read_columns(
    path: Path, columns: Sequence[str], given: Sequence[str] | None, command: str
) -> Columns:
    """Read the columns of a table that a run has too.

    columns: names of the run's. given: headings in place of the file's own. command: what the user
    called, for saying how the file can be read. Raises SpecError with one line per fault.
    """
    rows = read_rows(path)
    blocks = find_blocks(rows)
    heading, block = _heading(path, rows, blocks, columns, given, command)
    used, messages, faults = _meanings(heading, columns)
    faults = [f"{path}:{heading.line}: {fault}" for fault in faults]
    kept = [row for row in rows[block.start : block.end] if not row.comment]
    if faults or len(used) < 2:
        if len(used) < 2 and not faults:
            found = ", ".join(name for name, _ in used.values()) or "none"
            faults = [
                f"{path}:{heading.line}: two columns or more are wanted, such as 'pressure_kPa, "
                f"bending_angle_deg'; found {found}"
            ]
        if given is None:
            faults[-1] += _advice(command, heading.names, used, columns)
        raise SpecError(*faults)
    messages += [f"line {row.line} is left out: {show(row.text)}" for row in block.after[:MANY]]
    values, lost = _numbers(path, kept, heading.names, used)
    return Columns(heading.line, values, tuple(messages + lost))


def _heading(
    path: Path,
    rows: Sequence[Row],
    blocks: Sequence[Block],
    columns: Sequence[str],
    given: Sequence[str] | None,
    command: str,
) -> tuple[Heading, Block]:
    """The row that names most columns of a run, and the numbers under it."""
    main = largest(blocks)
    if given is not None:
        line = rows[main.start].line if main else rows[0].line
        names = Heading(line, tuple(given), main.start if main else 0)
        return names, main or Block(min(1, len(rows)), len(rows), len(given))
    if main is None:
        first = next((i for i, row in enumerate(rows) if not row.comment), 0)
        names = Heading(rows[first].line, rows[first].cells, first + 1)
        return names, Block(first + 1, len(rows), len(rows[first].cells))
    above = list(headings(rows, main, end_above(blocks, main)))
    best = max(above, key=lambda heading: len(_meanings(heading, columns)[0]), default=None)
    # A comment that names nothing is no heading.
    if best is None or (best.comment and not _meanings(best, columns)[0]):
        cells = ("",) * main.width
        raise SpecError(
            f"{path}:{rows[main.start].line}: the table has no headings; name its columns in a "
            "line above it, such as 'pressure_kPa, bending_angle_deg'"
            f"{_advice(command, cells, {}, columns)}"
        )
    return best, from_heading(rows, main, best.end)


def _meanings(heading: Heading, columns: Sequence[str]) -> tuple[Used, list[str], list[str]]:
    """Place -> (run's column, factor), what to say of the others, and faults."""
    used: Used = {}
    messages: list[str] = []
    faults: list[str] = []
    for place, text in enumerate(heading.names):
        if text in (SKIPPED, ""):
            continue
        try:
            name, factor = meaning(text, columns)
        except ValueError as error:
            if counts_only(text):
                messages.append(f"{show(text)} left out")
            else:
                faults.append(str(error))
            continue
        if name in [entry[0] for entry in used.values()]:
            faults.append(f"two columns are {name}; keep one")
            continue
        used[place] = name, factor
    return used, messages, faults


def _advice(command: str, names: Sequence[str], used: Used, columns: Sequence[str]) -> str:
    """The command that reads the file: columns that were understood, and '-' for the others."""
    written = [names[i].replace(",", " ") if i in used else SKIPPED for i in range(len(names))]
    have = {name for name, _ in used.values()}
    others = [name for name in (*EXAMPLES, *columns) if name in columns and name not in have]
    guessed = False
    for i in range(len(names)):
        if len(have) >= 2 or not others:
            break
        if i not in used and not (names[i] and counts_only(names[i])):
            written[i] = others.pop(0)
            have.add(written[i])
            guessed = True
    if len(have) < 2:
        return ""
    said = ", with what the columns hold in place of the names" if guessed else ""
    return f"; read it with: {command} --columns {shlex.quote(', '.join(written))}{said}"


def _numbers(
    path: Path, rows: Sequence[Row], names: Sequence[str], used: Used
) -> tuple[dict[str, np.ndarray], list[str]]:
    """Return the columns in the run's units, and what to say of rows without a value."""
    if not rows:
        raise SpecError(f"{path}: there are headings but no values under them")
    found, wrong = numbers(rows, used)
    in_order = sorted(
        (line, f"{path}:{line}: column '{names[i]}': {fault}")
        for i in used
        for line, fault in wrong[i]
    )
    faults = [fault for _, fault in in_order]
    full = np.all([np.isfinite(column) for column in found.values()], axis=0)
    if len(faults) > MANY:
        faults = [*faults[:MANY], f"{path}: and {len(faults) - MANY} more faults of this kind"]
    if not faults and not full.any():
        faults = [f"{path}: no row has a value in every column; skip a column with '-'"]
    if faults:
        raise SpecError(*faults)
    lost = len(rows) - int(full.sum())
    first = rows[int(np.argmin(full))].line
    said = f"{lost} of {len(rows)} rows lack a value and are left out, first line {first}"
    values = {name: factor * found[i][full] for i, (name, factor) in used.items()}
    return values, [said] if lost else []


def meaning(heading: str, columns: Sequence[str]) -> tuple[str, float]:
    """Return the run's column that a heading means and the factor to that column's unit.

    'bending_angle_deg', 'bending angle (rad)' and 'Pressure [bar]' are understood. Raises
    ValueError with what would be right.
    """
    if heading in columns:
        return heading, 1.0
    words = re.sub(r"[_,;:()\[\]]+", " ", heading).split()
    lower = [word.lower() for word in words]
    for name in sorted(columns, key=len, reverse=True):
        stem, unit = split_unit(name)
        known = stem.lower().split("_")
        if lower[: len(known)] != known:
            continue
        written = " ".join(words[len(known) :])
        if not unit and written in ("", "-", "1"):
            return name, 1.0
        if not unit:
            continue
        if not written:
            raise ValueError(f"{show(heading)} names no unit; write for example '{name}'")
        try:
            return name, conversion(_unit(written, unit), _unit(unit, unit))
        except ValueError as error:
            raise ValueError(f"{show(heading)}: {error}") from None
    raise ValueError(f"{show(heading)} is no column of a run; {nearest(heading, columns)}")


def _unit(text: str, like: str) -> str:
    """A unit as the registry writes it: '/ kPa', 'KPa' and 'N/mm2' are understood too.

    like: a unit of what is measured.
    """
    text = re.sub(r"^(/|in)\s+", "", text)
    for dimension in (LENGTH, FORCE, PRESSURE):
        if registry_unit(like, dimension) and (unit := registry_unit(text, dimension)):
            return unit
    return UNITS.get(text) or re.sub(r"(?<=[A-Za-z])([23])\b", r"^\1", text)


def split_unit(name: str) -> tuple[str, str]:
    """'pressure_kPa' -> ('pressure', 'kPa'); no unit: ('max_principal_stretch', '')."""
    stem, _, ending = name.rpartition("_")
    return (stem, ending) if stem and ending in ENDINGS else (name, "")
