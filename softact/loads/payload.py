"""Dead forces on surfaces, shared out over their undeformed area, on lines and on points."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from softact.fields import Fault, Forces, Part, Place
from softact.loads.base import Load, vector_faults
from softact.loads.several import added_up, entries, one_or_several, placed
from softact.loads.traction import SurfaceForce
from softact.mesh.layout import Layout
from softact.system.term import Value

if TYPE_CHECKING:
    from softact.model import Model

ACROSS = (
    "a force across the symmetry plane '{plane}' would pull its mirror image the other way; model "
    "the whole actuator or leave it out"
)


class Payload(Part):
    """A dead force on a surface, shared out over its undeformed area, on a line or on a point: a
    weight that hangs there."""

    surface: str | None = Field(
        None, description="surface of the geometry, line or point; by default the tip"
    )
    force: Forces = Field(description="force on the whole actuator along x, y, z")


class PayloadLoad(Load):
    """Forces per undeformed area (3,) MPa that add up to the payload of the whole actuator."""

    key = "payload"
    annotation = one_or_several(Payload)
    description = "dead force on a surface, line or point, the tip by default; or a list of them"

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        for entry, at in placed(written, place):
            yield from vector_faults(entry, "force", at, layout, operator.eq, ACROSS, layout.marks)

    def ends(
        self, value: Payload | Sequence[Payload], model: Model
    ) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        layout = model.mesh.layout
        forces = [(load.surface or layout.tip, np.asarray(load.force)) for load in entries(value)]
        areas = {name: layout.copies * model.surfaces.area(name) for name, _ in forces}
        return {self.key: added_up((name, force / areas[name]) for name, force in forces)}

    def said(self, name: str, value: Value, model: Model) -> str:
        """See ``Load.said``."""
        area = model.mesh.layout.copies * model.surfaces.area(name)
        return f"payload of {area * np.linalg.norm(value):.4g} N on '{name}'"

    def term(self, model: Model, name: str) -> SurfaceForce:
        """See ``Load.term``."""
        return SurfaceForce(self.key, name, model.unit_forces(name))
