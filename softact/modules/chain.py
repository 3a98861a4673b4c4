"""An actuator as a chain of modules: how it stands as a rod, and what is measured of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from softact.errors import SpecError
from softact.loads.several import entries
from softact.measures.base import continued
from softact.measures.bending import axis_of_bending
from softact.mesh.layout import free_components
from softact.modules.driven import driven
from softact.modules.grip import Grip
from softact.modules.rod import Distance, Frames, Loads, Points, Rod
from softact.modules.rod_motion import inertias
from softact.modules.section import Section
from softact.modules.segments import PIECES, Segments
from softact.modules.table import Table
from softact.spec import Spec

Array = NDArray[np.float64]
NEAR = 1e-6  # mm/s² or N across the plane: none
STRAIGHT = 1e-6  # 1/mm

Row = dict[str, float | str]


@dataclass(frozen=True)
class Acting:
    """What acts at the end of a step. gravity (3,): mm/s², payload (3,): N; pressures
    (segments, m): MPa of the table's groups of cavities."""

    gravity: Array
    payload: Array
    pressures: Array

    def towards(self, other: Acting, part: float) -> Acting:
        """On the way to another one."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Acting(*((1 - part) * a + part * b for a, b in pairs))


class Chain:
    """A spec's actuator, which passes ``check``, as a rod of the modules of a table."""

    def __init__(self, spec: Spec, table: Table):
        self.spec, self.table = spec, table
        self.layout = spec.layout()
        self.axis = np.asarray(self.layout.axis, dtype=float)
        self.free = free_components(self.layout.symmetry).ravel()
        self.cavities = spec.geometry.in_segments()
        self.segments = Segments.of_chain(
            spec.geometry.pitches, len(self.cavities), table.ends.stiff
        )
        beside = table.origin - (table.origin @ self.axis) * self.axis
        along = (np.asarray(self.layout.origin) @ self.axis) * self.axis
        self.base = along + beside
        self.pressures = self._pressures()
        self.lengths = self.segments.spread(self.segments.bending) * table.pitch
        self.pieces = len(self.lengths)
        near = np.arange(min(PIECES, self.pieces))
        self.last_modules = near, self.pieces - 1 - near  # pieces of those at the clamp and the tip
        self.spare = (self.layout.length - self.lengths.sum()) / 2
        self.start = self.base + self.spare * self.axis
        self.tip_arm = table.lumps.tip - self.start - self.lengths.sum() * self.axis
        self.carried, self.masses, self.clamped = self._weights()
        self.touching = self._touching()
        self.inertia = inertias(
            self.carried.at,
            table.lumps.masses,
            self.carried.arms,
            table.lumps.spreads,
            self.pieces + 1,
        )

    def _weights(self) -> tuple[Points, Array, float]:
        """Which frame carries which lump of the undeformed actuator, the masses that hang there,
        and that which the clamp holds, tonne."""
        lumps = self.table.lumps
        places = lumps.centres - self.start
        frames = np.concatenate([[0.0], np.cumsum(self.lengths)])
        at = np.abs((places @ self.axis)[:, None] - frames).argmin(axis=1)
        arms = places - np.outer(frames[at], self.axis)
        clamped = at == 0
        hanging = np.where(clamped, 0.0, lumps.masses)
        return Points(at, arms), hanging, float(lumps.masses[clamped].sum())

    def _touching(self) -> Points:
        """What may touch obstacles: the outline of the modules, and that of the tip."""
        lumps, beside = self.table.lumps, self.start - self.start @ self.axis * self.axis
        last = self.tip_arm @ self.axis * self.axis
        sides = [Points.ends(self.pieces, arm) for arm in lumps.outline - beside]
        edges = lumps.tip_outline - beside + last
        return Points.joined(*sides, Points(np.full(len(edges), self.pieces), edges))

    def _pressures(self) -> Array:
        """Where each step goes to, of the table's groups (steps, segments, m)."""
        mine = driven(self.spec)
        steps = [[self._of_module(mine.cavities(p)) for p in step] for step in mine.goals]
        return np.array(steps)

    def _of_module(self, pressures: Mapping[str, float]) -> list[float]:
        """Pressures of the table's groups from those of a module's cavities, MPa."""
        pairs = zip(self.leading, self.table.groups, strict=True)
        return [float(pressures.get(name, 0.0)) / group[name] for name, group in pairs]

    def of_groups(self, pressures: Mapping[str, float]) -> Array:
        """Pressures (segments, m) of the table's groups from those of the actuator's cavities,
        MPa."""
        found = []
        for names in self.cavities:
            known = {
                alone: pressures[whole] for alone, whole in names.items() if whole in pressures
            }
            found.append(self._of_module(known))
        return np.array(found)

    @property
    def leading(self) -> list[str]:
        """Of each of the table's groups, the cavity of a module with the largest share."""
        return [max(group, key=group.__getitem__) for group in self.table.groups]

    def called(self, what: str) -> list[list[str]]:
        """Titles of columns, without units, of what each segment has of each group: ``pressure``,
        ``cavity_volume``."""
        if len(self.table.groups) * len(self.cavities) == 1:
            return [[what]]
        return [[f"{what}_{names[name]}" for name in self.leading] for names in self.cavities]

    def acting(self, number: int, before: Acting) -> Acting:
        """What acts at the end of a step. Raises SpecError."""
        step = self.spec.steps[number]
        gravity, payload = before.gravity, before.payload
        if (given := step.loads.get("gravity")) is not None:
            gravity = self._in_plane(given, f"steps.{step.name}.gravity")
        if loads := entries(step.payload):
            forces = [self._in_plane(p.force, f"steps.{step.name}.payload") for p in loads]
            payload = np.sum(forces, axis=0)
        return Acting(gravity, payload, self.pressures[number])

    def at_rest(self) -> Acting:
        """Without any load."""
        nothing = np.zeros((len(self.cavities), len(self.table.groups)))
        return Acting(np.zeros(3), np.zeros(3), nothing)

    def _in_plane(self, vector: Any, where: str) -> Array:
        given = np.asarray(vector, dtype=float)
        if np.abs(given[~self.free[3:]]).max(initial=0.0) > NEAR:
            raise SpecError(
                f"{where}: pulls out of the actuator's plane of symmetry, where its rod bends; "
                "geometry.symmetry: false takes it"
            )
        return given * self.free[3:]


