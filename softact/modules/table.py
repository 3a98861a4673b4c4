"""A planar module walked over curvature, axial force and pressure: what a rod asks of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

from softact.errors import NoEquilibriumError, SpecError
from softact.geometry.base import make_mesh
from softact.loads.load_step import LoadStep
from softact.measures.cross_section import CrossSection
from softact.mesh.layout import COMPONENTS, Layout
from softact.model import Model
from softact.modules.ends import Ends, FreeModule, ends_of
from softact.modules.response import AtPressure, Response, errors, fit
from softact.run.from_spec import build_model
from softact.solve.progress import Attempt, Trying
from softact.solve.stepping import Stepper
from softact.spec import Spec
from softact.system.term import State

Array = NDArray[np.float64]
SAGS = 1.2  # times how far the dead loads bend a linear rod
BEYOND = 0.5  # of the largest free curvature: how far the table goes past straight and past free
PULLED = 0.5  # of the force that keeps the length of a straight module
HELD_OUT = 5  # each such state is not in the fit whose error is told
DEGREES = (3, 4, 5, 6)
GRAVITY = "gravity"


@dataclass(frozen=True)
class Grid:
    """How many pressures above zero, curvatures at each, and axial forces at each."""

    pressures: int = 4
    curvatures: int = 5
    forces: int = 2


@dataclass(frozen=True)
class Dead:
    """Weight and payload for which a table has room. moment: of them about the clamp of the
    straight actuator, N mm. sags: from its stiffness against bending, N mm², to the least and the
    largest curvature, 1/mm, that they alone give it."""

    moment: float
    sags: Callable[[float], tuple[float, float]]


@dataclass(frozen=True)
class Plane:
    """In which a module bends: the axis, and across it the way in which a positive curvature turns
    the axis; about: index of the component. Unit vectors (3,)."""

    axis: Array
    across: Array
    about: int
    sign: float

    @classmethod
    def of(cls, layout: Layout) -> Plane:
        """Raises SpecError where the module may bend in another plane, too."""
        planes = set(layout.symmetry.values())
        if len(planes) != 1:
            raise SpecError(
                "a table of a module is that of a plane one: the geometry needs one plane of "
                f"symmetry along its axis, and has {len(planes) or 'none'}"
            )
        about = planes.pop()
        bending = np.eye(3)[about]
        if layout.bending_axis is not None:
            bending = np.asarray(layout.bending_axis, dtype=float)
        axis = np.asarray(layout.axis, dtype=float)
        return cls(axis, np.cross(bending, axis), about, float(bending[about]))

    def flat(self, places: Array) -> NDArray[np.complex128]:
        """Places (..., 3) as complex numbers: along the axis, and across it."""
        return np.asarray(places @ self.axis + 1j * (places @ self.across))

    def space(self, places: NDArray[np.complex128]) -> Array:
        """Places (n,) in the plane as those in space, (n, 3)."""
        return np.outer(places.real, self.axis) + np.outer(places.imag, self.across)

    def vector(self, name: str, force: complex) -> dict[str, float]:
        """A force in the plane as columns of a table, N."""
        (vector,) = self.space(np.array([force]))
        return {f"{name}_{c}_N": float(v) for c, v in zip("xyz", vector, strict=True)}


@dataclass(frozen=True)
class Walked:
    """What was found on the way.

    states (n, 3): curvature 1/mm, stretch, pressure MPa; the first is at rest. conjugates (3, n):
    moment N mm, force N, air by length mm². levels: pressures at which all curvatures were walked.
    free: curvature of the free module there, and free_air: its air by length. lost: how many states
    of the grid had no equilibrium. iterations: of Newton's method, in all.
    """

    states: Array
    conjugates: Array
    levels: Array
    free: Array
    free_air: Array
    lost: int
    iterations: int


@dataclass(frozen=True)
class Table:
    """The energy of a module and what a rod of such modules needs besides.

    errors: of moment, force and air at states that were held out, a part of each largest. moment:
    of dead loads, N mm, for which there is room. pressures: of the cavities where the largest is 1.
    origin: the middle of the left face. outline: (m,) corners of the convex hull of a module, from
    there. Places are complex (``Plane.flat``), mm.
    """

    response: Response
    errors: Array
    degree: int
    pitch: float
    outline: NDArray[np.complex128]
    origin: complex
    walked: Walked
    moment: float
    pressures: dict[str, float]
    ends: Ends

    def idle(self, pressure: float) -> float:
        """Modules that do not bend under a pressure, MPa."""
        return float(np.interp(pressure, self.ends.pressures, self.ends.idle))

    def free(self, pressure: float) -> float:
        """Curvature of the free module at a pressure, MPa."""
        return float(np.interp(pressure, self.walked.levels, self.walked.free))

    def reach(self, pressure: float) -> tuple[float, float]:
        """Least and largest curvature, 1/mm, that was walked near a pressure, MPa."""
        curvature, _, walked = self.walked.states.T
        levels = self.walked.levels
        found = [curvature[np.abs(walked - level) < 1e-9] for level in levels]
        ends = [(near.min(initial=0.0), near.max(initial=0.0)) for near in found]
        low, high = (np.interp(pressure, levels, end) for end in np.array(ends).T)
        return float(low), float(high)

    def check(self, law: AtPressure, strains: Array) -> None:
        """Raise ValueError where a rod's curvatures and stretches (2, n) leave what was walked."""
        states = law.states(*strains)
        low, high = self.reach(law.pressure)
        for value in (states[:, 0].min(), states[:, 0].max()):
            if not low <= value <= high:
                raise ValueError(
                    f"a curvature of {1e3 * value:.4g} per m is outside of the table: "
                    f"{1e3 * low:.4g} to {1e3 * high:.4g} per m at {1e3 * law.pressure:.4g} kPa"
                )
        self.response.check(states)


