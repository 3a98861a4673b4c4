"""Solids made of prisms along x: one section meshed once, and extruded stretch by stretch.

Round actuators with thin walls are unions and cuts of prisms over plane shapes. An unstructured
mesh of them has slivers in the walls; here all shapes together divide the section (the plane y, z)
into faces, gmsh meshes these with triangles, and every stretch of x between two planes is filled
with prisms over those triangles that are solid there, each split into three tetrahedra.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from math import pi
from types import ModuleType

import numpy as np

from softact.geometry.boxes import OUTSIDE, SAME_PLANE, Plane
from softact.geometry.carrying import CarriedMesh
from softact.geometry.curved import are_curved, curves_of
from softact.geometry.fillets import divide, halves, round_edges
from softact.geometry.gmsh_groups import add_mesh, prism_sides, prism_tetrahedra
from softact.geometry.steps import repeatable, steps
from softact.geometry.subdivide import Pieces
from softact.mesh.cells import check_number
from softact.mesh.curves import Curves, bent, edges_of

# The least number of edges of a full circle: its polygon lacks 2.6 % of the area.
EDGES_OF_A_CIRCLE = 16
Entities = list[tuple[int, int]]  # gmsh's dimensions and tags
Shapes = dict[str, Entities]
Named = tuple[frozenset[str], np.ndarray]


def lacking(radius: float, size: float, circle_edges: int = EDGES_OF_A_CIRCLE) -> float:
    """Share of a circle's area that its polygon lacks at most: sin(a)/a < 1 − a²/6 + a⁴/120 for
    edges that span the angle a."""
    return min(2 * pi / circle_edges, size / radius) ** 2 / 6


@dataclass(frozen=True)
class Prism:
    """The shape ``shape`` of the section from x = ``start`` to ``end`` (mm), filled with ``name``:
    a region, a cavity or OUTSIDE. rounded: radius of its edges, of those along x
    alone where ``along``; in what OCC builds, no extruded mesh has them."""

    name: str
    shape: str
    start: float
    end: float
    rounded: float = 0.0
    along: bool = False


@dataclass(frozen=True)
class Skin:
    """A named part of the outer surface's sides, which stays part of ``outer``, too.

    where: function of y and z (arrays of the middles of edges) that says which sides are in it.
    """

    name: str
    start: float
    end: float
    where: Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Section:
    """Triangles (k, 3) over points (n, 2) at (y, z) in mm; shapes: name -> whether each triangle
    lies in it (k,). curves: edges that are not straight."""

    points: np.ndarray
    triangles: np.ndarray
    shapes: Mapping[str, np.ndarray]
    curves: Curves


@dataclass(frozen=True)
class Prisms:
    """A solid painted prism over prism: where prisms overlap, the later one counts.

    shapes: function that adds plane shapes to an OCC kernel, y and z as its first two coordinates,
    and returns their dimension and tag pairs by name. regions, cavities: which names are solid and
    which are air; a wall between a region and a cavity is in the surface of the cavity's name.
    planes: names for parts of the outside (any axis); what no plane takes is ``outer``.
    circle_edges: the least number of edges of a full circle.
    """

    shapes: Callable[[object], Shapes]
    prisms: tuple[Prism, ...]
    regions: tuple[str, ...]
    cavities: tuple[str, ...] = ()
    planes: tuple[Plane, ...] = ()
    skins: tuple[Skin, ...] = ()
    circle_edges: int = EDGES_OF_A_CIRCLE

    def lines(self, size: float, least: int = 1) -> np.ndarray:
        """Planes of the grid along x, at most ``size`` apart, with at least ``least`` steps from
        where one prism or skin begins or ends to the next such place."""
        ends = [at for part in self.prisms + self.skins for at in (part.start, part.end)]
        breaks = np.unique(np.round(ends, 7))
        pieces = [
            np.linspace(start, end, steps(end - start, size, least) + 1)[1:]
            for start, end in pairwise(breaks)
        ]
        return np.concatenate([breaks[:1], *pieces])

    def section(self, gmsh: ModuleType, size: float, least: int = 1) -> Section:
        """Meshes the section with edges of about ``size`` (mm) in a gmsh model of its own: with
        larger ones, each triangle of which is cut so that ``least`` lie side by side in a wall."""
        gmsh.model.add("section")
        occ = gmsh.model.occ
        shapes = self.shapes(occ)
        everything = [tag for tags in shapes.values() for tag in tags]
        _, origins = occ.fragment(everything[:1], everything[1:])
        occ.synchronize()
        # Intersections leave curves behind that bound nothing.
        loose = [c for c in gmsh.model.getEntities(1) if not len(gmsh.model.getAdjacencies(*c)[0])]
        occ.remove(loose, recursive=True)
        occ.synchronize()
        faces: dict[str, set[int]] = {}
        remaining = iter(origins)
        for name, tags in shapes.items():
            faces[name] = {tag for _ in tags for _, tag in next(remaining)}

        def make() -> None:
            _divide_curves(gmsh, least * size, self.circle_edges)
            gmsh.option.setNumber("Mesh.MeshSizeMax", least * size)
            gmsh.option.setNumber("Mesh.Algorithm", 6)
            gmsh.model.mesh.generate(2)

        repeatable(make, lambda: CarriedMesh(gmsh), lambda kept: kept.put(gmsh))
        section = _read_section(gmsh, faces, least)
        gmsh.model.remove()
        return section

    def mesh(self, gmsh: ModuleType, size: float, least: int = 1) -> None:
        """Puts the mesh and its named groups into a new, discrete gmsh model; see ``lines`` and
        ``section``."""
        section = self.section(gmsh, size, least)
        made = PrismMesh(self, section, self.lines(size, least))
        check_number(made.cells())
        made.add_to(gmsh)

    def divide(self, gmsh: ModuleType) -> None:
        """Adds the solid as it is meshed to the current gmsh model, all parts in named groups. A
        whole, of which the half y >= 0 stays where a plane is y = 0. No cavity is painted over."""
        air = tuple(prism for prism in self.prisms if prism.name in self.cavities)
        solid = tuple(prism for prism in self.prisms if prism.name not in self.cavities)
        solids = replace(self, prisms=solid).build(gmsh)
        rooms = replace(self, prisms=air, regions=self.cavities).build(gmsh)
        if any(plane.axis == 1 and plane.at == 0.0 for plane in self.planes):
            solids, rooms = halves(gmsh, solids), halves(gmsh, rooms)
        divide(gmsh, solids, rooms, self.planes)

    def build(self, gmsh: ModuleType) -> Shapes:
        """Adds the solid to the current gmsh model as OCC volumes; returns them by region."""
        occ = gmsh.model.occ
        shapes = self.shapes(occ)
        solids: Shapes = {name: [] for name in self.regions}
        # One operation with many prisms is much quicker than one for each.
        for name, prisms in groupby(self.prisms, lambda p: p.name if p.name in solids else None):
            tools = [solid for prism in prisms for solid in _extrude(gmsh, shapes, prism)]
            for other in self.regions:
                if solids[other] and other != name:
                    solids[other], _ = occ.cut(solids[other], tools, removeTool=False)
            if name is None:
                occ.remove(tools, recursive=True)
                continue
            solids[name] += tools
            if len(solids[name]) > 1:
                solids[name], _ = occ.fuse(solids[name][:1], solids[name][1:])
        occ.remove([face for faces in shapes.values() for face in faces], recursive=True)
        occ.synchronize()
        return solids


def _extrude(gmsh: ModuleType, shapes: Shapes, prism: Prism) -> Entities:
    """The volume of a prism over a copy of its shape."""
    occ = gmsh.model.occ
    faces = occ.copy(shapes[prism.shape])
    occ.rotate(faces, 0, 0, 0, 1, 1, 1, 2 * pi / 3)  # first two coordinates become y and z
    occ.translate(faces, prism.start, 0, 0)
    made = occ.extrude(faces, prism.end - prism.start, 0, 0)
    solids = [entity for entity in made if entity[0] == 3]
    if not prism.rounded:
        return solids

    def wanted(lower: np.ndarray, upper: np.ndarray) -> bool:
        return not prism.along or upper[0] - lower[0] > (prism.end - prism.start) / 2

    return [tag for one in solids for tag in round_edges(gmsh, one, prism.rounded, wanted)]


def _divide_curves(gmsh: ModuleType, size: float, circle_edges: int) -> None:
    """Sets the number of edges of every curve: at most ``size`` long, and enough on circles."""
    for _, tag in gmsh.model.getEntities(1):
        length = gmsh.model.occ.getMass(1, tag)
        start, end = (values[0] for values in gmsh.model.getParametrizationBounds(1, tag))
        curvature = gmsh.model.getCurvature(1, tag, [(start + end) / 2])[0]
        longest = min(size, 2 * pi / circle_edges / max(curvature, 1e-9))
        gmsh.model.mesh.setTransfiniteCurve(tag, steps(length, longest) + 1)


def _read_section(gmsh: ModuleType, faces: Mapping[str, set[int]], least: int) -> Section:
    cut = Pieces(gmsh, 2, least)
    found = {tag: part for (dimension, tag), part in cut.of.items() if dimension == 2}
    curves = curves_of(gmsh, cut.points, cut.of, 2) if are_curved() else Curves()
    face = np.concatenate([np.full(len(part), tag) for tag, part in found.items()])
    inside = {name: np.isin(face, list(tags)) for name, tags in faces.items()}
    flat = Curves(curves.edges, curves.places[:, :2])
    return Section(cut.points[:, :2], np.vstack(list(found.values())), inside, flat)


class PrismMesh:
    """Prisms over a section between planes of x; see ``Prisms``."""

    def __init__(self, solid: Prisms, section: Section, lines: np.ndarray):
        self.solid, self.section, self.lines = solid, section, lines
        # label (layers, triangles): 0 outside, then the regions, then the cavities
        names = (OUTSIDE, *solid.regions, *solid.cavities)
        self.label = np.zeros((len(lines) - 1, len(section.triangles)), dtype=int)
        for prism in solid.prisms:
            layers = self._layers(prism.start, prism.end)
            self.label[layers, section.shapes[prism.shape]] = names.index(prism.name)

    def _layers(self, start: float, end: float) -> slice:
        first, last = np.searchsorted(self.lines, np.array([start, end]) - SAME_PLANE)
        return slice(int(first), int(last))

    def cells(self) -> int:
        """Number of tetrahedra of all regions."""
        return 3 * int(((0 < self.label) & (self.label <= len(self.solid.regions))).sum())

    def points(self) -> np.ndarray:
        """All points (n, 3), mm, plane by plane, also those that no cell uses."""
        count = len(self.section.points)
        x = np.repeat(self.lines, count)
        return np.column_stack([x, np.tile(self.section.points, (len(self.lines), 1))])

    def middles(self, edges: np.ndarray) -> np.ndarray:
        """Places (k, 3) mm of the middles of edges (k, 2) between those points."""
        count = len(self.section.points)
        level, across = np.divmod(edges, count)
        x = self.lines[level].mean(axis=1)
        ends = self.section.points[across]
        return np.column_stack([x, self.section.curves.middles_of(across, ends)])

    def tetrahedra(self, region: int) -> np.ndarray:
        """Corners (m, 4) of the tetrahedra of a region, turned either way."""
        count = len(self.section.points)
        pieces = [
            prism_tetrahedra(self.section.triangles[row == region + 1], 1, count) + layer * count
            for layer, row in enumerate(self.label)
        ]
        return np.vstack(pieces)

    def triangles(self) -> list[Named]:
        """Triangles (k, 3) of every surface piece with the names of the surfaces it is in."""
        pieces: dict[frozenset[str], list[np.ndarray]] = {}
        for names, triangles in (*self._caps(), *self._sides()):
            if len(triangles):
                pieces.setdefault(names, []).append(triangles)
        ordered = sorted(pieces.items(), key=lambda piece: sorted(piece[0]))
        return [(names, np.vstack(parts)) for names, parts in ordered]

    def _walls(self, below: np.ndarray, above: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Whether there is a solid on one side only (k,), and what is on the other side (k,)."""
        count = len(self.solid.regions)
        solid_below, solid_above = (0 < below) & (below <= count), (0 < above) & (above <= count)
        return solid_below != solid_above, np.where(solid_below, above, below)

    def _cavity_walls(self, wall: np.ndarray, other: np.ndarray) -> Iterator[Named]:
        first = len(self.solid.regions) + 1
        for number, name in enumerate(self.solid.cavities, start=first):
            yield frozenset({name}), wall & (other == number)

    def _caps(self) -> Iterator[Named]:
        """Names and triangles of the faces across x."""
        count, flat = len(self.section.points), np.zeros_like(self.label[:1])
        padded = np.vstack([flat, self.label, flat])
        for level, (below, above) in enumerate(pairwise(padded)):
            triangles = self.section.triangles + level * count
            wall, other = self._walls(below, above)
            for names, members in self._cavity_walls(wall, other):
                yield names, triangles[members]
            free, names = triangles[wall & (other == 0)], frozenset({"outer"})
            for plane in self.solid.planes:
                if plane.axis == 0 and abs(self.lines[level] - plane.at) < SAME_PLANE:
                    names = _names(plane)
            yield names, free

    def _sides(self) -> Iterator[Named]:
        """Names and triangles of the faces along x."""
        edges, left, right = _edges(self.section.triangles)
        middle = self.section.points[edges].mean(axis=1)
        count = len(self.section.points)
        for layer, row in enumerate(self.label):
            wall, other = self._walls(row[left], np.where(right < 0, 0, row[right]))

            def sides(members: np.ndarray, layer: int = layer) -> np.ndarray:
                return prism_sides(edges[members], 1, count) + layer * count

            for names, members in self._cavity_walls(wall, other):
                yield names, sides(members)
            free = wall & (other == 0)
            for plane in self.solid.planes:
                if plane.axis:
                    across = self.section.points[edges][:, :, plane.axis - 1]
                    members = free & (abs(across - plane.at) < SAME_PLANE).all(axis=1)
                    free &= ~members
                    yield _names(plane), sides(members)
            for skin in self.solid.skins:
                layers = self._layers(skin.start, skin.end)
                if layers.start <= layer < layers.stop:
                    members = free & skin.where(*middle.T)
                    free &= ~members
                    yield frozenset({skin.name, "outer"}), sides(members)
            yield frozenset({"outer"}), sides(free)

    def add_to(self, gmsh: ModuleType) -> None:
        """Puts the mesh and its named groups into a new, discrete gmsh model."""
        regions = {name: self.tetrahedra(i) for i, name in enumerate(self.solid.regions)}
        points, edges = self.points(), edges_of(np.vstack(list(regions.values())))
        curves = bent(edges, points, self.middles(edges))
        add_mesh(gmsh, points, regions, self.triangles(), curves)


def _names(plane: Plane) -> frozenset[str]:
    return frozenset({plane.name, "outer"}) if plane.outer else frozenset({plane.name})


def _edges(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Edges (e, 2) of triangles and the one or two triangles that each is in (-1: none)."""
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, number = np.unique(sides, axis=0, return_inverse=True)
    number = number.ravel()
    owner = np.repeat(np.arange(len(triangles)), 3)
    left, right = np.full(len(edges), -1), np.full(len(edges), -1)
    left[number[::-1]] = owner[::-1]  # the first of them stays
    right[number] = owner
    right[right == left] = -1
    return edges, left, right
