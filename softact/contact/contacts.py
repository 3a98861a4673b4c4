"""All contacts of a model: what the solver asks of them between and during its iterations."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator

import numpy as np
from mpi4py import MPI

from softact.contact.base import Contact
from softact.contact.free_body import FreeBody
from softact.contact.memory import stiffness_factor, stiffness_key
from softact.errors import SpecError
from softact.system.term import State

# Overlap that is still contact, of the element size; stiffer from ENOUGH of it on.
LIMIT = 0.02
ENOUGH = 0.75
STIFFER, STIFFEST = 4.0, 1e4
UNSEEN = "a surface met '{}', which was farther off than contact looks ahead"
PASSED = "a point went through '{}' on its way"
OVERLAP = "'{}' overlaps by {:.1%} of an element; {:.0%} is the limit"
SUNK = "'{}' overlaps '{}' by {:.3g} mm"
OVERRUN = "'{}' moved too far into the body in one increment"


class Contacts:
    """The contacts of a model, in order; collective over the processes of ``comm``.

    bodies: free bodies, of which ``rests`` holds what they do with obstacles that stay in place.
    """

    def __init__(
        self, comm: MPI.Comm, contacts: Iterable[Contact] = (), bodies: Iterable[FreeBody] = ()
    ):
        self._comm = comm
        self._all, self._bodies = list(contacts), list(bodies)
        self._rests = [rest for body in self._bodies for rest in body.rests]

    def __iter__(self) -> Iterator[Contact]:
        return iter(self._all)

    def __len__(self) -> int:
        return len(self._all)

    @property
    def symmetric(self) -> bool:
        """Whether the tangent is: without friction."""
        sliding = any(rest.friction for rest in self._rests)
        return not sliding and all(contact.symmetric for contact in self._all)

    def remember(self, state: State) -> None:
        """Take ``state`` as the last equilibrium: from it friction is counted on."""
        kept: dict[str, np.ndarray] = {}
        for contact in self._all:
            kept |= contact.remember(state)
        for body in self._bodies:
            kept |= body.remember(state)
        state.memory = {**state.memory, **kept}

    def resume(self, state: State) -> None:
        """Take up a run at an equilibrium that was stored with its ``shift``, ``presence`` and
        ``memory``: all else that contact needs follows from these."""
        for contact in self._all:
            contact.resume(state)

    def stiffen(self, state: State) -> bool:
        """Raise the stiffness where bodies overlap too far; whether it was raised anywhere."""
        raised = False
        for contact in self._all:
            overlap = self._overlap(contact, state)
            factor = stiffness_factor(state, contact.name)
            if overlap > ENOUGH * LIMIT and factor < STIFFEST:
                state.memory = state.memory | {stiffness_key(contact.name): STIFFER * factor}
                raised = True
        return raised

    def look_afresh(self, state: State, keep: bool = False) -> bool:
        """Let points face what they would if nothing were known of the way to this state; whether
        any that touches faces something else then. keep: they stay as they are, and the state
        remembers it."""
        return any([contact.look_afresh(state, keep) for contact in self._all])

    def strayed(self, state: State) -> float:
        """How far surfaces have moved since contact looked about, relative to how far they may;
        above 1 they may have passed something unseen."""
        farthest = max((contact.strayed(state) for contact in self._all), default=0.0)
        return self._comm.allreduce(farthest, op=MPI.MAX) if self._all else 0.0

    def smallest_gap(self, contact: Contact, state: State) -> tuple[float, float]:
        """Smallest gap (mm) and smallest ratio of a gap to the element size, over all processes;
        inf: none."""
        gap, ratio = contact.smallest_gap(state)
        return self._comm.allreduce(gap, op=MPI.MIN), self._comm.allreduce(ratio, op=MPI.MIN)

    def touch(self, state: State) -> bool:
        """Whether anything is in touch."""
        if any(rest.touches(state) for rest in self._rests):
            return True
        return any(self._overlap(contact, state) > 0.0 for contact in self._all)

    def kinks(self, state: State) -> bool:
        """Whether forces may have kinks near a state: where surfaces touch, and wherever there is
        an obstacle."""
        return any(contact.obstacle is not None for contact in self) or self.touch(state)

    def _overlap(self, contact: Contact, state: State) -> float:
        """How far bodies overlap, relative to the element size; zero or less: they do not."""
        return -self._comm.allreduce(contact.overlap(state)[1], op=MPI.MIN)

    def area(self, contact: Contact, state: State) -> float:
        """Undeformed area (mm²) of the meshed part that is in touch."""
        return self._comm.allreduce(contact.area(state))

    def largest_pressure(self, contact: Contact, state: State) -> float:
        """Largest pressure of a contact, per undeformed area, MPa."""
        largest = float(contact.pressures(state).max(initial=0.0))
        return self._comm.allreduce(largest, op=MPI.MAX)

    def force(self, contact: Contact, state: State) -> np.ndarray:
        """Force (3,) N on the meshed part of the body."""
        return self._comm.allreduce(contact.force(state))

    def admissible(self, state: State, x: np.ndarray, to: np.ndarray) -> bool:
        """Whether Newton may go from ``x`` to ``to`` (local unknowns) at the loads of ``state``."""
        fine = all([contact.admissible(state, x, to) for contact in self._all])
        fine = fine and all(rest.admissible(state, x, to) for rest in self._rests)
        return bool(self._comm.allreduce(fine, op=MPI.LAND)) if self._all else True

    def met_unseen(self, state: State) -> str | None:
        """What met something that was out of its sight, as a reason to give the state up."""
        return self._first(UNSEEN, [c.met_unseen(state) for c in self])

    def passed(self, before: State, after: State) -> str | None:
        """What was passed through between two states, as a reason to give the second one up."""
        return self._first(PASSED, [c.passed(before, after) for c in self._all])

    def overlap_fault(self, state: State) -> str | None:
        """Which contact overlaps beyond the limit, as such a reason."""
        for contact in self._all:
            overlap = self._overlap(contact, state)
            if overlap > LIMIT:
                return OVERLAP.format(contact.name, overlap, LIMIT)
        for body in self._bodies:
            for rest in body.rests:
                if depth := rest.overlap(state):
                    return SUNK.format(body.name, rest.other.name, depth)
        return None

    def overrun(self, before: State, after: State) -> str | None:
        """Which obstacle moved too far into a body that had not moved, as such a reason."""
        return self._first(OVERRUN, [c.overrun(before, after) for c in self._all])

    def _first(self, reason: str, faults: list[bool]) -> str | None:
        for contact, fault in zip(self._all, faults, strict=True):
            if self._comm.allreduce(bool(fault), op=MPI.LOR):
                return reason.format(contact.name)
        return None

    def check_clear(self, state: State, names: Container[str] | None = None) -> None:
        """Raise SpecError where an obstacle (one of ``names``) that is there overlaps the body."""
        for body in self._bodies:
            for rest in body.rests:
                if depth := rest.overlap(state):
                    raise SpecError(
                        f"obstacles.{body.name}: overlaps obstacles.{rest.other.name} by "
                        f"{depth:.3g} mm; place it free of that, or let it touch"
                    )
        for contact in self._all:
            if not contact.stands(state):
                continue
            if names is not None and contact.name not in names:
                continue
            _, ratio = self.smallest_gap(contact, state)
            if ratio < -LIMIT:
                found = self._comm.allgather(contact.deepest(state))
                depth, place = min(found, key=lambda pair: pair[0])
                where = ", ".join(f"{c:.3g}" for c in place)
                raise SpecError(
                    f"obstacles.{contact.name}: overlaps the body by {-depth:.3g} mm near "
                    f"({where}) mm when it is put there; place it free of the body, or let it "
                    "touch"
                )
