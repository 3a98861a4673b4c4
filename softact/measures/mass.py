"""What the actuator weighs, and what it does for that: force and work over mass."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure
from softact.measures.contact import blocked_force
from softact.measures.energy import lifted

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot

GRAMS, KILOGRAMS = 1e6, 1e3  # in a tonne


def _mass(snapshot: Snapshot) -> float | None:
    """Of the whole actuator without what it carries, tonne; None where a body has no density.
    Collective."""
    model = snapshot.model
    made_of = [body for body in model.bodies if body.elastic]
    if len(model.weights) - len(model.masses) < len(made_of):
        return None
    mass = model.sum(sum(weight.mass for weight in model.weights))
    carried = sum(carried.mass for carried in model.masses)
    return snapshot.layout.copies * (mass - carried)


def _force(snapshot: Snapshot) -> float | None:
    """Size of the force on a load cell, else on what holds the tip, N; None where neither is."""
    measured = blocked_force(snapshot)
    tip = snapshot.layout.tip
    if measured is None and tip and snapshot.held(tip):
        measured, _ = snapshot.reaction_at(tip, snapshot.tip.centre_after)
    return None if measured is None else float(np.linalg.norm(measured))


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    mass = _mass(snapshot)
    if not mass:
        return {}
    columns = {"mass_g": GRAMS * mass}
    force, work = _force(snapshot), lifted(snapshot)
    if force is not None:
        columns["specific_force_N_per_kg"] = force / (KILOGRAMS * mass)
    if work is not None:
        columns["specific_work_J_per_kg"] = work / (GRAMS * mass)
    return columns


MASS = Measure(
    "mass",
    "mass of the whole actuator without its air, and force and work over it",
    {
        "mass_g": "of solids, layers and sheets",
        "specific_force_N_per_kg": "size of the force on the obstacles with load_cell: true, else "
        "on what holds the tip, over the mass; empty where neither is",
        "specific_work_J_per_kg": "payload_energy over the mass",
    },
    _evaluate,
)
