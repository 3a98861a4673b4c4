"""How far the actuator bends, past a full turn without wrapping."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure, continued

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot
    from softact.mesh.layout import Layout

# Below this the plane of bending is not known well enough to give the angle a sign.
SMALL = 1.0


def bending_axis(snapshot: Snapshot) -> np.ndarray:
    """Unit vector about which the tip has turned: the layout's, or the one that is seen."""
    axis = np.asarray(snapshot.layout.axis)
    return axis_of_bending(snapshot.layout, snapshot.tip_rotation @ axis, snapshot.previous)


def axis_of_bending(
    layout: Layout, direction: np.ndarray, previous: Mapping[str, float]
) -> np.ndarray:
    """The same where the tip's axis goes in a direction (3,). previous: the last columns."""
    if layout.bending_axis is not None:
        return np.asarray(layout.bending_axis)
    axis = np.asarray(layout.axis)
    normal = np.cross(axis, direction)
    length = np.linalg.norm(normal)
    if length > 1e-12:
        normal = normal / length
        before = np.array([previous.get(f"bending_axis_{c}", 0.0) for c in "xyz"])
        # Past half a turn the cross product flips; the axis of the last state says so.
        turned = previous.get("bending_angle_deg", 0.0) > SMALL
        return -normal if turned and before @ normal < 0 else normal
    return np.cross(axis, np.roll(axis, 1))


def _angle(snapshot: Snapshot, direction: np.ndarray, column: str) -> float:
    axis = np.asarray(snapshot.layout.axis)
    across = np.cross(bending_axis(snapshot), axis)
    angle = np.rad2deg(np.arctan2(direction @ across, direction @ axis))
    return float(continued(angle, snapshot.previous.get(column)))


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    if not snapshot.layout.tip:
        return {}
    axis = np.asarray(snapshot.layout.axis)
    clamp = snapshot.motion(snapshot.layout.clamp)
    chord = snapshot.tip.centre_after - clamp.centre_after
    columns = {
        "bending_angle_deg": _angle(snapshot, snapshot.tip_rotation @ axis, "bending_angle_deg"),
        "chord_angle_deg": _angle(snapshot, chord, "chord_angle_deg"),
    }
    if snapshot.layout.bending_axis is None:
        names = ("bending_axis_x", "bending_axis_y", "bending_axis_z")
        columns |= dict(zip(names, map(float, bending_axis(snapshot)), strict=True))
    return columns


BENDING = Measure(
    "bending",
    "rotation of the tip's end face, and direction of the chord",
    {
        "bending_angle_deg": "rotation of the tip's end face in the plane of bending, unwrapped",
        "chord_angle_deg": "angle of the line from clamp to tip, unwrapped",
    },
    _evaluate,
)
