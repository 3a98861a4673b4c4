"""Follower pressure on faces that enclose no cavity, such as one face of a block."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from softact.errors import SpecError
from softact.fields import Fault, Place
from softact.loads.base import Load, surface_fault
from softact.mesh.layout import Layout
from softact.system.kernels import Coefficient, Kernel
from softact.system.term import FUNCTIONS, Origin, State, Value
from softact.units import Pressure

if TYPE_CHECKING:
    from softact.model import Model


class SurfacePressure(Load):
    """Pressures of surfaces, MPa, pushing inwards."""

    key = "surface_pressure"
    annotation = dict[str, Pressure]
    description = "on faces that enclose no cavity: {surface: pressure}, pushing inwards"

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        for name in written if isinstance(written, dict) else ():
            yield from surface_fault(name, (*place, name), layout)

    def said(self, name: str, value: Value, model: Model) -> str:
        """See ``Load.said``."""
        return f"surface pressure of {1e3 * float(value):.4g} kPa on '{name}'"

    def term(self, model: Model, name: str) -> FacePressure:
        """See ``Load.term``."""
        if model.surfaces.is_sheet(name):
            raise SpecError(f"surface_pressure: '{name}' is a sheet; only cavities press it")
        return FacePressure(model, name)


class FacePressure:
    """Follower pressure on a surface that need not be closed."""

    def __init__(self, model: Model, name: str):
        assembler, facets = model.assembler, model.surfaces.facets(name)
        self.name = name
        self._size = 3 * FUNCTIONS[model.degree]
        self._table = assembler.unknowns.cell_dofs
        self._force, self._tangent = (
            Kernel(assembler, k, facets)
            for k in assembler.kernels("surface_pressure", model.degree)
        )

    def _arguments(self, state: State) -> tuple[int, list[Coefficient], list[float]]:
        pressure = float(state["surface_pressure"].get(self.name, 0.0))
        return self._size, [Coefficient(state.x, self._size, self._table)], [pressure]

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        self._force.add_vector(out, *self._arguments(state))

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        self._tangent.add_matrix(*self._arguments(state))

    def energy(self, state: State) -> float:
        """Such a pressure has no potential; it counts as zero."""
        return 0.0
