"""What presses on the actuator from outside, and how well contact keeps the gap closed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure, vector_columns

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def blocked_force(snapshot: Snapshot) -> np.ndarray | None:
    """Force (3,) N of the whole actuator on all load cells; None where there is none."""
    contacts, state = snapshot.model.contacts, snapshot.state
    cells = [c for c in contacts if c.obstacle is not None and c.obstacle.load_cell]
    if not cells:
        return None
    return np.sum([snapshot.of_whole(contacts.force(cell, state)) for cell in cells], axis=0)


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
            moved = np.asarray(state["shift"].get(contact.name, np.zeros(3)))
            columns |= vector_columns(f"obstacle_{contact.name}_<xyz>_mm", moved)
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
    | {f"obstacle_<obstacle>_{c}_mm": f"how far an obstacle has moved along {c}" for c in "xyz"}
    | {
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
