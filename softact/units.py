"""Values with a unit, read into the units that softact computes in: mm, N, MPa, tonne, s, degree.

A field of a spec says what it is by its type (``wall: Length``). It is written with a unit
(``3 mm``) and held as a plain float in internal units. A default may be written either as the
float in internal units or, in a model with ``validate_default=True``, as the text ``"3 mm"``.
"""

import math
import re
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any

from pydantic import BeforeValidator, PlainSerializer, WithJsonSchema
from pydantic_core import PydanticCustomError

from softact.unit_lookup import UNKNOWN, meant, measure, refusal

_NUMBER = r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?"
_BEGINS = re.compile(_NUMBER)
_NOT_FINITE = re.compile(r"[+-]?\.?(?:nan|inf|infinity)\b", re.IGNORECASE)
_COMMA = re.compile(r"[+-]?\d+,\d")
_SHOWN_LENGTH = 40
SCHEMA_KEY = "x-dimension"  # where a field's JSON schema names its dimension


@dataclass(frozen=True)
class Dimension:
    """A kind of value: its name, the internal unit, and the units in which it is shown.

    internal: the unit in which softact computes.
    shown: units in which ``format`` writes, the first that gives a handy exact number.
    other: more units worth naming to somebody who gave one that does not fit.
    example: a value as one would write it in a spec.
    """

    name: str
    internal: str
    shown: tuple[str, ...]
    other: tuple[str, ...]
    example: str

    def parse(self, value: Any) -> float:
        """Return ``value`` (text with a unit) as a float in internal units.

        Raises ValueError with one line that says what is wrong and what would be right.
        """
        if value is None:
            raise ValueError(f"no value is given; {self.hint}")
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise ValueError(f"{show(value)} is not {self.wanted}")
        text = value.strip() if isinstance(value, str) else plain(value)
        if _NOT_FINITE.match(text):
            raise ValueError(f"{show(value)} is not a finite number; {self.hint}")
        if _COMMA.match(text):
            raise ValueError(f"{show(value)} has a decimal comma; write a decimal point")
        parts = split(text)
        if parts is None:
            raise ValueError(f"{show(value)} is not {self.wanted}{_because(refusal(text))}")
        number, unit = parts
        if not unit and self.internal != "degree":
            raise ValueError(f"{show(value)} has no unit; {self.hint}")
        magnitude = float(number)
        if not math.isfinite(magnitude):
            raise ValueError(f"{show(value)} is too large for a number; {self.hint}")
        # Exact until the last step, so that 50 kPa is 0.05 MPa and not its neighbour.
        result = _to_float(Fraction(repr(magnitude)) * self._factor(unit or self.internal, value))
        if not math.isfinite(result) or (result == 0.0 and not _is_zero(number)):
            raise ValueError(f"{show(value)} is out of the range of numbers; {self.hint}")
        return result

    def format(self, value: float) -> str:
        """Return ``value`` (internal units) as text that ``parse`` reads back to the same float."""
        texts = [self._text(value, unit) for unit in self.shown]
        exact = [text for text in texts if text and self.parse(text) == value]
        handy = [text for text in exact if not value or 0.1 <= abs(float(text.split()[0])) < 1000]
        if handy:
            return handy[0]
        return min(exact, key=len) if exact else f"{_number(value)} {self.internal}"

    @property
    def wanted(self) -> str:
        """What to write, for the end of an error line."""
        article = "an" if self.name[0] in "aeiou" else "a"
        return f"{article} {self.name} such as '{self.example}'"

    @property
    def hint(self) -> str:
        """What would be right, with the units that fit."""
        article = "an" if self.name[0] in "aeiou" else "a"
        return (
            f"write {article} {self.name}, for example '{self.example}' "
            f"(units that fit: {', '.join(self.shown + self.other)})"
        )

    def _factor(self, unit: str, value: Any) -> Fraction:
        kind, factor = measure(unit, self.internal)
        if factor is not None:
            return factor
        other = meant(unit, self.internal)
        why = refusal(unit, self.internal)
        right = f"did you mean '{other}'?" if other else why or self.hint
        if kind == UNKNOWN:
            raise ValueError(f"{show(value)}: there is no unit {show(unit)}; {right}")
        raise ValueError(f"{show(value)} is {kind}; {right}")

    def _text(self, value: float, unit: str) -> str | None:
        factor = measure(unit, self.internal)[1]
        if factor is None:
            return None
        number = _to_float(Fraction(value) / factor)
        return f"{_number(number)} {unit}" if math.isfinite(number) else None


