"""How columns and fields are called in a report, and in which unit they are shown."""

from dataclasses import dataclass

#: Endings of column names: (unit as shown, factor from the stored unit to the shown one).
_UNITS = {
    "kPa": ("kPa", 1.0),
    "MPa": ("MPa", 1.0),
    "deg": ("°", 1.0),
    "mm3": ("mL", 1e-3),
    "mm": ("mm", 1.0),
    "mJ": ("mJ", 1.0),
    "Nmm": ("N·mm", 1.0),
    "N": ("N", 1.0),
}

#: Columns that say where a row stands or where a largest value lies; not results themselves.
BOOKKEEPING = {"step", "increment", "step_fraction", "newton_iterations", "residual", "iterations"}


@dataclass(frozen=True)
class Label:
    """A quantity's name, the unit it is shown in, and the factor from the stored unit."""

    name: str
    unit: str
    factor: float = 1.0

    def __str__(self) -> str:
        return f"{self.name} ({self.unit})" if self.unit else self.name


FIELDS = {
    "von_mises": Label("von Mises stress", "MPa"),
    "max_principal_stress": Label("largest principal stress", "MPa"),
    "max_principal_stretch": Label("largest principal stretch", ""),
}


def field(name: str) -> Label:
    """Label of a field of fields.h5."""
    known = Label(name.replace("_", " "), "mm" if name == "displacement" else "")
    return FIELDS.get(name, known)


def column(name: str) -> Label:
    """Label of a column of curve.csv or summary.csv, from its name."""
    stem, _, ending = name.rpartition("_")
    unit, factor = _UNITS.get(ending, ("", 1.0)) if stem else ("", 1.0)
    words = (stem if unit else name).replace("_", " ")
    if words.startswith("max "):
        words = "largest " + words.removeprefix("max ")
    if words.endswith(" max"):
        words = "largest " + words.removesuffix(" max")
    words = words.replace("von mises", "von Mises stress")
    return Label(words[:1].upper() + words[1:] if words[:3] != "von" else words, unit, factor)


def number(value: float) -> str:
    """A number with four significant digits, without an exponent where it can be avoided."""
    if value != value:
        return "–"
    if value == 0:
        return "0"
    if not 1e-4 <= abs(value) < 1e6:
        return f"{value:.3g}"
    digits = max(0, 3 - len(str(int(abs(value)))) + 1) if abs(value) >= 1 else 4
    return f"{value:.{digits}f}".rstrip("0").rstrip(".") if digits else f"{value:.0f}"
