"""What the two ends of a chain of modules take from its bending: a short whole actuator says it."""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator

from softact.errors import NoEquilibriumError
from softact.geometry.base import make_mesh
from softact.geometry.chains import Chain
from softact.measures.snapshot import Snapshot
from softact.model import Model
from softact.modules.driven import Driven
from softact.modules.presser import Presser
from softact.modules.screws import logarithm
from softact.run.from_spec import build_model, supports_of
from softact.spec import Spec
from softact.spec.one_module import first_segment
from softact.system.term import State

Array = NDArray[np.float64]
LEAST = 0.05  # of the largest curvature: below it a module hardly bends
TURNED = 1e-4  # rad of the tip by the force that shows how stiff the ends are


def short_spec(spec: Spec) -> Spec | None:
    """One segment of a few modules of the same actuator, from a spec of its pressures alone; None
    where its geometry does not say how many those are, or the actuator has no more."""
    changes = spec.geometry.short() if isinstance(spec.geometry, Chain) else {}
    if not changes:
        return None
    short = first_segment(spec).with_(
        {f"geometry.{name}": value for name, value in changes.items()}
        | {"contact": "none", "supports": None}
    )
    return short if short.geometry.pitches < spec.geometry.pitches else None


@dataclass(frozen=True)
class Ends:
    """What the two ends of an actuator take from so many equal modules.

    stiff: modules that do not bend under a force. At pressures (c, m) of m groups of cavities, MPa:
    idle (c,) modules that do not bend under them, and air (c, m) mm³ less. Nothing where that is
    not known.
    """

    stiff: float = 0.0
    pressures: Array = field(default_factory=lambda: np.zeros((0, 0)))
    idle: Array = field(default_factory=lambda: np.zeros(0))
    air: Array = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def known(self) -> bool:
        """Whether a short actuator said it."""
        return self.pressures.size > 0

    def at(self, pressures: Array) -> tuple[float, Array]:
        """Modules that do not bend under pressures (m,), MPa, and how much less air there is (m,),
        mm³: between the known pressures, and never beyond what was found there."""
        if not self.known:
            return 0.0, np.zeros(len(pressures))
        idle, *air = self._between(pressures[None])[0]
        return float(np.clip(idle, self.idle.min(), self.idle.max())), np.array(air)

    @functools.cached_property
    def _between(self) -> Callable[[Array], Array]:
        span = np.ptp(self.pressures, axis=0)
        values = np.column_stack([self.idle, self.air])
        inner = RBFInterpolator(self.pressures / span, values, kernel="linear", degree=0)
        return lambda pressures: inner(pressures / span)


@dataclass(frozen=True)
class FreeModule:
    """A module that nothing holds, and how it bends by a moment.

    pitch: mm. bending: stiffness, N mm², of the undeformed one, about a unit vector about (3,);
    axis (3,). At pressures (c, m) MPa of groups of cavities, the first at rest: curvatures (c, 3)
    1/mm, air by length (c, m), mm².
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
    presser = Presser(model, loads.groups, supports_of(spec.supports or ()), exact=False)
    length, pitches = spec.geometry.layout().length, spec.geometry.pitches
    push = TURNED * 2 * module.bending / length**2
    nothing = np.zeros(len(loads.groups))
    try:
        rest = presser.settle(np.zeros(model.unknowns.local), None, nothing)
        pushed = presser.moved_by(model.mesh.layout.tip, push * np.cross(module.about, module.axis))
        turned = float(_turned(model, presser.state(pushed, nothing)) @ module.about)
        found = [rest]
        for pressures in module.pressures[1:]:
            known = module.pressures[: len(found)]
            nearest = int(np.linalg.norm(known - pressures, axis=1).argmin())
            found.append(presser.inflated(*found[nearest], pressures))
        turns = np.array([_turned(model, state) for state, _ in found])
        volumes = np.array([presser.air(state) for state, _ in found])
    except ArithmeticError as error:
        raise NoEquilibriumError(
            f"the short actuator that shows what the ends take has no state: {error}"
        ) from None
    free = module.curvatures
    size = (free**2).sum(axis=1)
    bent = np.sqrt(size) > LEAST * np.sqrt(size.max())  # elsewhere nothing shows what is idle
    ratio = (turns * free).sum(axis=1) / np.where(bent, size, 1.0) / module.pitch
    bends = 2 * turned * module.bending / (push * length)
    stiff = float(pitches - bends / module.pitch)
    # What bends under no pressure shows nothing but how stiff the ends are.
    idle = np.where(bent, pitches - ratio, stiff)
    shown = np.flatnonzero(bent)
    for number in np.flatnonzero(~bent) if len(shown) else ():
        gaps = np.linalg.norm(module.pressures[shown] - module.pressures[number], axis=1)
        idle[number] = idle[shown[gaps.argmin()]]
    air = pitches * module.pitch * module.air - volumes
    return Ends(stiff, module.pressures, idle, air)


def _turned(model: Model, state: State) -> Array:
    """Rotation vector of the tip's face (3,), rad, less than half a turn."""
    rotation = Snapshot(model, state).tip_rotation
    return np.asarray(logarithm(rotation, np.zeros(3))[:3])