class Standing:
    """A chain under what acts: the rod and its loads. grips: of its obstacles,
    where one has friction."""

    def __init__(self, chain: Chain, acting: Acting, grips: Sequence[Grip] = ()):
        self.chain, self.acting, self.grips = chain, acting, grips
        of = chain.segments.of
        more = np.zeros((chain.pieces, chain.table.k))
        for at, pressures in zip(chain.last_modules, acting.pressures[[0, -1]], strict=True):
            more[at] += self._lacking(pressures, float(chain.lengths[at].sum()))
        pairs = zip(acting.pressures, chain.segments.ends, strict=True)
        self.lost_air = np.array([self._lost(*pair) for pair in pairs])
        self.law = Section(chain.table, acting.pressures[of], more)
        self.rod = Rod(self.law, chain.pieces, chain.lengths, chain.axis, chain.free)
        self.loads = self._loads(acting)

    def _lacking(self, pressures: Array, length: float) -> Array:
        """Curvatures (k,) that the module at one end, which bends over a length, lacks at pressures
        (m,): what that end takes beyond what it takes under a force."""
        table = self.chain.table
        if not table.ends.known:
            return np.zeros(table.k)
        idle, _ = table.ends.at(pressures)
        lacking = (idle - table.ends.stiff) / 2 * table.pitch / length
        return np.asarray(table.turns * table.free_curvature(pressures) * lacking)

    def _lost(self, pressures: Array, ends: float) -> Array:
        """Air (m,), mm³, that so many ends of an actuator take from a segment at pressures (m,).
        Where a cavity ends at the next segment, its walls move as in a module, but no channel goes
        on."""
        table = self.chain.table
        _, air = table.ends.at(pressures)
        _, closed = table.ends.at(np.zeros_like(pressures))
        return np.asarray(air * ends + closed * (2 - ends)) / 2

    def _loads(self, acting: Acting) -> Loads:
        chain = self.chain
        points = Points.joined(chain.carried, Points(np.array([chain.pieces]), chain.tip_arm[None]))
        forces = np.vstack([np.outer(chain.masses, acting.gravity), acting.payload])
        obstacles = [self._distance(o.shape()) for o in chain.spec.obstacles.values()]
        return Loads(points, forces * chain.free[3:], chain.touching, obstacles, self.grips)

    def settled(self, frames: Frames) -> tuple[Frames, Loads]:
        """The equilibrium near frames, and the loads there. Raises ArithmeticError."""
        found = self.rod.settle(frames, self.loads)
        return found, self.rod.held(found, self.loads) if self.grips else self.loads

    def first_grips(self, frames: Frames) -> list[Grip]:
        """Of the obstacles of the spec before anything touches; none where none has friction."""
        obstacles = self.chain.spec.obstacles.values()
        if not any(obstacle.friction for obstacle in obstacles):
            return []
        places = self.chain.touching.places(frames)
        return [Grip.none(float(obstacle.friction), places) for obstacle in obstacles]

    def _distance(self, shape: Any) -> Distance:
        free = self.chain.free[3:].astype(float)

        def distance(places: Array) -> tuple[Array, Array, Array]:
            gaps, normals, second = shape.distance(places + self.chain.start)
            return gaps, normals * free, second * np.outer(free, free)

        return distance

    def _carried(self, frames: Frames, arm: Array) -> Array:
        """A place that the last frame carries (3,)."""
        points = Points(np.array([self.chain.pieces]), np.asarray(arm)[None])
        return np.asarray(self.chain.start + points.places(frames)[0])

    def tip(self, frames: Frames) -> Array:
        """The middle of the tip's face, (3,)."""
        return self._carried(frames, self.chain.tip_arm)

    def line(self, frames: Frames) -> Array:
        """From the clamp to the tip, (pieces + 3, 3)."""
        end = self._carried(frames, self.chain.spare * self.chain.axis)
        return np.vstack([self.chain.base, self.chain.start + frames.places, end])

    def row(self, frames: Frames, loads: Loads, before: Row) -> Row:
        """The measures of a state under loads; before: those of the last one."""
        chain, rod, strains = self.chain, self.rod, self.rod.strains(frames)
        found = _each(chain.called("pressure"), 1e3 * self.acting.pressures, "kPa")
        found |= bending(chain, frames, before)
        found |= _vector("tip", self.tip(frames), "mm")
        by_length = chain.segments.means(self.law.air(strains))
        air = chain.segments.modules * chain.table.pitch * by_length - self.lost_air
        found |= _each(chain.called("cavity_volume"), air, "mm3")
        # What holds the first frame, inertia or not, and what the clamp itself carries.
        held = rod.unbalanced(frames, loads)[0, 3:] - chain.clamped * self.acting.gravity
        cells = []
        pressed = rod.pressed(frames, loads)
        for (name, obstacle), forces in zip(chain.spec.obstacles.items(), pressed, strict=True):
            found |= _vector(f"contact_force_{name}", forces.sum(axis=0), "N")
            cells += [forces.sum(axis=0)] if obstacle.load_cell else []
        if cells:
            found["blocked_force_N"] = float(np.linalg.norm(np.sum(cells, axis=0)))
        found |= _vector("reaction", held, "N")
        curved = self.law.states(strains)[:, chain.table.turns]  # of the modules, ends or not
        steepest = chain.segments.steepest(curved)
        most = np.linalg.norm(curved, axis=1).max()
        found["curvature_change_percent"] = 100 * steepest / float(most) if most > STRAIGHT else 0.0
        return found


