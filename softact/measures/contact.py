"""What presses on the actuator from outside, and how well contact keeps the gap closed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.dropped import rubbing
from softact.contact.pose import pose_of
from softact.measures.base import Measure, vector_columns

if TYPE_CHECKING:
    from softact.contact.rigid import Obstacle
    from softact.measures.snapshot import Snapshot


def blocked_force(snapshot: Snapshot) -> np.ndarray | None:
    """Force (3,) N of the whole actuator on all load cells; None where there is none."""
    contacts, state = snapshot.model.contacts, snapshot.state
    cells = [c for c in contacts if c.obstacle is not None and c.obstacle.load_cell]
    if not cells:
        return None
    return np.sum([snapshot.of_whole(contacts.force(cell, state)) for cell in cells], axis=0)


def _place(snapshot: Snapshot, obstacle: Obstacle) -> dict[str, float]:
    """Where an obstacle is; of a free body also what it rests on and by what it is held."""
    model, state, name = snapshot.model, snapshot.state, obstacle.name
    body = model.free_bodies.get(name)
    pose = pose_of(state["shift"].get(name), state["turn"].get(name))
    pose = pose if body is None else body.pose(state)
    middle = np.asarray(obstacle.shape.center, float)
    columns = vector_columns(f"obstacle_{name}_<xyz>_mm", pose.placed(middle) - middle)
    if body is not None or obstacle.turns:
        columns |= vector_columns(f"obstacle_{name}_turn_<xyz>_deg", pose.rotation)
    if body is None:
        return columns
    columns[f"hold_force_{name}_N"] = float(
        np.linalg.norm(snapshot.of_whole(body.hold_force(state)[:3]))
    )
    if body.rests:
        rests = np.sum([rest.force(state)[:3] for rest in body.rests], axis=0)
        columns[f"rest_force_{name}_N"] = float(np.linalg.norm(snapshot.of_whole(rests)))
    _, rubs, most = rubbing(model, name, state)
    columns[f"friction_used_{name}_percent"] = 100 * rubs / most if most else 0.0
    return columns


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    contacts, state = snapshot.model.contacts, snapshot.state
    columns: dict[str, float] = {}
    worst = 0.0
    for contact in contacts:
        gap, ratio = contacts.smallest_gap(contact, state)
        worst = max(worst, -ratio)
        if contact.obstacle is not None:
            force = snapshot.of_whole(contacts.force(contact, state))
            columns |= vector_columns(f"contact_force_{contact.name}_<xyz>_N", force)
            columns |= _place(snapshot, contact.obstacle)
        area = snapshot.layout.copies * contacts.area(contact, state)
        columns[f"contact_area_{contact.name}_mm2"] = area
        pressure = contacts.largest_pressure(contact, state)
        columns[f"contact_pressure_{contact.name}_kPa"] = 1e3 * pressure
        if math.isfinite(gap):
            columns[f"contact_gap_{contact.name}_mm"] = gap
    if (blocked := blocked_force(snapshot)) is not None:
        columns["blocked_force_N"] = float(np.linalg.norm(blocked))
    if len(contacts):
        columns["contact_overlap_percent"] = 100 * worst
    return columns


CONTACT = Measure(
    "contact",
    "forces of the obstacles on the whole actuator, and how far bodies overlap",
    {f"contact_force_<obstacle>_{c}_N": f"force of an obstacle along {c}" for c in "xyz"}
    | {
        f"obstacle_<obstacle>_{c}_mm": f"how far the middle of an obstacle has moved along {c}"
        for c in "xyz"
    }
    | {
        f"obstacle_<obstacle>_turn_{c}_deg": "rotation vector of a free body, or of an obstacle "
        f"that a step turns, of at most half a turn: along {c}"
        for c in "xyz"
    }
    | {
        "hold_force_<obstacle>_N": "size of the force that holds a free body in place",
        "rest_force_<obstacle>_N": "size of the force of all other obstacles on a free body",
        "friction_used_<obstacle>_percent": "friction on a free body, summed up without its "
        "directions, by the most that there could be: at 100 it slips",
        "contact_gap_<contact>_mm": "smallest gap to an obstacle or of a contact, below zero: the "
        "largest overlap; empty where the obstacle is not there or no gap is near",
        "contact_area_<contact>_mm2": "undeformed area in touch of the whole actuator; of two "
        "surfaces in contact, the mean of theirs",
        "contact_pressure_<contact>_kPa": "largest pressure, per undeformed area; in a field with "
        "fields: [contact_pressure]",
        "blocked_force_N": "size of the force on the obstacles with load_cell: true",
        "contact_overlap_percent": "largest overlap of all contacts, of the local element size",
    },
    _evaluate,
)
