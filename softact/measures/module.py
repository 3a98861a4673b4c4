"""One module of a chain as the cross-section of a rod."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure
from softact.measures.cross_section import CrossSection

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot

STRAINS = [f"{kind}_{c}" for kind in ("curvature", "stretch") for c in "xyz"]
LOADS = [f"{kind}_{c}_{unit}" for kind, unit in (("moment", "Nmm"), ("force", "N")) for c in "xyz"]
PER_METRE = 1e3


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    if snapshot.model.repeat is None:
        return {}
    section = CrossSection(snapshot.model, snapshot.state)
    free = np.flatnonzero(section.free)
    turn = np.degrees(section.strain[:3] * section.repeat.length)
    columns = {f"module_angle_{'xyz'[i]}_deg": turn[i] for i in free if i < 3}
    for i in free:
        per = ("_per_m", PER_METRE) if i < 3 else ("", 1.0)
        columns[f"module_{STRAINS[i]}{per[0]}"] = section.strain[i] * per[1]
    columns |= {f"module_{LOADS[i]}": section.load[i] for i in free}
    return {title: float(value) for title, value in columns.items()}


MODULE = Measure(
    "module",
    "of a module of a chain: how the right face stands to the left one, and what the cross-section "
    "of the rod that the chain is carries, in the frame of the left face",
    {f"module_angle_{c}_deg": f"turn of a module about {c}" for c in "xyz"}
    | {f"module_curvature_{c}_per_m": f"turn about {c} by undeformed length, rad" for c in "xyz"}
    | {f"module_stretch_{c}": f"what a unit of length becomes along {c}" for c in "xyz"}
    | {f"module_moment_{c}_Nmm": f"moment of the cross-section about {c}" for c in "xyz"}
    | {f"module_force_{c}_N": f"force of the cross-section along {c}" for c in "xyz"},
    _evaluate,
)