LENGTH = Dimension("length", "mm", ("mm", "m"), ("cm", "um", "in"), "3 mm")
PRESSURE = Dimension("pressure", "MPa", ("kPa", "MPa", "GPa", "Pa"), ("bar", "psi"), "50 kPa")
DENSITY = Dimension("density", "tonne/mm^3", ("kg/m^3", "tonne/mm^3"), ("g/cm^3",), "1130 kg/m^3")
ANGLE = Dimension("angle", "degree", ("deg",), ("rad",), "30 deg")
ACCELERATION = Dimension("acceleration", "mm/s^2", ("m/s^2", "mm/s^2"), (), "-9.81 m/s^2")
FORCE = Dimension("force", "N", ("N", "mN", "kN"), ("lbf",), "2 N")
TIME = Dimension("time", "s", ("s", "ms"), ("min",), "0.5 s")
VOLUME = Dimension("volume", "mm^3", ("mm^3", "ml"), ("cm^3", "l"), "1.5 ml")
MOMENT = Dimension("moment", "N*mm", ("N*mm", "N*m"), (), "20 N*mm")
STIFFNESS = Dimension("stiffness", "N/mm", ("N/mm", "N/m"), (), "2 N/mm")
FREQUENCY = Dimension("frequency", "Hz", ("Hz", "kHz"), ("1/min",), "2 Hz")
CONDUCTANCE = Dimension(
    "conductance", "mm^3/(s*MPa)", ("mm^3/(s*MPa)",), ("l/(min*bar)",), "2 l/(min*bar)"
)
MASS = Dimension("mass", "tonne", ("g", "kg"), ("mg", "tonne"), "50 g")
COMPLIANCE = Dimension("compliance", "1/MPa", ("1/MPa",), ("1/kPa",), "2.9 1/MPa")

DIMENSIONS = (
    LENGTH,
    PRESSURE,
    DENSITY,
    ANGLE,
    ACCELERATION,
    FORCE,
    TIME,
    VOLUME,
    COMPLIANCE,
    MOMENT,
    STIFFNESS,
    FREQUENCY,
    CONDUCTANCE,
    MASS,
)


def split(text: str) -> tuple[str, str] | None:
    """Number and unit of a value as it is written: ``1.5 mm`` -> ("1.5", "mm"); None: no number
    comes first. In a time that grows with the length of the text."""
    text = text.strip()
    if text.startswith("\N{MINUS SIGN}"):
        text = f"-{text[1:]}"
    match = _BEGINS.match(text)
    return (match[0], text[match.end() :].strip()) if match else None


def conversion(unit: str, to: str) -> float:
    """Return the factor from ``unit`` to ``to``; raises ValueError where no such factor is."""
    kind, factor = measure(unit, to)
    if factor is None:
        what = "no unit" if kind == UNKNOWN else kind
        other = meant(unit, to)
        wanted = f", and a unit such as {show(to)} is wanted"
        right = f"; did you mean '{other}'?" if other else wanted
        raise ValueError(f"{show(unit)} is {what}{right}")
    return _to_float(factor)


def show(value: Any) -> str:
    """Return ``value`` in quotes as in the spec, on one line, shortened where it is long."""
    whole = plain(value).strip()
    text = one_line(whole[: 10 * _SHOWN_LENGTH])  # a spec may hold a million characters
    short = len(text) <= _SHOWN_LENGTH and len(whole) <= 10 * _SHOWN_LENGTH
    return f"'{text}'" if short else f"'{text[:_SHOWN_LENGTH]}…'"


def plain(value: Any) -> str:
    """``str(value)``, which fails for a whole number of very many digits."""
    try:
        return str(value)
    except ValueError:
        return "a whole number of more than 4300 digits"


