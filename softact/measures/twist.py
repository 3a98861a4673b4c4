"""How far the tip turns about its own axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure, continued
from softact.measures.bending import BENDING, bending_axis
from softact.system.rotation import rotation_about

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    if not snapshot.layout.tip:
        return {}
    axis = np.asarray(snapshot.layout.axis)
    bent = BENDING.evaluate(snapshot)["bending_angle_deg"]
    twist = rotation_about(bending_axis(snapshot), bent).T @ snapshot.tip_rotation
    # The axis of a rotation matrix times the sine of its angle stands in its skew part.
    skew = np.array(
        [twist[2, 1] - twist[1, 2], twist[0, 2] - twist[2, 0], twist[1, 0] - twist[0, 1]]
    )
    angle = np.rad2deg(np.arctan2(skew @ axis / 2, (np.trace(twist) - 1) / 2))
    return {"twist_angle_deg": float(continued(angle, snapshot.previous.get("twist_angle_deg")))}


TWIST = Measure(
    "twist",
    "rotation of the tip's end face about the axis, after the bending is undone",
    {"twist_angle_deg": "rotation of the tip's end face about the axis, unwrapped"},
    _evaluate,
)
