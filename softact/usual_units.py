"""The units that specs are written in, so that pint is loaded for the others only.

pint's import and its registry take 0.5 to 0.8 s of processor time in every process that reads a
spec: the command, and the solver of each run. A test compares every factor with pint's.
"""

from fractions import Fraction

_SIZES: dict[str, dict[str, int | str | Fraction]] = {
    "mm": {"mm": 1, "m": 1000, "cm": 10, "um": "1/1000", "µm": "1/1000", "in": "254/10"},
    "MPa": {"MPa": 1, "kPa": "1/1000", "GPa": 1000, "Pa": "1e-6", "bar": "1/10",
            "N/mm^2": 1, "N/mm²": 1, "mbar": "1e-4"},
    "tonne/mm^3": {"tonne/mm^3": 1, "kg/m^3": "1e-12", "kg/m³": "1e-12", "g/cm^3": "1e-9",
                   "g/cm³": "1e-9"},
    "degree": {"deg": 1, "degree": 1, "°": 1},
    "mm/s^2": {"mm/s^2": 1, "m/s^2": 1000, "m/s²": 1000},
    "N": {"N": 1, "mN": "1/1000", "kN": 1000},
    "Hz": {"Hz": 1, "kHz": 1000, "1/s": 1},
    "s": {"s": 1, "ms": "1/1000", "min": 60},
    "mm^3": {"mm^3": 1, "mm³": 1, "cm^3": 1000, "ml": 1000, "mL": 1000, "l": 1000000},
    "N*mm": {"N*mm": 1, "N*m": 1000},
    "N/mm": {"N/mm": 1, "N/m": Fraction(1, 1000)},
    "mm^3/(s*MPa)": {"mm^3/(s*MPa)": 1, "l/(min*bar)": "500000/3"},
    "1/MPa": {"1/MPa": 1, "1/kPa": 1000, "1/Pa": 1000000},
    "tonne": {"tonne": 1, "g": "1e-6", "kg": "1e-3", "mg": "1e-9"},
}  # fmt: skip

#: Internal unit -> unit -> how many of the internal unit it is.
USUAL: dict[str, dict[str, Fraction]] = {
    internal: {unit: Fraction(factor) for unit, factor in units.items()}
    for internal, units in _SIZES.items()
}