def one_line(text: str) -> str:
    """Return ``text`` without line breaks and characters that a terminal might obey."""
    return printable(" ".join(text.split()))


def printable(text: str) -> str:
    """Return ``text`` without characters that a terminal might obey or cannot show."""
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def is_utf8(text: str) -> bool:
    """Whether a text can be written into a file: one out of '\\ud800' or of odd bytes cannot."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def dimension_of(annotation: Any) -> Dimension | None:
    """Return the dimension of an annotation or of a pydantic ``FieldInfo``, None if it has none."""
    for entry in getattr(annotation, "__metadata__", getattr(annotation, "metadata", ())):
        if isinstance(entry, Dimension):
            return entry
    for part in getattr(annotation, "__args__", ()):
        if found := dimension_of(part):
            return found
    inner = getattr(annotation, "annotation", None)
    return dimension_of(inner) if inner is not None else None


def _number(value: float) -> str:
    """The shortest text of a float that reads back to it, without a needless ``.0``."""
    text = repr(value)
    return text.removesuffix(".0")


def _because(why: str | None) -> str:
    return f": {why}" if why else ""


def _is_zero(number: str) -> bool:
    """Whether the digits of a number say zero, as those of 1e-400 do not."""
    return not any(c.isdecimal() and int(c) for c in re.split("[eE]", number)[0])


def _to_float(value: Fraction) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _quantity(dimension: Dimension) -> tuple[Any, ...]:
    def parse(value: Any) -> float:
        try:
            return dimension.parse(value)
        except ValueError as error:
            # The text goes in as context: braces in it are no template.
            raise PydanticCustomError("quantity", "{fault}", {"fault": str(error)}) from None

    schema = {
        "type": ["string", "number"] if dimension is ANGLE else "string",
        "description": f"{dimension.name} with unit, such as '{dimension.example}'",
        "examples": [dimension.example],
        SCHEMA_KEY: dimension.name,
    }
    if dimension is not ANGLE:
        schema["pattern"] = rf"^\s*{_NUMBER}\s*\S"
    return (
        BeforeValidator(parse),
        PlainSerializer(dimension.format, return_type=str, when_used="json"),
        WithJsonSchema(schema),
        dimension,
    )


def _parse_number(value: Any) -> Any:
    # YAML 1.1 reads 1e-4 (without a point) as text.
    if isinstance(value, str):
        parts = split(value)
        if parts and not parts[1]:
            value = float(parts[0])
        elif _NOT_FINITE.match(value.strip()):
            value = math.nan
        elif parts:
            fault = f"{show(value)} has a unit; a bare number is wanted here"
            raise PydanticCustomError("number", "{fault}", {"fault": fault})
    if isinstance(value, bool) or not isinstance(value, int | float):
        fault = f"{show(value)} is not a number"
        raise PydanticCustomError("number", "{fault}", {"fault": fault})
    try:
        finite = math.isfinite(value)
    except OverflowError:
        finite = False
    if not finite:
        fault = f"{show(value)} is not a finite number"
        raise PydanticCustomError("number", "{fault}", {"fault": fault})
    return float(value)


Length = Annotated[float, *_quantity(LENGTH)]
Pressure = Annotated[float, *_quantity(PRESSURE)]
Density = Annotated[float, *_quantity(DENSITY)]
Angle = Annotated[float, *_quantity(ANGLE)]
Acceleration = Annotated[float, *_quantity(ACCELERATION)]
Force = Annotated[float, *_quantity(FORCE)]
Time = Annotated[float, *_quantity(TIME)]
Moment = Annotated[float, *_quantity(MOMENT)]
Stiffness = Annotated[float, *_quantity(STIFFNESS)]
Volume = Annotated[float, *_quantity(VOLUME)]
Compliance = Annotated[float, *_quantity(COMPLIANCE)]
Conductance = Annotated[float, *_quantity(CONDUCTANCE)]
Frequency = Annotated[float, *_quantity(FREQUENCY)]
Mass = Annotated[float, *_quantity(MASS)]
Dimensionless = Annotated[float, BeforeValidator(_parse_number)]
