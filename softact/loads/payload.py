"""Dead forces on surfaces, shared out over their undeformed area: weights that hang there."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from softact.fields import Fault, Forces, Part, Place
from softact.loads.base import Load, vector_faults
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
    """A dead force on a surface, shared out over its undeformed area: a weight that hangs there."""

    surface: str | None = Field(None, description="surface of the geometry; by default its tip")
    force: Forces = Field(description="force on the whole actuator along x, y, z")


class PayloadLoad(Load):
    """Forces per undeformed area (3,) MPa that add up to the payload of the whole actuator."""

    key = "payload"
    annotation = Payload
    description = "dead force on a surface, the tip by default"

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        return vector_faults(written, "force", place, layout, operator.eq, ACROSS)

    def ends(self, value: Payload, model: Model) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        surface = value.surface or model.mesh.layout.tip
        area = model.mesh.layout.copies * model.surfaces.area(surface)
        return {self.key: {surface: np.asarray(value.force) / area}}

    def term(self, model: Model, name: str) -> SurfaceForce:
        """See ``Load.term``."""
        return SurfaceForce(self.key, name, model.unit_forces(name))
