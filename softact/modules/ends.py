"""What the two ends of a chain of modules take from its bending: a short whole actuator says it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from softact.errors import NoEquilibriumError
from softact.geometry.base import make_mesh
from softact.geometry.chains import Chain
from softact.measures.bending import BENDING
from softact.measures.snapshot import Snapshot
from softact.model import Model
from softact.modules.driven import Driven
from softact.modules.walker import Presser
from softact.run.from_spec import build_model, supports_of
from softact.spec import Spec
from softact.system.term import State

Array = NDArray[np.float64]
TURNED = 1e-4  # rad of the tip by the force that shows how stiff the ends are
PARTS = 4  # pressures of the short actuator


def short_spec(spec: Spec) -> Spec | None:
    """The same actuator of a few modules, from a spec of its pressures alone; None where its
    geometry does not say which is short, or the actuator is no longer than that."""
    changes = spec.geometry.short() if isinstance(spec.geometry, Chain) else {}
    if not changes:
        return None
    short = spec.with_(
        {f"geometry.{name}": value for name, value in changes.items()}
        | {"contact": "none", "supports": None}
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


def ends_of(spec: Spec, loads: Driven, module: FreeModule, across: Array) -> Ends:
    """From a short actuator, which is pushed at its tip, and inflated.

    spec: of ``short_spec``; loads: of its one group of cavities. across: the way (3,) in which a
    positive curvature turns the axis. A small force F turns the tip of a rod of stiffness B, of
    length L with a in its middle that bends, by F a L / (2 B). Raises NoEquilibriumError.
    """
    with TemporaryDirectory(prefix="softact-") as scratch:
        mesh = Path(scratch) / "short.msh"
        make_mesh(spec.geometry, mesh, curved=spec.solver.curved)
        model = build_model(MPI.COMM_SELF, spec, mesh)
    presser = Presser(model, loads.groups, supports_of(spec.supports or ()))
    length, pitches = spec.geometry.layout().length, spec.geometry.pitches
    push = TURNED * 2 * module.bending / length**2
    try:
        state, columns = presser.settle(np.zeros(model.unknowns.local), None, None, np.zeros(1))
        pushed = presser.moved_by(model.mesh.layout.tip, push * across)
        turned = _angle(model, presser.state(pushed, np.zeros(1)), 0.0)
        full = float(loads.high[0] or loads.low[0])
        pressures, angles, volumes = [0.0], [0.0], [float(presser.air(state)[0])]
        for pressure in full * np.arange(1, PARTS + 1) / PARTS:
            state, columns = presser.inflated(state, columns, np.array([pressure]))
            pressures.append(pressure)
            angles.append(_angle(model, state, angles[-1]))
            volumes.append(float(presser.air(state)[0]))
    except ArithmeticError as error:
        raise NoEquilibriumError(
            f"the short actuator that shows what the ends take has no state: {error}"
        ) from None
    bends = 2 * turned * module.bending / (push * length)
    at = np.array(pressures)
    free = np.interp(at, module.pressures, module.curvatures) * module.pitch
    idle = pitches - np.array(angles[1:]) / free[1:]
    air = pitches * module.pitch * np.interp(at, module.pressures, module.air)
    return Ends(
        float(pitches - bends / module.pitch),
        at,
        np.append(idle[0], idle),  # at rest as soon after
        air - np.array(volumes),
    )


def _angle(model: Model, state: State, before: float) -> float:
    """Of the tip's face, rad."""
    previous = {"bending_angle_deg": float(np.degrees(before))}
    found = BENDING.evaluate(Snapshot(model, state, previous))["bending_angle_deg"]
    return float(np.radians(found))
