"""The estimate of a beam: angle, elongation, what blocks it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softact.estimate.beam import Beam, Curve, blocked, follow
from softact.estimate.driven import left_out, title
from softact.estimate.table import Estimate
from softact.estimate.weight import loaded
from softact.spec import Spec

METHOD = (
    "A beam: walls of plane sections against the pressure on the cavities' areas and first moments "
    "(generalised from Polygerinos et al. 2013, equations 1 to 5)"
)
#: An actuator that turns by less is straight, and its elongation is of interest (degrees).
STRAIGHT = 1.0


def bending(
    spec: Spec,
    beam: Beam,
    driven: dict[str, float],
    points: int,
    reservations: Sequence[str],
) -> Estimate:
    """Table of a beam over the pressures of a spec."""
    curve = follow(beam, driven, np.linspace(0.0, 1.0, points))
    name, most = title(spec, driven)
    turned = loaded(spec, beam, curve)
    notes, reservations = list(_notes(spec)), list(reservations)
    if turned is None:
        turned = curve.angle
        reservations.append("weight and payload buckle this beam, so they are left out")
    if curve.reached < 1.0:
        reservations.append(
            f"beyond {1e3 * most * curve.reached:.4g} kPa the walls carry no more: a limit of the "
            "pressure, or near one"
        )
    reservations += _tested(spec, curve, 1e3 * most)
    if min(driven.values()) < 0:
        reservations.append("under vacuum walls buckle and touch each other, which is left out")
    columns = {name: 1e3 * most * curve.parts, "bending_angle_deg": _angle(spec, turned)}
    if np.degrees(np.abs(curve.angle)).max() < STRAIGHT:
        columns["elongation_mm"] = curve.elongation
    columns |= _blocked(beam, curve, driven)
    return Estimate(spec.name, METHOD, columns, notes, reservations)


def _tested(spec: Spec, curve: Curve, full: float) -> list[str]:
    """Where the walls stretch beyond the tests of their constants. full: kPa at the end."""
    ranges = [law.card.stretch_range for law in spec.materials.values()]
    most = min((known[1] for known in ranges if known), default=np.inf)
    beyond = np.flatnonzero(curve.stretch > most)
    if not len(beyond):
        return []
    return [
        f"from about {full * curve.parts[beyond[0]]:.4g} kPa on walls stretch by more than the "
        f"{most:g} to which the constants were tested"
    ]


def _angle(spec: Spec, turned: np.ndarray) -> np.ndarray:
    """(n,) degrees, signed where the layout has a plane of bending."""
    if spec.geometry.layout().bending_axis is not None:
        return np.degrees(turned[:, 0])
    return np.degrees(np.hypot(turned[:, 0], turned[:, 1]))


def _blocked(beam: Beam, curve: Curve, driven: dict[str, float]) -> dict[str, np.ndarray]:
    """What holds the actuator in its undeformed shape."""
    from softact.export.rod import blocking_lever

    pull, moments = blocked(beam, driven)
    if np.degrees(np.abs(curve.angle)).max() < STRAIGHT:
        return {"blocked_force_N": pull * curve.parts}
    moment = float(np.hypot(*moments)) * curve.parts
    lever = blocking_lever(beam.length - beam.clamp - beam.tip, beam.tip)
    return {"blocked_torque_Nmm": moment, "blocked_force_N": moment * lever}


def _notes(spec: Spec) -> list[str]:
    notes = ["that chambers touch each other, and that their sections grow, is left out"]
    notes += left_out(spec, ("pressure", "gravity", "payload"))
    notes.append("blocked: at the undeformed shape; the force at the tip's centre, which may turn")
    return notes
