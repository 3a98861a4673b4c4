"""The tolerances of a spec as distributions of its parameters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import TYPE_CHECKING, Any

from softact.errors import SpecError
from softact.sensitivities.parameters import Parameter, at, parameters
from softact.spec.tolerances import PERCENT
from softact.units import conversion, show, split

if TYPE_CHECKING:
    from softact.spec import Spec
    from softact.spec.tolerances import ToleranceSpec

EVEN = math.sqrt(12.0)  # width of an even distribution by its standard deviation


@dataclass(frozen=True)
class Cause:
    """Parameters that scatter together.

    name: as the spec has it. means, deviations: of each parameter, in internal units. even: evenly
    between limits, else normally.
    """

    name: str
    parameters: tuple[Parameter, ...]
    means: tuple[float, ...]
    deviations: tuple[float, ...]
    even: bool

    @property
    def shifts(self) -> tuple[float, ...]:
        """By how much the mean of each parameter is above its value in the spec."""
        return tuple(m - p.value for m, p in zip(self.means, self.parameters, strict=True))

    def values(self, fraction: float) -> tuple[float, ...]:
        """The parameters' values, in internal units, below which this part of all actuators is."""
        way = EVEN * (fraction - 0.5) if self.even else NormalDist().inv_cdf(fraction)
        return tuple(m + way * d for m, d in zip(self.means, self.deviations, strict=True))

    def along(self, first: float) -> tuple[float, ...]:
        """The values of all parameters, in internal units, where the first has this one."""
        way = (first - self.means[0]) / self.deviations[0]
        return tuple(m + way * d for m, d in zip(self.means, self.deviations, strict=True))


def causes(spec: Spec) -> list[Cause]:
    """The tolerances of a spec. Raises SpecError with a line for each that is none."""
    if not spec.tolerances:
        return []
    known = {p.place: p for p in parameters(spec)}
    data = spec.model_dump(mode="json", exclude_none=True)
    found: list[Cause] = []
    faults, seen = [], set()
    for name, tolerance in spec.tolerances.items():
        try:
            those = [at(spec, path.strip(), known, data) for path in name.split(",")]
            for parameter in those:
                if parameter.path in seen:
                    raise SpecError(f"{parameter.path} has a tolerance already")
                seen.add(parameter.path)
            found.append(_cause(name, those, tolerance))
        except SpecError as error:
            faults += [f"tolerances: {name}: {line}" for line in error.lines]
    if faults:
        raise SpecError(*faults)
    return found


def paths(some: Sequence[Cause]) -> list[str]:
    """The paths of all their parameters."""
    return [parameter.path for cause in some for parameter in cause.parameters]


def _cause(name: str, those: Sequence[Parameter], tolerance: ToleranceSpec) -> Cause:
    pairs = [_mean_and_deviation(parameter, tolerance) for parameter in those]
    means, deviations = zip(*pairs, strict=True)
    return Cause(name, tuple(those), means, deviations, tolerance.std is None)


def _mean_and_deviation(parameter: Parameter, tolerance: ToleranceSpec) -> tuple[float, float]:
    """Of one parameter, in internal units."""
    if tolerance.std is not None:
        return parameter.value, _width(parameter, tolerance.std)
    assert tolerance.limits is not None  # one of both is given
    if len(tolerance.limits) == 1:
        return parameter.value, 2 * _width(parameter, tolerance.limits[0]) / EVEN
    low, high = _ends(parameter, tolerance.limits)
    return (low + high) / 2, (high - low) / EVEN


def _ends(parameter: Parameter, limits: Sequence[str]) -> Iterator[float]:
    if any(text.endswith(PERCENT) for text in limits):
        raise SpecError("two limits are values with their units; in % write one, for both sides")
    low, high = (_internal(parameter, text) for text in limits)
    if not low <= parameter.value <= high or low == high:
        value = f"{parameter.told:.10g} {parameter.unit}".strip()
        raise SpecError(f"the value of the spec, {value}, is not between {' and '.join(limits)}")
    return iter((low, high))


def _width(parameter: Parameter, text: str) -> float:
    number, unit = _split(text)
    if unit != PERCENT:
        return _internal(parameter, text)
    if parameter.value == 0.0:
        raise SpecError(f"{show(text)} of 0 is nothing; write it with its unit")
    return number / 100 * abs(parameter.value)


def _internal(parameter: Parameter, text: str) -> float:
    """A number as it is written, in the parameter's internal unit."""
    number, unit = _split(text)
    if bool(unit) != bool(parameter.unit):
        right = f"{number:g} {parameter.unit}".strip()
        raise SpecError(f"{show(text)} is none of its values; write for example '{right}'")
    try:
        factor = conversion(unit, parameter.unit) if unit else 1.0
    except ValueError as error:
        raise SpecError(str(error)) from None
    return number * factor * parameter.factor


def _split(text: str) -> tuple[float, str]:
    parts: Any = split(text)
    return float(parts[0]), parts[1]
