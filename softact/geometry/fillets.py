"""Rounded edges: what they take from a volume, and how OCC rounds solids and names their faces.

A prism over a convex section whose edges are rounded with the radius r is the smaller prism that
lies r inside of it and everything within r of that; its volume is Steiner's polynomial of r
(Schneider 2014, Convex Bodies, equation 4.8). A channel that shares a wall with the chamber which
it leaves cuts through the rounding there; ``mouth`` is what it takes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import ceil, pi, sin
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from softact.geometry.subdivide import fill

if TYPE_CHECKING:
    from softact.geometry.boxes import Box, Plane

#: Area between a right-angled corner and the circle of radius 1 in it.
CORNER = 1 - pi / 4
#: Elements around a quarter of a rounding, where nothing is said.
AROUND = 2
NEAR = 1e-5  # mm: gmsh's boxes are a little too large
Entities = list[tuple[int, int]]
Solids = dict[str, Entities]


@dataclass(frozen=True)
class Rounded:
    """A convex section with rounded corners. area (mm²) and perimeter (mm): of the section that
    lies ``radius`` (mm) inside of it."""

    radius: float
    area: float
    perimeter: float

    @classmethod
    def rectangle(cls, width: float, height: float, radius: float) -> Rounded:
        """A rectangle of width times height (mm)."""
        width, height = width - 2 * radius, height - 2 * radius
        return cls(radius, width * height, 2 * (width + height))

    @property
    def section(self) -> float:
        """Its area, mm²."""
        r = self.radius
        return self.area + r * self.perimeter + pi * r**2

    def prism(self, length: float) -> float:
        """Volume (mm³) of a prism over it, so long, whose edges at both ends are rounded, too."""
        r, inside = self.radius, length - 2 * self.radius
        skin = 2 * self.area + self.perimeter * inside
        edges = pi * (inside + self.perimeter / 2)
        return self.area * inside + r * skin + r**2 * edges + 4 / 3 * pi * r**3

    def round_edges(self, length: float) -> float:
        """Length (mm) of all edges of that prism."""
        return 2 * (self.perimeter + 2 * pi * self.radius) + 4 * length


def mouth(radius: float, chord: float, turn: float = 0.0) -> float:
    """What a channel takes from a chamber's rounding where it leaves it along shared walls, mm³.

    radius: of both. chord: length across of the flat part that they share, mm. turn: angle (rad)
    between the normals of two shared walls.

    At the distance t from where the rounding begins the chamber is ρ = √(r² − t²) beyond its
    smaller prism and the channel r, which takes chord (r − ρ) along the walls, turn (r² − ρ²)/2
    around the corner between them and ∫ (r − √(r² − z²)) at either side; integrated over t.
    """
    sides = 2 * (pi / 4 - 2 / 3)
    return chord * radius**2 * CORNER + (turn / 6 + sides) * radius**3


def around(radius: float, finest: float | None) -> int:
    """Number of edges around a quarter of a rounding: at most ``finest`` (mm) long, by default
    ``AROUND`` of them."""
    return ceil(pi / 2 * radius / finest) if finest else AROUND


def chord_error(radius: float, edges: int) -> float:
    """Area (mm²) between a quarter of a rounding and so many straight edges along it."""
    return radius**2 * (pi / 4 - edges / 2 * sin(pi / 2 / edges))


def too_large(
    name: str, radius: float, rooms: Mapping[str, float], times: int = 2
) -> Iterator[tuple[str, str]]:
    """Field and fault where so many times a radius do not fit in the narrowest room (mm)."""
    narrowest = min(rooms, key=lambda room: rooms[room])
    if radius and times * radius >= rooms[narrowest]:
        yield (
            name,
            f"{radius:g} mm is too large for {narrowest} of {rooms[narrowest]:g} mm: no flat part "
            f"would be left; write less than {rooms[narrowest] / times:g} mm",
        )


def beside(
    radius: float, channel: Mapping[str, float], chamber: Mapping[str, float], sides: int = 2
) -> Iterator[tuple[str, str]]:
    """Field and fault where a channel does not leave a chamber through the flat part of its end.

    channel: width and height, mm; chamber: of the same names, with "a chamber_" for what comes
    before. sides: how many roundings lie beside the channel in its height.
    """
    for (name, size), beside in zip(channel.items(), (2, sides), strict=True):
        room = "a chamber_" + name.rpartition("_")[2]
        flat = chamber[room] - beside * radius
        if radius and size > flat:
            yield (
                "fillet",
                f"{radius:g} mm leaves {flat:g} mm flat of {room} {chamber[room]:g} mm, less than "
                f"{name} {size:g} mm; write a smaller one",
            )


def round_edges(
    gmsh: ModuleType,
    solid: tuple[int, int],
    radius: float,
    wanted: Callable[[np.ndarray, np.ndarray], bool],
) -> Entities:
    """Round the edges of an OCC solid. wanted: of the lower and upper corners (3,) of the box
    around an edge, mm."""
    gmsh.model.occ.synchronize()
    faces = gmsh.model.getBoundary([solid], oriented=False)
    edges = gmsh.model.getBoundary(faces, combined=False, oriented=False)
    chosen = [
        tag
        for tag in sorted({tag for _, tag in edges})
        # A seam of a round face bounds that face alone.
        if len(set(gmsh.model.getAdjacencies(1, tag)[0])) > 1
        and wanted(*np.reshape(gmsh.model.getBoundingBox(1, tag), (2, 3)))
    ]
    return gmsh.model.occ.fillet([solid[1]], chosen, [radius])


def rounded_box(gmsh: ModuleType, box: Box) -> Entities:
    """A box as an OCC solid, with its rounded edges."""
    solid = (3, gmsh.model.occ.addBox(*box.lower, *np.subtract(box.upper, box.lower)))
    if not box.rounded:
        return [solid]

    def wanted(lower: np.ndarray, upper: np.ndarray) -> bool:
        axis = int(np.argmax(upper - lower))
        sharp = any(abs(lower[a] - at) < NEAR and abs(upper[a] - at) < NEAR for a, at in box.sharp)
        return axis in box.along and not sharp

    return round_edges(gmsh, solid, box.rounded, wanted)


def halves(gmsh: ModuleType, solids: Solids) -> Solids:
    """The halves y >= 0 of OCC solids; those that have none are left out."""
    occ = gmsh.model.occ
    found: Solids = {}
    for name, tags in solids.items():
        box = np.array([occ.getBoundingBox(*tag) for tag in tags])
        lower, upper = box[:, :3].min(axis=0) - 1.0, box[:, 3:].max(axis=0) + 1.0
        if upper[1] - 1.0 < NEAR:
            occ.remove(tags, recursive=True)
            continue
        lower[1] = 0.0
        half = (3, occ.addBox(*lower, *(upper - lower)))
        found[name], _ = occ.intersect(tags, [half])
    return found


def divide(
    gmsh: ModuleType,
    solids: Solids,
    air: Solids,
    planes: Sequence[Plane],
    sheets: Sequence[Box] = (),
) -> None:
    """Cut the air of cavities out of OCC solids, join these where they touch, and name all parts.

    solids: region -> its solids, which do not overlap; air: cavity -> its room. planes: as of
    ``Boxes``. sheets: named surfaces inside of the solids.
    """
    occ = gmsh.model.occ
    parts = [*solids.items(), *air.items()]
    flats = {sheet.name: [_sheet(gmsh, sheet)] for sheet in sheets}
    everything = [tag for _, tags in [*parts, *flats.items()] for tag in tags]
    _, origins = occ.fragment(everything[:1], everything[1:])
    found, rest = {}, iter(origins)
    for name, tags in [*parts, *flats.items()]:
        found[name] = {tag for _ in tags for tag in next(rest)}
    rooms = set().union(*(found[name] for name in air)) if air else set()
    occ.synchronize()
    walls = {
        tag: name
        for name in air
        for _, tag in gmsh.model.getBoundary(list(found[name]), oriented=False)
    }
    inside = {tag: name for name in flats for _, tag in found[name]}
    occ.remove(sorted(rooms))
    occ.synchronize()
    loose = [face for face in gmsh.model.getEntities(2) if not len(_owners(gmsh, face))]
    occ.remove(loose, recursive=True)
    occ.synchronize()
    groups = {(3, name): [tag for _, tag in sorted(found[name] - rooms)] for name in solids}
    for face in gmsh.model.getEntities(2):
        for name in _names_of(gmsh, face, walls, inside, planes):
            groups.setdefault((2, name), []).append(face[1])
    for (dimension, name), tags in groups.items():
        gmsh.model.setPhysicalName(
            dimension, gmsh.model.addPhysicalGroup(dimension, sorted(tags)), name
        )


def _owners(gmsh: ModuleType, face: tuple[int, int]) -> np.ndarray:
    """The solids that a face bounds."""
    return gmsh.model.getAdjacencies(*face)[0]


def _names_of(
    gmsh: ModuleType,
    face: tuple[int, int],
    walls: Mapping[int, str],
    inside: Mapping[int, str],
    planes: Sequence[Plane],
) -> list[str]:
    tag = face[1]
    if len(_owners(gmsh, face)) > 1:
        return [inside[tag]] if tag in inside else []
    if tag in walls:
        return [walls[tag]]
    box = np.reshape(gmsh.model.getBoundingBox(*face), (2, 3))
    for plane in planes:
        if (abs(box[:, plane.axis] - plane.at) < NEAR).all():
            return [plane.name, "outer"] if plane.outer else [plane.name]
    return ["outer"]


def _sheet(gmsh: ModuleType, sheet: Box) -> tuple[int, int]:
    """A rectangle without thickness as an OCC face."""
    occ = gmsh.model.occ
    lower, upper = np.array(sheet.lower), np.array(sheet.upper)
    one, other = np.diag(upper - lower)[upper > lower]
    corners = [occ.addPoint(*at) for at in (lower, lower + one, upper, lower + other)]
    lines = [occ.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]
    return 2, occ.addPlaneSurface([occ.addCurveLoop(lines)])


def fill_rounded(
    gmsh: ModuleType, radius: float, size: float, finest: float | None, least: int
) -> None:
    """Mesh the solid in the current gmsh model, with edges of ``size`` (mm) and of ``finest``
    around roundings of ``radius``: by default ``AROUND`` of them to a quarter."""
    fill(gmsh, size, least, 4 * around(radius, finest))
