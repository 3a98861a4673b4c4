"""A row of flat pouches that stand on an inextensible strip, press on each other and bend it.

Nguyen and Zhang 2020, Sci. Rep. 10:9638, Fig. 3c.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import Layout
from softact.geometry.chains import Chain, OneModule
from softact.geometry.cutting_pattern import Pattern, rectangle
from softact.geometry.flat_sheets import BetweenLines, Lines, SheetGeometry, sides
from softact.mesh.sheets import SheetMesh
from softact.units import Length


class WovenBending(SheetGeometry, Chain):
    """Pouches of two equal rectangles that stand on a strip, each sewn to it over ``seam`` along x.

    As it lies, the two walls of a pouch stand apart by the width of its floor, which falls to
    nothing at its top and at its sides. The first floor is the clamp, the last the tip. Half is
    meshed, y ≥ 0. A module is from the middle of a pouch to that of the next.
    """

    type: Literal["woven_bending"] = "woven_bending"
    n: int = Field(13, ge=3, le=100, description="number of pouches")
    w_a: Length = Field(41.0, description="width of a pouch across the actuator (active width)")
    h_a: Length = Field(30.0, description="height of a pouch above the strip (active height)")
    pitch: Length = Field(16.0, description="distance of the pouches along the strip")
    seam: Length = Field(6.0, description="width of the strip to which a pouch is sewn")
    mesh_size: Length = Field(
        8.0,
        description="longest side of the triangles along the axes, of the strip's in the middle",
    )
    between_lines: BetweenLines = None
    module_alone: OneModule = None

    counted: ClassVar[tuple[str, str] | None] = ("n", "pouch")

    @property
    def _floors(self) -> tuple[str, ...]:
        """Names of the sheets between the walls of a pouch."""
        return ("floors",) if self.alone else ("clamp", "floors", "tip")

    def faults(self) -> Iterator[tuple[str, str]]:
        yield from super().faults()
        if self.seam >= self.pitch:
            yield (
                "seam",
                f"{self.seam:g} mm is no less than the pitch of {self.pitch:g} mm: the pouches "
                "would stand in each other",
            )

    def layout(self) -> Layout:
        return Layout(
            regions=(),
            surfaces=(),
            sheets=("fore", "aft", *self._floors, "strip"),
            curves=(*self.ends, "middle", "seams") if self.alone else ("middle", "seams"),
            cavities={"air": ("fore", "aft", *self._floors)},
            symmetry={"middle": 1},
            bending_axis=(0.0, 1.0, 0.0),
            length=self.pitch if self.alone else (self.n - 1) * self.pitch,
            clamp=self.ends[0],
            tip=self.ends[1],
            repeats=self.repeats,
        )

    def volumes(self) -> dict[str, float]:
        half, floor = self.w_a / 2, self.seam * self.w_a / 4
        # A wall is x = s/2 (1 − y/half) (1 − z/h): by Gauss's rule.
        at, weight = np.polynomial.legendre.leggauss(8)
        u, weights = (at + 1) / 2, weight / 2
        by_y, by_z = np.meshgrid((1 - u) / half, (1 - u) / self.h_a)
        stretch = np.sqrt(1 + (self.seam / 2) ** 2 * (by_y**2 + by_z**2))
        wall = half * self.h_a * float(weights @ stretch @ weights)
        pouches, gaps = (1, 1) if self.alone else (self.n, self.n - 1)
        floors = {"clamp": 1, "floors": pouches - 2, "tip": 1}
        return {
            "fore": pouches * wall,
            "aft": pouches * wall,
            **({"floors": floor} if self.alone else {n: k * floor for n, k in floors.items()}),
            "strip": gaps * (self.pitch * half - floor),
            "air": pouches * self.seam * half * self.h_a / 4,
        }

    def sheet_mesh(self) -> SheetMesh:
        """Each pouch is a grid of its two walls, from floor to top; then floors and strip."""
        half = self.w_a / 2
        y, z = self.divided([0.0, half]), self.divided([0.0, self.h_a])
        sewn = _Sewn(Lines(y, z), self.seam / 2)
        if self.alone:
            self._add_module(sewn)
        else:
            self._add_row(sewn)
        corners, elements = sewn.points.whole(), np.vstack(sewn.triangles)
        edges = sides(elements)
        ends = corners[edges]
        lowest = (ends[:, :, 2] == 0).all(axis=1)
        members = {name: np.concatenate(numbers) for name, numbers in sewn.parts.items()}
        walls = sides(np.vstack([elements[members[n]] for n in ("fore", "aft")]))
        key = len(corners)
        of_walls = np.isin(edges[:, 0] * key + edges[:, 1], walls[:, 0] * key + walls[:, 1])
        outer = (ends[:, :, 1] == half).all(axis=1) | (ends[:, :, 2] == self.h_a).all(axis=1)
        seams = edges[of_walls & (lowest | outer)]
        curves = {"middle": edges[(ends[:, :, 1] == 0).all(axis=1)], "seams": seams}
        for name, place in zip(self.ends, (0.0, self.pitch), strict=True) if self.alone else ():
            curves[name] = edges[(ends[:, :, 0] == place).all(axis=1)]
        flat = (*self._floors, "strip")
        return SheetMesh(corners, elements, members, curves, hinges=seams, continuous=flat)

    def _add_row(self, sewn: "_Sewn") -> None:
        """All pouches, then the strip between them."""
        borders = []
        for k in range(self.n):
            fore, aft = (sewn.wall(k * self.pitch, name) for name in ("fore", "aft"))
            name = "clamp" if k == 0 else "tip" if k == self.n - 1 else "floors"
            sewn.between(name, aft, fore, self.steps(self.seam))
            borders.append((aft, fore))
        for (_, left), (right, _) in pairwise(borders):
            sewn.between("strip", left, right, self.steps(self.pitch - self.seam))

    def _add_module(self, sewn: "_Sewn") -> None:
        """The second half of a pouch, the strip, and the first half of the next pouch."""
        fore, aft = sewn.wall(0.0, "fore"), sewn.wall(self.pitch, "aft")
        half = -(-self.steps(self.seam) // 2)
        sewn.between("floors", sewn.line(0.0), fore, half)
        sewn.between("floors", aft, sewn.line(self.pitch), half)
        sewn.between("strip", fore, aft, self.steps(self.pitch - self.seam))

    def pattern(self) -> Pattern:
        """Two rectangles for each pouch in two rows, and the strip below them with its seams."""
        cut, seam, apart = [], [], 1.1
        for k in range(2 * self.n):
            x, y = (k // 2) * self.w_a * apart, (k % 2) * self.h_a * apart
            rim = rectangle((x, y), self.w_a, self.h_a)
            cut += rim
            seam += rim
        length = (self.n - 1) * self.pitch + self.seam
        middle, below = (self.n - 1) * self.pitch / 2, -apart * (self.w_a + self.h_a) / 2
        cut += rectangle((middle, below), length, self.w_a)
        for k in range(self.n):
            seam += rectangle((k * self.pitch, below), self.seam, self.w_a)
        return Pattern(tuple(cut), tuple(seam), pieces=1)


class _Points:
    """Points that are added grid by grid; those at the same place are one."""

    def __init__(self) -> None:
        self._places: list[np.ndarray] = []
        self._known: dict[tuple, int] = {}

    def add(self, places: np.ndarray) -> np.ndarray:
        """Their numbers."""
        numbers = []
        for place in places:
            key = tuple(np.round(place, 9) + 0.0)
            if key not in self._known:
                self._known[key] = len(self._places)
                self._places.append(place)
            numbers.append(self._known[key])
        return np.array(numbers)

    def rows(self, first: np.ndarray, last: np.ndarray, steps: int) -> list[np.ndarray]:
        """Rows of numbers (k,) from one row to another, with those added that lie between."""
        start, end = self.whole()[first], self.whole()[last]
        shares = np.arange(1, steps) / steps
        return [first, *(self.add((1 - s) * start + s * end) for s in shares), last]

    def whole(self) -> np.ndarray:
        """All places (n, 3)."""
        return np.array(self._places)


class _Sewn:
    """Walls of pouches on a strip and what is between them. points: of all; triangles: arrays of
    them; parts: name -> arrays of their numbers.

    lines: of a wall, along y and z. rise: how far its foot is from its top, mm.
    """

    def __init__(self, lines: Lines, rise: float):
        self.points = _Points()
        self.triangles: list[np.ndarray] = []
        self.parts: dict[str, list[np.ndarray]] = {}
        self._lines, self._flat = lines, lines.points()
        of_width, of_height = (self._flat[:, c] / self._flat[:, c].max() for c in range(2))
        self._wide = rise * (1 - of_width) * (1 - of_height)
        diagonals = lines.alternating()
        diagonals[-1, -1] = False  # at the corner of two seams it ends there, or would weld them
        self._grid = lines.triangles(diagonals=diagonals)

    def _add(self, name: str, elements: np.ndarray) -> None:
        first = sum(map(len, self.triangles))
        self.parts.setdefault(name, []).append(first + np.arange(len(elements)))
        self.triangles.append(elements)

    def wall(self, place: float, name: str) -> np.ndarray:
        """Add the wall ``fore`` or ``aft`` of the pouch at a place; numbers (k,) of its foot."""
        sign = 1 if name == "fore" else -1
        corners = np.column_stack([place + sign * self._wide, self._flat[:, :2]])
        number = self.points.add(corners)
        self._add(name, number[self._grid][:, ::sign])
        return number.reshape(len(self._lines.x), len(self._lines.y))[:, 0]

    def line(self, place: float) -> np.ndarray:
        """Numbers (k,) of a line of points across the strip."""
        y = self._lines.x
        return self.points.add(np.column_stack([np.full_like(y, place), y, np.zeros_like(y)]))

    def between(self, name: str, first: np.ndarray, last: np.ndarray, steps: int) -> None:
        """Add a flat sheet from one row of points to another that is ahead of it; the normals of
        the strip are up, those of floors down."""
        turn = -1 if name == "strip" else 1
        for one, other in pairwise(self.points.rows(first, last, steps)):
            self._add(name, _between(other, one)[:, ::turn])


def _between(fore: np.ndarray, aft: np.ndarray) -> np.ndarray:
    """Triangles between two rows of nodes along y, which may meet at their end; normals down where
    ``fore`` has the larger x."""
    first = np.column_stack([fore[:-1], aft[:-1], aft[1:]])
    second = np.column_stack([fore[:-1], aft[1:], fore[1:]])
    return np.vstack([first, second[aft[1:] != fore[1:]]])


if __name__ == "__main__":
    from softact.geometry.base import main

    main(WovenBending)
