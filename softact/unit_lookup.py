"""What a unit measures and how large it is: spellings of the field, then pint's registry."""

import re
import unicodedata
from fractions import Fraction
from functools import cache, lru_cache
from typing import Any

from softact.usual_units import USUAL

UNKNOWN = "unknown"
_LONGEST = 60

#: A unit of the internal system -> what a value in such a unit is.
KINDS = {
    "mm": "a length",
    "MPa": "a pressure",
    "tonne/mm^3": "a density",
    "mm/s^2": "an acceleration",
    "N": "a force",
    "s": "a time",
    "mm^3": "a volume",
    "1/MPa": "a compliance",
    "N*mm": "a moment",
    "N/mm": "a stiffness",
    "tonne": "a mass",
    "mm^2": "an area",
    "K": "a temperature",
    "mm/s": "a velocity",
    "kg/mm^2": "a mass per area",
    "kg/mm": "a mass per length",
    "N/mm^3": "a weight per volume",
    "mm^4": "a second moment of area",
    "N*mm^2": "a bending stiffness",
    "MPa*s": "a viscosity",
    "mm^3/s": "a flow",
    "kg/s": "a flow of mass",
    "W": "a power",
    "Hz": "a frequency",
    "A": "an electric current",
    "V": "a voltage",
    "1/mm": "a curvature",
    "mm^3/(s*MPa)": "a conductance",
}

# What people write, and how pint knows it. A pressure in softact counts from the ambient, as a
# gauge's does.
_SPELLINGS = {
    '"': "in",
    "''": "in",
    "mil": "thou",  # pint's mil is an angle
    "mils": "thou",
    "Nm": "N*m",  # pint's Nm counts yarn
    "Nmm": "N*mm",
    "Ncm": "N*cm",
    "mNm": "mN*m",
    "kNm": "kN*m",
    "kp": "kgf",
    "tf": "metric_ton_force",
    "Msi": "Mpsi",
    "Torr": "torr",
    "mTorr": "millitorr",
    "ccm": "cc",
    "rev": "turn",
}
_GAUGE = re.compile(r"(psi|m?bar|[kM]?Pa) ?(?:g|\(g\)|gauge|\(gauge\))")
_ABSOLUTE = re.compile(r"(?:psi|m?bar|[kM]?Pa) ?(?:a|\(a\)|abs\.?|\(abs\.?\)|absolute)")

#: Units that are refused, since people mean different things by them, with what to write.
_REFUSED = {
    "ton": "a ton is 907 kg, 1000 kg or 1016 kg; write 'tonne' for 1000 kg",
    "tons": "a ton is 907 kg, 1000 kg or 1016 kg; write 'tonne' for 1000 kg",
    "tonf": "a ton is 907 kg, 1000 kg or 1016 kg; write kN or kgf",
    "gr": "'gr' is a grain, 0.065 g; write 'g' for gram",
}
_ABSOLUTE_IS = "this is an absolute pressure, and softact's count from the ambient; subtract it"
_HARDNESS_IS = "a hardness gives no modulus; take a card (softact list materials) or test data"
_GRAVITY_IS = "write m/s^2; multiples of g are bare numbers: gravity: [0, 0, -1]"
_WEIGHTS = {"kg": "kgf", "g": "gf", "lb": "lbf", "lbs": "lbf", "oz": "ozf", "t": "tf"}

# A name with a digit behind it has an exponent: mm2, mm-2. A power is one digit, and no power of a
# power, which pint would compute.
_EXPONENT = re.compile(r"(?<=[A-Za-z])(?=(?:-[1-9]|[2-9])(?![\w.]))")
_POWER = re.compile(r"\)\s*(?:\^|\*\*)|(?:\^|\*\*)(?!\s*-?\d(?![\w.]|\s*(?:[.^(]|\*\*)))")
_STRANGE = re.compile(r"[^\w\s*/^().°%-]")
_WORD = re.compile(r"[A-Za-z_]+|\"|''")
_TYPED = str.maketrans({"·": "*", "⋅": "*", "×": "*", "∙": "*", "−": "-", "⁄": "/", "∕": "/",
                        "″": '"', "”": '"', "“": '"', "μ": "u", "º": "°", "˚": "°"})  # fmt: skip
