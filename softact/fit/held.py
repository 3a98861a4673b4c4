"""Constants that a fit holds (``--fix``): names and values, each as the law can have it."""

import math
from collections.abc import Mapping
from typing import Any

from pydantic import TypeAdapter, ValidationError

from softact.errors import SpecError
from softact.fit.candidates import Candidate, Parameter
from softact.materials.base import MAX_VOLUMETRIC_ORDER, VOLUMETRIC
from softact.nearest import nearest
from softact.units import dimension_of, show

_OF_THE_CARD = (*VOLUMETRIC, *(f"d{i}" for i in range(2, MAX_VOLUMETRIC_ORDER + 1)))


def hold(candidate: Candidate, held: Mapping[str, str]) -> Candidate:
    """Return the candidate with constants held at values as the user writes them.

    Raises SpecError for a constant that the law has not and a value that it cannot have.
    """
    values = {name: _value(candidate, name, text) for name, text in held.items()}
    return candidate.fix(values)


def _value(candidate: Candidate, name: str, text: str) -> object:
    """A held value in internal units."""
    own = [c.name for c in candidate.law.constants() if c.name in candidate.held_names]
    known = [*candidate.names, *own, *_OF_THE_CARD]
    if name not in known:
        raise SpecError(
            f"--fix: {candidate.name} has no constant {show(name)}; {nearest(name, known)}"
        )
    entry = candidate.law.model_fields[name]
    whole = dimension_of(entry) is None and text.isdecimal() and len(text) < 4
    adapter: TypeAdapter[Any] = TypeAdapter(entry.rebuild_annotation())
    try:
        value = adapter.validate_python(int(text) if whole else text)
    except ValidationError as error:
        raise SpecError(f"--fix {name}: {first_fault(error)}") from None
    parameter = next((p for p in candidate.parameters if p.name == name), None)
    if parameter is not None:
        _check_bounds(parameter, float(value))
    return value


def _check_bounds(parameter: Parameter, value: float) -> None:
    if not math.isfinite(value) or abs(value) < parameter.apart:
        raise SpecError(f"--fix {parameter.name}: {value:g} is too near to 0")
    if not parameter.lower <= value <= parameter.upper:
        bounds = f"from {parameter.lower:g} to {parameter.upper:g}"
        raise SpecError(f"--fix {parameter.name}: {value:g} is not within what is fitted, {bounds}")


def first_fault(error: ValidationError) -> str:
    """What pydantic says of a value first, in one line without its decoration."""
    fault = error.errors(include_url=False)[0]
    return " ".join(fault["msg"].removeprefix("Value error, ").split())
