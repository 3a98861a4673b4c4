"""How far the numbers of a spec scatter from one actuator to the next, as a spec has it."""

import math
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, WithJsonSchema, model_validator

from softact.fields import Part, fault, fault_at
from softact.units import show, split

#: The end of a part of the number itself, such as ``16 %``.
PERCENT = "%"


def _text(value: Any) -> str:
    """A number with its unit, as it is written."""
    parts = None if isinstance(value, bool | dict | list | tuple) else split(str(value))
    if parts is None or not math.isfinite(float(parts[0])):
        raise fault(f"{show(value)} is no number with its unit; write for example 0.1 mm or 16 %")
    return str(value).strip()


def _limits(value: Any) -> tuple[str, ...]:
    """One text, or two."""
    given = value if isinstance(value, list | tuple) else [value]
    if len(given) not in (1, 2):
        raise fault("write one number (0.1 mm: so much to both sides), or the lower and the upper")
    return tuple(_text(entry) for entry in given)


_TEXT_SCHEMA: dict[str, Any] = {"type": ["string", "number"], "examples": ["0.1 mm", "16 %"]}
_LIMITS_SCHEMA: dict[str, Any] = {
    "anyOf": [_TEXT_SCHEMA, {"type": "array", "items": _TEXT_SCHEMA, "minItems": 2, "maxItems": 2}]
}


class ToleranceSpec(Part, title="Tolerance"):
    """How far a number scatters: normally about its value, or evenly between limits."""

    std: Annotated[str, BeforeValidator(_text), WithJsonSchema(_TEXT_SCHEMA)] | None = Field(
        None, description="standard deviation, with its unit or in % of the number"
    )
    limits: (
        Annotated[tuple[str, ...], BeforeValidator(_limits), WithJsonSchema(_LIMITS_SCHEMA)] | None
    ) = Field(
        None,
        strict=False,
        description="evenly between limits: so much to both sides, or [lower, upper]",
    )

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        if (self.std is None) == (self.limits is None):
            raise fault("write either 'std' or 'limits'")
        alone = [("std", self.std)] if self.std else []
        alone += [("limits", self.limits[0])] if self.limits and len(self.limits) == 1 else []
        for key, text in alone:
            parts = split(text)
            if parts is None or float(parts[0]) <= 0.0:
                raise fault_at((key,), f"{show(text)} has to be above 0")
        return self


def _short(value: Any) -> Any:
    """A standard deviation may stand alone."""
    return value if isinstance(value, dict | ToleranceSpec) else {"std": value}


#: A tolerance, or a standard deviation alone.
AnyTolerance = Annotated[
    ToleranceSpec,
    BeforeValidator(_short),
    WithJsonSchema({"anyOf": [_TEXT_SCHEMA, ToleranceSpec.model_json_schema()]}),
]
