"""What a chain of equal modules does as a whole, from the curves of one module, free and blocked.

The two ends of an actuator are not in it.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

ANGLE, OF_WHOLE = "module_angle_", "actuator_angle_"
#: Runs of a blocked module -> beginning of the columns that say what it exerts.
OF_LOADS = {"straight": "module_moment_", "clamped": "module_force_"}
#: Beginnings of columns that a chain has so many times as its module.
TIMES = ("bending_angle_", "twist_angle_", "cavity_volume", "air_", "strain_energy_",
         "pressure_work_", "softening_loss_", "mass_g", "contact_area_")  # fmt: skip
#: And of those that need the ends of an actuator, or a place on it.
OF_ENDS = ("tip_", "chord_angle_", "elongation_", "reaction_", "pull_", "blocked_force_N",
           "blocked_torque_", "blocked_axial_torque_", "probe_", "face_", "target_distance_",
           "payload_", "specific_")  # fmt: skip

Columns = Mapping[str, np.ndarray]


def angles(curve: Columns, modules: float) -> dict[str, np.ndarray]:
    """Columns (n,) of the angle of so many modules, degrees."""
    return {
        f"{OF_WHOLE}{name.removeprefix(ANGLE)}": modules * values
        for name, values in curve.items()
        if name.startswith(ANGLE)
    }


def exerted(free: Columns, blocked: Mapping[str, Columns]) -> dict[str, np.ndarray]:
    """Columns (n,) of what a module exerts that is blocked, at the states of the free one.

    blocked: the curves of the runs ``straight`` and ``clamped``, as far as they are wanted.
    """
    return {
        f"blocked_{name.removeprefix('module_')}": -_at_states(free, curve, name)
        for kind, curve in blocked.items()
        for name in curve
        if name.startswith(OF_LOADS[kind])
    }


def whole(curve: Columns, modules: float) -> dict[str, np.ndarray]:
    """The columns of a module as those of so many: what adds up is so many times that of one, what
    is the same everywhere stays, what the ends of an actuator have is left out. Columns that begin
    with ``module_`` are still of one."""
    kept = {name: values for name, values in curve.items() if not name.startswith(OF_ENDS)}
    scaled = {name: modules * kept[name] for name in kept if name.startswith(TIMES)}
    return kept | scaled | angles(curve, modules)


def _at_states(free: Columns, other: Columns, name: str) -> np.ndarray:
    """A column of another run at the free one's fractions of the same steps; NaN beyond its
    last equilibrium."""
    steps = list(dict.fromkeys(free["step"]))

    def time(curve: Columns) -> np.ndarray:
        begun = np.array([steps.index(step) for step in curve["step"]], dtype=float)
        return begun + np.asarray(curve["step_fraction"], dtype=float)

    known = np.isin(other["step"], steps)
    inside = {column: values[known] for column, values in other.items()}
    values = np.asarray(inside[name], dtype=float)
    return np.interp(time(free), time(inside), values, right=np.nan)
