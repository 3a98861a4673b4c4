"""The specimen's sizes as they stand above the table: in lines, or in a table of results."""

import math
import re
from collections.abc import Callable, Iterator, Sequence

from softact.measured.blocks import Block, Heading
from softact.measured.cells import Row, decimal_mark, value
from softact.measured.spelling import is_unit, registry_unit
from softact.units import LENGTH

# Which words stand for a size; the first that is found counts. Areas are in mm².
WORDS = {
    "thickness": r"(\bthickness\b|dicke\b|\bepaisseur\b)",
    "width": r"(\bwidth\b|breite\b|\blargeur\b)",
    "diameter": r"(\bdiameter\b|durchmesser)",
    "area": r"(\bcross ?section|\bquerschnitt|\barea\b|\bs 0\b)",
    "gauge": r"(\bgau?ge\b|\bl 0\b|messlange|einspannlange|\bgrip separation\b|\bklemmlange)",
    "length": r"(\blength\b|lange\b|\blongueur\b|\bheight\b|\bhohe\b)",
}
_LINE = re.compile(r"([^:=]{2,60})[:=]\s*([-+.,0-9eE]{1,20})\s*([^\s]{0,12})")


def sizes_above(
    rows: Sequence[Row],
    blocks: Sequence[Block],
    main: Block | None,
    named: Callable[[Block], Heading | None],
    plain_words: Callable[[str], str],
) -> dict[str, float]:
    """Return the sizes in mm (areas in mm²) that a file states outside of its table.

    named: the heading of a block. plain_words: those of a text. A size that a file states with
    two values (several specimens in a results table) is left out.
    """
    found: dict[str, set[float]] = {}
    for i, row in enumerate(rows):
        if main is None or not main.start <= i < main.end:
            for name, size in _of_row(row, plain_words):
                found.setdefault(name, set()).add(size)
    for block in blocks:
        if block is not main and (heading := named(block)):
            for name, size in _of_block(rows, block, heading, plain_words):
                found.setdefault(name, set()).add(size)
    sizes = {name: values.pop() for name, values in found.items() if len(values) == 1}
    if "diameter" in sizes:
        sizes.setdefault("area", math.pi / 4 * sizes.pop("diameter") ** 2)
    if "gauge" in sizes:
        sizes["length"] = sizes.pop("gauge")
    return sizes


def _of_row(row: Row, plain_words: Callable[[str], str]) -> Iterator[tuple[str, float]]:
    """'Width (mm);3', 'Width;3;mm' and 'Width: 3 mm'."""
    cells = [cell for cell in row.cells if cell]
    if len(cells) > 1 and (number := _number(cells[1])) is not None:
        unit = cells[2] if len(cells) > 2 and is_unit(cells[2]) else _last_unit(cells[0])
        yield from _size(cells[0], number, unit, plain_words)
    elif match := _LINE.match(row.text.strip(' "')):
        if (number := _number(match[2])) is not None:
            yield from _size(match[1], number, match[3].strip('";,'), plain_words)


def _of_block(
    rows: Sequence[Row], block: Block, heading: Heading, plain_words: Callable[[str], str]
) -> Iterator[tuple[str, float]]:
    for row in rows[block.start : block.end]:
        for name, cell in zip(heading.names, row.cells, strict=False):
            if (number := _number(cell)) is not None:
                yield from _size(name, number, _last_unit(name), plain_words)


def _size(
    name: str, number: float, unit: str, plain_words: Callable[[str], str]
) -> Iterator[tuple[str, float]]:
    plain = plain_words(name)
    size = next((size for size, pattern in WORDS.items() if re.search(pattern, plain)), None)
    if size is None:
        return
    factor = _factor(unit, size == "area")
    if factor is not None:
        yield size, number * factor


def _factor(unit: str, area: bool) -> float | None:
    if area:
        match = re.fullmatch(r"([A-Za-z]+)\^?[2²]", unit.strip("()[]{} "))
        unit = match[1] if match else ""
    known = registry_unit(unit, LENGTH)
    if known is None:
        return None
    factor = LENGTH.parse(f"1 {known}")
    return factor * factor if area else factor


def _last_unit(name: str) -> str:
    """'Width (mm)', 'Width_mm' and 'Width in mm' have mm."""
    return (re.sub(r"[_():\[\]]+", " ", name).split() or [""])[-1]


def _number(cell: str) -> float | None:
    number = value(cell, decimal_mark([cell]))
    return number if number is not None and math.isfinite(number) else None
