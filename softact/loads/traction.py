"""Dead forces per undeformed area on surfaces: they keep their direction."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from softact.fields import Fault, Part, Place, Vector
from softact.loads.base import Load, surface_fault
from softact.loads.several import added_up, entries, one_or_several, placed
from softact.mesh.layout import Layout
from softact.system.term import Origin, State, Value

if TYPE_CHECKING:
    from softact.model import Model


class Traction(Part):
    """A dead force per undeformed area on a surface: it keeps its direction."""

    surface: str = Field(description="surface of the geometry")
    value: Vector = Field(description="force per area along x, y, z")


class TractionLoad(Load):
    """Forces per undeformed area (3,) MPa; per undeformed length, N/mm, on a curve."""

    key = "traction"
    annotation = one_or_several(Traction)
    description = "dead load on a surface; or a list of them"

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        for entry, at in placed(written, place):
            if isinstance(entry, dict):
                yield from surface_fault(entry.get("surface"), (*at, "surface"), layout)

    def ends(
        self, value: Traction | Sequence[Traction], model: Model
    ) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        loads = ((load.surface, np.asarray(load.value)) for load in entries(value))
        return {self.key: added_up(loads)}

    def said(self, name: str, value: Value, model: Model) -> str:
        """See ``Load.said``."""
        return f"traction of {1e3 * np.linalg.norm(value):.4g} kPa on '{name}'"

    def term(self, model: Model, name: str) -> SurfaceForce:
        """See ``Load.term``."""
        return SurfaceForce(self.key, name, model.unit_forces(name))


class SurfaceForce:
    """Dead force per undeformed area on a surface; unit: nodal forces (3, local) N of 1 N/mm²
    along x, y and z. field: where a state holds its value."""

    def __init__(self, field: str, name: str, unit: np.ndarray):
        self.field, self.name, self._unit = field, name, unit

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        if self.name in state[self.field]:
            out -= state[self.field][self.name] @ self._unit

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """A dead force does not depend on the displacement."""

    def energy(self, state: State) -> float:
        """See ``Term``."""
        if self.name not in state[self.field]:
            return 0.0
        return -float(state[self.field][self.name] @ self._unit @ state.x)
