"""Units as machines and spreadsheets write them: 'KPa', 'N/mm2', '[Kgf/cm2.]', 'inch', 'Newton'."""

import re
import unicodedata

from softact.units import FORCE, LENGTH, PRESSURE, Dimension

# As written, in small letters -> as the registry reads it. A mass stands for its weight: nobody
# writes a load or a stress in a true mass.
_LENGTHS = {"mm": "mm", "cm": "cm", "m": "m", "um": "um", "in": "in", "inch": "in",
            "inches": "in", "mil": "mil", "ft": "ft", "micron": "um", "millimeter": "mm",
            "millimetre": "mm", "µm": "um", "μm": "um", "nm": "nm", '"': "in"}  # fmt: skip
_FORCES = {"n": "N", "mn": "mN", "kn": "kN", "newton": "N", "newtons": "N", "kgf": "kgf",
           "kg": "kgf", "kp": "kgf", "gf": "gf", "g": "gf", "grf": "gf", "lbf": "lbf", "lb": "lbf",
           "lbs": "lbf", "cn": "cN", "dn": "dN", "dan": "daN", "kips": "kip", "kip": "kip",
           "dyn": "dyn", "ozf": "force_ounce", "tf": "force_metric_ton"}  # fmt: skip
_PRESSURES = {"pa": "Pa", "kpa": "kPa", "mpa": "MPa", "gpa": "GPa", "hpa": "hPa", "bar": "bar",
              "mbar": "mbar", "psi": "psi", "ksi": "ksi", "pascal": "Pa", "pascals": "Pa",
              "atm": "atm", "torr": "torr", "mmhg": "mmHg"}  # fmt: skip
_WEIGHTS = {"kg", "kp", "g", "lb", "lbs"}
RATIOS = {"%": 0.01, "percent": 0.01, "pct": 0.01, "prozent": 0.01, "‰": 1e-3, "": 1.0, "-": 1.0,
          "1": 1.0, "mm/mm": 1.0, "m/m": 1.0, "in/in": 1.0, "none": 1.0, "ratio": 1.0,
          "µe": 1e-6, "µε": 1e-6, "με": 1e-6, "ue": 1e-6, "microstrain": 1e-6}  # fmt: skip
# Units of columns that are not used, so that a row of units is known for one.
_TIMES = {"s", "sec", "secs", "second", "seconds", "sek", "ms", "min", "h", "hr"}
_OTHERS = {"°c", "degc",
           "c", "°f", "°", "deg", "rad", "k", "v", "mv", "a", "ma", "hz", "j", "mj", "nm", "nmm",
           "ml", "cm3", "mm3", "mm2", "cm2", "mm/s", "mm/min", "in/min", "1/s", "%/s", "%/min",
           "l", "cycles", "segments"}  # fmt: skip
_LONGEST = 24


def is_unit(text: str) -> bool:
    """Whether a cell holds a unit: all of it in brackets, or one that tests are written in."""
    text = text.strip()
    if re.fullmatch(r"[(\[{<][^()\[\]{}<>]*[)\]}>]", text):
        return True
    plain = clean(text).lower()
    if plain in _OTHERS | _TIMES or (plain in RATIOS and plain not in ("", "ratio", "1")):
        return True
    return any(registry_unit(text, dimension) for dimension in (LENGTH, FORCE, PRESSURE))


def is_time(text: str) -> bool:
    """Whether a text is a unit of time."""
    return clean(text).lower() in _TIMES


def registry_unit(text: str, dimension: Dimension) -> str | None:
    """Return the unit ``text`` as the registry spells it, None where it is none of ``dimension``.

    dimension: LENGTH, FORCE or PRESSURE.
    """
    text = clean(text)
    if not text or len(text) > _LONGEST:
        return None
    if dimension is LENGTH:
        return _LENGTHS.get(text.lower())
    if dimension is FORCE:
        return text if text in _FORCES.values() or text == "MN" else _FORCES.get(text.lower())
    if single := _PRESSURES.get(text.lower()):
        return single
    written, slash, area = text.replace(" ", "").partition("/")
    side = re.fullmatch(r"(?:sq\.?)?([A-Za-z]+)(?:\^?2)?", area) if slash else None
    if side is None or not ("2" in area or area.lower().startswith("sq")):
        return None
    force, length = registry_unit(written, FORCE), _LENGTHS.get(side[1].lower())
    return f"{force}/{length}^2" if force and length else None


def clean(text: str) -> str:
    """A unit without brackets, marks and superscripts around and in it."""
    plain = unicodedata.normalize("NFKC", text.strip()).strip(" ()[]{}<>'.:,;")
    return re.sub(r"\*\*\s*2", "^2", plain)


def weight_for_mass(text: str) -> bool:
    """Whether a unit names a mass where a force is meant, as in 'kg/cm2'."""
    return clean(text).replace(" ", "").partition("/")[0].lower() in _WEIGHTS


def mega_for_milli(text: str) -> bool:
    """Whether a unit is 'mPa': a thousandth of a pascal as written, a megapascal as meant."""
    return clean(text) == "mPa"
