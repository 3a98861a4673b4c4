"""Round solids about x without slivers: a polar section, for the prisms over it.

Tubes and bellows have thin walls all around. Here every circle of the section has the same number
of edges, so the triangles of a wall are halves of the rectangles between two circles, and walls may
be as thin as a sleeve. Corners lie a little outside of their circle, so that each polygon has the
circle's area: volumes, and with them the thrust of a pressure on the ends, are exact.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil, pi, sin, sqrt
from typing import Literal

import numpy as np

from softact.boxes import Plane
from softact.prisms import EDGES_OF_A_CIRCLE, PrismMesh, Prisms, Section, Shapes

Part = Literal["whole", "half", "quarter"]
QUARTERS: dict[Part, int] = {"whole": 4, "half": 2, "quarter": 1}
# Symmetry planes of each part, y = 0 and z = 0, as a layout has them.
SYMMETRY: dict[Part, dict[str, int]] = {
    "whole": {},
    "half": {"symmetry_y": 1},
    "quarter": {"symmetry_y": 1, "symmetry_z": 2},
}


def corner_radius(radius: float, size: float, arc: float = 2 * pi) -> float:
    """Radius of the corners of a polygon with a circle's area, where ``Prisms`` divides ``arc``
    (radians) of it into equal edges of about ``size`` (mm)."""
    corners, angle = radius, 0.0
    while True:
        longest = min(size / corners, 2 * pi / EDGES_OF_A_CIRCLE)
        next_angle = arc / max(1, ceil(arc / longest - 1e-6))
        if next_angle == angle:
            return corners
        angle = next_angle
        corners = radius * sqrt(angle / sin(angle))


@dataclass(frozen=True)
class RoundSection:
    """Concentric discs in the plane y, z, of which ``part`` (y >= 0, and z >= 0) is meshed.

    discs: name -> radius (mm), ascending; the first is the core.
    """

    discs: Mapping[str, float]
    part: Part

    @property
    def share(self) -> float:
        """The part of the whole that is meshed."""
        return QUARTERS[self.part] / 4

    def shapes(self, occ) -> Shapes:
        """The discs as OCC faces, cut to the part; see ``Prisms.shapes``."""
        size = 2 * max(self.discs.values())
        left = -size if self.part == "whole" else 0.0
        low = 0.0 if self.part == "quarter" else -size
        shapes: Shapes = {}
        for name, radius in self.discs.items():
            disc = [(2, occ.addDisk(0, 0, 0, radius, radius))]
            if self.part != "whole":
                within = [(2, occ.addRectangle(left, low, 0, size - left, size - low))]
                disc, _ = occ.intersect(disc, within)
            shapes[name] = disc
        return shapes

    def edges_of_a_quarter(self, size: float) -> int:
        """Edges of a quarter of each circle, at most ``size`` (mm) long on the largest."""
        most = max(self.discs.values())
        return max(EDGES_OF_A_CIRCLE // 4, ceil(pi / 2 * most / size - 1e-9))

    def widening(self, size: float) -> float:
        """Radius of a polygon's corners by that of the circle with the same area."""
        angle = pi / 2 / self.edges_of_a_quarter(size)
        return sqrt(angle / sin(angle))

    def mesh(self, size: float) -> Section:
        """Triangles with edges of about ``size``; each disc has its own rings of them."""
        n, quarters = self.edges_of_a_quarter(size), QUARTERS[self.part]
        radii, names = self._circles(n, size)
        wider = self.widening(size)
        rings = [_Ring(min(k, n), quarters) for k in range(len(radii))]
        start = -pi / 2 if self.part == "half" else 0.0
        rows = zip(radii, rings, strict=True)
        points = np.vstack([radius * wider * ring.directions(start) for radius, ring in rows])
        first = np.cumsum([0, *(ring.count for ring in rings)])
        pieces, disc = [], []
        for k in range(1, len(radii)):
            piece = rings[k - 1].triangles_to(rings[k], first[k - 1], first[k])
            pieces.append(piece)
            disc.append(np.full(len(piece), names[k]))
        disc = np.concatenate(disc)
        shapes = {name: disc <= number for number, name in enumerate(self.discs)}
        return Section(points, np.vstack(pieces), shapes)

    def _circles(self, n: int, size: float) -> tuple[list[float], list[int]]:
        """Radii of all circles, the middle first, and the number of the disc that each is in."""
        radii, names, inner = [0.0], [0], 0.0
        for number, radius in enumerate(self.discs.values()):
            count = n if number == 0 else max(1, ceil((radius - inner) / size - 1e-9))
            radii += [inner + (radius - inner) * (i + 1) / count for i in range(count)]
            names += [number] * count
            inner = radius
        return radii, names


@dataclass(frozen=True)
class _Ring:
    """Points on a circle, ``edges`` to each of its quarters; one point where there are none."""

    edges: int
    quarters: int

    @property
    def closed(self) -> bool:
        return self.quarters == 4

    @property
    def count(self) -> int:
        return self.edges * self.quarters + (0 if self.closed and self.edges else 1)

    def directions(self, start: float) -> np.ndarray:
        """Unit vectors (count, 2) from the middle, from the angle ``start`` on."""
        angles = start + pi / 2 * np.arange(self.count) / max(self.edges, 1)
        return np.column_stack([np.cos(angles), np.sin(angles)])

    def number(self, quarter: int, steps: np.ndarray) -> np.ndarray:
        """Numbers of the points some steps from the beginning of a quarter."""
        place = quarter * self.edges + steps
        return place % self.count if self.closed else place

    def triangles_to(self, outer: "_Ring", here: int, there: int) -> np.ndarray:
        """Triangles (k, 3) between this ring, whose points count from ``here``, and the next."""
        pieces = []
        for quarter in range(self.quarters):
            a = here + self.number(quarter, np.arange(self.edges + 1))
            b = there + outer.number(quarter, np.arange(outer.edges + 1))
            if self.edges == outer.edges:
                pieces.append(np.column_stack([a[:-1], b[:-1], b[1:]]))
                pieces.append(np.column_stack([a[:-1], b[1:], a[1:]]))
            else:  # one edge more outside than inside: they point out and in by turns
                pieces.append(np.column_stack([a, b[:-1], b[1:]]))
                pieces.append(np.column_stack([a[:-1], b[1:-1], a[1:]]))
        return np.vstack(pieces)


def ends_and_planes(length: float, part: Part) -> tuple[Plane, ...]:
    """The clamp at x = 0, the tip at ``length`` (mm), and the part's symmetry planes."""
    planes = [Plane(name, axis, 0.0) for name, axis in SYMMETRY[part].items()]
    return (Plane("clamp", 0, 0.0), Plane("tip", 0, length), *planes)


class Bent(PrismMesh):
    """A straight round solid whose points are taken to other places along the axis and the radius.

    bend: function of x and the radius (n,) of the straight solid's points, mm, to those that they
    have; wider: see ``RoundSection.widening``.
    """

    def __init__(
        self,
        solid: Prisms,
        section: Section,
        lines: np.ndarray,
        wider: float,
        bend: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]],
    ):
        super().__init__(solid, section, lines)
        self._wider, self._bend = wider, bend

    def points(self) -> np.ndarray:
        """See ``PrismMesh``."""
        points = super().points()
        radius = np.linalg.norm(points[:, 1:], axis=1)
        x, there = self._bend(points[:, 0], radius / self._wider)
        factor = self._wider * there / np.where(radius > 0.0, radius, 1.0)
        return np.column_stack([x, points[:, 1:] * factor[:, None]])
