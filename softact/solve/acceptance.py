"""What a state must not be that Newton's method has found: nothing impossible is an equilibrium."""

from __future__ import annotations

from softact.bodies.soundness import NOTHING, smallest_in_the_middle
from softact.contact.dropped import lost
from softact.model import Model
from softact.system.term import State

# Volume that a cavity with walls of solids keeps at least, of its first one.
EMPTY = 1e-6


def fault(model: Model, before: State, state: State) -> str | None:
    """Why ``state`` is no equilibrium that can follow ``before``, an accepted one; None where it
    is. Collective."""
    return way_fault(model, before, state) or state_fault(model, state)


def way_fault(model: Model, before: State, state: State) -> str | None:
    """Why nothing can have moved from one state to the other; None where it can. Collective."""
    return model.contacts.met_unseen(state) or model.contacts.passed(before, state)


def state_fault(model: Model, state: State) -> str | None:
    """What is impossible in a state; None: nothing. Collective."""
    overlap = model.contacts.overlap_fault(state)
    return overlap or _empty_cavity(model, state) or _inverted(model, state) or lost(model, state)


def _empty_cavity(model: Model, state: State) -> str | None:
    for name, at_rest in model.cavity_volumes_at_rest.items():
        if at_rest > 0.0 and model.cavity_volume(state, name) < EMPTY * at_rest:
            return f"cavity '{name}' has no volume left: its walls have passed through each other"
    return None


def _inverted(model: Model, state: State) -> str | None:
    found = [smallest_in_the_middle(solid, state.x) for solid in model.solids.values()]
    worst = min(model.comm.allgather(min(found, default=NOTHING)))
    if worst.jacobian > 0.0:
        return None
    where = ", ".join(f"{c:.3g}" for c in worst.place)
    return f"an element at ({where}) mm is turned inside out"
