"""What the two ends of a chain of modules take from its bending: a short whole actuator says it."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray

from softact.errors import NoEquilibriumError
from softact.geometry.chains import Chain
from softact.results.folder import read
from softact.run.start import run
from softact.spec import Spec

Array = NDArray[np.float64]
TINY = 1e-9  # MPa
PARTS = 4  # increments of the short actuator at least


def short_spec(spec: Spec) -> Spec | None:
    """The same actuator of a few modules, from a spec of its pressures alone; None where its
    geometry does not say which is short, or the actuator is no longer than that."""
    changes = spec.geometry.short() if isinstance(spec.geometry, Chain) else {}
    if not changes:
        return None
    short = spec.with_(
        {f"geometry.{name}": value for name, value in changes.items()}
        | {"contact": "none", "supports": None}
        | {"solver.initial_increment": 1 / PARTS, "solver.max_increment": 1 / PARTS}
    )
    return short if short.geometry.pitches < spec.geometry.pitches else None


def lost(spec: Spec, pitch: float, pressures: Array, curvatures: Array, air: Array) -> Array:
    """What the ends of a short actuator take from the bending and the air of all of its modules.

    spec: of ``short_spec``. pitch: mm. Of a free module at pressures (n,) MPa: curvatures, 1/mm,
    and air by length, mm². Returns rows of pressure MPa, modules, mm³. Raises NoEquilibriumError.
    """
    with TemporaryDirectory(prefix="softact-") as scratch:
        run(spec, Path(scratch) / "run", report=False)
        curve = read(Path(scratch) / "run").curve
    driven, angle, volume = (
        np.asarray(curve[next(name for name in curve if name.startswith(start))], dtype=float)
        for start in ("pressure_", "bending_angle_deg", "cavity_volume_")
    )
    driven, length = driven / 1e3, spec.geometry.pitches * pitch
    seen = np.flatnonzero(driven > TINY)
    if not len(seen):
        raise NoEquilibriumError("the short actuator that shows what the ends take has no state")
    bent = np.interp(driven, pressures, curvatures)
    modules = np.radians(angle[seen]) / (bent[seen] * pitch)
    modules = np.append(modules[0], modules)  # at rest as soon after
    at = np.append(0, seen)
    whole = length * np.interp(driven, pressures, air)
    return np.column_stack([driven[at], spec.geometry.pitches - modules, (whole - volume)[at]])
