"""An actuator as a rod whose cross-section is its module: from the spec to states."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from softact.errors import SpecError
from softact.estimate.weight import last_loads, mass
from softact.fields import Fault
from softact.geometry.base import make_mesh
from softact.mesh.msh_file import Tetrahedra, read_msh
from softact.modules.planar_rod import Array, Distance, Linear, Loads, Places, Points, Rod
from softact.modules.response import AtPressure
from softact.modules.table import Dead, Plane, Table, largest_pressures, pressures_of
from softact.spec import Spec, Step

LOADED = {"gravity", "pressure", "payload"}
PIECES = 2  # by module
NEAR = 1e-6  # mm/s² or N across the plane: none
STRAIGHT = 1e-6  # 1/mm
TINY = 1e-300  # tonne
SAMPLES = 32  # pieces of the linear rod that says how far weight bends
STIFF = 1e4  # its stiffness against stretch, by that against bending and its length

Row = dict[str, float | str]


@dataclass(frozen=True)
class Driven:
    """What acts at the end of a step. gravity: mm/s², payload: N, both in the plane; pressure: MPa
    of the cavities whose share in the table is 1."""

    gravity: complex = 0.0
    payload: complex = 0.0
    pressure: float = 0.0

    def towards(self, other: Driven, part: float) -> Driven:
        """On the way to another one."""
        return Driven(
            *(
                (1 - part) * a + part * b
                for a, b in zip(vars(self).values(), vars(other).values(), strict=True)
            )
        )


@dataclass(frozen=True)
class RodRun:
    """rows: as curve.csv. lines: places (pieces + 3, 3) from the clamp to the tip at each;
    curvatures (pieces,), 1/mm. stopped: why it did not arrive, or empty."""

    rows: list[Row]
    lines: list[Array]
    curvatures: list[Array]
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
    largest_pressures(spec)


def dead(spec: Spec) -> Dead:
    """Weight and payload of a spec at the end of its steps, on the actuator without pressure."""
    gravity, force = last_loads(spec)
    layout, weight = spec.geometry.layout(), mass(spec)
    plane, length = Plane.of(layout), layout.length
    points = Points.ends(SAMPLES)
    forces = np.full(SAMPLES, plane.flat(weight * gravity) / SAMPLES)
    forces[-1] += plane.flat(force)

    def sags(bending: float) -> tuple[float, float]:
        rod = Rod(Linear(bending, STIFF * bending / length**2), SAMPLES, length / SAMPLES)
        start = np.concatenate([np.zeros(SAMPLES), np.ones(SAMPLES)])
        bent = rod.equilibrium(start, Loads(points, forces))[:SAMPLES]
        return min(0.0, float(bent.min())), max(0.0, float(bent.max()))

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


def _areas(corners: Array) -> Array:
    """Of triangles (n, 3, 3)."""
    a, b, c = corners.transpose(1, 0, 2)
    return np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2)


class Chain:
    """A spec's actuator, which passes ``check``, as a rod of the modules of a table."""

    def __init__(self, spec: Spec, table: Table):
        self.spec, self.table = spec, table
        self.layout = spec.layout()
        self.plane = Plane.of(self.layout)
        self.modules = spec.geometry.pitches
        self.pieces = max(1, round(PIECES * self.modules))
        height = 1j * table.origin.imag
        self.base = complex(self.plane.flat(np.asarray(self.layout.origin)).real) + height
        with TemporaryDirectory(prefix="softact-") as scratch:
            mesh = Path(scratch) / "actuator.msh"
            make_mesh(spec.geometry, mesh)
            found = read_msh(mesh, self.layout)
        self.tip, self.edges = self._tip(found)
        self.lumps = self._lumps(found)

    def _tip(self, mesh: Tetrahedra) -> tuple[complex, Places]:
        """Where the middle of the tip's face is beside the end of the rod's line, and its
        corners."""
        corners = mesh.points[mesh.surfaces[self.layout.tip][:, :3]]
        places = self.plane.flat(corners) - (self.base + self.layout.length)
        areas = _areas(corners)
        middle = (areas @ places.mean(axis=1)) / areas.sum()
        edges = np.array([places.imag.min(), places.imag.max()])
        return complex(middle), middle.real + 1j * edges

    def _lumps(self, mesh: Tetrahedra) -> tuple[Places, Array]:
        """Places from the rod's base, and masses, tonne: one for each cell, and for each triangle
        of a layer, of the whole actuator."""
        cells = mesh.points[mesh.cells[:, :4]]
        names = self.layout.regions
        densities = np.array([self.spec.materials[name].density for name in names])
        edges = cells[:, 1:] - cells[:, :1]
        places = [self.plane.flat(cells).mean(axis=1)]
        masses = [np.abs(np.linalg.det(edges)) / 6 * densities[mesh.region]]
        for layer in self.spec.layers:
            corners = mesh.points[mesh.surfaces[layer.surface][:, :3]]
            places.append(self.plane.flat(corners).mean(axis=1))
            masses.append(_areas(corners) * layer.thickness * layer.material.density)
        whole = self.layout.copies * np.concatenate(masses)
        return np.concatenate(places) - self.base, whole

    def driven(self, step: Step, pressure: float, before: Driven) -> Driven:
        """What acts at the end of a step. Raises SpecError."""
        gravity, payload = before.gravity, before.payload
        if (given := step.loads.get("gravity")) is not None:
            gravity = self._in_plane(given, f"steps.{step.name}.gravity")
        if loads := _payloads(step):
            payload = sum(self._in_plane(p.force, f"steps.{step.name}.payload") for p in loads)
        return Driven(gravity, payload, pressure)

    def _in_plane(self, vector: Any, where: str) -> complex:
        given = np.asarray(vector, dtype=float)
        flat = self.plane.flat(given)
        if np.linalg.norm(given) - abs(flat) > NEAR:
            raise SpecError(f"{where}: a plane rod is not loaded across its plane")
        return complex(flat)


