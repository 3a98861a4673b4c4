"""An actuator as a rod whose cross-section is its module: from the spec to states."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softact.errors import SpecError
from softact.estimate.weight import last_loads, mass
from softact.fields import Fault
from softact.mesh.layout import free_components
from softact.modules.driven import driven
from softact.modules.rod import Distance, Frames, Linear, Loads, Points, Rod
from softact.modules.section import Section
from softact.modules.table import COMPONENTS, Dead, Table, axis_of
from softact.spec import Spec, Step

Array = NDArray[np.float64]
LOADED = {"gravity", "pressure", "payload"}
PIECES = 2  # by module
NEAR = 1e-6  # mm/s² or N across the plane: none
STRAIGHT = 1e-6  # 1/mm
TINY = 1e-300  # tonne
SAMPLES = 32  # pieces of the linear rod that says how far weight bends
BENT = 1.0  # degrees: below it the plane of bending is not known

Row = dict[str, float | str]


@dataclass(frozen=True)
class Acting:
    """What acts at the end of a step. gravity (3,): mm/s², payload (3,): N; pressures (m,): MPa of
    the table's groups of cavities."""

    gravity: Array
    payload: Array
    pressures: Array

    def towards(self, other: Acting, part: float) -> Acting:
        """On the way to another one."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Acting(*((1 - part) * a + part * b for a, b in pairs))


@dataclass(frozen=True)
class RodRun:
    """rows: as curve.csv. lines: places (pieces + 3, 3) from the clamp to the tip at each;
    strains (pieces, 6), 1/mm and 1. stopped: why it did not arrive, or empty."""

    rows: list[Row]
    lines: list[Array]
    strains: list[Array]
    stopped: str


def faults(spec: Spec) -> Iterator[Fault]:
    """What of a spec a rod cannot be asked."""
    yield from (((key,), why) for key, why in _refused(spec) if why)
    for name, obstacle in spec.obstacles.items():
        if obstacle.friction:
            yield ("obstacles", name, "friction"), "a rod slides on what it touches; write 0"
        if not obstacle.active:
            yield ("obstacles", name, "active"), "what a rod may touch stands there from the start"
    for index, step in enumerate(spec.steps):
        for key in sorted(set(step.loads) - LOADED):
            yield ("steps", index, key), f"a rod takes {', '.join(sorted(LOADED))} alone"
        if step.supports is not None:
            yield ("steps", index, "supports"), "a rod stays clamped"
        if step.timing(spec.layout()) is not None:
            yield ("steps", index, "duration"), "a rod has no clock; leave it out"
        for load in _payloads(step):
            if load.surface not in (None, spec.layout().tip):
                yield ("steps", index, "payload"), "a rod is loaded at its tip"


def check(spec: Spec) -> None:
    """Raise SpecError with one line for each thing that a rod cannot be asked."""
    spec.geometry.module()  # or it says that there is none
    if found := list(faults(spec)):
        raise SpecError(*(f"{'.'.join(map(str, place))}: {text}" for place, text in found))
    driven(spec)
    axis_of(spec.layout())


def dead(spec: Spec) -> Dead:
    """Weight and payload of a spec at the end of its steps, on the actuator without pressure."""
    gravity, force = last_loads(spec)
    layout, weight = spec.geometry.layout(), mass(spec)
    axis, length = np.asarray(layout.axis, dtype=float), layout.length
    free = free_components(layout.symmetry).ravel()
    points = Points.ends(SAMPLES)
    forces = np.tile(weight * gravity / SAMPLES, (SAMPLES, 1))
    forces[-1] += force
    natural = np.concatenate([np.zeros(3), axis])

    def sags(stiffness: Array) -> tuple[Array, Array]:
        rod = Rod(Linear(stiffness, natural), SAMPLES, length / SAMPLES, axis, free)
        bent = rod.strains(rod.equilibrium(rod.straight(), Loads(points, forces * free[3:])))
        changes = np.vstack([np.zeros(6), bent - natural])
        return changes.min(axis=0), changes.max(axis=0)

    moment = float(weight * np.linalg.norm(gravity) / 2 + np.linalg.norm(force)) * length
    return Dead(moment, sags)


def _refused(spec: Spec) -> Iterator[tuple[str, str]]:
    clamp = spec.layout().clamp
    loose = [s for s in spec.supports or () if s.surface != clamp or s.spring or s.turn]
    yield "supports", "a rod is clamped at its base, and nowhere else" if loose else ""
    yield "module", "a rod is of a whole actuator" if spec.layout().repeats else ""
    yield "masses", "a rod takes the weight of a mass as a payload" if spec.masses else ""
    yield "contact", "a rod does not meet itself; leave contact out" if spec.contact else ""


def _payloads(step: Step) -> list[Any]:
    value = step.loads.get("payload")
    return list(value) if isinstance(value, list | tuple) else [value] if value else []


class Chain:
    """A spec's actuator, which passes ``check``, as a rod of the modules of a table."""

    def __init__(self, spec: Spec, table: Table):
        self.spec, self.table = spec, table
        self.layout = spec.layout()
        self.axis = np.asarray(self.layout.axis, dtype=float)
        self.free = free_components(self.layout.symmetry).ravel()
        self.modules = spec.geometry.pitches
        self.pieces = max(1, round(PIECES * self.modules))
        beside = table.origin - (table.origin @ self.axis) * self.axis
        along = (np.asarray(self.layout.origin) @ self.axis) * self.axis
        self.base = along + beside
        self.pressures = self._pressures()

    def _pressures(self) -> Array:
        """At the end of each step, of the table's groups (steps, m)."""
        mine = driven(self.spec)
        columns = dict(zip(mine.names, mine.ends.T, strict=True))
        shares = {n: s for group in mine.groups for n, s in group.items()}
        found = np.zeros((len(self.spec.steps), len(self.table.groups)))
        for number, group in enumerate(self.table.groups):
            for name, column in columns.items():
                if name in group:
                    found[:, number] = column * shares[name] / group[name]
        return found

    def acting(self, number: int, before: Acting) -> Acting:
        """What acts at the end of a step. Raises SpecError."""
        step = self.spec.steps[number]
        gravity, payload = before.gravity, before.payload
        if (given := step.loads.get("gravity")) is not None:
            gravity = self._in_plane(given, f"steps.{step.name}.gravity")
        if loads := _payloads(step):
            forces = [self._in_plane(p.force, f"steps.{step.name}.payload") for p in loads]
            payload = np.sum(forces, axis=0)
        return Acting(gravity, payload, self.pressures[number])

    def at_rest(self) -> Acting:
        """Without any load."""
        return Acting(np.zeros(3), np.zeros(3), np.zeros(len(self.table.groups)))

    def _in_plane(self, vector: Any, where: str) -> Array:
        given = np.asarray(vector, dtype=float)
        if np.abs(given[~self.free[3:]]).max(initial=0.0) > NEAR:
            raise SpecError(
                f"{where}: pulls out of the actuator's plane of symmetry, where its rod bends; "
                "geometry.symmetry: false takes it"
            )
        return given * self.free[3:]


