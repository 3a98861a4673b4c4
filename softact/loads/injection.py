"""Volume that is added to cavities, as by a syringe; their pressures are then unknown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from softact.fields import Fault, Place, Volumes
from softact.loads.base import Load
from softact.loads.cavity_pressure import cavity_faults, for_cavities
from softact.mesh.layout import Layout
from softact.system.term import Value
from softact.units import show

if TYPE_CHECKING:
    from softact.model import Model


class Injection(Load):
    """Volumes that are added to cavities in a step."""

    key = "inject"
    annotation = Volumes
    description = (
        "volume added to a cavity in this step, as by a syringe; its pressure follows, and stays "
        "when the step has ended. Of all cavities, or {cavity: volume}; below zero to withdraw"
    )
    holds_volume = True

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        yield from cavity_faults(written, place, layout, "volume", "2 ml")
        pressure = step.get("pressure")
        if pressure is None:
            return
        both = isinstance(pressure, dict) and isinstance(written, dict)
        names = [n for n in written if n in pressure] if both else ["all cavities"]
        for name in names:
            yield (
                place,
                f"{show(name)} has a pressure in this step too; drive a cavity by one of them",
            )

    def for_layout(self, value: Mapping[str, float], layout: Layout) -> dict[str, float]:
        """See ``Load.for_layout``."""
        return for_cavities(value, layout)

    def ends(self, value: Mapping[str, float], model: Model) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``: of the meshed part."""
        copies = model.mesh.layout.copies
        return {self.key: {name: volume / copies for name, volume in value.items()}}
