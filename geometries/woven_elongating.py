"""A stack of flat pouches of woven fabric, one on the other: it lengthens under pressure.

Nguyen and Zhang 2020, Sci. Rep. 10:9638, Fig. 3b.
"""

from collections.abc import Iterator
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import Layout
from softact.geometry.chains import Chain, OneModule
from softact.geometry.cutting_pattern import Pattern, rectangle
from softact.geometry.flat_sheets import BetweenLines, Lines, SheetGeometry, sides
from softact.mesh.sheets import SheetMesh
from softact.units import Length


class WovenElongating(SheetGeometry, Chain):
    """Pouches of two equal rectangles, sealed at their rims and joined around square passages.

    x runs along the stack, w_a along y, h_a along z; a quarter is meshed, y and z ≥ 0. As it lies,
    each sheet rises by half the pitch between its passage and its rim, so that no two coincide: the
    side of a frustum. The end plates are the size of a passage. A module is a pouch from passage to
    passage, without them.
    """

    #: Flat pouches lie on each other, and unfold through each other: with contact they do not yet.
    meets_itself: ClassVar[bool] = False

    type: Literal["woven_elongating"] = "woven_elongating"
    n_a: int = Field(5, ge=1, le=100, description="number of pouches")
    w_a: Length = Field(62.0, description="width of a pouch (active width)")
    h_a: Length = Field(31.0, description="height of a pouch across the stack (active height)")
    passage: Length = Field(10.0, description="side of the square passage between the pouches")
    pitch: Length = Field(1.0, description="length of the empty stack for each pouch")
    mesh_size: Length = Field(8.0, description="longest side of the triangles along the rims")
    between_lines: BetweenLines = None
    module_alone: OneModule = None

    counted: ClassVar[tuple[str, str] | None] = ("n_a", "pouch")

    @property
    def _sheets(self) -> tuple[str, ...]:
        return ("pouches",) if self.alone else ("pouches", "ends")

    @property
    def _pouches(self) -> int:
        """How many are meshed."""
        return 1 if self.alone else self.n_a

    def faults(self) -> Iterator[tuple[str, str]]:
        yield from super().faults()
        for name in ("w_a", "h_a"):
            side = getattr(self, name)
            if self.passage >= side:
                yield "passage", f"{self.passage:g} mm leave no fabric across {name} = {side:g} mm"
        most = min(self.w_a, self.h_a) - self.passage
        if 0 < most < self.pitch:
            yield (
                "pitch",
                f"{self.pitch:g} mm is no flat stack: its sheets would be steeper than 45°; write "
                f"at most {most:g} mm",
            )

    def layout(self) -> Layout:
        return Layout(
            regions=(),
            surfaces=(),
            sheets=self._sheets,
            curves=(*self.ends, "y_0", "z_0", "seams"),
            cavities={"air": self._sheets},
            symmetry={"y_0": 1, "z_0": 2},
            length=self._pouches * self.pitch,
            clamp=self.ends[0],
            tip=self.ends[1],
            repeats=self.repeats,
        )

    def volumes(self) -> dict[str, float]:
        w, h, p, rise = self.w_a, self.h_a, self.passage, self.pitch / 2
        trapezoids = sum(
            (p + one) / 2 * np.hypot((other - p) / 2, rise) / 2 for one, other in ((w, h), (h, w))
        )
        prismoid = rise / 6 * (p**2 + (p + w) * (p + h) + w * h) / 4
        return {
            "pouches": 2 * self._pouches * float(trapezoids),
            **({} if self.alone else {"ends": p**2 / 2}),
            "air": 2 * self._pouches * prismoid,
        }

    @property
    def _counts(self) -> tuple[int, int, int]:
        """Divisions of half the height, half the width, and from a passage to the rim."""
        across = max(self.w_a, self.h_a) - self.passage
        return self.steps(self.h_a / 2), self.steps(self.w_a / 2), self.steps(across / 2)

    def _round(self, width: float, height: float) -> np.ndarray:
        """Points (m, 2) of a quarter of a rectangle's outline, from y to z."""
        up, across, _ = self._counts
        first = np.column_stack([np.full(up + 1, width), np.linspace(0, height, up + 1)])
        second = np.column_stack([np.linspace(width, 0, across + 1), np.full(across + 1, height)])
        return np.vstack([first, second[1:]]) / 2

    def sheet_mesh(self) -> SheetMesh:
        """Rows of nodes from each passage to each rim; passages and rims are shared."""
        radial = self._counts[2]
        ring, rim = self._round(self.passage, self.passage), self._round(self.w_a, self.h_a)
        columns, levels = len(ring), 2 * self._pouches + 1
        grid = Lines(np.arange(radial + 1), np.arange(columns)).triangles()
        shared = np.arange(levels * columns).reshape(levels, columns)
        places = [
            np.column_stack([np.full(columns, k * self.pitch / 2), rim if k % 2 else ring])
            for k in range(levels)
        ]
        walls = []
        for k in range(levels - 1):
            inner, outer = (k, k + 1) if k % 2 == 0 else (k + 1, k)
            share = np.arange(1, radial)[:, None, None] / radial
            between = (1 - share) * places[inner] + share * places[outer]
            first = len(shared.ravel()) + k * (radial - 1) * columns
            number = first + np.arange((radial - 1) * columns).reshape(radial - 1, columns)
            rows = np.vstack([shared[inner], number, shared[outer]]).ravel()
            places.append(between.reshape(-1, 3))
            walls.append(_turned(rows[grid], k % 2 == 0))
        points, pouches = np.vstack(places), np.vstack(walls)
        ends: list[np.ndarray] = []
        for level in () if self.alone else (0, levels - 1):
            plate, numbers = self._plate(level * self.pitch / 2, shared[level], len(points))
            points = np.vstack([points, plate])
            ends.append(_turned(numbers, level == 0))
        triangles = np.vstack([pouches, *ends])
        parts = {"pouches": np.arange(len(pouches))}
        if not self.alone:
            parts["ends"] = np.arange(len(pouches), len(triangles))
        edges, seams = sides(triangles), shared[:, [np.arange(columns - 1), np.arange(1, columns)]]
        if self.alone:
            curves = dict(zip(self.ends, (_chain(shared[0]), _chain(shared[-1])), strict=True))
        else:
            curves = {"clamp": sides(ends[0]), "tip": sides(ends[1])}
        for name, axis in (("y_0", 1), ("z_0", 2)):
            curves[name] = edges[(points[edges][:, :, axis] == 0).all(axis=1)]
        curves["seams"] = seams.transpose(0, 2, 1).reshape(-1, 2)
        return SheetMesh(points, triangles, parts, curves, hinges=curves["seams"])

    def _plate(self, x: float, ring: np.ndarray, first: int) -> tuple[np.ndarray, np.ndarray]:
        """Further points, from number ``first`` on, and triangles (normals along x) of an end."""
        up, across, _ = self._counts
        y, z = (np.linspace(0, self.passage / 2, n + 1) for n in (across, up))
        grid = Lines(y, z)
        number = np.empty((across + 1, up + 1), dtype=int)
        number[:-1, :-1] = first + np.arange(across * up).reshape(across, up)
        number[-1, :], number[::-1, -1] = ring[: up + 1], ring[up:]
        inner = grid.points().reshape(across + 1, up + 1, 3)[:-1, :-1, :2].reshape(-1, 2)
        return np.column_stack([np.full(len(inner), x), inner]), number.ravel()[grid.triangles()]

    def pattern(self) -> Pattern:
        """All sheets in two rows, those of the stack's ends without a passage."""
        cut, seam, apart = [], [], 1.1
        for k in range(2 * self.n_a):
            centre = np.array([(k // 2) * self.w_a, (k % 2) * self.h_a]) * apart
            rim = rectangle(centre, self.w_a, self.h_a)
            ring = rectangle(centre, self.passage, self.passage)
            joined = 0 < k < 2 * self.n_a - 1
            cut += rim + ring * joined
            seam += rim + ring * joined
        return Pattern(tuple(cut), tuple(seam), pieces=1)


def _chain(nodes: np.ndarray) -> np.ndarray:
    """Edges (k, 2) from each of a row of nodes to the next."""
    return np.column_stack([nodes[:-1], nodes[1:]])


def _turned(triangles: np.ndarray, turn: bool) -> np.ndarray:
    """The triangles, with their normals turned round or not."""
    return triangles[:, [0, 2, 1]] if turn else triangles


if __name__ == "__main__":
    from softact.geometry.base import main

    main(WovenElongating)
