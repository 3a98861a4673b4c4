"""Where in a file the numbers stand, and what may be their headings."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from softact.measured.cells import SEPARATORS, Row, cell_kind, split
from softact.measured.spelling import is_unit

_ABOVE = 12  # rows above the numbers in which headings are looked for
_SAID_UNIT = {"unit", "units", "einheit", "einheiten", "unite", "unites"}


@dataclass(frozen=True)
class Block:
    """Rows ``start`` to ``end`` (not included) of a file: numbers, row under row.

    width: cells of most of its rows. after: rows at its end that hold text where the others hold
    numbers, and are no part of it.
    """

    start: int
    end: int
    width: int
    after: tuple[Row, ...] = ()

    @property
    def count(self) -> int:
        """Number of rows."""
        return self.end - self.start


@dataclass(frozen=True)
class Heading:
    """Names of columns, each with the unit that stood under it.

    end: the row after the units. comment: the names stand in a comment.
    """

    line: int
    names: tuple[str, ...]
    end: int
    comment: bool = False


def find_blocks(rows: Sequence[Row]) -> list[Block]:
    """Return the blocks of a file from top to bottom.

    A block begins with a row of two numbers or more and goes on while a row has a number or no
    text.
    """
    kinds = [[] if row.comment else [cell_kind(cell) for cell in row.cells] for row in rows]
    found, start = [], None
    for i, have in enumerate([*kinds, ["text"]]):
        numbers = have.count("number")
        if start is None:
            alone = numbers == 1 and "text" not in have and len(have) > 1
            if numbers > 1 or alone:
                start = i
        elif not (numbers or "text" not in have):
            found.append(_trimmed(rows, kinds, start, i))
            start = None
    return [block for block in found if block.count]


def _trimmed(rows: Sequence[Row], kinds: list[list[str]], start: int, end: int) -> Block:
    """The block without the rows at its ends that are text to most of the others."""
    inside = [i for i in range(start, end) if kinds[i]]
    numbers = Counter(j for i in inside for j, kind in enumerate(kinds[i]) if kind == "number")
    usual = [j for j, count in numbers.items() if 2 * count >= len(inside)]

    def foreign(i: int) -> bool:
        return any(j < len(kinds[i]) and kinds[i][j] == "text" for j in usual)

    first = next((i for i in inside if not foreign(i)), end)
    last = next((i for i in reversed(inside) if not foreign(i)), first - 1)
    width = Counter(len(rows[i].cells) for i in inside).most_common(1)[0][0]
    return Block(first, last + 1, width, tuple(rows[i] for i in inside if i > last))


def largest(blocks: Sequence[Block]) -> Block | None:
    """The block with most rows, the last of those; None where there is none."""
    return max(blocks, key=lambda block: (block.count, block.start), default=None)


def end_above(blocks: Sequence[Block], block: Block) -> int:
    """The row at which the block before ends."""
    return max((other.end for other in blocks if other.end <= block.start), default=0)


def from_heading(rows: Sequence[Row], block: Block, first: int) -> Block:
    """The block with the rows below its heading in which some cell is a number: bad ones too."""
    start = block.start
    while start > first and any(cell_kind(cell) == "number" for cell in rows[start - 1].cells):
        start -= 1
    return Block(start, block.end, block.width, block.after)


def headings(rows: Sequence[Row], block: Block, above: int) -> Iterator[Heading]:
    """Yield the rows above a block that may name its columns, the nearest first.

    A row of units under a row of names is joined with it. Comments come after all others. above:
    the row at which the block before ends.
    """
    lowest = max(above, block.start - _ABOVE)
    near = [i for i in range(block.start - 1, lowest - 1, -1) if not rows[i].comment]
    notes = [i for i in range(block.start - 1, lowest - 1, -1) if rows[i].comment]
    units: tuple[int, tuple[str, ...]] | None = None
    for i in [*near, *notes]:
        cells = _fitting(rows[i], block.width)
        if is_unit_row(cells):
            units = units or (i, cells)
        elif sum(bool(cell) for cell in cells) > 1:
            yield _joined(rows[i], i, cells, units)


def _joined(
    row: Row, i: int, cells: tuple[str, ...], units: tuple[int, tuple[str, ...]] | None
) -> Heading:
    if units is None or units[0] < i:
        return Heading(row.line, cells, i + 1, row.comment)
    under = [*units[1], *[""] * len(cells)]
    names = [
        f"{name} ({unit})" if name and (unit := under[j].strip("()[]{}<> ")) else name
        for j, name in enumerate(cells)
    ]
    return Heading(row.line, tuple(names), units[0] + 1, row.comment)


def is_unit_row(cells: Sequence[str]) -> bool:
    """Whether all cells that hold anything hold a unit, such as (mm), [N] or kPa."""
    full = [cell for cell in cells if cell]
    if full and full[0].lower().strip(":") in _SAID_UNIT:
        full = full[1:]
    return bool(full) and all(is_unit(cell) for cell in full)


def _fitting(row: Row, width: int) -> tuple[str, ...]:
    """The cells of a heading: split so that there are as many as there are columns, if it can."""
    cells = _without_end(row.cells)
    if len(cells) == width:
        return cells
    for mark in SEPARATORS[:-1]:
        other = _without_end(split(row.text, mark))
        if len(other) == width:
            return other
    wide = tuple(part.strip() for part in row.text.split("  ") if part.strip())
    joined = _brackets_joined(row.text.split())
    return next((other for other in (wide, joined) if len(other) == width), cells)


def _without_end(cells: tuple[str, ...]) -> tuple[str, ...]:
    """The cells without empty ones at the end."""
    count = max((i + 1 for i, cell in enumerate(cells) if cell), default=0)
    return cells[:count]


def _brackets_joined(words: list[str]) -> tuple[str, ...]:
    """Words with the bracket that follows: 'force (N)' is one heading."""
    cells: list[str] = []
    for word in words:
        if cells and word[0] in "([":
            cells[-1] += f" {word}"
        else:
            cells.append(word)
    return tuple(cells)
