"""A row of flat pouches that stand on an inextensible strip, press on each other and bend it.

Nguyen and Zhang 2020, Sci. Rep. 10:9638, Fig. 3c.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import Layout
from softact.geometry.cutting_pattern import Pattern, rectangle
from softact.geometry.flat_sheets import BetweenLines, Lines, SheetGeometry, sides
from softact.mesh.sheets import SheetMesh
from softact.units import Length


class WovenBending(SheetGeometry):
    """Pouches of two equal rectangles that stand on a strip, each sewn to it over ``seam`` along x.

    As it lies, the two walls of a pouch stand apart by the width of its floor, which falls to
    nothing at its top and at its sides. The first floor is the clamp, the last the tip. Half is
    meshed, y ≥ 0.
    """

    why_no_module: ClassVar[str] = (
        ": its pouches bend it by pressing on each other, and a module sees no contact"
    )

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

    def faults(self) -> Iterator[tuple[str, str]]:
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
            sheets=("fore", "aft", "clamp", "floors", "tip", "strip"),
            curves=("middle", "seams"),
            cavities={"air": ("fore", "aft", "clamp", "floors", "tip")},
            symmetry={"middle": 1},
            bending_axis=(0.0, 1.0, 0.0),
            length=(self.n - 1) * self.pitch,
        )

    def volumes(self) -> dict[str, float]:
        half, floor = self.w_a / 2, self.seam * self.w_a / 4
        # A wall is x = s/2 (1 − y/half) (1 − z/h): by Gauss's rule.
        at, weight = np.polynomial.legendre.leggauss(8)
        u, weights = (at + 1) / 2, weight / 2
        by_y, by_z = np.meshgrid((1 - u) / half, (1 - u) / self.h_a)
        stretch = np.sqrt(1 + (self.seam / 2) ** 2 * (by_y**2 + by_z**2))
        wall = half * self.h_a * float(weights @ stretch @ weights)
        total = (self.n - 1) * self.pitch * half
        return {
            "fore": self.n * wall,
            "aft": self.n * wall,
            "clamp": floor,
            "floors": (self.n - 2) * floor,
            "tip": floor,
            "strip": total - (self.n - 1) * floor,
            "air": self.n * self.seam * half * self.h_a / 4,
        }

    def sheet_mesh(self) -> SheetMesh:
        """Each pouch is a grid of its two walls, from floor to top; then floors and strip."""
        half = self.w_a / 2
        y, z = self.divided([0.0, half]), self.divided([0.0, self.h_a])
        points = _Points()
        parts: dict[str, list[np.ndarray]] = {}
        triangles: list[np.ndarray] = []

        def add(name: str, elements: np.ndarray) -> None:
            first = sum(map(len, triangles))
            parts.setdefault(name, []).append(first + np.arange(len(elements)))
            triangles.append(elements)

        wall = Lines(y, z)
        grid_points = wall.points()
        of_width, of_height = grid_points[:, 0] / half, grid_points[:, 1] / self.h_a
        wide = self.seam / 2 * (1 - of_width) * (1 - of_height)
        diagonals = wall.alternating()
        diagonals[-1, -1] = False  # at the corner of two seams it ends there, or would weld them
        grid = wall.triangles(diagonals=diagonals)
        borders = []
        for k in range(self.n):
            place, border = k * self.pitch, []
            for name, sign in (("fore", 1), ("aft", -1)):
                corners = np.column_stack([place + sign * wide, grid_points[:, :2]])
                number = points.add(corners)
                add(name, number[grid][:, :: 1 if sign == 1 else -1])
                border.append(number.reshape(len(y), len(z))[:, 0])
            fore, aft = border
            name = "clamp" if k == 0 else "tip" if k == self.n - 1 else "floors"
            for one, other in pairwise(points.rows(aft, fore, self.steps(self.seam))):
                add(name, _between(other, one))
            borders.append((aft, fore))
        gap = self.steps(self.pitch - self.seam)
        for (_, left), (right, _) in pairwise(borders):
            for one, other in pairwise(points.rows(left, right, gap)):
                add("strip", _between(other, one)[:, ::-1])
        corners, elements = points.whole(), np.vstack(triangles)
        edges = sides(elements)
        ends = corners[edges]
        lowest = (ends[:, :, 2] == 0).all(axis=1)
        walls = sides(np.vstack([elements[np.concatenate(parts[n])] for n in ("fore", "aft")]))
        key = len(corners)
        of_walls = np.isin(edges[:, 0] * key + edges[:, 1], walls[:, 0] * key + walls[:, 1])
        outer = (ends[:, :, 1] == half).all(axis=1) | (ends[:, :, 2] == self.h_a).all(axis=1)
        seams = edges[of_walls & (lowest | outer)]
        curves = {"middle": edges[(ends[:, :, 1] == 0).all(axis=1)], "seams": seams}
        members = {name: np.concatenate(numbers) for name, numbers in parts.items()}
        members.setdefault("floors", np.empty(0, dtype=int))
        flat = ("clamp", "floors", "tip", "strip")
        return SheetMesh(corners, elements, members, curves, hinges=seams, continuous=flat)

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


def _between(fore: np.ndarray, aft: np.ndarray) -> np.ndarray:
    """Triangles between two rows of nodes along y, which may meet at their end; normals down where
    ``fore`` has the larger x."""
    first = np.column_stack([fore[:-1], aft[:-1], aft[1:]])
    second = np.column_stack([fore[:-1], aft[1:], fore[1:]])
    return np.vstack([first, second[aft[1:] != fore[1:]]])


if __name__ == "__main__":
    from softact.geometry.base import main

    main(WovenBending)
