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
from softact.measures.snapshot import Snapshot
from softact.model import Model
from softact.modules.driven import Driven
from softact.modules.screws import logarithm
from softact.modules.walker import Presser
from softact.run.from_spec import build_model, supports_of
from softact.spec import Spec
from softact.system.term import State

Array = NDArray[np.float64]
TURNED = 1e-4  # rad of the tip by the force that shows how stiff the ends are


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

    stiff: modules that do not bend under a force. For each of m groups of cavities that is driven
    alone: pressures (m, q), MPa, and there idle (m, q) modules that do not bend under it, and air
    (m, q) mm³ less. Nothing where that is not known.
    """

    stiff: float = 0.0
    pressures: Array = field(default_factory=lambda: np.zeros((0, 0)))
    idle: Array = field(default_factory=lambda: np.zeros((0, 0)))
    air: Array = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def known(self) -> bool:
        """Whether a short actuator said it."""
        return self.pressures.size > 0

    def idle_at(self, pressures: Array) -> float:
        """Modules that do not bend under pressures (m,), MPa: of several groups by their shares."""
        return (
            float(self._shares(pressures) @ self._at(self.idle, pressures)) if self.known else 0.0
        )

    def air_at(self, pressures: Array) -> Array:
        """How much less air the groups have (m,), mm³."""
        return self._at(self.air, pressures) if self.known else np.zeros(len(pressures))

    def _shares(self, pressures: Array) -> Array:
        size = np.abs(pressures)
        return size / size.sum() if size.sum() > 0 else np.full(len(size), 1 / len(size))

    def _at(self, table: Array, pressures: Array) -> Array:
        found = []
        for known, values, pressure in zip(self.pressures, table, pressures, strict=True):
            order = np.argsort(known)
            found.append(float(np.interp(pressure, known[order], values[order])))
        return np.array(found)


@dataclass(frozen=True)
class FreeModule:
    """A module that nothing holds, and how it bends by a moment.

    pitch: mm. bending: stiffness, N mm², of the undeformed one, about a unit vector about (3,);
    axis (3,). For each group that is driven alone (m, q): pressures MPa, curvatures (m, q, 3) 1/mm,
    air of that group by length (m, q), mm²; the first at rest.
    """

    pitch: float
    bending: float
    about: Array
    axis: Array
    pressures: Array
    curvatures: Array
    air: Array


def ends_of(spec: Spec, loads: Driven, module: FreeModule) -> Ends:
    """From a short actuator, which is pushed at its tip, and inflated.

    spec: of ``short_spec``. A small force F turns the tip of a rod of stiffness B, of length L with
    a in its middle that bends, by F a L / (2 B). Raises NoEquilibriumError.
    """
    with TemporaryDirectory(prefix="softact-") as scratch:
        mesh = Path(scratch) / "short.msh"
        make_mesh(spec.geometry, mesh, curved=spec.solver.curved)
        model = build_model(MPI.COMM_SELF, spec, mesh)
    presser = Presser(model, loads.groups, supports_of(spec.supports or ()))
    length, pitches = spec.geometry.layout().length, spec.geometry.pitches
    push = TURNED * 2 * module.bending / length**2
    nothing = np.zeros(len(loads.groups))
    try:
        rest = presser.settle(np.zeros(model.unknowns.local), None, None, nothing)
        pushed = presser.moved_by(model.mesh.layout.tip, push * np.cross(module.about, module.axis))
        turned = float(_turned(model, presser.state(pushed, nothing)) @ module.about)
        idle, air = np.zeros((2, *module.pressures.shape))
        full = pitches * module.pitch
        for group, pressures in enumerate(module.pressures):
            air[group, 0] = full * module.air[group, 0] - presser.air(rest[0])[group]
            here = rest
            for number, pressure in enumerate(pressures[1:], 1):
                here = presser.inflated(*here, pressure * (np.arange(len(nothing)) == group))
                free = module.curvatures[group, number]
                bent = _turned(model, here[0]) @ free / (free @ free)
                idle[group, number] = pitches - bent / module.pitch
                volume = presser.air(here[0])[group]
                air[group, number] = full * module.air[group, number] - volume
            idle[group, 0] = idle[group, 1]  # at rest as soon after
    except ArithmeticError as error:
        raise NoEquilibriumError(
            f"the short actuator that shows what the ends take has no state: {error}"
        ) from None
    bends = 2 * turned * module.bending / (push * length)
    return Ends(float(pitches - bends / module.pitch), module.pressures, idle, air)


def _turned(model: Model, state: State) -> Array:
    """Rotation vector of the tip's face (3,), rad, less than half a turn."""
    rotation = Snapshot(model, state).tip_rotation
    return np.asarray(logarithm(rotation, np.zeros(3))[:3])
