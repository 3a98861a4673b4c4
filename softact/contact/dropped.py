"""Whether free bodies are held by what touches them, and in words why not."""

from __future__ import annotations

from collections.abc import Container
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.free_body import LOST, FreeBody
from softact.contact.rigid import RigidContact
from softact.system.term import State

if TYPE_CHECKING:
    from softact.model import Model

# A body slips where this part of the friction that there may be is used.
SLIPS = 0.9
PLACE = "obstacles."


def rubbing(model: Model, name: str, state: State) -> np.ndarray:
    """What presses on a free body, rubs on it, and might rub at most (3,), N, see
    ``RigidContact.rubbing``; of the meshed part. Collective."""
    touching = [c for c in model.contacts if isinstance(c, RigidContact) and c.name == name]
    found = model.sum(sum((contact.rubbing(state) for contact in touching), np.zeros(3)))
    return found + sum((r.rubs(state) for r in model.free_bodies[name].rests), np.zeros(3))


def lost(model: Model, state: State) -> str | None:
    """Which free body nothing holds in a state that Newton's method has found, and why; None where
    all are held, or move in time. Collective."""
    if state.motion is not None:
        return None
    for body in model.free_bodies.values():
        if body.held(state) == 1.0:
            continue
        acts = rubbing(model, body.name, state)
        total = float(np.linalg.norm(body.weight(state))) + acts[0] + acts[1]
        if np.linalg.norm(body.resistance(state)) > LOST * total:
            return f"{PLACE}{body.name}: {_why(body, state, acts)}"
    return None


def slipping(model: Model, state: State) -> list[str]:
    """Which free bodies are about to slip out of what holds them. Collective."""
    found = []
    for body in model.free_bodies.values():
        acts = rubbing(model, body.name, state)
        if body.held(state) < 1.0 and acts[2] > 0.0 and acts[1] > SLIPS * acts[2]:
            found.append(f"{PLACE}{body.name}: {_why(body, state, acts)}")
    return found


def smooth(model: Model, state: State, free: Container[str]) -> list[str]:
    """Which of the free bodies of these names are pressed on, and nothing rubs on them.
    Collective."""
    found = []
    for body in model.free_bodies.values():
        presses, _, most = rubbing(model, body.name, state)
        if body.name in free and presses > 0.0 and most == 0.0:
            found.append(
                f"{PLACE}{body.name}: what presses on it with {presses:.3g} N has no friction, and "
                "may let it slip"
            )
    return found


def _why(body: FreeBody, state: State, acts: np.ndarray) -> str:
    presses, rubs, most = acts
    weighs = float(np.linalg.norm(body.weight(state)))
    if presses == 0.0:
        return (
            f"nothing holds it: it touches nothing, and weighs {weighs:.3g} N; hold it in place "
            "(held: true), or let something hold it before"
        )
    if most > 0.0 and rubs > SLIPS * most:
        return (
            f"it slips: {rubs / most:.0%} of the friction of what presses on it with "
            f"{presses:.3g} N is used, and it weighs {weighs:.3g} N"
        )
    return f"nothing holds it: what touches it presses with {presses:.3g} N and lets it go"
