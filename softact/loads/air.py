"""Air in cavities: a supply behind a valve, and a cavity that is closed with the air it has."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from softact.fields import ALL_CAVITIES, Fault, Part, Place, fault
from softact.loads.base import Load
from softact.loads.cavity_pressure import cavity_faults, for_cavities
from softact.loads.gas_flow import Valve
from softact.mesh.layout import Layout
from softact.system.term import Value
from softact.units import Conductance, Dimensionless, Length, Pressure, show

if TYPE_CHECKING:
    from softact.model import Model

OTHERS = ("pressure", "inject", "supply", "sealed")


class SupplySpec(Part, title="Supply"):
    """Air of a constant pressure behind a valve; below the cavity's pressure it is an exhaust."""

    pressure: Pressure = Field(
        gt=-0.101325, description="of the supply, above ambient; 0 kPa lets the air out"
    )
    diameter: Length | None = Field(None, gt=0, description="of the valve's orifice")
    discharge_coefficient: Dimensionless = Field(
        0.8, gt=0, le=1, description="part of the orifice's area that counts"
    )
    conductance: Conductance | None = Field(
        None, gt=0, description="of a laminar valve or tube, in place of an orifice"
    )

    @model_validator(mode="after")
    def _has_one_valve(self) -> Self:
        if (self.diameter is None) == (self.conductance is None):
            raise fault("a supply has a diameter or a conductance; write for example 1 mm")
        return self


class SealedSpec(Part, title="Sealed"):
    """A cavity that keeps its air: p V = n R T with absolute pressures."""

    heated: Dimensionless = Field(
        1.0, gt=0, le=10, description="absolute temperature at the end of the step by that before"
    )


def _each(inside: str) -> BeforeValidator:
    def written(value: Any) -> Any:
        if value is True:
            return {ALL_CAVITIES: {}}
        whole = isinstance(value, dict) and (not value or inside in value)
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
        known = (*SupplySpec.model_fields, *SealedSpec.model_fields)
        return not written or any(key in known for key in written)

    def for_layout(self, value: Mapping[str, Any], layout: Layout) -> dict[str, Any]:
        """See ``Load.for_layout``."""
        return for_cavities(value, layout)


class Supply(_Air):
    """Supplies: by cavity [pressure, area, conductance] of the meshed part."""

    key = "supply"
    annotation = Annotated[dict[str, SupplySpec], _each("pressure")]
    description = (
        "air behind a valve, of all cavities or {cavity: ...}, in a step with a clock; the "
        "pressure follows from how much has flowed, and stays when the step has ended"
    )
    example = "{pressure: 60 kPa, diameter: 1 mm}"

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
        return {self.key: {name: _numbers(s) / [1, copies, copies] for name, s in value.items()}}


class Sealed(_Air):
    """Closed cavities: by cavity how much hotter they become."""

    key = "sealed"
    annotation = Annotated[dict[str, SealedSpec], _each("heated")]
    description = (
        "closed with the air that is in it at the start of the step: true, or {heated: ratio}, or "
        "{cavity: ...}; its pressure follows, and stays when the step has ended"
    )
    example = "{heated: 1.1}"

    def ends(self, value: Mapping[str, Any], model: Model) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        return {self.key: {name: np.asarray(sealed.heated) for name, sealed in value.items()}}


def _numbers(supply: SupplySpec) -> np.ndarray:
    area = 0.0
    if supply.diameter is not None:
        area = supply.discharge_coefficient * np.pi * supply.diameter**2 / 4
    return np.array([supply.pressure, area, supply.conductance or 0.0])


def valve_of(numbers: Value) -> Valve:
    """The valve of the numbers of a ``Supply``."""
    pressure, area, conductance = map(float, np.asarray(numbers))
    return Valve(pressure, area, conductance)
