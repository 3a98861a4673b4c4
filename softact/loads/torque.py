"""A torque on a surface, about an axis that keeps its direction."""

from __future__ import annotations

import operator
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from softact.fields import Fault, Moments, Part, Place
from softact.loads.base import Load, vector_faults
from softact.loads.several import added_up, entries, one_or_several, placed
from softact.mesh.layout import Layout
from softact.system.term import Origin, State, Value

if TYPE_CHECKING:
    from softact.model import Model

FULL = 2 * np.pi
IN_PLANE = (
    "a moment about an axis in the symmetry plane '{plane}' would turn its mirror image the other "
    "way; model the whole actuator or leave it out"
)


class Torque(Part):
    """A torque on a surface: its axis keeps its direction, the surface may turn as far as it
    wants."""

    surface: str | None = Field(
        None, description="surface of the geometry, or line; by default the tip"
    )
    moment: Moments = Field(description="moment on the whole actuator about x, y, z")


class TorqueLoad(Load):
    """Moments (3,) N·mm on surfaces of the meshed part."""

    key = "torque"
    annotation = one_or_several(Torque)
    description = (
        "moment on a surface or line, the tip by default; its axis keeps its direction; or a list "
        "of them"
    )

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        for entry, at in placed(written, place):
            yield from vector_faults(
                entry, "moment", at, layout, operator.ne, IN_PLANE, layout.lines
            )

    def ends(
        self, value: Torque | Sequence[Torque], model: Model
    ) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        layout = model.mesh.layout
        moments = (
            (load.surface or layout.tip, np.asarray(load.moment) / layout.copies)
            for load in entries(value)
        )
        return {self.key: added_up(moments)}

    def said(self, name: str, value: Value, model: Model) -> str:
        """See ``Load.said``."""
        moment = model.mesh.layout.copies * np.linalg.norm(value)
        return f"torque of {moment:.4g} N·mm on '{name}'"

    def term(self, model: Model, name: str) -> SurfaceTorque:
        """See ``Load.term``."""
        return SurfaceTorque(model, name)


class SurfaceTorque:
    """Potential −M φ, where φ is the mean rotation of the surface about the torque's axis e.

    With the arms r of the undeformed points from the surface's middle, across e, and with the
    shares w of its area, φ = atan2(s·u, c·c₀ + c·u), s = w e × r and c = w r: the rotation that
    takes the undeformed surface nearest to the deformed one, in the least squares' sense. The
    forces are tangential and grow with the arm, as the shear in a round bar.
    """

    def __init__(self, model: Model, name: str):
        self.name, self._assembler, self._comm = name, model.assembler, model.comm
        nodes, self._share = model.surfaces.shares(name)
        self._dofs = model.displacement_dofs[nodes]
        places = model.nodes.places[nodes]
        self._arms = places - model.sum(self._share @ places)
        numbers = model.unknowns.number[self._dofs].ravel()
        every = np.concatenate(self._comm.allgather(numbers))
        self._slots = model.assembler.couple(
            np.repeat(numbers, len(every)), np.tile(every, len(numbers))
        )
        self._angle = 0.0  # the last one

    def _parts(self, state: State) -> tuple[float, np.ndarray, np.ndarray, float, float]:
        """Torque, s and c (k, 3), and S and C, the sums of whose ratio φ is the angle."""
        vector = state["torque"][self.name]
        torque = float(np.linalg.norm(vector))
        axis = vector / torque
        arms = self._arms - np.outer(self._arms @ axis, axis)
        s = self._share[:, None] * np.cross(axis, arms)
        c = self._share[:, None] * arms
        u = state.x[self._dofs]
        sums = np.array([np.sum(s * u), np.sum(c * (self._arms + u))])
        sine, cosine = self._comm.allreduce(sums)
        return torque, s, c, float(sine), float(cosine)

    def _acts(self, state: State) -> bool:
        return bool(np.any(state["torque"].get(self.name, 0.0)))

    def angle(self, state: State) -> float:
        """Mean rotation of the surface about the torque's axis, radians, past half turns."""
        _, _, _, sine, cosine = self._parts(state)
        angle = float(np.arctan2(sine, cosine))
        self._angle = angle + FULL * round((self._angle - angle) / FULL)
        return self._angle

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        if self._acts(state):
            torque, s, c, sine, cosine = self._parts(state)
            out[self._dofs] -= torque * (cosine * s - sine * c) / (sine**2 + cosine**2)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        if not self._acts(state):
            return
        torque, s, c, sine, cosine = self._parts(state)
        free = self._assembler.fixed[self._dofs] == 0
        s, c = (free * s).ravel(), (free * c).ravel()
        all_s, all_c = (np.concatenate(self._comm.allgather(v)) for v in (s, c))
        mixed = (sine**2 - cosine**2) * (np.outer(s, all_c) + np.outer(c, all_s))
        alike = 2 * sine * cosine * (np.outer(s, all_s) - np.outer(c, all_c))
        second = (mixed - alike) / (sine**2 + cosine**2) ** 2
        self._assembler.extra_values[self._slots] -= torque * second.ravel()

    def energy(self, state: State) -> float:
        """See ``Term``: on the first process."""
        if not self._acts(state):
            return 0.0
        torque = float(np.linalg.norm(state["torque"][self.name]))
        angle = self.angle(state)
        return -torque * angle if self._comm.rank == 0 else 0.0
