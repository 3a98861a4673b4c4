"""Which columns of a table are the deformation and the load, where it has several of each."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from softact.fit.sheet import TestSheet
from softact.measured.headings import Column
from softact.measured.tables import Table, UnreadableError

# The better first: a strain may come from an extensometer and needs no gauge length.
DEFORMATIONS = ("stretch", "strain", "true_strain", "displacement", "position", "length")
LOADS = ("nominal_stress", "standard_stress", "stress", "cauchy_stress", "force")
TRAVEL = ("displacement", "position", "length")
CONSTANT = 0.01  # scatter of a ratio of two columns that is taken for rounding
APART = 0.02  # of two sizes that should be one


@dataclass(frozen=True)
class Choice:
    """Places of the columns that are read. stress: 'nominal', 'cauchy' or 'force'."""

    x: int
    y: int
    stress: str
    messages: tuple[str, ...]


def choose(sheet: TestSheet, table: Table, rows: np.ndarray, direction: str | None) -> Choice:
    """Return the columns to read: what the options ask for, else the physically better ones.

    rows: of the specimen. Raises ``UnreadableError`` where nothing fits or several could be meant.
    """
    x = pick(sheet, table, rows, "x", direction)
    y = pick(sheet, table, rows, "y", direction)
    stress, lines = _kind_of_stress(sheet, table, rows, x, y)
    messages = [*_taken(table, rows, x, y, direction), *lines]
    return Choice(x, y, stress, tuple(messages))


def pick(sheet: TestSheet, table: Table, rows: np.ndarray, role: str, direction: str | None) -> int:
    """Return the place of the column that is taken for a role ('x' or 'y')."""
    places = _candidates(table, rows, role, direction)
    order = _preference(sheet, role)
    places.sort(key=lambda i: (table.columns[i].fault is not None, order(table.columns[i])))
    if not places:
        kind = "deformation (stretch, strain, displacement)" if role == "x" else "load"
        raise UnreadableError(f"no column for the {kind}", table.columns, table.values)
    best = table.columns[places[0]]
    if best.fault:
        raise UnreadableError(f"column {best.fault}", table.columns, table.values)
    alike = [i for i in places if table.columns[i].quantity is best.quantity
             and not table.columns[i].fault]  # fmt: skip
    if len(alike) > 1:
        said = ", ".join(f"'{table.columns[i].heading}'" for i in alike)
        raise UnreadableError(
            f"several columns could be meant ({said})", _only(table, places[0]), table.values
        )
    return places[0]


def _only(table: Table, place: int) -> list[Column]:
    """The columns without those that mean the same as one of them."""
    best = table.columns[place]
    ignored = Column("-", type(best.quantity)("ignored", "", None, ""), 1.0, None)
    return [
        ignored if i != place and c.quantity is best.quantity else c
        for i, c in enumerate(table.columns)
    ]


def _candidates(table: Table, rows: np.ndarray, role: str, direction: str | None) -> list[int]:
    found = [
        i
        for i, c in enumerate(table.columns)
        if c.quantity.role == role and c.direction in (None, direction)
    ]
    exact = [i for i in found if direction and table.columns[i].direction == direction] or found
    filled = [i for i in exact if i in table.faults or np.isfinite(table.values[rows, i]).any()]
    moving = [i for i in filled if i in table.faults or _moves(table.values[rows, i])]
    return moving or filled or exact


def _moves(values: np.ndarray) -> bool:
    values = values[np.isfinite(values)]
    return len(values) > 0 and float(np.ptp(values)) > 0.0


def _preference(sheet: TestSheet, role: str) -> Callable[[Column], int]:
    """Order of the quantities: what the options ask for comes first."""
    names = list(DEFORMATIONS if role == "x" else LOADS)
    asked: tuple[str, ...] = ()
    if role == "x" and sheet.length is not None:
        asked = TRAVEL
    elif role == "y" and (sheet.area or sheet.width or sheet.thickness):
        asked = ("force",)
    elif role == "y" and sheet.stress == "cauchy":
        asked = ("cauchy_stress", "stress", "standard_stress")
    order = {name: i for i, name in enumerate([*asked, *names][::-1])}
    return lambda column: -order[column.quantity.name]


def _taken(table: Table, rows: np.ndarray, x: int, y: int, direction: str | None) -> list[str]:
    """Say what is read where there was a choice."""
    left = [
        f"'{table.columns[i].heading}'"
        for role in "xy"
        for i in _candidates(table, rows, role, direction)
        if i not in (x, y)
    ]
    messages = [remark for i in (x, y) if (remark := table.columns[i].remark)]
    if left:
        took = " and ".join(f"'{table.columns[i].heading}'" for i in (x, y))
        messages.append(f"{took} taken; left out: {', '.join(left)}")
    return messages


def _kind_of_stress(
    sheet: TestSheet, table: Table, rows: np.ndarray, x: int, y: int
) -> tuple[str, list[str]]:
    """Return 'nominal', 'cauchy' or 'force', and what to say of it."""
    column = table.columns[y]
    kind = column.quantity.name
    if kind == "force":
        return "force", []
    if kind in ("nominal_stress", "cauchy_stress"):
        found = kind.removesuffix("_stress")
        if sheet.stress and sheet.stress != found:
            raise UnreadableError(
                f"'{column.heading}' is not the {sheet.stress} stress", table.columns, table.values
            )
        return found, []
    if sheet.stress:
        return sheet.stress, []
    by_load = _by_load(table, rows, x, y)
    if by_load:
        return by_load
    if kind == "standard_stress":
        return "nominal", [
            f"'{column.heading}' read as force per undeformed area, as ISO 37 and ISO 527 have "
            "it; --stress cauchy if it is not"
        ]
    raise UnreadableError(
        f"column '{column.heading}' does not say which stress; name it nominal_stress (force per "
        "undeformed area) or cauchy_stress, or give --stress",
        table.columns,
        table.values,
    )


def _by_load(table: Table, rows: np.ndarray, x: int, y: int) -> tuple[str, list[str]] | None:
    """What a column of the load beside it says of a stress."""
    stretch = rough_stretch(table.columns[x], table.values[rows, x])
    for i, column in enumerate(table.columns):
        if column.quantity.name != "force" or column.fault or stretch is None:
            continue
        with np.errstate(all="ignore"):
            areas = table.values[rows, i] * column.factor / table.values[rows, y]
        far = np.isfinite(areas * stretch) & (np.abs(stretch - 1.0) > 0.05)
        if np.sum(far) < 5 or np.ptp(stretch[far]) < 5 * CONSTANT:
            continue
        said = f"'{table.columns[y].heading}' and '{column.heading}' are in one ratio"
        if _scatter(areas[far]) < CONSTANT:
            return "nominal", [f"{said}: read as nominal stress"]
        if _scatter((areas * stretch)[far]) < CONSTANT:
            return "cauchy", [f"{said} to the stretch: read as Cauchy stress"]
    return None


def rough_stretch(column: Column, values: np.ndarray) -> np.ndarray | None:
    """The stretch that a column of ratios means; None for lengths."""
    if column.factor is None or column.quantity.name in TRAVEL:
        return None
    values = values * column.factor
    if column.quantity.name == "true_strain":
        with np.errstate(over="ignore"):
            return np.exp(values)
    return values if column.quantity.name == "stretch" else 1.0 + values


def _scatter(values: np.ndarray) -> float:
    """Standard deviation over mean."""
    mean = float(np.mean(values))
    return float(np.std(values)) / abs(mean) if mean else np.inf


def contradictions(
    table: Table, rows: np.ndarray, choice: Choice, sizes: dict[str, float | None]
) -> Sequence[str]:
    """Return a line where columns that are not read contradict the specimen's sizes.

    sizes: 'area' in mm² and 'length' in mm as they are known, or None.
    """
    lines = []
    for kinds, role, other, size, unit in (
        (("force",), "y", ("nominal_stress", "standard_stress"), "area", "mm²"),
        (TRAVEL[:2], "x", ("strain",), "length", "mm"),
    ):
        known = sizes.get(size)
        first, second = (_filled(table, rows, role, names) for names in (kinds, other))
        if not known or first is None or second is None:
            continue
        meant, scatter = _ratio(table, rows, first, second)
        if scatter < CONSTANT and abs(meant / known - 1.0) > APART:
            name = "a cross-section" if size == "area" else "a gauge length"
            option = "--area" if size == "area" else "--length"
            lines.append(
                f"attention: '{table.columns[first].heading}' over "
                f"'{table.columns[second].heading}' is {name} of {meant:.4g} {unit}, the sizes say "
                f"{known:.4g} {unit}; one is wrong ({option} '{known:.4g} "
                f"{'mm^2' if size == 'area' else 'mm'}' takes the latter)"
            )
    return lines


def _filled(table: Table, rows: np.ndarray, role: str, names: Sequence[str]) -> int | None:
    for i in _candidates(table, rows, role, None):
        if table.columns[i].quantity.name in names and not table.columns[i].fault:
            return i
    return None


def _ratio(table: Table, rows: np.ndarray, first: int, second: int) -> tuple[float, float]:
    """Slope of one column over another, and how much its points scatter about it."""
    a, b = (table.values[rows, i] * table.columns[i].factor for i in (first, second))
    good = np.isfinite(a) & np.isfinite(b)
    with np.errstate(all="ignore"):
        a, b = a[good] - np.mean(a[good]), b[good] - np.mean(b[good])
        slope = float(np.sum(a * b) / np.sum(b * b))
        rest = float(np.sqrt(np.sum((a - slope * b) ** 2) / np.sum(a * a)))
    return (slope, rest) if np.isfinite(slope) and np.isfinite(rest) else (0.0, np.inf)
