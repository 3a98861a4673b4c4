"""A table of test data: columns and their meaning, numbers, specimen sizes, every cell checked."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

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
from softact.measured.headings import Column, plain_words, read_heading
from softact.measured.sizes import sizes_above
from softact.units import show

MANY = 5  # faults that are told one by one
_SPECIMEN_ROWS = 5  # a column of labels names that many rows alike; else it counts the rows


class UnreadableError(Exception):
    """A table cannot be read without help. message: why, without the path.

    columns, values: of what was found, for saying which help. renamed: better headings, by place.
    """

    def __init__(
        self,
        message: str,
        columns: Sequence[Column] = (),
        values: np.ndarray | None = None,
        renamed: Mapping[int, str] | None = None,
    ):
        super().__init__(message)
        self.columns, self.values, self.renamed = tuple(columns), values, dict(renamed or {})


@dataclass(frozen=True)
class Table:
    """Columns and their numbers.

    values: (rows, columns), NaN where a cell holds no number. sizes: specimen dimensions in mm
    (area in mm²) that stand above the table. specimens: label per row or None. rows: line numbers
    in the file. faults: of the cells of each column, one line each. messages: what was left out.
    """

    columns: tuple[Column, ...]
    values: np.ndarray
    sizes: dict[str, float]
    specimens: list[str] | None
    rows: list[int]
    faults: dict[int, list[str]] = field(default_factory=dict)
    messages: tuple[str, ...] = ()


def read_table(path: Path, given: tuple[str, ...] | None) -> Table:
    """Read a table separated by commas, semicolons, tabs or blanks.

    given: headings in place of the file's own. Raises SpecError where the file cannot be read and
    ``UnreadableError`` where nothing in it names a deformation and a load.
    """
    rows = read_rows(path)
    blocks = find_blocks(rows)
    main = largest(blocks)
    if given is not None:
        heading = None
        columns = tuple(read_heading(name) for name in given)
        parts = [main] if main else []
    else:
        heading, main = _heading_of(rows, blocks, main)
        columns = tuple(read_heading(name) for name in heading.names)
        parts = _alike(rows, blocks, main, columns)

    def named(block: Block) -> Heading | None:
        return next(headings(rows, block, end_above(blocks, block)), None)

    sizes = sizes_above(rows, blocks, main, named, plain_words)
    kept = [row for part in parts for row in rows[part.start : part.end] if not row.comment]
    _check_width(columns, kept, heading)
    labels = _labels(columns, kept, parts, rows)
    messages = _left_out(rows, blocks, parts, heading)
    values, faults = _numbers(columns, kept)
    return Table(
        columns, values, sizes, labels, [row.line for row in kept], faults, tuple(messages)
    )


def roles(columns: Sequence[Column]) -> set[str]:
    """The roles that columns play: 'x', 'y' or both."""
    return {column.quantity.role for column in columns} - {""}


def _heading_of(
    rows: Sequence[Row], blocks: Sequence[Block], main: Block | None
) -> tuple[Heading, Block]:
    """The heading that names a deformation and a load, and the block from the row after it on."""
    if main is None:
        return _without_numbers(rows)
    nearest = None
    for heading in headings(rows, main, end_above(blocks, main)):
        columns = [read_heading(name) for name in heading.names]
        nearest = nearest or columns
        if roles(columns) == {"x", "y"}:
            return heading, from_heading(rows, main, heading.end)
    _check_above(rows, blocks, main)
    kept = [row for row in rows[main.start : main.end] if not row.comment]
    columns = (nearest or [])[: main.width]
    columns += [read_heading("-")] * (main.width - len(columns))
    first = show(", ".join(cell for cell in rows[0].cells if cell))
    raise UnreadableError(
        f"no headings that name a deformation and a load (the first line is {first})",
        columns,
        _numbers(columns, kept, every=True)[0],
    )


def _check_above(rows: Sequence[Row], blocks: Sequence[Block], main: Block) -> None:
    """A line of text may part a table under good headings in two."""
    for block in blocks:
        if block.end <= main.start and block.width == main.width:
            for heading in headings(rows, block, end_above(blocks, block)):
                if roles([read_heading(name) for name in heading.names]) == {"x", "y"}:
                    raise _parted(rows[block.end])


def _parted(row: Row, columns: Sequence[Column] = ()) -> UnreadableError:
    return UnreadableError(
        f"line {row.line}: {show(row.text)} stands between rows of numbers; delete it, or make "
        "two files",
        columns,
    )


def _without_numbers(rows: Sequence[Row]) -> tuple[Heading, Block]:
    """A file of headings alone, or of headings and rows in which hardly a cell is a number."""
    for i, row in enumerate(rows):
        if roles([read_heading(cell) for cell in row.cells]) == {"x", "y"}:
            return Heading(row.line, row.cells, i + 1), Block(i + 1, len(rows), len(row.cells))
    first = show(", ".join(cell for cell in rows[0].cells if cell))
    raise UnreadableError(f"there is no table of numbers (the first line is {first})")


def _alike(
    rows: Sequence[Row], blocks: Sequence[Block], main: Block, columns: Sequence[Column]
) -> list[Block]:
    """The blocks under headings that mean what those of the main block mean: other specimens."""
    meant = [(column.quantity.name, column.factor) for column in columns]
    parts = []
    for block in blocks:
        if block.start <= main.start < block.end or block.end == main.end:
            parts.append(main)
            continue
        for heading in headings(rows, block, end_above(blocks, block)):
            others = [read_heading(name) for name in heading.names]
            if [(c.quantity.name, c.factor) for c in others] == meant:
                parts.append(from_heading(rows, block, heading.end))
                break
        else:
            if block.start >= main.end and block.width == main.width and block.count >= MANY:
                raise _parted(rows[main.end])
    return parts or [main]


def _labels(
    columns: Sequence[Column], kept: Sequence[Row], parts: Sequence[Block], rows: Sequence[Row]
) -> list[str] | None:
    """A label of the specimen per row: from a column, or by the table in which it stands."""
    place = next((i for i, c in enumerate(columns) if c.quantity.name == "specimen"), None)
    if place is not None:
        labels = [row.cells[place] if place < len(row.cells) else "" for row in kept]
        if _SPECIMEN_ROWS * len(set(labels)) <= len(labels):
            return labels
    if len(parts) < 2:
        return None
    counts = [sum(not row.comment for row in rows[p.start : p.end]) for p in parts]
    return [str(i) for i, count in enumerate(counts, 1) for _ in range(count)]


def _left_out(
    rows: Sequence[Row], blocks: Sequence[Block], parts: Sequence[Block], heading: Heading | None
) -> list[str]:
    """What was not read though it holds numbers or stands within the table."""
    messages = []
    for part in parts:
        for row in part.after:
            messages.append(f"line {row.line} is no row of numbers and left out: {show(row.text)}")
    used = [range(part.start, part.end) for part in parts]
    for block in blocks:
        seen = block.count > 2 * MANY or (parts and block.start >= parts[-1].end)
        if seen and not any(block.end - 1 in part for part in used):
            first, last = rows[block.start].line, rows[block.end - 1].line
            messages.append(f"another table, lines {first} to {last}, is left out")
    if heading and parts:
        between = [row for row in rows[heading.end : parts[0].start] if not row.comment]
        for row in between:
            messages.append(f"line {row.line} under the headings is left out: {show(row.text)}")
    return messages[:MANY]


def _check_width(columns: Sequence[Column], kept: Sequence[Row], heading: Heading | None) -> None:
    """More cells than headings are decimal commas in a table that commas separate, or an error."""
    if heading is None:
        return
    for row in kept:
        if extra := [cell for cell in row.cells[len(columns) :] if cell]:
            raise UnreadableError(
                f"line {row.line} holds {len(columns) + len(extra)} values under {len(columns)} "
                "headings; decimal commas in a table separated by commas? Then separate it by "
                "semicolons, or write decimal points",
                columns,
            )


def _numbers(
    columns: Sequence[Column], kept: Sequence[Row], every: bool = False
) -> tuple[np.ndarray, dict[int, list[str]]]:
    """Values (rows, columns), and the faults of each column that could be used."""
    used = [i for i, column in enumerate(columns) if column.quantity.role or every]
    found, wrong = numbers(kept, used)
    values = np.full((len(kept), len(columns)), math.nan)
    for i in used:
        values[:, i] = found[i]
    return values, {
        i: [f"{line}: column '{columns[i].heading}': {fault}" for line, fault in wrong[i]]
        for i in used
        if wrong[i]
    }
