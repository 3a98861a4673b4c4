"""How columns and fields are called in a report, and in which unit they are shown."""

import math
from dataclasses import dataclass

#: Endings of column names, the longer ones first: (unit as shown, factor to it from the stored
#: unit).
_UNITS = {
    "nl_per_min": ("nl/min", 1.0),
    "per_m": ("1/m", 1.0),
    "N_per_kg": ("N/kg", 1.0),
    "J_per_kg": ("J/kg", 1.0),
    "nl": ("nl", 1.0),
    "mm2": ("mm²", 1.0),
    "g": ("g", 1.0),
    "s": ("s", 1.0),
    "kPa": ("kPa", 1.0),
    "MPa": ("MPa", 1.0),
    "deg": ("°", 1.0),
    "mm3": ("mL", 1e-3),
    "mm": ("mm", 1.0),
    "mJ": ("mJ", 1.0),
    "Nmm2": ("N·mm²", 1.0),
    "Nmm": ("N·mm", 1.0),
    "N": ("N", 1.0),
    "percent": ("%", 1.0),
}


# What ends with the name of a region, which may look like a unit.
_PURE = "principal_stretch_p999_"


@dataclass(frozen=True)
class Label:
    """A quantity's name, the unit it is shown in, and the factor from the stored unit."""

    name: str
    unit: str
    factor: float = 1.0

    def __str__(self) -> str:
        return f"{self.name} ({self.unit})" if self.unit else self.name


_SPECIAL = {
    "volume_change_max": Label("Volume change at the worst point", "%", 100.0),
    "volume_change_mean": Label("Mean volume change", "%", 100.0),
    "volume_change_p99": Label("Volume change exceeded in 1 % of the volume", "%", 100.0),
    "volume_change_beyond_percent": Label("Part whose volume changes by more than 20 %", "%"),
    "jacobian_min": Label("Smallest J anywhere in an element", ""),
}

#: Beginnings of column names that words alone would not explain, longest first; what follows is the
#: name of a region.
_STEMS = {
    "principal_stress_p999": "Principal stress exceeded in 0.1 % of the volume",
    "principal_stress_peak": "Principal stress at its highest node",
    "principal_stretch_p999": "Principal stretch exceeded in 0.1 % of the volume",
    "principal_nominal_stress_p999": "Nominal stress exceeded in 0.1 % of the volume",
    "failure_pressure_nominal": "Failure pressure by nominal stress",
    "failure_pressure_cauchy": "Failure pressure by Cauchy stress",
    "failure_pressure_stretch": "Failure pressure by stretch at break",
    "failure_pressure_peak": "Failure pressure by the highest node",
    "tested_stretch_pressure": "Pressure at the end of the tested stretch",
    "contact_overlap": "Overlap in contact",
}

FIELDS = {
    "von_mises": Label("von Mises stress", "MPa"),
    "max_principal_stress": Label("largest principal stress", "MPa"),
    "max_principal_stretch": Label("largest principal stretch", ""),
    "contact_pressure": Label("contact pressure", "MPa"),
} | {f"stress_{c}": Label(f"stress {c}", "MPa") for c in ("xx", "yy", "zz", "xy", "xz", "yz")}


def field(name: str) -> Label:
    """Label of a field of fields.h5."""
    known = Label(name.replace("_", " "), "mm" if name == "displacement" else "")
    return FIELDS.get(name, known)


def column(name: str) -> Label:
    """Label of a column of curve.csv or summary.csv, from its name."""
    if name in _SPECIAL:
        return _SPECIAL[name]
    endings = () if name.startswith(_PURE) else _UNITS
    ending = next((end for end in endings if name.endswith(f"_{end}")), "")
    unit, factor = _UNITS.get(ending, ("", 1.0))
    stem = name.removesuffix(f"_{ending}") if unit else name
    for beginning, said in _STEMS.items():
        if stem == beginning or stem.startswith(f"{beginning}_"):
            region = stem.removeprefix(beginning).replace("_", " ").strip()
            return Label(f"{said}, {region}" if region else said, unit, factor)
    words = stem.replace("_", " ")
    if words.startswith("max "):
        words = "largest " + words.removeprefix("max ")
    words = words.replace("von mises", "von Mises stress")
    return Label(words[:1].upper() + words[1:] if words[:3] != "von" else words, unit, factor)


def meaning(name: str) -> str:
    """What a column of curve.csv is, in a sentence; "" where no measure has it."""
    from softact.measures.titles import title_of

    found = title_of(name)
    return found.meaning if found else ""


def number(value: float, digits: int = 4, largest: float | None = None) -> str:
    """A number with ``digits`` significant digits, or with as many decimals as ``largest``, the
    largest of its row, has then; without an exponent where that can be avoided."""
    if not math.isfinite(value):
        return "–"
    size = abs(value if largest is None else largest)
    if size < 1e-9:  # in any of the units shown, this is rounding
        return "0"
    if not 1e-3 <= size < 1e7:
        return f"{value:.{digits - 1}g}".replace("-", "−")
    decimals = max(0, digits - 1 - math.floor(math.log10(size)))
    text = f"{value:.{decimals}f}"
    if largest is None and decimals:
        text = text.rstrip("0").rstrip(".")
    if not text.strip("-0."):
        text = text.removeprefix("-")  # what rounds to zero has no sign
    return text.replace("-", "−")
