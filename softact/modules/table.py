"""A module walked over its strains and pressures: what a rod asks of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from softact.errors import SpecError
from softact.geometry.base import make_mesh
from softact.mesh.layout import Layout
from softact.modules.dead import Dead
from softact.modules.driven import Driven
from softact.modules.ends import Ends, FreeModule, ends_of
from softact.modules.energy import Energy, errors, fit, weighted
from softact.modules.lumps import Lumps
from softact.modules.walk import Grid, Walk, Walked
from softact.modules.walker import Held, Walker
from softact.run.from_spec import build_model
from softact.spec import Spec

Array = NDArray[np.float64]
GOOD = 2e-2  # of the largest: with larger errors there are more states
REFINED = 2  # times, at most
HELD_OUT = 5  # each such state is not in the fit whose error is told
DEGREES = (3, 4, 5, 6, 7, 8)
USUAL = 0.5  # of the largest: secondary strains of states that nobody sheared or twisted
ROOM = 0.05  # of the range: how far outside of what was walked a state may be
FREE_STEPS = 4  # of Newton's method: 1e-8 from the nearest state
FLAT = 1e-9  # of the largest range: the same in all states
COMPONENTS = (*(f"curvature_{c}" for c in "xyz"), *(f"force_{c}" for c in "xyz"))


@dataclass(frozen=True)
class Table:
    """The energy of a module and what a rod of such modules needs besides.

    energy: W − F · (ν − ν₀) by length, over curvatures, forces F and pressures; its derivatives are
    the moments, −(ν − ν₀), and minus the air by length. A layer that does not stretch makes W steep
    in the stretches ν, and this one flat in the forces. free: (k,) which of ``COMPONENTS`` symmetry
    leaves; the energy's variables are these and the pressures of groups. axis: along which
    coordinate the module lies. errors: of its first derivatives at states that were held out, a
    part of each largest. pitch: mm. origin (3,): the middle of the left face. room (c,): moments of
    dead loads about the clamp, N mm, that were thought of at each of ``walked.centres``. groups: of
    cavities that go together, their shares. lumps: of the whole actuator.
    """

    energy: Energy
    free: NDArray[np.int64]
    axis: int
    errors: Array
    degree: int
    pitch: float
    origin: Array
    walked: Walked
    room: Array
    groups: tuple[Mapping[str, float], ...]
    lumps: Lumps
    ends: Ends = field(default_factory=Ends)

    @property
    def k(self) -> int:
        """How many strains are free."""
        return len(self.free)

    @property
    def pressure_names(self) -> tuple[str, ...]:
        """Of the groups of cavities, as columns without a unit."""
        return self.energy.names[self.k :]

    @property
    def low(self) -> Array:
        """Of the pressures (m,), MPa."""
        return self.energy.low[self.k :]

    @property
    def high(self) -> Array:
        """Of the pressures (m,), MPa."""
        return self.energy.high[self.k :]

    @property
    def turns(self) -> NDArray[np.bool_]:
        """Which of the free strains are curvatures (k,)."""
        return np.asarray(self.free < 3)

    def free_curvature(self, pressures: Array) -> Array:
        """Curvatures (k,), zero at stretches, of the module that nothing holds, by the energy:
        Newton's method from the nearest state that was walked."""
        centres, k = self.walked.centres, self.k
        span = np.maximum(self.high - self.low, np.finfo(float).tiny)
        nearest = np.linalg.norm((centres[:, k:] - pressures) / span, axis=1).argmin()
        place = np.concatenate([np.where(self.turns, centres[nearest, :k], 0.0), pressures])
        bent = np.flatnonzero(self.turns)
        for _ in range(FREE_STEPS):
            first, second = self.energy.both(place[None])
            place[bent] -= np.linalg.solve(second[0][np.ix_(bent, bent)], first[0, bent])
        return np.asarray(place[:k])

    def check(self, states: Array, pressures: Array) -> None:
        """Raise ValueError where curvatures and forces (n, k) of modules leave what was walked at
        their pressures (n, m), MPa."""
        energy, k = self.energy, self.k
        places = np.hstack([states, pressures])
        for i, name in enumerate(energy.names):
            span = ROOM * (energy.high[i] - energy.low[i])
            least, most = places[:, i].min(), places[:, i].max()
            if least < energy.low[i] - span or most > energy.high[i] + span:
                raise ValueError(
                    f"{_said(name, least)} to {_said(name, most)} is outside of the table: "
                    f"{_said(name, energy.low[i])} to {_said(name, energy.high[i])}"
                )
        bends = [i for i in range(k) if energy.names[i].startswith("curvature")]
        chosen = [*bends, *range(k, len(energy.names))]
        over = _outside(self.walked.samples.places[:, chosen], places[:, chosen])
        if over.max(initial=0.0) > ROOM:
            worst = places[over.argmax()]
            said = ", ".join(f"{_said(energy.names[i], worst[i])}" for i in chosen)
            raise ValueError(f"a module at {said} is outside of the states of the table")


def _said(name: str, value: float) -> str:
    """A variable's name, value and unit as a user writes them."""
    if name.startswith("curvature"):
        return f"{name.replace('_', ' about ')} of {1e3 * value:.4g} per m"
    if name.startswith("force"):
        return f"{name.replace('_', ' along ')} of {value:.4g} N"
    return f"{name.replace('_', ' ')} of {1e3 * value:.4g} kPa"


