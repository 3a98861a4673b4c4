"""What the columns of a test's table mean: quantity and unit, read from headings."""

import re
from dataclasses import dataclass

from softact.units import FORCE, LENGTH, PRESSURE, Dimension

RATIO = "ratio"  # of no unit, or in percent


@dataclass(frozen=True)
class Quantity:
    """A kind of column. role: 'x' for deformation, 'y' for load, '' for anything not used."""

    name: str
    role: str
    dimension: Dimension | str | None
    words: tuple[str, ...]


# The first whose words all stand in the heading wins: the more precise ones come first.
QUANTITIES = (
    Quantity("ignored", "", None, ("-",)),
    Quantity("ignored", "", None, ("time",)),
    Quantity("specimen", "", None, ("specimen",)),
    Quantity("true_strain", "x", RATIO, ("true", "strain")),
    Quantity("true_strain", "x", RATIO, ("log", "strain")),
    Quantity("true_strain", "x", RATIO, ("logarithmic", "strain")),
    Quantity("true_strain", "x", RATIO, ("hencky", "strain")),
    Quantity("cauchy_stress", "y", PRESSURE, ("true", "stress")),
    Quantity("cauchy_stress", "y", PRESSURE, ("cauchy",)),
    Quantity("nominal_stress", "y", PRESSURE, ("engineering", "stress")),
    Quantity("nominal_stress", "y", PRESSURE, ("nominal", "stress")),
    Quantity("nominal_stress", "y", PRESSURE, ("pk1",)),
    Quantity("stress", "y", PRESSURE, ("stress",)),
    Quantity("stretch", "x", RATIO, ("stretch",)),
    Quantity("strain", "x", RATIO, ("strain",)),
    Quantity("displacement", "x", LENGTH, ("displacement",)),
    Quantity("displacement", "x", LENGTH, ("extension",)),
    Quantity("displacement", "x", LENGTH, ("elongation",)),
    Quantity("length", "x", LENGTH, ("length",)),
    Quantity("force", "y", FORCE, ("force",)),
    Quantity("force", "y", FORCE, ("load",)),
)
DIRECTIONS = ("course", "wale")


@dataclass(frozen=True)
class Column:
    """One column: its quantity, the factor to internal units, and the sheet's direction if named.

    factor: None where the heading names no unit and the quantity needs one.
    """

    heading: str
    quantity: Quantity
    factor: float | None
    direction: str | None


def read_heading(text: str) -> Column:
    """Return what a heading such as ``Engineering Stress (MPa)`` or ``strain_percent`` means.

    Raises ValueError for a unit that does not fit the quantity.
    """
    words = re.sub(r"[_,;:()\[\]]+", " ", text).split()
    lower = [word.lower() for word in words]
    direction = next((d for d in DIRECTIONS if d in lower), None)
    for quantity in QUANTITIES:
        if all(any(word == have for have in lower) for word in quantity.words):
            break
    else:
        return Column(text, QUANTITIES[0], None, direction)
    known = {w for q in QUANTITIES for w in q.words} | set(DIRECTIONS) | {"rate", "of", "in"}
    unit = " ".join(word for word in words if word.lower() not in known)
    return Column(text, quantity, _factor(text, quantity, unit), direction)


def _factor(heading: str, quantity: Quantity, unit: str) -> float | None:
    if quantity.dimension is None:
        return 1.0
    if quantity.dimension is RATIO:
        if unit.lower() in ("%", "percent", "pct"):
            return 0.01
        if unit.lower() in ("", "-", "1", "mm/mm", "m/m", "none", "ratio"):
            return 1.0
        raise ValueError(f"'{heading}': '{unit}' is no unit of a {quantity.name.replace('_', ' ')}")
    if not unit:
        return None
    try:
        return quantity.dimension.parse(f"1 {unit}")
    except ValueError as error:
        raise ValueError(f"'{heading}': {error}") from None
