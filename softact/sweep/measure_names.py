"""Whether the runs of a study have a measure that it asks for, told before any is computed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from softact.measured.columns import column_fault, known_columns
from softact.measures import MEASURES
from softact.mesh.layout import COMPONENTS, free_components
from softact.nearest import nearest
from softact.results import chain
from softact.spec import Spec
from softact.sweep.module_point import SLOW
from softact.sweep.spec import KINDS


def measure_fault(measure: str, spec: Spec, blocked: Sequence[str] | None) -> str:
    """Why no run of a study has a measure of this name; "" where it may.

    spec, blocked: of a point and of the study, see ``StudyFile``.
    """
    if blocked is None:
        return column_fault(measure, spec)
    for slow in SLOW:
        if measure.startswith(f"{slow}_") or measure in MEASURES[slow].columns:
            why = f"a study leaves it out unless 'measures' in the base names {slow}"
            return "" if slow in spec.measures else why
    for word, kind in KINDS.items():
        if measure in _exerted(spec, [kind]) and kind not in blocked:
            return f"takes a run of a blocked module: write 'blocked: [{word}]' beside 'model'"
    own = known_columns(spec)
    known = [*chain.whole(dict.fromkeys(own, np.zeros(0)), 1.0), *_exerted(spec, blocked)]
    known = [name for name in known if name not in _held(spec)]
    if measure in known or measure in MEASURES:
        return "" if measure in known else column_fault(measure, spec)
    if measure in own and measure not in _held(spec):
        return (
            "is of the ends of an actuator or of a place on it, and a module has none; "
            "'model: full' computes whole actuators"
        )
    return f"the run has no such column; {nearest(measure, known)}"


def _exerted(spec: Spec, blocked: Sequence[str]) -> list[str]:
    """Columns of what the blocked runs exert."""
    units = {"straight": "moment_{}_Nmm", "clamped": "force_{}_N"}
    return [f"blocked_{units[kind].format(c)}" for kind in blocked for c in "xyz"]


def _held(spec: Spec) -> set[str]:
    """Columns of turns and shifts that symmetry leaves no room for."""
    layout = spec.layout()
    free = free_components(layout.symmetry).ravel()
    held = [name.split("_") for name, is_free in zip(COMPONENTS, free, strict=True) if not is_free]
    of = {"turn": ("module_angle_{}_deg", "module_curvature_{}_per_m", "module_moment_{}_Nmm",
                   "actuator_angle_{}_deg", "blocked_moment_{}_Nmm"),
          "shift": ("module_stretch_{}", "module_force_{}_N", "blocked_force_{}_N")}  # fmt: skip
    return {title.format(c) for kind, c in held for title in of[kind]}
