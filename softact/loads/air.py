"""Air in cavities: a supply behind a valve, and a cavity that is closed with the air it has."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from softact.fields import ALL_CAVITIES, Fault, Part, Place, fault
from softact.loads.base import Load
from softact.loads.cavity_pressure import cavity_faults, for_cavities
from softact.loads.gas_flow import GAMMA, SPEED, Valve
from softact.loads.tube_flow import Tube
from softact.mesh.layout import Layout
from softact.system.term import Value
from softact.units import Conductance, Dimensionless, Length, Pressure, show

if TYPE_CHECKING:
    from softact.model import Model

OTHERS = ("pressure", "inject", "supply", "exhaust", "sealed")
Exponent = Annotated[Dimensionless, Field(ge=1, le=GAMMA)]
_EXPONENT = (
    "n of p Vⁿ: 1 where the air keeps its temperature (slow), 1.4 where it exchanges no heat (fast)"
)


class TubeSpec(Part, title="Tube"):
    """A straight smooth tube in the supply line; the air that is in it does not count."""

    length: Length = Field(gt=0, description="of the tube")
    diameter: Length = Field(gt=0, description="inside")


class _Opening(Part):
    """What air passes: an orifice or a laminar valve, a tube, or both in a row."""

    diameter: Length | None = Field(None, gt=0, description="of the valve's orifice")
    discharge_coefficient: Dimensionless = Field(
        0.8, gt=0, le=1, description="part of the orifice's area that counts"
    )
    conductance: Conductance | None = Field(
        None, gt=0, description="of a laminar valve, in place of an orifice"
    )
    tube: TubeSpec | None = Field(None, description="between the valve and the cavity")
    polytropic: Exponent = Field(1.0, description=_EXPONENT)

    @model_validator(mode="after")
    def _has_one_valve(self) -> Self:
        if self.diameter is not None and self.conductance is not None:
            raise fault("a valve has a diameter or a conductance, not both")
        if self.diameter is None and self.conductance is None and self.tube is None:
            raise fault(
                "a supply has a diameter or a conductance, or a tube; write for example 1 mm"
            )
        return self


class SupplySpec(_Opening, title="Supply"):
    """Air of a constant pressure behind a valve; below the cavity's pressure it is an exhaust."""

    pressure: Pressure = Field(
        gt=-0.101325, description="of the supply, above ambient; 0 kPa lets the air out"
    )


class ExhaustSpec(_Opening, title="Exhaust"):
    """A way out into the ambient."""


class SealedSpec(Part, title="Sealed"):
    """A cavity that keeps its air: p V = n R T with absolute pressures."""

    heated: Dimensionless = Field(
        1.0, gt=0, le=10, description="absolute temperature at the end of the step by that before"
    )
    polytropic: Exponent = Field(1.0, description=_EXPONENT)

    @model_validator(mode="after")
    def _has_one_temperature(self) -> Self:
        if self.heated != 1.0 and self.polytropic != 1.0:
            raise fault("heated says the temperature, and so does polytropic; write one of them")
        return self


def _each(part: type[Part]) -> BeforeValidator:
    def written(value: Any) -> Any:
        if value is True:
            return {ALL_CAVITIES: {}}
        whole = isinstance(value, dict) and (not value or bool(part.model_fields.keys() & value))
        return {ALL_CAVITIES: value} if whole else value

    return BeforeValidator(written)


class _Air(Load):
    """What cavities filled by air have in common."""

    holds_volume = True

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        named = written if isinstance(written, dict) and not self._is_one(written) else None
        yield from cavity_faults(named, place, layout, "pressure", self.example)
        for other in OTHERS:
            if other != self.key and step.get(other) is not None:
                text = f"this step has {show(other)} too; drive cavities by one of them in a step"
                yield place, text
        if not layout.regions:
            yield place, "sheets without a solid cannot be filled with air yet; give a pressure"

    example = ""

    @staticmethod
    def _is_one(written: Mapping[str, Any]) -> bool:
        known = {*SupplySpec.model_fields, *SealedSpec.model_fields}
        return not written or any(key in known for key in written)

    def for_layout(self, value: Mapping[str, Any], layout: Layout) -> dict[str, Any]:
        """See ``Load.for_layout``."""
        return for_cavities(value, layout)


class _Flows(_Air):
    """What cavities that air flows into or out of have in common: by cavity the numbers of
    ``_numbers``."""

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        yield from super().faults(written, place, layout, step)
        if step.get("duration") is None and step.get("amplitude") is None:
            yield place, "air takes time to flow; give the step a duration"

    def ends(self, value: Mapping[str, Any], model: Model) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        copies = model.mesh.layout.copies
        return {self.key: {name: _numbers(opening, copies) for name, opening in value.items()}}


class Supply(_Flows):
    """Supplies of cavities."""

    key = "supply"
    annotation = Annotated[dict[str, SupplySpec], _each(SupplySpec)]
    description = (
        "air behind a valve or a tube, of all cavities or {cavity: ...}, in a step with a clock; "
        "the pressure follows from how much has flowed, and stays when the step has ended"
    )
    example = "{pressure: 60 kPa, diameter: 1 mm}"


class Exhaust(_Flows):
    """Openings of cavities into the ambient."""

    key = "exhaust"
    annotation = Annotated[dict[str, ExhaustSpec], _each(ExhaustSpec)]
    description = (
        "a valve or a tube through which air goes out into the ambient, of all cavities or "
        "{cavity: ...}, in a step with a clock"
    )
    example = "{diameter: 2 mm}"


class Sealed(_Air):
    """Closed cavities: by cavity how much hotter they become."""

    key = "sealed"
    annotation = Annotated[dict[str, SealedSpec], _each(SealedSpec)]
    description = (
        "closed with the air that is in it at the start of the step: true, {heated: ratio}, "
        "{polytropic: n} or {cavity: ...}; its pressure follows, and stays when the step has ended"
    )
    example = "{heated: 1.1}"

    def ends(self, value: Mapping[str, Any], model: Model) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        ends = {n: np.array([sealed.heated, sealed.polytropic]) for n, sealed in value.items()}
        return {self.key: ends}


def _numbers(opening: _Opening, copies: int) -> np.ndarray:
    """Pressure, area, conductance, exponent, length and diameter of the tube (0: none), and by how
    many meshed parts the flow is shared."""
    pressure = opening.pressure if isinstance(opening, SupplySpec) else 0.0
    area = 0.0
    if opening.diameter is not None:
        area = opening.discharge_coefficient * np.pi * opening.diameter**2 / 4
    tube = [opening.tube.length, opening.tube.diameter] if opening.tube else [0.0, 0.0]
    valve = [pressure, area, opening.conductance or 0.0]
    return np.array([*valve, opening.polytropic, *tube, float(copies)])


def valve_of(numbers: Value) -> Valve:
    """The valve of the numbers of a load that flows."""
    pressure, area, conductance, _, length, diameter, copies = map(float, np.asarray(numbers))
    tube = Tube(length, diameter, SPEED) if length else None
    return Valve(pressure, area, conductance, tube, copies)


def exponent_of(numbers: Value) -> float:
    """n of a load that flows."""
    return float(np.asarray(numbers)[3])


def sealed_of(numbers: Value) -> tuple[float, float]:
    """How much hotter the air of a ``Sealed`` cavity becomes, and its n."""
    heated, exponent = map(float, np.asarray(numbers))
    return heated, exponent
