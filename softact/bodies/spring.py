"""Springs that hold surfaces of the actuator, see ``softact.loads.support.Spring``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from softact.bodies.base import BodyKind
from softact.loads.support import Spring
from softact.system.term import Origin, State

if TYPE_CHECKING:
    from softact.model import Model
    from softact.system.term import Term


class SpringTerm:
    """½ Σ k |u|² over the points of a surface; its reactions act on the actuator.

    The area is lumped at points that integrate a quadratic exactly: exact where the surface moves
    as a rigid body.
    """

    def __init__(self, model: Model, spring: Spring):
        self.spring, self.surface = spring, spring.surface
        nodes, shares = model.surfaces.shares(spring.surface)
        stiffness = np.asarray(spring.stiffness) / model.mesh.layout.copies
        self._dofs = model.displacement_dofs[nodes]
        self._stiffness = shares[:, None] * stiffness
        self._assembler = model.assembler
        numbers = model.unknowns.number[self._dofs].ravel()
        self._slots = model.assembler.couple(numbers, numbers)

    def forces(self, state: State) -> np.ndarray:
        """Forces (k, 3) N of the springs on this process's own points of the surface."""
        return -self._stiffness * state.x[self._dofs]

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        out[self._dofs] -= self.forces(state)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        free = self._assembler.fixed[self._dofs] == 0
        self._assembler.extra_values[self._slots] += (free * self._stiffness).ravel()

    def energy(self, state: State) -> float:
        """See ``Term``."""
        return float(np.sum(self._stiffness * state.x[self._dofs] ** 2)) / 2


class SpringSupport:
    """Springs beside the bodies: their energy is none of the actuator's; see ``Body``."""

    elastic: Sequence[Term] = ()
    slowness, slackens, smooth, stiffness = 0.0, False, True, 0.0

    def __init__(self, model: Model, spring: Spring):
        self.term = SpringTerm(model, spring)

    @property
    def external(self) -> Sequence[Term]:
        """See ``Body``."""
        return [self.term]

    def weight(self) -> None:
        """See ``Body``."""

    def inertia(self) -> None:
        """See ``Body``."""


class Springs(BodyKind):
    """The kind of body that supports with springs are; see ``BodyKind``."""

    key = "springs"

    def build(self, model: Model, parts: Sequence[Spring]) -> list[SpringSupport]:
        """See ``BodyKind``."""
        return [SpringSupport(model, spring) for spring in parts]
