"""From the columns of a table to stretch and nominal stress, each refused where it cannot be."""

from dataclasses import dataclass

import numpy as np

from softact.fit.choose import TRAVEL, Choice
from softact.fit.sheet import TestSheet
from softact.measured.headings import Column
from softact.measured.tables import Table, UnreadableError

SMALLEST_STRETCH, LARGEST_STRETCH = 0.01, 100.0
SMALLEST_STRESS, LARGEST_STRESS = 1e-9, 1e6  # MPa


@dataclass(frozen=True)
class Reading:
    """One specimen in one direction of a table. rows: those in which both columns have a value."""

    sheet: TestSheet
    table: Table
    choice: Choice
    rows: np.ndarray
    messages: list[str]

    @property
    def backwards(self) -> bool:
        """Whether a deformation of the other sign is meant: compression in positive numbers."""
        return self.sheet.mode == "compression"

    def refuse(self, message: str, **renamed: str) -> UnreadableError:
        """A refusal; x, y: a heading that would be right for the column of that role."""
        places = {"x": self.choice.x, "y": self.choice.y}
        better = {places[role]: name for role, name in renamed.items()}
        return UnreadableError(message, self.table.columns, self.table.values, better)


def size_of(reading: Reading, name: str) -> float | None:
    """A size of the specimen in mm, 'area' in mm²: as the options say, else as the file does."""
    sheet, sizes = reading.sheet, reading.table.sizes
    if name == "area":
        if sheet.area:
            return sheet.area
        given = sheet.width or sheet.thickness
        if not given and "area" in sizes:
            return _positive(reading, "area", sizes["area"])
        width, thickness = size_of(reading, "width"), size_of(reading, "thickness")
        return width * thickness if width and thickness else None
    value = getattr(sheet, name)
    if value is None and name in sizes:
        return _positive(reading, name, sizes[name])
    return value


def _positive(reading: Reading, name: str, value: float) -> float:
    if not value > 0:
        unit = "mm²" if name == "area" else "mm"
        raise reading.refuse(f"the specimen's {name} is {value:g} {unit}; it must be positive")
    return value


def stretch_of(reading: Reading, place: int) -> np.ndarray:
    """Return the stretch (n,) that a column means."""
    column = reading.table.columns[place]
    values = reading.table.values[reading.rows, place] * column.factor
    kind = column.quantity.name
    if kind in TRAVEL:
        stretch = _from_travel(reading, kind, values)
    else:
        stretch = _from_ratio(reading, column, kind, values)
    low, high = np.min(stretch), np.max(stretch)
    if low < SMALLEST_STRETCH or high > LARGEST_STRETCH:
        worst = low if low < SMALLEST_STRETCH else high
        size = "the gauge length" if kind in TRAVEL else f"column '{column.heading}'"
        raise reading.refuse(
            f"the stretch goes to {worst:.3g}, which no material bears; is {size} right?"
        )
    return stretch


def _from_travel(reading: Reading, kind: str, values: np.ndarray) -> np.ndarray:
    length = size_of(reading, "length")
    if length is None:
        raise reading.refuse(f"a {kind} needs the gauge length; give --length")
    if reading.sheet.length is None:
        reading.messages.append(f"gauge length {length:g} mm, as the file says")
    if kind == "length":
        stretch = values / length
        stretch = 2.0 - stretch if reading.backwards and np.mean(stretch) > 1 else stretch
    else:
        if kind == "position" and values[0]:
            reading.messages.append(f"the position counts from its first value, {values[0]:g} mm")
            values = values - values[0]
        stretch = 1.0 + _turned(reading, values, "travel") / length
    if np.any(stretch <= 0):
        raise reading.refuse(
            f"with the gauge length {length:g} mm the stretch becomes {stretch.min():.3g}; "
            "is the length right?"
        )
    return stretch


def _from_ratio(reading: Reading, column: Column, kind: str, values: np.ndarray) -> np.ndarray:
    if kind == "stretch":
        _check_stretch(reading, column, values)
        if reading.backwards and np.mean(values) > 1:
            reading.messages.append("stretches above 1 taken as compression")
            return 2.0 - values
        return values
    values = _turned(reading, values, "strain")
    if kind == "true_strain":
        with np.errstate(over="ignore"):
            return np.exp(values)
    _check_strain(reading, column, values)
    return 1.0 + values


def _turned(reading: Reading, values: np.ndarray, what: str) -> np.ndarray:
    """Values of a compression test, which many write with positive numbers."""
    if reading.backwards and np.mean(values) > 0:
        reading.messages.append(f"positive {what} of a compression test taken as compression")
        return -values
    return values


def _check_stretch(reading: Reading, column: Column, values: np.ndarray) -> None:
    if np.any(values <= 0) or (values[0] < 0.3 and np.max(values) > 0.5):
        raise reading.refuse(
            f"column '{column.heading}' begins at {values[0]:g}; a stretch is 1 in "
            "the undeformed state. This looks like engineering strain: name the column 'strain'",
            x="strain",
        )


def _check_strain(reading: Reading, column: Column, values: np.ndarray) -> None:
    if np.any(values <= -1):
        raise reading.refuse(
            f"column '{column.heading}' goes to {values.min():g}; "
            "a strain is above -1. Is it a percentage? Then write 'strain %'",
            x="strain %",
        )
    if np.max(np.abs(values)) > 25:
        raise reading.refuse(
            f"column '{column.heading}' goes to {values.max():g}, a stretch of "
            f"{1 + values.max():g}. This looks like a percentage: name the column 'strain %'",
            x="strain %",
        )
    if 0.97 <= np.min(values) <= 1.1 and np.max(values) > 1.2:
        raise reading.refuse(
            f"column '{column.heading}' begins at {values[0]:g}; a strain is 0 in "
            "the undeformed state. This looks like stretch: name the column 'stretch'",
            x="stretch",
        )


def stress_of(reading: Reading, stretch: np.ndarray) -> np.ndarray:
    """Return the nominal stress (n,) in MPa that the column of the load means."""
    column = reading.table.columns[reading.choice.y]
    values = reading.table.values[reading.rows, reading.choice.y] * column.factor
    values = _turned(reading, values, "load")
    if reading.choice.stress == "cauchy":
        values = values / stretch
    elif reading.choice.stress == "force":
        area = size_of(reading, "area")
        if area is None:
            raise reading.refuse(
                "a force needs the cross-section; give --width and --thickness, or --area"
            )
        sheet = reading.sheet
        if not (sheet.area or (sheet.width and sheet.thickness)):
            reading.messages.append(f"cross-section {area:g} mm², as the file says")
        values = values / area
    largest = float(np.max(np.abs(values)))
    if not largest <= LARGEST_STRESS:
        raise reading.refuse(
            f"the stress goes to {largest:.3g} MPa; no material bears that. Is the unit right?"
        )
    if 0 < largest < SMALLEST_STRESS:
        raise reading.refuse(
            f"the stress goes to {1e6 * largest:.3g} Pa only; nothing measures that. Is the unit "
            "right?"
        )
    return values
