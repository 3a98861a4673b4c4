"""Masses that an actuator carries: a weight at its tip, a sensor, a payload that swings along."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from softact.bodies.base import BodyKind
from softact.bodies.inertia import Inertia, LumpedInertia
from softact.bodies.weight import Weight
from softact.fields import Fault, Part, Place
from softact.loads.base import surface_fault
from softact.mesh.layout import Layout
from softact.units import Mass

if TYPE_CHECKING:
    from softact.model import Model
    from softact.system.term import Term


class CarriedMass(Part):
    """A mass without a stiffness of its own, spread over a surface, a line or a point."""

    surface: str | None = Field(
        None, description="surface of the geometry, line or point; by default the tip"
    )
    mass: Mass = Field(gt=0, description="what the whole actuator carries there")


def carried_at(masses: Sequence[CarriedMass] | None, surface: str, tip: str) -> float:
    """Tonne on a surface; those that name none are at the tip."""
    return sum(carried.mass for carried in masses or () if (carried.surface or tip) == surface)


class MassOnSurface:
    """A carried mass as a body beside the others; see ``Body``. mass: of the meshed part, tonne."""

    elastic: Sequence[Term] = ()
    external: Sequence[Term] = ()
    slowness, slackens, smooth, stiffness = 0.0, False, True, 0.0

    def __init__(self, model: Model, carried: CarriedMass):
        layout = model.mesh.layout
        nodes, shares = model.surfaces.shares(carried.surface or layout.tip)
        self.mass = carried.mass / layout.copies
        dofs, masses = model.displacement_dofs[nodes], self.mass * shares
        unit = np.zeros((3, model.unknowns.local))
        unit[np.arange(3), dofs] = masses[:, None]
        self._weight = Weight(unit)
        self._inertia = LumpedInertia(model, dofs, masses)

    def weight(self) -> Weight:
        """See ``Body``."""
        return self._weight

    def inertia(self) -> Inertia:
        """See ``Body``."""
        return self._inertia


class CarriedMasses(BodyKind):
    """The kind of body that a spec's ``masses`` are."""

    key = "masses"
    annotation = list[CarriedMass]
    description = (
        "masses that the actuator carries: gravity pulls at them, and they swing along where a "
        "step has dynamics"
    )

    def faults(self, written: Any, place: Place, layout: Layout) -> Iterator[Fault]:
        """See ``BodyKind``."""
        for index, entry in enumerate(written if isinstance(written, list) else ()):
            if isinstance(entry, dict):
                name = entry.get("surface") or layout.tip
                yield from surface_fault(name, (*place, index, "surface"), layout, layout.marks)

    def build(self, model: Model, parts: Sequence[CarriedMass]) -> list[MassOnSurface]:
        """See ``BodyKind``."""
        return [MassOnSurface(model, part) for part in parts]