class Walker:
    """Takes one module from state to state: pressure, curvature and axial force are given.

    states: curvature, stretch and pressure of all that it accepted since the last ``clear``;
    conjugates: moment, axial force, and air by length.
    """

    def __init__(self, spec: Spec, model: Model):
        self.model, self.plane = model, Plane.of(model.mesh.layout)
        assert model.repeat is not None  # it is a module
        self.repeat = model.repeat
        self.pressures = largest_pressures(spec)
        self.iterations = 0
        self.clear()
        settings = replace(spec.solver.settings, initial_increment=1.0, max_increment=1.0)
        self._stepper = Stepper(model, settings, self._accept, on_iteration=self._count)

    def compliance(self) -> float:
        """Curvature by moment of the undeformed module, 1/(N mm²)."""
        self._stepper.walk.set_supports(())  # or nothing is held in the planes of symmetry
        section = CrossSection(self.model, self.model.initial_state())
        about = int(np.flatnonzero(np.flatnonzero(section.free) == self.plane.about)[0])
        return float(np.linalg.inv(section.stiffness())[about, about])

    def clear(self) -> None:
        """Forget the states so far."""
        self.states: list[tuple[float, float, float]] = []
        self.conjugates: list[tuple[float, float, float]] = []

    def _count(self, trying: Trying) -> None:
        self.iterations += 1

    def _accept(self, state: State, attempt: Attempt, number: int) -> None:
        if attempt.fraction == 0.0:
            return
        section, plane = CrossSection(self.model, state), self.plane
        bent, moment = (plane.sign * six[plane.about] for six in (section.strain, section.load))
        stretch, axial = (float(six[3:] @ plane.axis) for six in (section.strain, section.load))
        name = max(self.pressures, key=self.pressures.__getitem__)
        self.states.append((bent, stretch, float(state["pressure"][name])))
        self.conjugates.append((moment, axial, self.air(state)))

    def air(self, state: State) -> float:
        """Of the whole module by its length, mm², the cavities by their share of the pressure."""
        full = max(self.pressures.values())
        whole = sum(
            value / full * self.model.cavity_volume(state, cavity)
            for cavity, value in self.pressures.items()
        )
        return self.model.mesh.layout.copies * whole / self.repeat.length

    def to(
        self,
        part: float,
        curvature: float | None = None,
        force: float = 0.0,
        clamped: bool = False,
        increments: int = 1,
    ) -> bool:
        """Whether there is an equilibrium at this part of the full pressures, with this curvature
        (None: that of no moment) and axial force; clamped: of the undeformed length instead."""
        repeat, plane = self.repeat, self.plane
        hold, wrench = {}, np.zeros(6)
        if curvature is not None:
            turn = curvature * repeat.length
            hold[COMPONENTS[plane.about]] = plane.sign * turn
            # No shear: the force goes along the chord of the arc, and its work by length is ν.
            way = np.cos(turn / 2) * plane.axis + np.sin(turn / 2) * plane.across
            wrench[3:] = force * way / np.sinc(turn / (2 * np.pi))
        if clamped:
            hold |= {f"shift_{c}": v for c, v in zip("xyz", repeat.pitch, strict=True)}
        repeat.faces = replace(repeat.faces, hold=hold)
        step = LoadStep(
            "walk",
            (),
            1 / increments,
            pressure={name: part * value for name, value in self.pressures.items()},
            wrench=(wrench / self.model.mesh.layout.copies).tolist(),
        )
        return not self._stepper.run([step], ()).stopped