class Standing:
    """A chain under what acts: the rod, its loads and where it begins."""

    def __init__(self, chain: Chain, acting: Acting):
        self.chain, self.acting = chain, acting
        table, pressures = chain.table, acting.pressures
        bending = chain.modules - table.ends.stiff
        more = np.zeros(table.k)
        idle, self.lost_air = table.ends.at(pressures)
        if table.ends.known:
            bends = np.array([COMPONENTS[i].startswith("curvature") for i in table.free])
            more = bends * table.free_strain(pressures) * (idle - table.ends.stiff) / bending
        self.law = Section(table, pressures, more)
        length = bending * table.pitch / chain.pieces
        self.rod = Rod(self.law, chain.pieces, length, chain.axis, chain.free)
        self.spare = (chain.layout.length - chain.pieces * length) / 2
        self.start = chain.base + self.spare * chain.axis
        self.loads = self._loads(acting)

    def _loads(self, acting: Acting) -> Loads:
        carried, masses, front = self._weights()
        chain = self.chain
        tip = Points(np.array([chain.pieces]), self.tip_arm[None])
        points = Points.joined(carried, tip)
        forces = np.vstack([np.outer(masses, acting.gravity), acting.payload])
        self.front_weight = front * acting.gravity
        obstacles = [self._distance(o.shape()) for o in chain.spec.obstacles.values()]
        return Loads(points, forces * chain.free[3:], self._touching(), obstacles)

    @property
    def tip_arm(self) -> Array:
        """The middle of the tip's face beside the last frame (3,)."""
        chain = self.chain
        end = self.start + chain.pieces * self.rod.length * chain.axis
        return np.asarray(chain.table.lumps.tip - end)

    def _weights(self) -> tuple[Points, Array, float]:
        """What each frame carries of the undeformed actuator, and the mass, tonne, that the clamp
        holds."""
        lumps, chain, rod = self.chain.table.lumps, self.chain, self.rod
        places = lumps.centres - self.start
        along = places @ chain.axis
        at = np.clip(np.round(along / rod.length).astype(int), 0, rod.pieces)
        arms = places - np.outer(at * rod.length, chain.axis)
        clamped = at == 0
        return (
            Points(at, arms),
            np.where(clamped, 0.0, lumps.masses),
            float(lumps.masses[clamped].sum()),
        )

    def _touching(self) -> Points:
        """What may touch obstacles: the outline of the modules, and that of the tip."""
        chain, pieces = self.chain, self.chain.pieces
        lumps, beside = chain.table.lumps, self.start - self.start @ chain.axis * chain.axis
        last = self.tip_arm @ chain.axis * chain.axis
        sides = [Points.ends(pieces, arm) for arm in lumps.outline - beside]
        edges = lumps.tip_outline - beside + last
        return Points.joined(*sides, Points(np.full(len(edges), pieces), edges))

    def _distance(self, shape: Any) -> Distance:
        free = self.chain.free[3:].astype(float)

        def distance(places: Array) -> tuple[Array, Array, Array]:
            gaps, normals, second = shape.distance(places + self.start)
            return gaps, normals * free, second * np.outer(free, free)

        return distance

    def _carried(self, frames: Frames, arm: Array) -> Array:
        """A place that the last frame carries (3,)."""
        points = Points(np.array([self.chain.pieces]), np.asarray(arm)[None])
        return np.asarray(self.start + points.places(frames)[0])

    def tip(self, frames: Frames) -> Array:
        """The middle of the tip's face, (3,)."""
        return self._carried(frames, self.tip_arm)

    def line(self, frames: Frames) -> Array:
        """From the clamp to the tip, (pieces + 3, 3)."""
        end = self._carried(frames, self.spare * self.chain.axis)
        return np.vstack([self.chain.base, self.start + frames.places, end])

    def row(self, frames: Frames, before: Row) -> Row:
        """The measures of a state; before: those of the last one."""
        chain, rod, strains = self.chain, self.rod, self.rod.strains(frames)
        names = ["pressure"] if len(chain.table.groups) == 1 else chain.table.pressure_names
        found: Row = {
            f"{name}_kPa": 1e3 * float(p)
            for name, p in zip(names, self.acting.pressures, strict=True)
        }
        found |= bending(chain, frames, before)
        found |= _vector("tip", self.tip(frames), "mm")
        whole = chain.modules * chain.table.pitch * self.law.air(strains).mean(axis=0)
        whole -= self.lost_air
        volumes = [n.replace("pressure", "cavity_volume") for n in names]
        found |= {f"{n}_mm3": float(v) for n, v in zip(volumes, whole, strict=True)}
        held, cells = -self.loads.forces.sum(axis=0) - self.front_weight, []
        pressed = rod.pressed(frames, self.loads)
        for (name, obstacle), forces in zip(chain.spec.obstacles.items(), pressed, strict=True):
            found |= _vector(f"contact_force_{name}", forces.sum(axis=0), "N")
            held = held - forces.sum(axis=0)
            cells += [forces.sum(axis=0)] if obstacle.load_cell else []
        if cells:
            found["blocked_force_N"] = float(np.linalg.norm(np.sum(cells, axis=0)))
        found |= _vector("reaction", held, "N")
        curved = strains[:, :3]
        steps = np.linalg.norm(np.diff(curved, axis=0), axis=1)
        steepest = steps.max(initial=0.0) * chain.pieces / chain.modules
        most = np.linalg.norm(curved, axis=1).max()
        found["curvature_change_percent"] = float(100 * steepest / most) if most > STRAIGHT else 0.0
        return found


