"""What a contact is, whether with a rigid obstacle or between bodies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from softact.system.term import State, Term

if TYPE_CHECKING:
    from softact.contact.facets import Facets
    from softact.contact.rigid import Obstacle


class Contact(Term, Protocol):
    """A term of the potential energy with a memory, of this process's part of the body.

    name: in a spec and in results. symmetric: whether its tangent is. facets: that may touch.
    obstacle: what the body touches, None where it touches a body. What it has to know of the last
    equilibrium stands in ``state.memory`` under keys that begin with its name.
    """

    name: str
    symmetric: bool

    @property
    def facets(self) -> Facets:
        """See the class."""

    @property
    def obstacle(self) -> Obstacle | None:
        """See the class."""

    def remember(self, state: State) -> dict[str, np.ndarray]:
        """What is to be kept of a new equilibrium; candidates are sought anew."""

    def resume(self, state: State) -> None:
        """Take up a run at an equilibrium that was stored with its memory."""

    def look_afresh(self, state: State, keep: bool = False) -> bool:
        """Let each point face what it would if nothing were known of the way to this state; whether
        any that touches faces something else then. keep: such points stay as they are, and the
        state remembers it. Collective."""

    def stand_beside(self, other: Contact, state: State) -> None:
        """Look only at what matters beside a state of another contact of the same facets, of which
        this one differs a little in the places of its points. Collective."""

    def strayed(self, state: State) -> float:
        """How far surfaces have moved since candidates were sought, relative to how far they
        may without a second look."""

    def met_unseen(self, state: State) -> bool:
        """Whether a point went into something that was no candidate."""

    def overlap(self, state: State) -> tuple[float, float]:
        """Smallest gap in mm and its ratio to the element size where bodies overlap; where they do
        not, neither is below zero, and they may be larger than the smallest ones."""

    def smallest_gap(self, state: State) -> tuple[float, float]:
        """Smallest gap in mm and its ratio to the element size, below zero where bodies overlap."""

    def force(self, state: State) -> np.ndarray:
        """Force (3,) N on the body."""

    def area(self, state: State) -> float:
        """Undeformed area in touch, mm²."""

    def pressures(self, state: State) -> np.ndarray:
        """Pressure (k, 12) per undeformed area at the points of ``facets``, MPa."""

    def admissible(self, state: State, x: np.ndarray, to: np.ndarray) -> bool:
        """Whether Newton may go from ``x`` to ``to`` (local,) at the loads of ``state``."""

    def passed(self, before: State, after: State) -> bool:
        """Whether a point went through something between two states."""

    def overrun(self, before: State, after: State) -> bool:
        """Whether an obstacle moved too far into a body that had not moved."""

    def stands(self, state: State) -> bool:
        """Whether an obstacle is there, so that a body may not begin inside of it."""

    def deepest(self, state: State) -> tuple[float, np.ndarray]:
        """Smallest gap (mm) and where it is (3,), for an obstacle that stands."""