def largest_pressures(spec: Spec) -> dict[str, float]:
    """Of the cavities of a spec over its steps, MPa, without those that stay at zero. Raises
    SpecError where there are none, where they are no multiples of each other, or below zero."""
    found: dict[str, float] = {}
    for values in pressures_of(spec):
        if values and max(values.values()) > max(found.values(), default=0.0):
            found = values
    if not found:
        raise SpecError("a table of a module is walked over its pressure; no step has one")
    for values in pressures_of(spec):
        parts = [values.get(name, 0.0) / found[name] for name in found]
        if max(parts) - min(parts) > 1e-9 or set(values) - set(found) or min(parts) < 0:
            raise SpecError(
                "a table of a module is walked over one pressure above zero: those of several "
                "cavities are to be multiples of each other in all steps"
            )
    return found


def pressures_of(spec: Spec) -> Iterator[dict[str, float]]:
    """The pressures at the end of each step, MPa, without those of zero."""
    now: dict[str, float] = {}
    for step in spec.steps:
        given = step.loads.get("pressure")
        if given is not None:
            cavities = spec.layout().cavities
            named = given if isinstance(given, dict) else dict.fromkeys(cavities, given)
            now = {name: float(v) for name, v in (now | named).items() if v}
        yield now


def walk(
    walker: Walker, grid: Grid, sags: tuple[float, float], tell: Callable[[str], None]
) -> Walked:
    """Visit a grid of states, each from its neighbour. Raises NoEquilibriumError where the free or
    the clamped module does not reach the full pressure."""
    parts = np.linspace(0, 1, grid.pressures + 1)
    rest = walker.air(walker.model.initial_state())
    if not walker.to(1.0, increments=grid.pressures):
        raise NoEquilibriumError("the free module does not reach the full pressure")
    reached, bent = np.array([(p, k) for k, _, p in walker.states]).T
    full = reached[-1]
    free = np.interp(parts, np.append(0, reached / full), np.append(0, bent))
    air = np.array([conjugates[2] for conjugates in walker.conjugates])
    free_air = np.interp(parts, np.append(0, reached / full), np.append(rest, air))
    beyond = BEYOND * max(abs(free))
    around = SAGS * sags[0] - beyond, SAGS * sags[1] + beyond
    if not walker.to(1.0, 0.0, clamped=True):
        raise NoEquilibriumError("the clamped module does not reach the full pressure")
    force = PULLED * abs(walker.conjugates[-1][1])
    walker.clear()
    lost, sweeps = 0, list(_sweeps(parts, free, around, force, grid))
    for number, (part, first, last, pull) in enumerate(sweeps, 1):
        found = len(walker.states)
        if walker.to(part, first, pull):
            walker.to(part, last, pull, increments=grid.curvatures - 1)
        lost += max(0, grid.curvatures - len(walker.states) + found)
        tell(f"table: {number} of {len(sweeps)} sweeps, {len(walker.states)} states, {lost} lost")
    states = np.array([(0.0, 1.0, 0.0), *walker.states])
    conjugates = np.array([(0.0, 0.0, rest), *walker.conjugates]).T
    work = walker.iterations
    return Walked(states, conjugates, parts * full, free, free_air, lost, work)


