"""What supports exert on the actuator."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure, vector_columns

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    layout = snapshot.layout
    columns: dict[str, float] = {}
    origin = np.asarray(layout.origin)
    if layout.clamp and snapshot.held(layout.clamp):
        force, moment = snapshot.reaction
        columns = _columns("reaction", force, moment)
        if layout.tip:
            columns["pull_N"] = float(-force @ np.asarray(layout.axis))
    surfaces = dict.fromkeys(support.surface for support in snapshot.model.supports)
    for surface in surfaces:
        if surface != layout.clamp:
            columns |= _columns(f"reaction_{surface}", *snapshot.reaction_at(surface, origin))
    for body in snapshot.model.springs:
        term = body.term
        forces = snapshot.model.sum(term.forces(snapshot.state).sum(axis=0))
        columns |= vector_columns(f"spring_{term.surface}_<xyz>_N", snapshot.of_whole(forces))
    return columns


def _columns(name: str, force: np.ndarray, moment: np.ndarray) -> dict[str, float]:
    moments = vector_columns(f"{name}_moment_<xyz>_Nmm", moment)
    return vector_columns(f"{name}_<xyz>_N", force) | moments


def _titles(name: str, what: str) -> dict[str, str]:
    return {f"{name}_{c}_N": f"force of {what} along {c}" for c in "xyz"} | {
        f"{name}_moment_{c}_Nmm": f"moment of {what} about {c}, taken at the origin" for c in "xyz"
    }


REACTION = Measure(
    "reaction",
    "force and moment that each support exerts on the whole actuator, the clamp's first; where two "
    "hold the same edge, each has one half of the force there",
    _titles("reaction", "the clamp")
    | {
        "pull_N": "force along the undeformed axis with which the actuator pulls at its clamp, and "
        "so on what its tip lifts or is held by; negative: it pushes"
    }
    | _titles("reaction_<support>", "what holds another surface, line or point")
    | {f"spring_<support>_{c}_N": f"force of the springs on a surface along {c}" for c in "xyz"},
    _evaluate,
)