class Standing:
    """A chain under what drives it: the rod, its loads and where it begins."""

    def __init__(self, chain: Chain, driven: Driven):
        self.chain = chain
        table, pressure = chain.table, driven.pressure
        bending = chain.modules - table.ends.stiff
        more = table.free(pressure) * (table.idle(pressure) - table.ends.stiff) / bending
        self.law = AtPressure(table.response, pressure, more)
        self.lost_air = float(np.interp(pressure, table.ends.pressures, table.ends.air))
        pitch = bending * table.pitch / chain.pieces
        self.rod = Rod(self.law, chain.pieces, pitch)
        self.spare = (chain.layout.length - chain.pieces * pitch) / 2
        self.start = chain.base + self.spare
        self.loads = self._loads(driven)

    def _loads(self, driven: Driven) -> Loads:
        last = self.chain.pieces - 1
        carried, masses, front = self._weights()
        points = Points.joined(
            carried, Points(np.array([last]), np.array([self.spare + self.chain.tip]))
        )
        forces = np.append(masses * driven.gravity, driven.payload)
        self.front_weight = front * driven.gravity
        obstacles = [self._distance(o.shape()) for o in self.chain.spec.obstacles.values()]
        return Loads(points, forces, 0.0, self._touching(), obstacles)

    def _weights(self) -> tuple[Points, Array, float]:
        """What each piece's end carries of the undeformed actuator, and the mass, tonne, that lies
        before them, in the clamp."""
        (places, masses), pieces, pitch = self.chain.lumps, self.chain.pieces, self.rod.pitch
        along = places - self.spare
        at = np.clip(np.round(along.real / pitch).astype(int), 0, pieces)
        whole = np.bincount(at, masses, pieces + 1).astype(float)
        held = along - at * pitch
        arms = np.bincount(at, masses * held.real, pieces + 1) + 0j
        arms += 1j * np.bincount(at, masses * held.imag, pieces + 1)
        arms /= np.maximum(whole, TINY)
        return Points(np.arange(pieces), arms[1:]), whole[1:], float(whole[0])

    def _touching(self) -> Points:
        """What may touch obstacles: both sides of the modules, and the edges of the tip."""
        chain, last = self.chain, self.chain.pieces - 1
        outline = chain.table.outline.imag
        sides = [Points.ends(last + 1, 1j * side) for side in (outline.min(), outline.max())]
        tip = Points(np.full(2, last), (self.spare + chain.edges).astype(complex))
        return Points.joined(*sides, tip)

    def _distance(self, shape: Any) -> Distance:
        plane = self.chain.plane

        def distance(places: Places) -> tuple[Array, Places, Array]:
            gaps, normals, second = shape.distance(plane.space(places + self.start))
            flat = plane.flat(normals)
            along = plane.space(1j * flat)
            return gaps, flat, np.einsum("ni,nij,nj->n", along, second, along)

        return distance

    def _last(self, strains: Array, arm: complex) -> Places:
        """A place that the end of the last piece carries, (1,)."""
        points = Points(np.array([self.chain.pieces - 1]), np.array([arm], dtype=complex))
        return self.start + self.rod.positions(strains, points)

    def tip(self, strains: Array) -> Array:
        """The middle of the tip's face, (3,)."""
        (place,) = self.chain.plane.space(self._last(strains, self.spare + self.chain.tip))
        return np.asarray(place)

    def line(self, strains: Array) -> Array:
        """From the clamp to the tip, (pieces + 3, 3)."""
        ends = self.start + self.rod.places(*strains.reshape(2, -1))
        end = self._last(strains, self.spare)
        return self.chain.plane.space(np.concatenate([[self.chain.base, self.start], ends, end]))

    def row(self, strains: Array) -> Row:
        """The measures of a state."""
        chain, rod, law, plane = self.chain, self.rod, self.law, self.chain.plane
        curvature, stretch = strains.reshape(2, -1)
        found: Row = {"pressure_kPa": 1e3 * law.pressure}
        found["bending_angle_deg"] = float(np.degrees(rod.pitch * curvature.sum()))
        tip = self.tip(strains)
        found |= {f"tip_{c}_mm": float(v) for c, v in zip("xyz", tip, strict=True)}
        air = law.response.conjugates(law.states(curvature, stretch))[2]
        whole = chain.modules * chain.table.pitch * air.mean()
        found["cavity_volume_mm3"] = float(whole - self.lost_air)
        held, cells = -self.loads.forces.sum() - self.front_weight, []
        pressed = rod.pressed(strains, self.loads)
        for (name, obstacle), forces in zip(chain.spec.obstacles.items(), pressed, strict=True):
            found |= plane.vector(f"contact_force_{name}", forces.sum())
            held -= forces.sum()
            cells += [forces.sum()] if obstacle.load_cell else []
        if cells:
            found["blocked_force_N"] = float(abs(sum(cells)))
        found |= plane.vector("reaction", held)
        steepest = np.abs(np.diff(curvature)).max(initial=0.0) * chain.pieces / chain.modules
        most = np.abs(curvature).max()
        found["curvature_change_percent"] = float(100 * steepest / most) if most > STRAIGHT else 0.0
        return found


def run(chain: Chain, increments: int) -> RodRun:
    """Carry a rod through the steps of its spec, each in so many increments."""
    strains = np.concatenate([np.zeros(chain.pieces), np.ones(chain.pieces)])
    before, found = Driven(), RodRun([], [], [], "")
    for step, pressures in zip(chain.spec.steps, pressures_of(chain.spec), strict=True):
        after = chain.driven(step, max(pressures.values(), default=0.0), before)
        for number in range(1 if found.rows else 0, increments + 1):
            part = number / increments
            standing = Standing(chain, before.towards(after, part))
            try:
                strains = standing.rod.settle(strains, standing.loads)
                chain.table.check(standing.law, strains.reshape(2, -1))
            except (ArithmeticError, ValueError) as error:
                return replace(found, stopped=f"step '{step.name}' stops at {part:.0%}: {error}")
            place: Row = {"step": step.name, "increment": float(number), "step_fraction": part}
            found.rows.append(place | standing.row(strains))
            found.lines.append(standing.line(strains))
            found.curvatures.append(strains[: chain.pieces].copy())
        before = after
    return found
