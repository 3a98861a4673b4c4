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


def lost_modules(spec: Spec, pressures: Array, turns: Array) -> Array:
    """How many modules the ends of a short actuator bend less than all of its modules would.

    spec: of ``short_spec``. pressures (n,) MPa, turns (n,) rad: of a free module. Returns rows of
    pressure, MPa, and modules. Raises NoEquilibriumError.
    """
    with TemporaryDirectory(prefix="softact-") as scratch:
        run(spec, Path(scratch) / "run", report=False)
        curve = read(Path(scratch) / "run").curve
    name = next(name for name in curve if name.startswith("pressure_"))
    driven = np.asarray(curve[name], dtype=float) / 1e3
    angle = np.radians(np.asarray(curve["bending_angle_deg"], dtype=float))
    seen = np.flatnonzero(driven > 1e-9)
    if not len(seen):
        raise NoEquilibriumError("the short actuator that shows what the ends take has no state")
    turn = np.interp(driven[seen], pressures, turns)
    return np.column_stack([driven[seen], spec.geometry.pitches - angle[seen] / turn])
