"""What a tip that is held exerts on whatever holds it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure, vector_columns
from softact.measures.bending import bending_axis

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    tip = snapshot.layout.tip
    if not tip or not snapshot.held(tip):
        return {}
    force, moment = snapshot.reaction_at(tip, snapshot.tip.centre_after)
    columns = vector_columns("tip_force_<xyz>_N", -force)
    columns |= vector_columns("tip_moment_<xyz>_Nmm", -moment)
    columns["blocked_torque_Nmm"] = float(-moment @ bending_axis(snapshot))
    columns["blocked_axial_torque_Nmm"] = float(-moment @ np.asarray(snapshot.layout.axis))
    return columns


HELD_TIP = Measure(
    "held_tip",
    "force and moment that the actuator exerts on a support of its tip; empty while it is free",
    {f"tip_force_{c}_N": f"force on what holds the tip along {c}" for c in "xyz"}
    | {
        f"tip_moment_{c}_Nmm": f"moment on what holds the tip about {c}, at the tip's centre"
        for c in "xyz"
    }
    | {
        "blocked_torque_Nmm": "the part of the moment about the bending axis: positive where the "
        "tip would bend on if it were let go",
        "blocked_axial_torque_Nmm": "the part of the moment about the undeformed axis: positive "
        "where the tip would twist on if it were let go",
    },
    _evaluate,
)