def bending(chain: Chain, frames: Frames, before: Row) -> Row:
    """The angle of the tip, unwrapped, and where the actuator may bend in any plane the axis about
    which it turned; as ``softact.measures.bending``."""
    layout, axis = chain.layout, chain.axis
    tip = frames.turns[-1] @ axis
    if layout.bending_axis is not None:
        about = np.asarray(layout.bending_axis, dtype=float)
    else:
        about = np.cross(axis, tip)
        size = np.linalg.norm(about)
        about = about / size if size > TINY else np.cross(axis, np.roll(axis, 1))
        seen = np.array([float(before.get(f"bending_axis_{c}", 0.0)) for c in "xyz"])
        if float(before.get("bending_angle_deg", 0.0)) > BENT and seen @ about < 0:
            about = -about
    angle = float(np.degrees(np.arctan2(tip @ np.cross(about, axis), tip @ axis)))
    last = float(before.get("bending_angle_deg", 0.0))
    found: Row = {"bending_angle_deg": angle + 360 * round((last - angle) / 360)}
    if layout.bending_axis is None:
        found |= {f"bending_axis_{c}": float(v) for c, v in zip("xyz", about, strict=True)}
    return found


def _vector(name: str, vector: Array, unit: str) -> Row:
    return {f"{name}_{c}_{unit}": float(v) for c, v in zip("xyz", vector, strict=True)}


def run(chain: Chain, increments: int) -> RodRun:
    """Carry a rod through the steps of its spec, each in so many increments."""
    frames, before = None, chain.at_rest()
    row: Row = {}
    found = RodRun([], [], [], "")
    for number, step in enumerate(chain.spec.steps):
        after = chain.acting(number, before)
        for increment in range(1 if found.rows else 0, increments + 1):
            part = increment / increments
            standing = Standing(chain, before.towards(after, part))
            if frames is None:
                frames = standing.rod.straight()
            try:
                frames = standing.rod.settle(frames, standing.loads)
                strains = standing.rod.strains(frames)
                chain.table.check(standing.law.of_modules(strains), standing.acting.pressures)
            except (ArithmeticError, ValueError) as error:
                return replace(found, stopped=f"step '{step.name}' stops at {part:.0%}: {error}")
            place: Row = {"step": step.name, "increment": float(increment), "step_fraction": part}
            row = standing.row(frames, row)
            found.rows.append(place | row)
            found.lines.append(standing.line(frames))
            found.strains.append(strains)
        before = after
    return found
