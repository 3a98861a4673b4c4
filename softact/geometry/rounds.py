"""Round solids about x without slivers: a polar section, for the prisms over it.

Tubes and bellows have thin walls all around. Here every circle of the section has the same number
of edges, so the triangles of a wall are halves of the rectangles between two circles, and walls may
be as thin as a sleeve. Curved edges have their middles on the circle. Where edges are straight,
corners lie a little outside of it, so that each polygon has the circle's area: volumes, and with
them the thrust of a pressure on the ends, are exact.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import pi, sin, sqrt
from typing import Any, Literal

import numpy as np

from softact.geometry.boxes import Plane
from softact.geometry.curved import are_curved
from softact.geometry.prisms import EDGES_OF_A_CIRCLE, PrismMesh, Prisms, Section, Shapes
from softact.geometry.steps import steps
from softact.mesh.curves import SIDES, Curves, bent

#: A sector whose arc is a parabola through its ends and its middle lacks this part of the area, of
#: the angle a: LACKING a⁴ (sin a/a + 8/3 sin(a/2) (1 − cos(a/2))/a).
LACKING = 1 / 480
Part = Literal["whole", "half", "quarter"]
QUARTERS: dict[Part, int] = {"whole": 4, "half": 2, "quarter": 1}
# Symmetry planes of each part, y = 0 and z = 0, as a layout has them.
SYMMETRY: dict[Part, dict[str, int]] = {
    "whole": {},
    "half": {"symmetry_y": 1},
    "quarter": {"symmetry_y": 1, "symmetry_z": 2},
}


@dataclass(frozen=True)
class RoundSection:
    """Concentric discs in the plane y, z, of which ``part`` (y >= 0, and z >= 0) is meshed.

    discs: name -> radius (mm), ascending; the first is the core. widest: the largest radius (mm)
    to which ``Bent`` takes a circle of it; by default that of the last disc.
    """

    discs: Mapping[str, float]
    part: Part
    widest: float | None = None

    @property
    def share(self) -> float:
        """The part of the whole that is meshed."""
        return QUARTERS[self.part] / 4

    def shapes(self, occ: Any) -> Shapes:
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
        most = self.widest or max(self.discs.values())
        return steps(pi / 2 * most, size, EDGES_OF_A_CIRCLE // 4)

    def widening(self, size: float) -> float:
        """Ratio of the radius of a polygon's corners to that of the circle with the same area; 1
        where edges are curved."""
        angle = pi / 2 / self.edges_of_a_quarter(size)
        return 1.0 if are_curved() else sqrt(angle / sin(angle))

    def lacking(self, size: float) -> float:
        """Share of each circle's area that its quadratic edges lack at most."""
        return 1.1 * LACKING * (pi / 2 / self.edges_of_a_quarter(size)) ** 4

    def triangles(self, size: float, least: int = 1) -> dict[str, int]:
        """How many triangles of ``mesh`` lie in each disc, before there is one."""
        n, number = self.edges_of_a_quarter(size), 0
        found: dict[str, int] = {}
        for disc, rings in self._rings(size, least).items():
            full = rings if found else rings - n  # the first n rings of the core have fewer edges
            number += QUARTERS[self.part] * (2 * n * full + (0 if found else n**2))
            found[disc] = number
        return found

    def mesh(self, size: float, least: int = 1) -> Section:
        """Triangles with edges of at most ``size`` around, and at least ``least`` of them from one
        circle of ``discs`` to the next."""
        n, quarters = self.edges_of_a_quarter(size), QUARTERS[self.part]
        radii, names = self._circles(size, least)
        wider = self.widening(size)
        rings = [_Ring(min(k, n), quarters) for k in range(len(radii))]
        start = -pi / 2 if self.part == "half" else 0.0
        rows = zip(radii, rings, strict=True)
        points = np.vstack([radius * wider * ring.directions(start) for radius, ring in rows])
        first = np.cumsum([0, *(ring.count for ring in rings)])
        pieces = [
            rings[k - 1].triangles_to(rings[k], int(first[k - 1]), int(first[k]))
            for k in range(1, len(radii))
        ]
        disc = np.repeat(names[1:], [len(piece) for piece in pieces])
        shapes = {name: disc <= number for number, name in enumerate(self.discs)}
        triangles = np.vstack(pieces)
        return Section(points, triangles, shapes, self._curves(points, triangles, first[n]))

    def _curves(self, points: np.ndarray, triangles: np.ndarray, first: int) -> Curves:
        """Edges between circles, from the one with the points from ``first`` on: their middles lie
        in the middle of the angle and of the radius. Further inside all are straight."""
        edges = np.unique(np.sort(triangles[:, SIDES].reshape(-1, 2), axis=1), axis=0)
        edges = edges[edges[:, 0] >= first]
        return bent(edges, points, in_the_middle(points[edges]))

    def _rings(self, size: float, least: int) -> dict[str, int]:
        """Number of rings of triangles of each disc outside of the one before. The core has a ring
        for each edge of a quarter, so that its triangles are as good as they get."""
        inner = 0.0
        found: dict[str, int] = {}
        for name, radius in self.discs.items():
            core = self.edges_of_a_quarter(size) if not found else 1
            found[name] = steps(radius - inner, size, max(core, least))
            inner = radius
        return found

    def _circles(self, size: float, least: int) -> tuple[np.ndarray, list[int]]:
        """Radii of all circles, the middle first, and the number of the disc that each is in."""
        radii, names = [0.0], [0]
        for number, (name, rings) in enumerate(self._rings(size, least).items()):
            radii += np.linspace(radii[-1], self.discs[name], rings + 1)[1:].tolist()
            names += [number] * rings
        return np.array(radii), names


@dataclass(frozen=True)
class _Ring:
    """Points on a circle, ``edges`` to each of its quarters; one point where there are none."""

    edges: int
    quarters: int

    @property
    def closed(self) -> bool:
        """Whether it goes all the way round."""
        return self.quarters == 4

    @property
    def count(self) -> int:
        """Number of its points."""
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


def in_the_middle(ends: np.ndarray) -> np.ndarray:
    """Points (k, 2) between those of pairs (k, 2, 2), in the middle of their angle and of their
    radius about the origin."""
    radius = np.linalg.norm(ends, axis=-1)
    towards = (ends / radius[..., None]).sum(axis=1)
    return radius.mean(axis=1)[:, None] * towards / np.linalg.norm(towards, axis=1)[:, None]


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
        return self._bent(super().points())

    def middles(self, edges: np.ndarray) -> np.ndarray:
        """See ``PrismMesh``."""
        return self._bent(super().middles(edges))

    def _bent(self, points: np.ndarray) -> np.ndarray:
        radius = np.linalg.norm(points[:, 1:], axis=1)
        x, there = self._bend(points[:, 0], radius / self._wider)
        factor = self._wider * there / np.where(radius > 0.0, radius, 1.0)
        return np.column_stack([x, points[:, 1:] * factor[:, None]])
