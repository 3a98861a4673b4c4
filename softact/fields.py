"""Types of fields that are more than one value with a unit, and the faults that they raise."""

import math
import re
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    PlainSerializer,
    PlainValidator,
    StringConstraints,
    TypeAdapter,
    WithJsonSchema,
)
from pydantic_core import InitErrorDetails, PydanticCustomError, ValidationError

from softact.units import (
    ACCELERATION,
    Dimensionless,
    Force,
    Length,
    Moment,
    Pressure,
    Volume,
    show,
)

STANDARD_GRAVITY = 9810.0  # mm/s^2, as in the design: g = 9.81 m/s^2
ALL_CAVITIES = "*"
#: A place in a spec, and what is wrong there.
Place = tuple[str | int, ...]
Fault = tuple[Place, str]


class Part(BaseModel):
    """Base of the parts of a spec."""

    # A command needs few of all models: each is built when it is used first.
    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, defer_build=True)


def fault(message: str) -> PydanticCustomError:
    """Return an error that pydantic reports word for word (braces in it are no template)."""
    return PydanticCustomError("softact", "{message}", {"message": message})


def fault_at(place: tuple[str | int, ...], message: str, value: Any = None) -> ValidationError:
    """Return an error about ``place``, seen from the value that is validated."""
    details: InitErrorDetails = {"type": fault(message), "loc": place, "input": value}
    return ValidationError.from_exception_data("spec", [details])


def given(data: Any) -> str:
    """Return what stands where something else is wanted, for the start of an error line."""
    if data is None:
        return "no value is given"
    if isinstance(data, dict):
        return "a mapping is given"
    if isinstance(data, list | tuple):
        return "a list is given"
    return f"{show(data)} is given"


Component = Literal["x", "y", "z"]
COMPONENTS: tuple[Component, Component, Component] = ("x", "y", "z")
Name = Annotated[
    str,
    StringConstraints(pattern=r"^[a-z0-9][a-z0-9_-]{0,63}$"),
]


def three(value: Any) -> tuple[Any, ...]:
    """Return a list of three as a tuple; anything else is a fault."""
    if not isinstance(value, list | tuple) or len(value) != 3:
        count = f"{len(value)} values are given" if isinstance(value, list) else given(value)
        raise fault(f"{count}; write a list of three for x, y, z")
    return tuple(value)


def _gravity(value: Any) -> tuple[float, float, float]:
    values = three(value)
    if any(isinstance(entry, str) for entry in values):
        x, y, z = (_acceleration(i, entry) for i, entry in enumerate(values))
        return x, y, z
    numbers = [isinstance(v, int | float) and not isinstance(v, bool) for v in values]
    if not all(numbers) or not all(abs(v) < 1e300 for v in values):
        raise fault("three finite numbers are wanted (direction times g), or three accelerations")
    if math.hypot(*values) > 9:
        raise fault(
            f"{show(list(values))} without unit counts in g; for accelerations write units, "
            "for example [0 m/s^2, 0 m/s^2, -9.81 m/s^2]"
        )
    return tuple(STANDARD_GRAVITY * entry for entry in values)


def _acceleration(index: int, value: Any) -> float:
    try:
        return ACCELERATION.parse(value)
    except ValueError as error:
        raise fault_at((index,), str(error), value) from None


def _for_all_cavities(value: Any) -> Any:
    return value if isinstance(value, dict) else {ALL_CAVITIES: value}


def _each_or_all(schema: dict[str, Any]) -> dict[str, Any]:
    return {"anyOf": [schema, {"type": "object", "additionalProperties": schema}]}


def is_zero(value: Any) -> bool:
    """Whether a quantity of plain data is nought, such as ``0 N``."""
    return bool(re.match(r"\s*[-+]?[0.]+\s", f"{value} "))


def one_or_more(value: Any) -> Any:
    """Return a single name as a list of one."""
    return (value,) if isinstance(value, str) else value


#: JSON schema of a name or a list of names.
NAMES_SCHEMA = {
    "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}, "minItems": 1}]
}
VECTOR = {"type": "array", "minItems": 3, "maxItems": 3}
GRAVITY_SCHEMA = {
    **VECTOR,
    "items": {"type": ["number", "string"]},
    "description": "direction times g, such as [0, 0, -1], or three accelerations with unit",
}
PRESSURE_SCHEMA = TypeAdapter(Pressure).json_schema()
VOLUME_SCHEMA = TypeAdapter(Volume).json_schema()
Gravity = Annotated[
    tuple[float, float, float],
    PlainValidator(_gravity),
    PlainSerializer(lambda v: [ACCELERATION.format(a) for a in v], when_used="json"),
    WithJsonSchema(GRAVITY_SCHEMA),
]
Pressures = Annotated[
    dict[str, Pressure],
    BeforeValidator(_for_all_cavities),
    WithJsonSchema(_each_or_all(PRESSURE_SCHEMA)),
]
Volumes = Annotated[
    dict[str, Volume],
    BeforeValidator(_for_all_cavities),
    WithJsonSchema(_each_or_all(VOLUME_SCHEMA)),
]
Forces = Annotated[tuple[Force, Force, Force], BeforeValidator(three)]
Moments = Annotated[tuple[Moment, Moment, Moment], BeforeValidator(three)]
Vector = Annotated[tuple[Pressure, Pressure, Pressure], BeforeValidator(three)]


def _direction(value: tuple[float, float, float]) -> tuple[float, float, float]:
    if math.hypot(*value) < 1e-9:
        raise fault("all three are zero; write a direction such as [0, 0, 1]")
    return value


Point = Annotated[tuple[Length, Length, Length], BeforeValidator(three)]
Direction = Annotated[
    tuple[Dimensionless, Dimensionless, Dimensionless],
    BeforeValidator(three),
    AfterValidator(_direction),
]
