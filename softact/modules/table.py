"""A module walked over its strains and pressures: what a rod asks of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from softact.errors import NoEquilibriumError, SpecError
from softact.geometry.base import make_mesh
from softact.mesh.layout import Layout
from softact.modules.dead import Dead
from softact.modules.driven import Driven
from softact.modules.ends import Ends, FreeModule, ends_of
from softact.modules.energy import Energy, Samples, errors, fit, weighted
from softact.modules.lumps import Lumps
from softact.modules.walker import Held, Walker
from softact.run.from_spec import build_model
from softact.spec import Spec

Array = NDArray[np.float64]
SAGS = 1.2  # times how far the dead loads bend a linear rod
BEYOND = 0.5  # of the largest free curvature: how far the table goes past straight and past free
FAR = 1.5  # times that: from here on a way has several states
PULLED = 0.5  # of the force that keeps the length of a straight module
SHEARED = 0.25  # of that force: across the axis
HELD_OUT = 5  # each such state is not in the fit whose error is told
DEGREES = (3, 4, 5, 6, 7, 8)
USUAL = 0.5  # of the largest: secondary strains of states that nobody sheared or twisted
HARDLY = 0.02  # rad of a module, or of its length: strains below it are secondary
ROOM = 0.05  # of the range: how far outside of what was walked a state may be
FREE_STEPS = 4  # of Newton's method: 1e-8 from the nearest state
FLAT = 1e-9  # of the largest range: the same in all states
COMPONENTS = (*(f"curvature_{c}" for c in "xyz"), *(f"stretch_{c}" for c in "xyz"))


@dataclass(frozen=True)
class Grid:
    """pressures: how many above zero, where one group of cavities is driven. bends: states each
    way from one that nothing holds, where that is far."""

    pressures: int = 3
    bends: int = 1


@dataclass(frozen=True)
class Walked:
    """What was found on the way.

    samples: the first is at rest. centres (c, k + m): strains and pressures of the module that
    nothing holds, the first at rest. lost: how many states had no equilibrium. iterations: of
    Newton's method, in all.
    """

    samples: Samples
    centres: Array
    lost: int
    iterations: int


@dataclass(frozen=True)
class Table:
    """The energy of a module and what a rod of such modules needs besides.

    free: (k,) which of ``COMPONENTS`` symmetry leaves; the energy's variables are these and the
    pressures of groups. errors: of its first derivatives at states that were held out, a part of
    each largest. pitch: mm. origin (3,): the middle of the left face. room (c,): moments of dead
    loads about the clamp, N mm, that were thought of at each of ``walked.centres``. groups: of
    cavities that go together, their shares. lumps: of the whole actuator.
    """

    energy: Energy
    free: NDArray[np.int64]
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

    def free_strain(self, pressures: Array) -> Array:
        """Of the module that nothing holds (k,), by the energy: Newton's method from the nearest
        state that was walked."""
        centres, k = self.walked.centres, self.k
        span = np.maximum(self.high - self.low, np.finfo(float).tiny)
        nearest = np.linalg.norm((centres[:, k:] - pressures) / span, axis=1).argmin()
        place = np.concatenate([centres[nearest, :k], pressures])
        for _ in range(FREE_STEPS):
            first, second = self.energy.both(place[None])
            place[:k] -= np.linalg.solve(second[0, :k, :k], first[0, :k])
        return np.asarray(place[:k])

    def check(self, strains: Array, pressures: Array) -> None:
        """Raise ValueError where strains (n, k) of modules leave what was walked."""
        energy, k = self.energy, self.k
        places = np.hstack([strains, np.tile(pressures, (len(strains), 1))])
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
    if name.startswith("stretch"):
        return f"{name.replace('_', ' along ')} of {value:.4g}"
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


# --- where a module is walked -------------------------------------------------------------------


class Design:
    """The states that a table asks for, one after the other, each from a neighbour."""

    def __init__(self, walker: Walker, loads: Driven, grid: Grid, axis: int):
        self.walker, self.loads, self.grid = walker, loads, grid
        free = walker.free.tolist()
        self.bends = [free.index(i) for i in range(3) if i != axis and i in free]
        self.along = free.index(3 + axis)
        self.secondary = [i for i in range(len(free)) if i not in (*self.bends, self.along)]
        self.lost = 0

    def pressures(self) -> Array:
        """Where the module is let go (p, m), MPa: a row of them for one group of cavities, for
        more the corners of what they reach, the middles of its axes, and its middle."""
        low, high = self.loads.low, self.loads.high
        if len(low) == 1:
            return np.linspace(low, high, self.grid.pressures + 1)
        corners = np.array(list(product(*zip(low, high, strict=True))))
        halves = np.diag((low + high) / 2)
        return np.unique(np.vstack([corners, halves, (low + high) / 2]), axis=0)

    def centres(self, rest: Held) -> list[Held]:
        """The module let go at all pressures, the first at rest. Raises NoEquilibriumError."""
        found, left = [rest], list(self.pressures())
        scale = self.loads.high - self.loads.low
        while left:
            gaps = np.array(
                [[np.linalg.norm((p - h.pressures) / scale) for h in found] for p in left]
            )
            row, column = np.unravel_index(gaps.argmin(), gaps.shape)
            goal = left.pop(int(row))
            if gaps.min() > 0:
                found.append(self.walker.released(found[int(column)], goal))
        return found

    def around(
        self, centre: Held, sags: tuple[Array, Array], beyond: float, pull: float, last: bool
    ) -> Iterator[Held]:
        """States about one that nothing holds: bent to and fro, stretched, and at the last
        pressures and at rest also sheared and twisted."""
        low, high = sags
        states = [centre]
        for i in self.bends:
            here = centre.strain[i]
            ends = min(here, 0.0) + low[i] - beyond, max(here, 0.0) + high[i] + beyond
            for end in ends:
                steps = self.grid.bends if abs(end - here) > FAR * beyond else 1
                goals = np.linspace(here, end, steps + 1)[1:]
                states += self._along(centre, [({i: goal}, {}) for goal in goals])
        if len(self.bends) == 2:
            one, two = self.bends
            for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                bent = {
                    i: centre.strain[i] + s * beyond / np.sqrt(2)
                    for i, s in zip((one, two), signs, strict=True)
                }
                states += self._along(centre, [(bent, {})])
        yield from states
        for number, state in enumerate(states):
            held = {i: state.strain[i] for i in self.bends}
            ways = (1, -1) if state is centre else (1 - 2 * (number % 2),)
            for way in ways:
                yield from self._along(state, [(held, {self.along: way * pull})])
        for i in self.secondary if last else ():
            twists = self.walker.free[i] < 3
            for way in (1, -1):
                given = {i: centre.strain[i] + way * beyond} if twists else {}
                pulls = {} if twists else {i: way * SHEARED * pull / PULLED}
                yield from self._along(centre, [(given, pulls)])

    def _along(
        self, start: Held, goals: list[tuple[dict[int, float], dict[int, float]]]
    ) -> list[Held]:
        """States from one to the next, as far as there are any; each goal is the strains that are
        given and the loads that others shall have, the rest being let go."""
        found: list[Held] = []
        for given, pulls in goals:
            try:
                strain = _relaxed(start, given, pulls)
                start = self.walker.to(start, strain, start.pressures)
            except NoEquilibriumError:
                self.lost += len(goals) - len(found)
                break
            found.append(start)
        return found


def _relaxed(held: Held, given: Mapping[int, float], pulls: Mapping[int, float]) -> Array:
    """Strains (k,) near a state, of which some are given and the others have loads (0 unless
    said), by its compliance."""
    compliance, k = held.compliance, len(held.strain)
    fixed = sorted(given)
    change = np.array([pulls.get(i, 0.0) for i in range(k)]) - held.load
    change[fixed] = 0.0
    if fixed:
        lacking = np.array([given[i] - held.strain[i] for i in fixed])
        lacking -= (compliance @ change)[fixed]
        change[fixed] = np.linalg.solve(compliance[np.ix_(fixed, fixed)], lacking)
    return np.asarray(held.strain + compliance @ change)


def walk(
    walker: Walker,
    loads: Driven,
    dead: Dead,
    grid: Grid,
    axis: int,
    tell: Callable[[str], None],
) -> tuple[Walked, Held, list[bool]]:
    """Visit all states; also the module at rest, and which variables are secondary. Raises
    NoEquilibriumError where the free module does not reach the full pressures."""
    design = Design(walker, loads, grid, axis)
    rest = walker.begin()
    try:
        centres = design.centres(rest)
    except NoEquilibriumError:
        raise NoEquilibriumError("the free module does not reach the full pressure") from None
    k, pitch = len(walker.free), walker.repeat.length
    stiffness = np.zeros((6, 6))
    stiffness[np.ix_(walker.free, walker.free)] = rest.second[:k, :k]
    sags = []
    for met in dead.near(np.array([c.pressures for c in centres])):
        low, high = dead.sags(stiffness, met)
        sags.append((SAGS * low[walker.free], SAGS * high[walker.free]))
    bent = max(float(np.linalg.norm(c.strain[design.bends])) for c in centres)
    beyond = BEYOND * max(bent, HARDLY / pitch)
    blocked = [c.second[:k, :k] @ (rest.strain - c.strain) for c in centres]
    pull = PULLED * max(abs(load[design.along]) for load in blocked)
    samples = [rest]
    for number, centre in enumerate(centres, 1):
        ends = number == 1 or np.allclose(centre.pressures, loads.high)
        around = design.around(centre, sags[number - 1], beyond, pull, ends)
        samples += [state for state in around if state is not rest]
        tell(
            f"table: {number} of {len(centres)} pressures, {len(samples)} states, "
            f"{design.lost} lost"
        )
    found = Samples(
        np.array([state.place for state in samples]),
        np.array([state.first for state in samples]),
        np.array([state.second for state in samples]),
    )
    let_go = np.array([c.place for c in centres])
    size = np.where(walker.free < 3, pitch, 1.0)
    moved = np.abs(let_go[:, :k] - walker.rest).max(axis=0) * size
    secondary = [i in design.secondary and bool(moved[i] < HARDLY) for i in range(k)]
    walked = Walked(found, let_go, design.lost, walker.iterations)
    return walked, rest, [*secondary, *[False] * len(loads.groups)]


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
    its ends take. Raises what its parts raise."""
    with TemporaryDirectory(prefix="softact-") as scratch:
        mesh = Path(scratch) / "module.msh"
        make_mesh(spec.geometry, mesh, curved=spec.solver.curved)
        model = build_model(MPI.COMM_SELF, spec, mesh)
    walker, layout = Walker(model, loads.groups), spec.layout()
    walked, rest, secondary = walk(walker, loads, dead, grid, axis_of(layout), tell)
    pressures = ["pressure"] if len(loads.groups) == 1 else [f"pressure_{n}" for n in loads.names]
    names = (*(COMPONENTS[i] for i in walker.free), *pressures)
    energy, off, degree = best_fit(walked, names, secondary)
    ends, bends = Ends(), [i for i in range(3) if i in walker.free and not layout.axis[i]]
    if short is not None and bends:
        tell("table: a short actuator, for its ends")
        ends = ends_of(short, loads, let_go(walker, layout, walked, rest))
    return Table(
        energy,
        walker.free,
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
    known = [int(np.abs(places - centre).sum(axis=1).argmin()) for centre in walked.centres]
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
