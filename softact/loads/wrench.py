"""A moment and a force on the cross-sections of a chain of modules."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from softact.fields import Fault, Forces, Moments, Part, Place, is_zero
from softact.loads.base import Load
from softact.mesh.layout import Layout, free_components
from softact.system.term import EVERYTHING, Origin, State, Value

if TYPE_CHECKING:
    from softact.model import Model


class Wrench(Part):
    """A moment and a force at the right face, about the middle of the left one, in the frame of the
    left one."""

    moment: Moments = Field((0.0, 0.0, 0.0), description="moment about x, y, z")
    force: Forces = Field((0.0, 0.0, 0.0), description="force along x, y, z")


class WrenchLoad(Load):
    """Moment N·mm and force N, (6,), on the meshed part: conjugate to ω and t."""

    key = "wrench"
    annotation = Wrench
    description = "moment and force on the cross-sections of a chain, of which a module is meshed"
    easy = False

    def faults(
        self, written: Any, place: Place, layout: Layout, step: Mapping[str, Any]
    ) -> Iterator[Fault]:
        """See ``Load.faults``."""
        if layout.repeats is None:
            yield place, "acts on a module of a chain; write module: {left: ..., right: ...} too"
            return
        for key, free in zip(("moment", "force"), free_components(layout.symmetry), strict=True):
            vector = written.get(key) if isinstance(written, dict) else None
            for axis, value in enumerate(vector if isinstance(vector, list | tuple) else ()):
                if axis < 3 and not free[axis] and not is_zero(value):
                    yield (*place, key, axis), "the symmetry planes leave no room for it"

    def ends(self, value: Wrench, model: Model) -> dict[str, Mapping[str, Value]]:
        """See ``Load.ends``."""
        wrench = np.concatenate([value.moment, value.force]) / model.mesh.layout.copies
        return {self.key: {EVERYTHING: wrench}}

    def said(self, name: str, value: Value, model: Model) -> str:
        """See ``Load.said``."""
        moment, force = (model.mesh.layout.copies * np.linalg.norm(v) for v in np.split(value, 2))
        return f"moment of {moment:.4g} N·mm and force of {force:.4g} N on the cross-sections"

    def term(self, model: Model, name: str) -> SectionLoad:
        """See ``Load.term``."""
        return SectionLoad(model)


class SectionLoad:
    """Potential −m · ω − f · t."""

    def __init__(self, model: Model):
        assert model.repeat is not None  # or it was refused
        self._dofs, self._scale = model.repeat.dofs, model.repeat.scale

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        out[self._dofs] -= state["wrench"].get(EVERYTHING, 0.0) * self._scale

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """It does not depend on the motion."""

    def energy(self, state: State) -> float:
        """See ``Term``."""
        wrench = state["wrench"].get(EVERYTHING, 0.0) * self._scale
        return -float(np.sum(wrench * state.x[self._dofs]))
