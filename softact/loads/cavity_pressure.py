"""Follower pressure on the walls of closed cavities."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from softact.fields import ALL_CAVITIES, Fault, Place, Pressures
from softact.loads.base import Load
from softact.mesh.layout import Layout
from softact.nearest import nearest
from softact.system.kernels import Coefficient, Kernel
from softact.system.term import FUNCTIONS, Origin, State, Value
from softact.units import show

if TYPE_CHECKING:
    from softact.model import Model
    from softact.system.assembly import Assembler


class Pressure(Load):
    """Pressures of cavities; conjugate to their volumes. Its terms are the model's cavities."""

    key = "pressure"
    annotation = Pressures
    description = "of all cavities, or {cavity: pressure}; below zero for a vacuum"

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        return cavity_faults(written, place, layout, "pressure", "50 kPa")

    def for_layout(self, value: Mapping[str, float], layout: Layout) -> dict[str, float]:
        """See ``Load.for_layout``."""
        return for_cavities(value, layout)

    def said(self, name: str, value: Value, model: Model) -> str:
        """See ``Load.said``."""
        return f"{name} at {1e3 * float(value):.4g} kPa"


def for_cavities(value: Mapping[str, float], layout: Layout) -> dict[str, float]:
    """One value for all cavities written out for each of them."""
    if ALL_CAVITIES in value:
        return dict.fromkeys(layout.cavities, value[ALL_CAVITIES])
    return dict(value)


def cavity_faults(
    written: Any, place: Place, layout: Layout, what: str, example: str
) -> Iterator[Fault]:
    """Yield what is wrong with a value for cavities."""
    if isinstance(written, dict):
        for cavity in written:
            if cavity not in layout.cavities:
                hint = nearest(cavity, layout.cavities)
                yield (*place, cavity), f"the geometry has no cavity {show(cavity)}; {hint}"
        if not written:
            yield place, f"no cavity is named; write {{cavity: {example}}} or {example}"
    if not layout.cavities:
        yield place, f"the geometry has no cavity that could hold a {what}"


class CavityPressure:
    """Follower pressure on the walls of a closed cavity: potential −p V(u)."""

    def __init__(self, assembler: Assembler, name: str, facets: np.ndarray, degree: int):
        self.name = name
        self._size = 3 * FUNCTIONS[degree]
        self._table = assembler.unknowns.cell_dofs
        self._volume, self._force, self._tangent = (
            Kernel(assembler, k, facets) for k in assembler.kernels("cavity", degree)
        )

    def _u(self, x: np.ndarray) -> list[Coefficient]:
        return [Coefficient(x, self._size, self._table)]

    def _pressure(self, state: State) -> float:
        return float(state["pressure"].get(self.name, 0.0))

    def volume(self, x: np.ndarray) -> float:
        """This process's share of the enclosed volume, mm³."""
        return self._volume.scalar(self._u(x))

    def add_volume_gradient(self, x: np.ndarray, factor: float, out: np.ndarray) -> None:
        """Add ``factor`` times the derivative of the volume with respect to the unknowns to ``out``
        (local,)."""
        self._force.add_vector(out, self._size, self._u(x), [-factor])

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        if pressure := self._pressure(state):
            self._force.add_vector(out, self._size, self._u(state.x), [pressure])

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        if pressure := self._pressure(state):
            self._tangent.add_matrix(self._size, self._u(state.x), [pressure])

    def energy(self, state: State) -> float:
        """See ``Term``."""
        return -self._pressure(state) * self.volume(state.x)
