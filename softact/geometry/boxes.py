"""Solids made of boxes: an exact mesh without slivers, and the same solid for CAD.

Most moulded actuators are boxes with boxes cut out, and their walls are thin. An unstructured
mesh of them has slivers in the walls; here every box edge becomes a plane of one grid, the cells
of the grid that lie in the solid are each split into five tetrahedra, and the worst tetrahedron is
as good as the flattest cell allows. The split (one tetrahedron on every second corner of a cell,
four at the other corners) fits between neighbours, since these corners alternate over the grid.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from types import ModuleType

import numpy as np

from softact.geometry.fillets import divide, rounded_box
from softact.geometry.gmsh_groups import add_mesh
from softact.geometry.steps import steps
from softact.geometry.walls import Wall

# Two planes nearer than this (mm) are one plane.
SAME_PLANE = 1e-7
CORNERS = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
OUTSIDE = ""
#: Steps of a grid between one break and the next, along x, y and z.
Counts = tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class Box:
    """A box from ``lower`` to ``upper`` (mm) filled with ``name``: a region, a cavity or OUTSIDE.

    A box without extent in one direction is a sheet: a named surface inside the solid. rounded:
    radius of the edges ``along`` these axes, but for those in the planes ``sharp`` (axis, at); in
    what OCC builds, no grid has them.
    """

    name: str
    lower: tuple[float, float, float]
    upper: tuple[float, float, float]
    rounded: float = 0.0
    along: tuple[int, ...] = (0, 1, 2)
    sharp: tuple[tuple[int, float], ...] = ()


@dataclass(frozen=True)
class Plane:
    """The part of the outside that lies in the plane ``axis`` = ``at`` is named ``name``.

    outer: whether it is part of the surface ``outer``, too.
    """

    name: str
    axis: int
    at: float
    outer: bool = False


@dataclass(frozen=True)
class Boxes:
    """A solid painted box over box: where boxes overlap, the later one counts.

    regions, cavities: which of the names are solid and which are air inside; a wall between a
        region and a cavity is in the surface of the cavity's name.
    sheets: surfaces inside the solid.
    planes: names for parts of the outside; what no plane takes is ``outer``.
    before: steps along x of a longer mesh before this part of it, which is split as there.
    lift: where the points (n, 3) of a mesh go, where parts of the solid are taller than others.
    """

    boxes: tuple[Box, ...]
    regions: tuple[str, ...]
    cavities: tuple[str, ...] = ()
    sheets: tuple[Box, ...] = ()
    planes: tuple[Plane, ...] = ()
    before: int = 0
    lift: Callable[[np.ndarray], np.ndarray] | None = None

    def breaks(self, axis: int) -> np.ndarray:
        """Where boxes and sheets begin and end along an axis: planes that every mesh has. What
        lies alike on both sides of 0 is divided there, as its half is."""
        everything = self.boxes + self.sheets
        breaks = np.sort([at for box in everything for at in (box.lower[axis], box.upper[axis])])
        breaks = breaks[np.concatenate([[True], np.diff(breaks) > SAME_PLANE])]
        middle = len(breaks) // 2
        if len(breaks) % 2 == 0 and abs(breaks[middle - 1] + breaks[middle]) < SAME_PLANE:
            breaks = np.insert(breaks, middle, 0.0)
        return breaks

    def counts(self, size: float, cavity_size: float, least: int = 1) -> Counts:
        """Steps between the breaks: at most ``size`` long, at most ``cavity_size`` where a cavity
        lies there, and at least ``least`` of them."""
        return tuple(
            tuple(
                steps(end - start, cavity_size if self._hollow(axis, start, end) else size, least)
                for start, end in pairwise(self.breaks(axis))
            )
            for axis in range(3)
        )

    def _hollow(self, axis: int, start: float, end: float) -> bool:
        middle = (start + end) / 2
        return any(
            box.name in self.cavities and box.lower[axis] < middle < box.upper[axis]
            for box in self.boxes
        )

    def walls(
        self, counts: Counts, places: Mapping[str, tuple[int, float, float]]
    ) -> tuple[Wall, ...]:
        """Walls in a mesh with these counts. places: name -> axis across it, where it begins on
        that axis, and thickness (mm)."""
        found = []
        for name, (axis, start, thickness) in places.items():
            breaks = self.breaks(axis)
            inside = breaks[:-1] > start - SAME_PLANE
            inside &= breaks[1:] < start + thickness + SAME_PLANE
            elements = int(np.array(counts[axis])[inside].sum())
            found.append(Wall(name, thickness, elements))
        return tuple(found)

    def cells(self, counts: Counts) -> int:
        """Number of tetrahedra of all regions in a mesh with these counts."""
        label = self._labels([self.breaks(axis) for axis in range(3)])
        solid = (0 < label) & (label <= len(self.regions))
        x, y, z = (np.array(numbers, dtype=float) for numbers in counts)
        return 5 * int(np.einsum("ijk,i,j,k->", solid, x, y, z))

    def mesh(self, size: float, cavity_size: float, least: int = 1) -> "BoxMesh":
        """Tetrahedra of the solid with edges of about ``size`` (mm) along the axes; see
        ``counts``."""
        return self.grid(self.counts(size, cavity_size, least))

    def grid(self, counts: Counts) -> "BoxMesh":
        """The same with so many steps between the breaks: a solid whose lengths have changed a
        little keeps its cells with the counts that it had before."""
        lines = []
        for axis, numbers in enumerate(counts):
            breaks = self.breaks(axis)
            pieces = [
                np.linspace(start, end, number + 1)[1:]
                for (start, end), number in zip(pairwise(breaks), numbers, strict=True)
            ]
            lines.append(np.concatenate([breaks[:1], *pieces]))
        return BoxMesh(self, lines, self._labels(lines))

    def _labels(self, lines: list[np.ndarray]) -> np.ndarray:
        """What fills each cell of a grid: see ``BoxMesh``."""
        names = (OUTSIDE, *self.regions, *self.cavities)
        label = np.zeros([len(line) - 1 for line in lines], dtype=int)
        for box in self.boxes:
            label[_cells_within(lines, box)] = names.index(box.name)
        return label

    def build(self, gmsh: ModuleType) -> dict[str, list[tuple[int, int]]]:
        """Adds the solid to the current gmsh model as OCC volumes; returns them by region."""
        occ = gmsh.model.occ
        solids: dict[str, list[tuple[int, int]]] = {name: [] for name in self.regions}
        pending: list[tuple[int, int]] = []

        def cut_pending() -> None:
            # One cut by many boxes is much quicker than one cut each.
            for name in self.regions:
                if pending and solids[name]:
                    solids[name], _ = occ.cut(solids[name], pending, removeTool=False)
            if pending:
                occ.remove(pending, recursive=True)
            pending.clear()

        for box in self.boxes:
            solid = rounded_box(gmsh, box)
            if box.name in self.regions:
                pending.extend(occ.copy(solid))
                cut_pending()
                solids[box.name].extend(solid)
            else:
                pending.extend(solid)
        cut_pending()
        for name, parts in solids.items():
            if len(parts) > 1:
                solids[name], _ = occ.fuse(parts[:1], parts[1:])
        occ.synchronize()
        return solids

    def divide(self, gmsh: ModuleType) -> None:
        """Adds the solid as it is meshed to the current gmsh model: divided at its sheets, all
        parts in named groups. No cavity is painted over."""
        solid = tuple(box for box in self.boxes if box.name not in self.cavities)
        solids = replace(self, boxes=solid).build(gmsh)
        air = {name: self._air(gmsh, name) for name in self.cavities}
        divide(gmsh, solids, air, self.planes, self.sheets)

    def _air(self, gmsh: ModuleType, cavity: str) -> list[tuple[int, int]]:
        """The room of a cavity as OCC volumes."""
        rooms = [tag for b in self.boxes if b.name == cavity for tag in rounded_box(gmsh, b)]
        return rooms if len(rooms) == 1 else gmsh.model.occ.fuse(rooms[:1], rooms[1:])[0]


def _cells_within(lines: list[np.ndarray], box: Box) -> tuple[slice, ...]:
    def index(axis: int, at: float) -> int:
        return int(np.searchsorted(lines[axis], at - SAME_PLANE))

    return tuple(slice(index(a, box.lower[a]), index(a, box.upper[a])) for a in range(3))


@dataclass
class BoxMesh:
    """Grid of a box solid. ``label``: per cell, 0 outside, then the regions, then the cavities."""

    solid: Boxes
    lines: list[np.ndarray]
    label: np.ndarray

    def __post_init__(self) -> None:
        # Counted from the origin, so that a half and a whole are split alike.
        self._odd = sum(int(np.argmin(abs(line))) for line in self.lines) % 2
        self._odd = (self._odd + self.solid.before) % 2

    def points(self) -> np.ndarray:
        """All points of the grid (n, 3), mm, also those that no cell uses."""
        points = np.stack(np.meshgrid(*self.lines, indexing="ij"), axis=-1).reshape(-1, 3)
        return points if self.solid.lift is None else self.solid.lift(points)

    def tetrahedra(self, region: int) -> np.ndarray:
        """Corners (m, 4) of the tetrahedra of a region, numbered as ``points``, turned
        either way."""
        cells = np.argwhere(self.label == region + 1)
        parity = (cells.sum(axis=1) + self._odd) % 2
        pieces = []
        for odd in (0, 1):
            start = cells[parity == odd][:, None]
            inner = CORNERS.sum(axis=1) % 2 == odd
            pieces.append(start + CORNERS[inner])
            for corner in CORNERS[~inner]:
                neighbours = corner ^ np.eye(3, dtype=int)
                pieces.append(start + np.vstack([corner, neighbours]))
        return self._number(np.concatenate(pieces))

    def triangles(self) -> list[tuple[frozenset[str], np.ndarray]]:
        """Triangles (k, 3) of every surface piece with the names of the surfaces it is in."""
        pieces: dict[frozenset[str], list[np.ndarray]] = {}
        for axis in range(3):
            padded = np.pad(self.label, [(int(a == axis), int(a == axis)) for a in range(3)])
            below = np.delete(padded, -1, axis=axis)
            above = np.delete(padded, 0, axis=axis)
            for names, faces in self._faces(axis, below, above):
                if len(faces):
                    pieces.setdefault(names, []).append(self._split_faces(axis, faces))
        ordered = sorted(pieces.items(), key=lambda piece: sorted(piece[0]))
        return [(names, np.vstack(parts)) for names, parts in ordered]

    def _faces(
        self, axis: int, below: np.ndarray, above: np.ndarray
    ) -> Iterator[tuple[frozenset[str], np.ndarray]]:
        """Pairs of surface names and (k, 3) grid indices of faces normal to ``axis``."""
        count = len(self.solid.regions)
        solid_below, solid_above = (0 < below) & (below <= count), (0 < above) & (above <= count)
        wall = solid_below != solid_above
        other = np.where(solid_below, above, below)
        for number, name in enumerate(self.solid.cavities):
            yield frozenset({name}), np.argwhere(wall & (other == count + 1 + number))
        free = wall & (other == 0)
        for plane in self.solid.planes:
            if plane.axis == axis:
                near = abs(self.lines[axis] - plane.at) < SAME_PLANE
                on_plane = free & near.reshape([-1 if a == axis else 1 for a in range(3)])
                free &= ~on_plane
                names = {plane.name, "outer"} if plane.outer else {plane.name}
                yield frozenset(names), np.argwhere(on_plane)
        yield frozenset({"outer"}), np.argwhere(free)
        for sheet in self.solid.sheets:
            if sheet.lower[axis] == sheet.upper[axis]:
                place = list(_cells_within(self.lines, sheet))
                place[axis] = slice(place[axis].start, place[axis].start + 1)
                inside = np.zeros(wall.shape, dtype=bool)
                inside[tuple(place)] = True
                faces = np.argwhere(inside & solid_below & solid_above)
                yield frozenset({sheet.name}), faces

    def _split_faces(self, axis: int, faces: np.ndarray) -> np.ndarray:
        """Two triangles for each face, cut from inner corner to inner corner of its cell."""
        across = [a for a in range(3) if a != axis]
        square = np.zeros((4, 3), dtype=int)
        square[:, across] = [[0, 0], [1, 0], [1, 1], [0, 1]]
        turned = (faces.sum(axis=1) + self._odd) % 2
        corners = self._number(faces[:, None] + square)
        corners = np.where(turned[:, None] == 1, np.roll(corners, -1, axis=1), corners)
        return np.vstack([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])

    def _number(self, grid: np.ndarray) -> np.ndarray:
        shape = [len(line) for line in self.lines]
        return np.ravel_multi_index(tuple(np.moveaxis(grid, -1, 0)), shape)

    def add_to(self, gmsh: ModuleType) -> None:
        """Puts the mesh and its named groups into a new, discrete gmsh model."""
        regions = {name: self.tetrahedra(i) for i, name in enumerate(self.solid.regions)}
        add_mesh(gmsh, self.points(), regions, self.triangles())
