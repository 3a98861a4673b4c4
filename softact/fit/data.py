"""From a table to tests: stretch and nominal stress, and whether they can be right."""

from dataclasses import dataclass

import numpy as np

from softact.errors import SpecError
from softact.fit.columns import Column
from softact.fit.sheet import TestSheet
from softact.fit.table import Table, read_table
from softact.fit.trimming import MIN_POINTS, branch, prepare

LARGEST_STRESS = 1e6  # MPa


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
    keep = branch(sheet, x, messages)
    x, y = x[keep], y[keep]
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
    test = prepare(sheet, test)
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
