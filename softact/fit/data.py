"""From a table to tests: stretch and nominal stress, branches, trimming, plausibility."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.signal import savgol_filter

from softact.errors import SpecError
from softact.fit.columns import Column
from softact.fit.sheet import TestSheet
from softact.fit.table import Table, read_table

MIN_POINTS = 5
LARGEST_STRESS = 1e6  # MPa
NOISE = 0.01  # of the range: smaller steps back are the extensometer's, not unloading


@dataclass(frozen=True)
class Test:
    """Nominal stress (n,) in MPa over stretch (n,) of one specimen in one mode.

    mode: a key of ``modes.MODES`` or 'biaxial'. direction: of the load in a sheet with fibres.
    other: stretch across it, in the mode 'biaxial'. messages: what was done and what looks odd.
    """

    __test__ = False  # not a test of pytest's

    name: str
    mode: str
    stretch: np.ndarray
    stress: np.ndarray
    direction: str | None = None
    other: np.ndarray | None = None
    messages: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """Name, mode and direction for people."""
        return f"{self.name} ({self.mode}{' ' + self.direction if self.direction else ''})"


def read_tests(sheet: TestSheet) -> list[Test]:
    """Return the tests of a file: one per specimen and measured direction.

    Raises SpecError for data that cannot be right, saying what it looks like.
    """
    table = read_table(sheet.file, sheet.columns)
    labels = sorted(set(table.specimens)) if table.specimens else [None]
    tests = []
    for label in labels:
        rows = slice(None) if label is None else np.array([s == label for s in table.specimens])
        name = sheet.name if label is None else f"{sheet.name}:{label}"
        numbers = np.array(table.rows)[rows]
        for direction in _directions(sheet, table):
            tests.append(_read_one(sheet, table, rows, numbers, name, direction))
    return tests


def _directions(sheet: TestSheet, table: Table) -> list[str | None]:
    measured = [c.direction for c in table.columns if c.quantity.role == "y" and c.direction]
    if measured:
        return list(dict.fromkeys(measured))
    return [sheet.direction]


def _read_one(sheet, table: Table, rows, numbers, name: str, direction: str | None) -> Test:
    _check_count(sheet, len(numbers))
    x = _stretch(sheet, table, rows, direction)
    other = None
    if sheet.mode == "biaxial":
        if direction is None:
            raise SpecError(f"{sheet.file}: biaxial data need columns named 'course' and 'wale'")
        other = _stretch(sheet, table, rows, "wale" if direction == "course" else "course")
    y = _load(sheet, table, rows, direction, x)
    messages: list[str] = []
    if sheet.mode == "compression" and np.mean(x) > 1 and np.mean(y) > 0:
        x, y = 2.0 - x, -y
        messages.append("positive strain and stress of a compression test taken as compression")
    keep = _branch(sheet, x, messages)
    x, y, numbers = x[keep], y[keep], numbers[keep]
    other = None if other is None else other[keep]
    test = Test(
        name=name,
        mode="uniaxial" if sheet.mode == "compression" else sheet.mode,
        stretch=x,
        stress=y,
        direction=direction,
        other=other,
        messages=tuple(messages),
    )
    test = _prepare(sheet, test, numbers)
    _check_count(sheet, len(test.stretch))
    if np.max(np.abs(test.stretch - 1.0)) < 1e-6:
        raise SpecError(f"{sheet.file}: the stretch is 1 throughout; there is no deformation")
    _check_sense(sheet, test)
    return test


def _pick(sheet: TestSheet, table: Table, role: str, direction: str | None) -> tuple[int, Column]:
    found = [
        (i, c)
        for i, c in enumerate(table.columns)
        if c.quantity.role == role and c.direction in (None, direction)
    ]
    exact = [entry for entry in found if entry[1].direction == direction and direction] or found
    # Engineering measures first, where a file has both them and true ones.
    exact.sort(key=lambda entry: entry[1].quantity.name in ("true_strain", "cauchy_stress"))
    if not exact:
        kind = "deformation (stretch, strain, displacement)" if role == "x" else "load"
        raise SpecError(f"{sheet.file}: no column for the {kind}; give --columns")
    names = {column.quantity.name for _, column in exact[:2]}
    if len(exact) > 1 and len(names) == 1:
        said = ", ".join(f"'{column.heading}'" for _, column in exact)
        raise SpecError(f"{sheet.file}: several columns could be meant ({said}); give --columns")
    return exact[0]


def _size(sheet: TestSheet, table: Table, name: str) -> float | None:
    value = getattr(sheet, name) or table.sizes.get(name)
    if value is not None and not value > 0:
        raise SpecError(f"{sheet.file}: the specimen's {name} is {value:g} mm; it must be positive")
    return value


def _stretch(sheet: TestSheet, table: Table, rows, direction: str | None) -> np.ndarray:
    i, column = _pick(sheet, table, "x", direction)
    values = table.values[rows, i]
    kind = column.quantity.name
    if column.factor is None:
        raise SpecError(f"{sheet.file}: column '{column.heading}' has no unit; write '... mm'")
    values = values * column.factor
    if kind == "stretch":
        _check_stretch(sheet, column, values)
        return values
    if kind == "strain":
        _check_strain(sheet, column, values)
        return 1.0 + values
    if kind == "true_strain":
        return np.exp(values)
    length = _size(sheet, table, "length")
    if length is None:
        raise SpecError(f"{sheet.file}: a {kind} needs the gauge length; give --length")
    stretch = values / length + (1.0 if kind == "displacement" else 0.0)
    if np.any(stretch <= 0):
        raise SpecError(
            f"{sheet.file}: with the gauge length {length:g} mm the stretch becomes "
            f"{stretch.min():.3g}; is the length right?"
        )
    return stretch


def _check_stretch(sheet: TestSheet, column: Column, values: np.ndarray) -> None:
    if np.any(values <= 0) or (values[0] < 0.3 and np.max(values) > 0.5):
        raise SpecError(
            f"{sheet.file}: column '{column.heading}' begins at {values[0]:g}; a stretch is 1 in "
            "the undeformed state. This looks like engineering strain: name the column 'strain'"
        )


def _check_strain(sheet: TestSheet, column: Column, values: np.ndarray) -> None:
    if np.any(values <= -1):
        raise SpecError(
            f"{sheet.file}: column '{column.heading}' goes to {values.min():g}; "
            "a strain is above -1. Is it a percentage? Then write 'strain %'"
        )
    if np.max(np.abs(values)) > 25:
        raise SpecError(
            f"{sheet.file}: column '{column.heading}' goes to {values.max():g}, a stretch of "
            f"{1 + values.max():g}. This looks like a percentage: name the column 'strain %'"
        )
    if 0.97 <= np.min(values) <= 1.1 and np.max(values) > 1.2:
        raise SpecError(
            f"{sheet.file}: column '{column.heading}' begins at {values[0]:g}; a strain is 0 in "
            "the undeformed state. This looks like stretch: name the column 'stretch'"
        )


def _load(sheet, table: Table, rows, direction, stretch: np.ndarray) -> np.ndarray:
    i, column = _pick(sheet, table, "y", direction)
    values, kind = table.values[rows, i], column.quantity.name
    if column.factor is None:
        example = "force N" if kind == "force" else f"{kind} MPa"
        raise SpecError(f"{sheet.file}: column '{column.heading}' has no unit; write '{example}'")
    values = values * column.factor
    if kind == "stress":
        if sheet.stress is None:
            raise SpecError(
                f"{sheet.file}: column '{column.heading}' does not say which stress; name it "
                "nominal_stress (force per undeformed area) or cauchy_stress, or give --stress"
            )
        kind = f"{sheet.stress}_stress"
    elif kind.endswith("_stress") and sheet.stress and not kind.startswith(sheet.stress):
        raise SpecError(f"{sheet.file}: '{column.heading}' is not the {sheet.stress} stress")
    if kind == "cauchy_stress":
        return values / stretch
    if kind == "force":
        area = sheet.cross_section
        if area is None:
            width, thickness = (_size(sheet, table, name) for name in ("width", "thickness"))
            if not (width and thickness):
                raise SpecError(
                    f"{sheet.file}: a force needs the cross-section; "
                    "give --width and --thickness, or --area"
                )
            area = width * thickness
        return values / area
    return values


def _branch(sheet: TestSheet, x: np.ndarray, messages: list[str]) -> slice | np.ndarray:
    """Rows to keep: all of a monotonic test, or the loading that the user chose."""
    turns = turning_points(x)
    if sheet.loading or sheet.cycle is not None:
        loadings = [
            slice(a, b + 1) for a, b in pairwise(turns) if abs(x[b] - 1.0) > abs(x[a] - 1.0)
        ]
        which = len(loadings) if sheet.cycle == "last" else sheet.cycle or 1
        if not 1 <= which <= len(loadings):
            raise SpecError(f"{sheet.file}: there is no cycle {which}; {len(loadings)} were found")
        kept = loadings[which - 1]
        messages.append(
            f"loading {which} of {len(loadings)} kept: {kept.stop - kept.start} of {len(x)} points"
        )
        return kept
    if len(turns) > 2:
        turn, after = turns[1], turns[2]
        raise SpecError(
            f"{sheet.file}: the stretch turns back at point {turn + 1}, from {x[turn]:.4g} to "
            f"{x[after]:.4g}: this looks like unloading or cycles. Give --loading for the first "
            "loading or --cycle last"
        )
    return slice(None)


def turning_points(x: np.ndarray) -> list[int]:
    """Indices of the first point, of every reversal by more than the noise, and of the last."""
    if len(x) < 2:
        return [0]
    limit = NOISE * (np.max(x) - np.min(x))
    turns, extreme, sense = [0], 0, 0
    for i in range(1, len(x)):
        step = x[i] - x[extreme]
        if sense == 0:
            if abs(step) > limit:
                sense, extreme = (1 if step > 0 else -1), i
        elif step * sense >= 0:
            extreme = i
        elif abs(step) > limit:
            turns.append(extreme)
            sense, extreme = -sense, i
    last = extreme if sense and (len(x) - 1 - extreme) else len(x) - 1
    return [*turns, last] if last > turns[-1] else turns


def _prepare(sheet: TestSheet, test: Test, numbers: np.ndarray) -> Test:
    x, y, other, messages = test.stretch, test.stress, test.other, list(test.messages)
    if sheet.zero and len(y):
        messages.append(f"stress of the first point, {y[0] * 1e3:.4g} kPa, subtracted")
        y = y - y[0]
    if sheet.smooth:
        if len(y) < sheet.smooth:
            raise SpecError(f"{sheet.file}: fewer points than the smoothing window")
        y = savgol_filter(y, sheet.smooth, 2)
        messages.append(f"stress smoothed (Savitzky-Golay, {sheet.smooth} points, order 2)")
    if sheet.toe and len(y):
        x, y, other = _cut_toe(sheet, x, y, other, messages)
    window = np.ones(len(x), dtype=bool)
    if sheet.stretch_from is not None:
        window &= x >= sheet.stretch_from
    if sheet.stretch_to is not None:
        window &= x <= sheet.stretch_to
    if not np.all(window):
        messages.append(f"{np.sum(~window)} of {len(x)} points outside the chosen range dropped")
        x, y, other = x[window], y[window], None if other is None else other[window]
    if sheet.points and len(x) > sheet.points:
        chosen = _spread(x, sheet.points)
        messages.append(f"thinned from {len(x)} to {len(chosen)} points")
        x, y, other = x[chosen], y[chosen], None if other is None else other[chosen]
    return replace(test, stretch=x, stress=y, other=other, messages=tuple(messages))


def _cut_toe(sheet, x, y, other, messages):
    """Drop the toe and move the zero of strain to where the curve above it points."""
    start = int(np.argmax(np.abs(y) >= sheet.toe))
    if abs(y[start]) < sheet.toe:
        raise SpecError(f"{sheet.file}: no point reaches the toe stress")
    end = max(start + MIN_POINTS, int(np.searchsorted(np.abs(y), 2 * sheet.toe)))
    slope, offset = np.polyfit(x[start:end], y[start:end], 1)
    shift = -offset / slope - 1.0
    messages.append(f"toe: {start} points dropped, zero of strain moved by {shift:.4f}")
    return x[start:] / (1.0 + shift), y[start:], None if other is None else other[start:]


def _spread(x: np.ndarray, count: int) -> np.ndarray:
    """Indices of about ``count`` points evenly spaced in stretch."""
    wanted = np.linspace(np.min(x), np.max(x), count)
    order = np.argsort(x, kind="stable")
    near = np.clip(np.searchsorted(x[order], wanted), 0, len(x) - 1)
    return np.unique(order[near])


def _check_count(sheet: TestSheet, count: int) -> None:
    if count < MIN_POINTS:
        raise SpecError(f"{sheet.file}: {count} points are left; a fit needs at least {MIN_POINTS}")


def _check_sense(sheet: TestSheet, test: Test) -> None:
    """The load must have a size that exists and the sense of the deformation."""
    if np.max(np.abs(test.stress)) > LARGEST_STRESS:
        raise SpecError(
            f"{sheet.file}: the stress goes to {np.max(np.abs(test.stress)):.3g} MPa; "
            "no material bears that. Is the unit right?"
        )
    if test.mode == "biaxial":
        return
    x, y = test.stretch, test.stress
    largest = np.max(np.abs(y))
    squeezed = (x < 0.97) & (y > 0.05 * largest)
    if np.any(squeezed):
        raise SpecError(
            f"{sheet.file}: the stress is tensile at a stretch of {x[squeezed][0]:.3g}. This looks "
            "like engineering strain given as stretch (name the column 'strain'), or a wrong sign"
        )
    pulled = (x > 1.03) & (y < -0.05 * largest)
    if np.mean(pulled) > 0.3:
        raise SpecError(
            f"{sheet.file}: the stress is compressive at a stretch of {x[pulled][0]:.3g}: "
            "a wrong sign, or an offset of the load cell (--zero subtracts the first value)"
        )