def _outside(known: Array, places: Array) -> Array:
    """How far places (n, d) are outside of the convex hull of known ones, by their range."""
    low, span = known.min(axis=0), np.ptp(known, axis=0)
    kept = span > FLAT * span.max()
    scaled, asked = ((p - low)[:, kept] / span[kept] for p in (known, places))
    if scaled.shape[1] == 1:
        return np.asarray(np.maximum(-asked, asked - 1).max(axis=1))
    try:
        sides = ConvexHull(scaled).equations
    except QhullError:
        return np.zeros(len(places))
    return np.asarray((asked @ sides[:, :-1].T + sides[:, -1]).max(axis=1))


def best_fit(
    walked: Walked, names: tuple[str, ...], secondary: list[bool]
) -> tuple[Energy, Array, int]:
    """The energy whose degree has the least error at states held out of its fit, then fitted to all
    of them; that error, and the degree. Raises SpecError where there are too few states."""
    samples = walked.samples
    number = np.arange(len(samples.places))
    within = samples.places.min(axis=0), samples.places.max(axis=0)
    primary = ~np.array(secondary)
    # The few that are sheared or twisted on purpose are all needed.
    moved = np.abs(samples.places - samples.places[0])[:, ~primary]
    usual = (moved <= USUAL * moved.max(axis=0)).all(axis=1)
    out = (number % HELD_OUT == HELD_OUT // 2) & usual
    tried, largest = [], np.abs(samples.first).max(axis=0)
    for degree in DEGREES:
        try:
            part = fit(samples.part(~out), names, degree, secondary, within)
        except ValueError:
            break
        held = samples.part(out)
        off = errors(part, held, largest)
        tried.append((weighted(part, held, largest)[primary].max(), degree, off))
    if not tried:
        raise SpecError(f"the module found only {len(number)} states, too few for a table")
    _, degree, off = min(tried, key=lambda one: one[0])
    return fit(samples, names, degree, secondary, within), off, degree


def table(
    spec: Spec,
    loads: Driven,
    grid: Grid,
    dead: Dead,
    lumps: Lumps,
    tell: Callable[[str], None],
    short: Spec | None = None,
) -> Table:
    """Mesh a module's spec, walk it and fit. short: a whole actuator of few modules, for what
    its ends take. Raises what its parts raise, and SpecError, see ``refuse_kinks``."""
    with TemporaryDirectory(prefix="softact-") as scratch:
        mesh = Path(scratch) / "module.msh"
        make_mesh(spec.geometry, mesh, curved=spec.solver.curved)
        model = build_model(MPI.COMM_SELF, spec, mesh)
    walker, layout = Walker(model, loads.groups), spec.layout()
    walk = Walk(walker, loads, dead, grid, axis_of(layout), tell)
    pressures = ["pressure"] if len(loads.groups) == 1 else [f"pressure_{n}" for n in loads.names]
    names = (*(COMPONENTS[i] for i in walker.free), *pressures)
    energy, off, degree = best_fit(walk.walked, names, walk.secondary)
    for _ in range(REFINED):
        worst = off[~np.array(walk.secondary)].max()
        if worst <= GOOD:
            break
        tell(f"table: off by {100 * worst:.2g} % at states held out; more states")
        walk.refine()
        energy, off, degree = best_fit(walk.walked, names, walk.secondary)
        if len(model.contacts):
            refuse_kinks(off[~np.array(walk.secondary)].max())
    walked = walk.walked
    ends, bends = Ends(), [i for i in range(3) if i in walker.free and not layout.axis[i]]
    if short is not None and bends:
        tell("table: a short actuator, for its ends")
        ends = ends_of(short, loads, let_go(walker, layout, walked, walk.rest))
    return Table(
        energy,
        walker.free,
        axis_of(layout),
        off,
        degree,
        walker.repeat.length,
        walker.repeat.centre,
        walked,
        dead.room(walked.centres[:, len(walker.free) :]),
        loads.groups,
        lumps,
        ends,
    )


def refuse_kinks(worst: float) -> None:
    """Raise SpecError where the law of a module that touches others is off by more than ``GOOD``:
    where its walls meet its stiffness jumps, and a polynomial that misses that is wrong by far more
    than its errors wherever a small moment acts."""
    if worst > GOOD:
        raise SpecError(
            f"contact: the law of the module is off by {100 * worst:.2g} %, where its walls begin "
            "to press on each other; solve the whole actuator, or write contact: none"
        )


def axis_of(layout: Layout) -> int:
    """Along which coordinate an actuator lies. Raises SpecError."""
    axis = np.abs(layout.axis)
    if axis.max() < 1 - FLAT:
        raise SpecError("a table of a module is of an actuator along x, y or z")
    return int(axis.argmax())


def let_go(walker: Walker, layout: Layout, walked: Walked, rest: Held) -> FreeModule:
    """What the ends of an actuator are compared with."""
    axis = np.asarray(layout.axis, dtype=float)
    at = next(i for i, c in enumerate(walker.free) if c < 3 and not axis[c])
    places, k = walked.samples.places, len(walker.free)
    loose = np.where(np.append(walker.turns, np.ones(places.shape[1] - k, bool)), walked.centres, 0)
    known = [int(np.abs(places - centre).sum(axis=1).argmin()) for centre in loose]
    bends = [i for i, c in enumerate(walker.free) if c < 3]
    turns = np.zeros((len(known), 3))
    turns[:, walker.free[bends]] = walked.centres[:, bends]
    return FreeModule(
        walker.repeat.length,
        float(1 / rest.compliance[at, at]),
        np.eye(3)[walker.free[at]],
        axis,
        walked.centres[:, k:],
        turns,
        -walked.samples.first[known, k:],
    )
