"""What the two ends of a chain of modules take from its bending: a short whole actuator says it."""

from __future__ import annotations

from dataclasses import dataclass, field
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
TURNED = 0.02  # rad of the tip by the force that shows how stiff the ends are
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


@dataclass(frozen=True)
class Ends:
    """What the two ends of an actuator take from so many equal modules.

    stiff: modules that do not bend under a force. pressures (k,): MPa, and there: idle (k,) modules
    that do not bend under the pressure, air (k,) mm^3 less. Nothing where that is not known.
    """

    stiff: float = 0.0
    pressures: Array = field(default_factory=lambda: np.zeros(1))
    idle: Array = field(default_factory=lambda: np.zeros(1))
    air: Array = field(default_factory=lambda: np.zeros(1))


@dataclass(frozen=True)
class FreeModule:
    """pitch: mm. bending: stiffness, N mm^2, of the undeformed one. At pressures (n,) MPa of one
    that nothing holds: curvatures, 1/mm, and air by length, mm^2."""

    pitch: float
    bending: float
    pressures: Array
    curvatures: Array
    air: Array


def ends_of(spec: Spec, module: FreeModule, across: Array) -> Ends:
    """From a run of a short actuator, which is pushed at its tip, let go, and inflated.

    spec: of ``short_spec``. across: the way (3,) in which a positive curvature turns the axis. A
    small force F turns the tip of a rod of stiffness B, of length L with a in its middle that
    bends, by F a L / (2 B). Raises NoEquilibriumError.
    """
    whole = spec.geometry.layout().length
    push = TURNED * 2 * module.bending / whole**2
    force = [f"{value!r} N" for value in (push * across).tolist()]
    inflated = spec.model_dump(mode="json", exclude_none=True)["steps"][0]
    gone = {"force": ["0 N"] * 3}
    steps = [{"name": "push", "payload": {"force": force}}, {"name": "release", "payload": gone}]
    with TemporaryDirectory(prefix="softact-") as scratch:
        run(spec.with_({"steps": [*steps, inflated]}), Path(scratch) / "run", report=False)
        curve = read(Path(scratch) / "run").curve
    driven, angle, volume = (
        np.asarray(curve[next(name for name in curve if name.startswith(start))], dtype=float)
        for start in ("pressure_", "bending_angle_deg", "cavity_volume_")
    )
    pushed = np.flatnonzero(curve["step"] == "push")
    seen = np.flatnonzero(driven > TINY)
    if not len(seen):
        raise NoEquilibriumError("the short actuator that shows what the ends take has no state")
    pitches, pressures = spec.geometry.pitches, driven[seen] / 1e3
    bends = 2 * np.radians(angle[pushed[-1]]) * module.bending / (push * whole)
    free = np.interp(pressures, module.pressures, module.curvatures) * module.pitch
    idle = pitches - np.radians(angle[seen]) / free
    air = pitches * module.pitch * np.interp(pressures, module.pressures, module.air) - volume[seen]
    rest = pitches * module.pitch * module.air[0] - volume[0]
    return Ends(
        float(pitches - bends / module.pitch),
        np.append(0.0, pressures),
        np.append(idle[0], idle),  # at rest as soon after
        np.append(rest, air),
    )
