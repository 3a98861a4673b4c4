"""Prescribed displacements of surfaces, and springs on them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from softact.system.rotation import rotation_about

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Turn:
    """A rotation about an axis, in degrees; about: a point (mm) of the axis, None for the middle
    of the undeformed surface."""

    axis: Vector
    angle: float
    about: Vector | None = None


@dataclass(frozen=True)
class Support:
    """Prescribed displacements (mm) of a surface: component (0, 1, 2) -> value.

    None holds each point where it is when the support begins. turn: a rotation of the undeformed
    surface, which prescribes all three components in place of ``values``.
    """

    surface: str
    values: Mapping[int, float | None] = field(default_factory=dict)
    turn: Turn | None = None

    @property
    def components(self) -> tuple[int, ...]:
        """Which components are prescribed."""
        return (0, 1, 2) if self.turn else tuple(self.values)


@dataclass(frozen=True)
class Spring:
    """Linear springs from where the points of a surface were undeformed to a fixed ground.

    stiffness: (3,) N/mm of the whole surface of the whole actuator along x, y and z, spread evenly
    over its undeformed area.
    """

    surface: str
    stiffness: Vector


@dataclass(frozen=True)
class Turned:
    """A surface on its way from one angle (degrees) to another.

    dofs, places: (k, 3) unknowns of its points, and where they were undeformed, mm. centre, axis:
    of the rotation.
    """

    surface: str
    dofs: np.ndarray
    places: np.ndarray
    centre: np.ndarray
    axis: np.ndarray
    start: float
    end: float

    def displacements(self, before: np.ndarray | float, fraction: float) -> np.ndarray:
        """Displacements (k, 3) mm at a part of the way from ``before`` (k, 3).

        What the surface's shape lacks to a rigid rotation fades as it turns.
        """
        arms = self.places - self.centre
        shape = (arms + before) @ rotation_about(self.axis, self.start)  # turned back
        shape = (1 - fraction) * shape + fraction * arms
        angle = self.angle(fraction)
        return shape @ rotation_about(self.axis, angle).T - arms

    def angle(self, fraction: float) -> float:
        """At a part of the way, degrees."""
        return (1 - fraction) * self.start + fraction * self.end

    def halted(self, part: float) -> Turned:
        """The same, at rest at a part of the way."""
        return replace(self, start=self.angle(part), end=self.angle(part))


@dataclass(frozen=True)
class Held:
    """Displacements (mm) that supports prescribe along a step.

    dofs: (m,) local unknowns, in rising order. start, end: (m,). turned: surfaces that rotate.
    """

    dofs: np.ndarray
    start: np.ndarray
    end: np.ndarray
    turned: Sequence[Turned] = ()

    def seen_from(self, x: np.ndarray) -> Held:
        """The same from where the body is, ``x`` (local,)."""
        return replace(self, start=x[self.dofs])

    def arrived(self) -> Held:
        """The same at the end of the way: what has been turned stays so."""
        return replace(self, turned=[replace(t, start=t.end) for t in self.turned])

    def halted(self, x: np.ndarray, part: float) -> Held:
        """The same where the way ended at a part of it, with the body at ``x`` (local,)."""
        turned = [t.halted(part) for t in self.turned]
        return replace(self, start=x[self.dofs], end=x[self.dofs], turned=turned)

    @property
    def moves(self) -> bool:
        """Whether anything moves."""
        return not np.array_equal(self.start, self.end)

    def at(self, fraction: float) -> np.ndarray:
        """Displacements (m,) at a part of the way."""
        values = (1 - fraction) * self.start + fraction * self.end
        for turned in self.turned:
            at = np.searchsorted(self.dofs, turned.dofs)
            values[at] = turned.displacements(self.start[at], fraction)
        return values
