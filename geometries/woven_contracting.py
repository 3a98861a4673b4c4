"""A row of flat pouches between two sheets of woven fabric: it shortens under pressure.

Nguyen and Zhang 2020, Sci. Rep. 10:9638, Fig. 3a; the principle is the pouch motor of Niiyama et
al., Soft Robotics 2 (2015) 59.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import Layout
from softact.geometry.chains import Chain, OneModule
from softact.geometry.cutting_pattern import Pattern
from softact.geometry.flat_sheets import BetweenLines, Lines, SheetGeometry, sides
from softact.mesh.sheets import SheetMesh
from softact.units import Length


class WovenContracting(SheetGeometry, Chain):
    """Two equal sheets, sealed along their rim and between the pouches but for an air passage.

    A quarter is meshed: the upper sheet for y ≥ 0. The seams stay in the plane between the sheets.
    Those across the actuator may have a width, which is welded as the tabs are; that along the rim
    is a line. A module is from the middle of a pouch to that of the next.
    """

    type: Literal["woven_contracting"] = "woven_contracting"
    n_a: int = Field(7, ge=1, le=100, description="number of pouches")
    l_i: Length = Field(200.0, description="length between the clamped ends")
    w_a: Length = Field(60.0, description="width across")
    h_a: Length = Field(22.86, description="length of one pouch along the actuator, flat")
    passage: Length = Field(5.0, description="width of the air passage between the pouches")
    seam: Length = Field(
        0.0, description="width of the welds before, between and after the pouches, half on each"
    )
    mesh_size: Length = Field(5.0, description="longest side of the triangles along the axes")
    between_lines: BetweenLines = None
    module_alone: OneModule = None

    counted: ClassVar[tuple[str, str] | None] = ("n_a", "pouch")

    @property
    def _span(self) -> float:
        """Length of what is meshed."""
        return self.h_a if self.alone else self.l_i

    @property
    def _welded(self) -> bool:
        """Whether there is more than the pouches: tabs, or seams with a width."""
        return not self.alone or self.seam > 0

    @property
    def _tab(self) -> float:
        return (self.l_i - self.n_a * self.h_a) / 2

    @property
    def _pouches(self) -> np.ndarray:
        """Where the air of each pouch begins and ends along x (n_a, 2)."""
        if self.alone:
            half, weld = self.h_a / 2, self.seam / 2
            return np.array([[0.0, half - weld], [half + weld, self.h_a]])
        starts = self._tab + self.h_a * np.arange(self.n_a + 1)
        return np.column_stack([starts[:-1] + self.seam / 2, starts[1:] - self.seam / 2])

    def faults(self) -> Iterator[tuple[str, str]]:
        yield from super().faults()
        if self._tab <= 0:
            yield (
                "l_i",
                f"{self.n_a} pouches of {self.h_a:g} mm need more than {self.l_i:g} mm: write at "
                f"least {self.n_a * self.h_a + 1:g} mm, so that tabs are left for the ends",
            )
        if self.seam >= self.h_a:
            yield "seam", f"{self.seam:g} mm leave no air in pouches of {self.h_a:g} mm"
        if self.passage >= self.w_a:
            yield "passage", f"{self.passage:g} mm leave no seam across a width of {self.w_a:g} mm"

    def layout(self) -> Layout:
        return Layout(
            regions=(),
            surfaces=(),
            sheets=("pouches", "tabs") if self._welded else ("pouches",),
            curves=(*self.ends, "middle", "seams"),
            cavities={"air": ("pouches",)},
            symmetry={"middle": 1, "seams": 2},
            length=self._span,
            clamp=self.ends[0],
            tip=self.ends[1],
            repeats=self.repeats,
        )

    def volumes(self) -> dict[str, float]:
        half = self.w_a / 2
        count, passages = (1, 1) if self.alone else (self.n_a, self.n_a - 1)
        pouches = count * (self.h_a - self.seam) * half + passages * self.seam * self.passage / 2
        return {"pouches": pouches} | (
            {"tabs": self._span * half - pouches} if self._welded else {}
        )

    def _in_pouches(self, x: np.ndarray) -> np.ndarray:
        """Which places along the actuator are beside the air of a pouch, not beside a weld."""
        begin, end = self._pouches.T
        return ((x[:, None] > begin) & (x[:, None] < end)).any(axis=1)

    def sheet_mesh(self) -> SheetMesh:
        pouches = self._pouches
        first, last, half, open_ = pouches[0, 0], pouches[-1, 1], self.w_a / 2, self.passage / 2
        x = self.divided(np.unique([0.0, *pouches.ravel(), self._span]))
        lines = Lines(x, self.divided([0.0, open_, half]))
        points, triangles = lines.points(), lines.triangles()
        centre = points[triangles].mean(axis=1)
        beside = (centre[:, 0] > first) & (centre[:, 0] < last)
        inside = beside & (self._in_pouches(centre[:, 0]) | (centre[:, 1] < open_))
        edges = sides(triangles)
        middle = points[edges].mean(axis=1)

        def along(axis: int, value: float) -> np.ndarray:
            return (np.abs(points[edges][:, :, axis] - value) < 1e-9).all(axis=1)

        sealed = middle[:, 1] > open_
        seams = along(1, half) & self._in_pouches(middle[:, 0])
        if not self.alone:
            seams |= along(0, first) | along(0, last)
        for end in pouches.ravel()[1:-1]:
            seams |= along(0, end) & sealed
        between = (middle[:, 0] > first) & (middle[:, 0] < last)
        seams |= along(1, open_) & between & ~self._in_pouches(middle[:, 0])
        curves = {
            self.ends[0]: edges[along(0, 0.0)],
            self.ends[1]: edges[along(0, self._span)],
            "middle": edges[along(1, 0.0)],
            "seams": np.unique(np.vstack([edges[seams], sides(triangles[~inside])]), axis=0),
        }
        parts = {"pouches": np.flatnonzero(inside)}
        if self._welded:
            parts["tabs"] = np.flatnonzero(~inside)
        return SheetMesh(points, triangles, parts, curves, hinges=edges[seams])

    def pattern(self) -> Pattern:
        w, p, end = self.w_a / 2, self.passage / 2, self.l_i
        ends = self._pouches
        first, last = float(ends[0, 0]), float(ends[-1, 1])
        corners = [(0.0, -w), (end, -w), (end, w), (0.0, w), (0.0, -w)]
        seams = [((first, s * w), (last, s * w)) for s in (-1, 1)]
        seams += [((x, -w), (x, w)) for x in (first, last)]
        for x in map(float, np.unique(ends.ravel()[1:-1])):
            seams += [((x, -w), (x, -p)), ((x, p), (x, w))]
        if self.seam:
            for before, after in zip(ends[:-1, 1], ends[1:, 0], strict=True):
                seams += [((float(before), s * p), (float(after), s * p)) for s in (-1, 1)]
        return Pattern(tuple(pairwise(corners)), tuple(seams))


if __name__ == "__main__":
    from softact.geometry.base import main

    main(WovenContracting)