# pint counts an angle as dimensionless, so '30 %' would pass for one.
_ANGLES = {"deg", "degree", "degrees", "°", "rad", "radian", "radians", "turn", "turns", "mrad",
           "grad", "gon", "arcmin", "arcsec", "revolution", "revolutions"}  # fmt: skip


@cache
def _registry() -> Any:
    """pint's registry on exact fractions. Built at first use: it costs half a second."""
    import pint

    return pint.UnitRegistry(non_int_type=Fraction)


@lru_cache(maxsize=1024)
def measure(unit: str, internal: str) -> tuple[str, Fraction | None]:
    """What kind of value ``unit`` measures, and its size in ``internal`` where that fits.

    The kind is "" where it fits and ``UNKNOWN`` where there is no such unit.
    """
    if len(unit) > _LONGEST:
        return UNKNOWN, None
    usual = USUAL.get(internal, {})
    if factor := usual.get(unit) or usual.get(canonical(unit)):
        return "", factor
    return by_pint(unit, internal)


def canonical(unit: str) -> str:
    """A unit as pint writes it: 'N/mm2', 'N·mm⁻²' and 'N mm-2' are 'N/mm^2' in their ways."""
    text = unicodedata.normalize("NFKC", unit.translate(_TYPED)).translate(_TYPED).strip()
    text = _EXPONENT.sub("^", re.sub(r"^/", "1/", text))
    if gauge := _GAUGE.fullmatch(text):
        return gauge[1]
    return _WORD.sub(lambda word: _SPELLINGS.get(word[0], word[0]), text)


def by_pint(unit: str, internal: str) -> tuple[str, Fraction | None]:
    """The same as ``measure`` from pint's registry, for units of all kinds."""
    text, wanted = canonical(unit), canonical(internal)
    if refusal(unit) or not (_is_plain(text) and _is_plain(wanted)):
        return UNKNOWN, None
    registry = _registry()
    try:
        parsed = registry.parse_units(text)
        if internal == "degree":
            fits = text in _ANGLES
        else:
            fits = bool(parsed.dimensionality) and parsed.is_compatible_with(wanted)
        if fits:
            return "", Fraction(registry.Quantity(Fraction(1), parsed).to(wanted).magnitude)
        return _kind(parsed), None
    except Exception:
        # pint's parser raises errors of many kinds on text that is no unit, AssertionError too,
        # and its arithmetic others on temperatures and decibels.
        return UNKNOWN, None


def _is_plain(text: str) -> bool:
    """Whether pint may see a unit: products and quotients of small powers."""
    return len(text) <= _LONGEST and not _STRANGE.search(text) and not _POWER.search(text)


def refusal(unit: str, internal: str = "") -> str | None:
    """Why a unit of this world is not read, in words; None where there is nothing special."""
    unit = unit[:_LONGEST]
    if internal == "mm/s^2" and unit in ("g", "G"):
        return _GRAVITY_IS
    if re.search(r"shore", unit, re.IGNORECASE):
        return _HARDNESS_IS
    if _ABSOLUTE.fullmatch(unit.strip()):
        return _ABSOLUTE_IS
    return next((_REFUSED[word] for word in _WORD.findall(unit) if word in _REFUSED), None)


def meant(unit: str, internal: str) -> str | None:
    """The unit that was probably meant by one that is unknown or of another kind, None: no idea.

    One that differs in capitals only, or the weight where a mass is written: 'kgf/cm^2'.
    """
    if len(unit) > _LONGEST:
        return None
    text = canonical(unit)
    twins = [known for known in USUAL.get(internal, {}) if known.lower() == text.lower()]
    twins += [known for known in ("psi", "lbf") if known == text.lower()]
    weight = _WORD.sub(lambda word: _WEIGHTS.get(word[0], word[0]), text)
    candidates = twins if weight == text else [*twins, weight]
    return next((known for known in candidates if measure(known, internal)[1]), None)


def _kind(parsed: Any) -> str:
    if parsed.dimensionless:
        return "an angle or a bare ratio"
    for unit, kind in KINDS.items():
        if parsed.is_compatible_with(unit):
            return kind
    return "of another kind"