def bending(chain: Chain, frames: Frames, before: Row) -> Row:
    """The angle of the tip, unwrapped, and where the actuator may bend in any plane the axis about
    which it turned; as ``softact.measures.bending``."""
    layout, axis = chain.layout, chain.axis
    tip = frames.turns[-1] @ axis
    numbers = {name: value for name, value in before.items() if isinstance(value, float)}
    about = axis_of_bending(layout, tip, numbers)
    angle = float(np.degrees(np.arctan2(tip @ np.cross(about, axis), tip @ axis)))
    unwrapped = continued(angle, numbers.get("bending_angle_deg"))
    found: Row = {"bending_angle_deg": float(unwrapped)}
    if layout.bending_axis is None:
        found |= {f"bending_axis_{c}": float(v) for c, v in zip("xyz", about, strict=True)}
    return found


def _each(names: Sequence[Sequence[str]], values: Array, unit: str) -> Row:
    """Of segments and groups (segments, m)."""
    pairs = zip(np.ravel(names), values.ravel(), strict=True)
    return {f"{name}_{unit}": float(value) for name, value in pairs}


def _vector(name: str, vector: Array, unit: str) -> Row:
    return {f"{name}_{c}_{unit}": float(v) for c, v in zip("xyz", vector, strict=True)}