def _sweeps(
    parts: Array, free: Array, around: tuple[float, float], force: float, grid: Grid
) -> Iterator[tuple[float, float, float, float]]:
    """Part of the pressure, first and last curvature, and force: each begins near the last one's
    end."""
    up, pulls = True, np.linspace(-force, force, grid.forces)
    for part, bent in list(zip(parts, free, strict=True))[::-1]:
        for pull in pulls:
            low, high = min(bent, 0.0) + around[0], max(bent, 0.0) + around[1]
            first, last = (low, high) if up else (high, low)
            yield float(part), float(first), float(last), float(pull)
            up = not up
        pulls = pulls[::-1]


def best_fit(walked: Walked) -> tuple[Response, Array, int]:
    """The energy whose degree has the least error at states held out of its fit, then fitted to all
    of them; that error, and the degree. Raises SpecError where there are too few states."""
    number = np.arange(len(walked.states))
    out = number % HELD_OUT == HELD_OUT // 2
    within = walked.states.min(axis=0), walked.states.max(axis=0)
    tried = []
    for degree in DEGREES:
        try:
            part = fit(walked.states[~out], walked.conjugates[:, ~out], degree, within)
        except ValueError:
            break
        off = errors(part, walked.states[out], walked.conjugates[:, out])
        tried.append((off.max(), degree, off))
    if not tried:
        raise SpecError(f"the module found only {len(number)} states, too few for a table")
    _, degree, off = min(tried, key=lambda one: one[0])
    return fit(walked.states, walked.conjugates, degree), off, degree


def table(
    spec: Spec,
    grid: Grid,
    dead: Dead,
    tell: Callable[[str], None],
    short: Spec | None = None,
) -> Table:
    """Mesh a module's spec, walk it and fit. short: a whole actuator of few modules, for what
    its ends take. Raises what its parts raise."""
    with TemporaryDirectory(prefix="softact-") as scratch:
        mesh = Path(scratch) / "module.msh"
        make_mesh(spec.geometry, mesh, curved=spec.solver.curved)
        model = build_model(MPI.COMM_SELF, spec, mesh)
    walker = Walker(spec, model)
    repeat, plane = walker.repeat, walker.plane
    origin = plane.flat(repeat.centre)
    bending = 1 / walker.compliance()
    walked = walk(walker, grid, dead.sags(bending), tell)
    response, off, degree = best_fit(walked)
    ends, full = Ends(), max(walker.pressures.values())
    if short is not None:
        tell("table: a short actuator, for its ends")
        free = FreeModule(repeat.length, bending, walked.levels, walked.free, walked.free_air)
        ends = ends_of(short, free, plane.across)
    return Table(
        response,
        off,
        degree,
        repeat.length,
        hull(plane.flat(model.nodes.places)) - origin,
        complex(origin),
        walked,
        dead.moment,
        {name: value / full for name, value in walker.pressures.items()},
        ends,
    )


def hull(points: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Corners of the convex hull of places in a plane."""
    from scipy.spatial import ConvexHull

    flat = np.column_stack([points.real, points.imag])
    return np.asarray(points[ConvexHull(flat).vertices])
