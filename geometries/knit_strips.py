"""A flat tube of knit with woven strips across it: it lengthens, bends about a seam, or twists.

Nguyen and Zhang 2020, Sci. Rep. 10:9638, Fig. 3e.
"""

from collections.abc import Iterator
from itertools import pairwise
from typing import Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import Layout
from softact.geometry.chains import Chain, OneModule
from softact.geometry.cutting_pattern import Pattern
from softact.geometry.flat_sheets import BetweenLines, Lines, SheetGeometry, sides
from softact.geometry.oblique import Oblique, pillow
from softact.mesh.sheets import SheetMesh
from softact.units import Angle, Length

SHARED = {"elongating": 4, "bending": 2, "twisting": 1}  # parts of the whole to one that is meshed
STEEPEST = 90.0  # degrees: strips along the tube
MOST_STRIPS = 300  # on a sheet
SMALL = 1e-6  # mm


class KnitStrips(SheetGeometry, Chain):
    """Two equal sheets that are joined along both sides and at both ends, where they stay flat.

    Strips are bonded to the sheets, n_r to each, evenly over its size at right angles to them and
    cut to it, or s_r apart, as many as there is room for with half of s_r to either side, in the
    middle; seen from outside they have the same angle on both, as a helix round the tube. kind
    bending: the lower sheet is sewn along its middle to an inextensible layer, and the half y ≥ 0
    is meshed. kind elongating: a quarter, the upper sheet for y ≥ 0. kind twisting: all of it.
    A module, where it elongates, is from the middle between two strips to the next such place.
    """

    type: Literal["knit_strips"] = "knit_strips"
    kind: Literal["bending", "elongating", "twisting"] = Field(
        "bending", description="with a seam; with strips at right angles; with oblique strips"
    )
    l_i: Length = Field(155.0, description="length between the two ends")
    w_i: Length = Field(40.0, description="width of the flat tube")
    w_r: Length = Field(1.5, description="width of a strip")
    n_r: int = Field(35, ge=1, le=MOST_STRIPS, description="number of strips on a sheet")
    s_r: Length | None = Field(
        None,
        description="distance of the middles of strips, at right angles to them; as many as there "
        "is room for then take the place of n_r",
    )
    alpha: Angle = Field(
        0.0,
        description="angle of the strips to the width, seen from outside: above 0 they are a "
        "right-handed helix, at 90° along the tube; 0 but where it twists",
    )
    w_z: Length = Field(14.0, description="width of the seam; only where it bends")
    held: Length = Field(
        15.0,
        description="length that the clamp holds: of the seam where it bends (up to the next edge "
        "of a strip), of both sides where it twists; the bending angle is that between the third "
        "such length of the seam from one end and from the other",
    )
    mesh_size: Length = Field(8.0, description="longest side of the triangles along the lines")
    between_lines: BetweenLines = None
    module_alone: OneModule = None

    def no_chain(self) -> Iterator[tuple[str, str]]:
        yield from super().no_chain()
        if self.kind != "elongating":
            yield "kind", f"{self.kind} has no module that repeats yet; elongating has one"
        elif self._strips == 1:
            yield "n_r", "one strip is no chain; write 2 or more"

    @property
    def pitches(self) -> float:
        return self._strips

    @property
    def _whole(self) -> Oblique:
        return Oblique(self.l_i, self.w_i, self.alpha)

    @property
    def _span(self) -> float:
        """Length of what is meshed."""
        return self._pitch if self.alone else self.l_i

    @property
    def _sheet(self) -> Oblique:
        """As it is meshed."""
        return Oblique(self._span, self.w_i, self.alpha)

    @property
    def _bends(self) -> bool:
        return self.kind == "bending"

    @property
    def _strips(self) -> int:
        """Number of strips on a whole sheet."""
        return self.n_r if self.s_r is None else int(self._whole.extent / self.s_r + SMALL)

    @property
    def _count(self) -> int:
        """Of those on what is meshed."""
        return 1 if self.alone else self._strips

    @property
    def _pitch(self) -> float:
        return self._whole.extent / self.n_r if self.s_r is None else self.s_r

    @property
    def _seam(self) -> float:
        return self.w_z if self._bends else 0.0

    def faults(self) -> Iterator[tuple[str, str]]:
        if no_chain := [*super().faults()]:
            yield from no_chain
            return
        if self.kind != "twisting" and self.alpha:
            yield "alpha", f"{self.alpha:g}° is for kind twisting; {self.kind} has strips at 0°"
            return
        if abs(self.alpha) > STEEPEST:
            yield "alpha", f"{self.alpha:g}°: write at most {STEEPEST:g}° either way"
            return
        extent, pitch = self._whole.extent, self._pitch
        if not 1 <= self._strips <= MOST_STRIPS:
            yield (
                "s_r",
                f"{self._strips} strips {pitch:g} mm apart on {extent:.4g} mm; write "
                f"{extent / MOST_STRIPS:.4g} to {extent:.4g} mm",
            )
        elif self.w_r >= pitch:
            yield (
                "w_r",
                f"{self._strips} strips of {self.w_r:g} mm leave no knit on {extent:g} mm; "
                f"write less than {pitch:.4g} mm",
            )
        if self._seam >= self.w_i:
            yield "w_z", f"{self.w_z:g} mm leave no knit beside the seam on {self.w_i:g} mm"
        if self.kind != "elongating" and self.held > self.l_i / 8:
            yield "held", f"{self.held:g} mm are more than an eighth of {self.l_i:g} mm"

    def layout(self) -> Layout:
        sheets = ("knit", "strips", "seam") if self._bends else ("knit", "strips")
        planes = {"elongating": {"middle": 1, "rim": 2}, "bending": {"middle": 1}, "twisting": {}}
        symmetry, bending = planes[self.kind], ("base",) if self._bends else ()
        return Layout(
            regions=(),
            surfaces=(),
            sheets=sheets,
            curves=tuple(dict.fromkeys((*self.ends, "rim", *symmetry, *bending))),
            base="base" if self._bends else None,
            cavities={"air": sheets},
            bending_axis=(0.0, 1.0, 0.0) if self._bends else None,
            symmetry=symmetry,
            length=self._span,
            clamp=self.ends[0],
            tip=self.ends[1],
            repeats=self.repeats,
        )

    def volumes(self) -> dict[str, float]:
        below = self._sheet.area_below(self._strip_edges())
        strips = float((below[1::2] - below[::2]).sum())
        free = 2 - self._seam / self.w_i  # of two sheets
        areas = {"knit": (self._span * self.w_i - strips) * free, "strips": strips * free}
        if self._bends:
            areas["seam"] = self.l_i * self._seam
        return {name: area / SHARED[self.kind] for name, area in areas.items()}

    def _strip_edges(self) -> np.ndarray:
        """Levels at which strips begin and end, (2 n_r,); see ``Oblique``."""
        places = np.arange(self._count) - (self._count - 1) / 2
        first = self._sheet.extent / 2 + places * self._pitch - self.w_r / 2
        return np.column_stack([first, first + self.w_r]).ravel()

    def sheet_mesh(self) -> SheetMesh:
        points, triangles, sewn = self._twisting() if self.kind == "twisting" else self._straight()
        strip = np.searchsorted(self._strip_edges(), self._levels(points, triangles)) % 2 == 1
        parts = {
            "knit": np.flatnonzero(~strip & ~sewn),
            "strips": np.flatnonzero(strip & ~sewn),
        }
        if self._bends:
            parts["seam"] = np.flatnonzero(sewn)
        curves = self._curves(points, sides(triangles), sides(triangles[sewn]))
        return SheetMesh(points, triangles, parts, curves, hinges=curves["rim"])

    def _levels(self, points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
        """Levels (m,) of the triangles' centres, those of the lower sheet seen from below."""
        centre = points[triangles].mean(axis=1)
        a, b, c = (points[triangles[:, i], :2] for i in range(3))
        upward = np.sign(np.cross(b - a, c - a))
        return self._sheet.levels(centre[:, :2] * np.column_stack([np.ones_like(upward), upward]))

    def _straight(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Points, triangles, and which of them are sewn: a grid, for y ≥ 0."""
        stops = sorted({0.0, self._seam / 2, self.w_i / 2})
        y = self.divided(stops)
        if len(y) % 2 == 0:  # an even number of divisions: see ``Lines.triangles``
            last = int((y > stops[-2] - 1e-9).sum())
            y = np.append(y[:-last], np.linspace(stops[-2], stops[-1], last + 1))
        x = self.divided([0.0, *self._strip_edges(), self._span])
        lines = Lines(x, y)
        points, triangles = lines.points(), lines.triangles(mirrored=True)
        sewn: np.ndarray = np.zeros(len(triangles), dtype=bool)
        if self._bends:
            free = np.flatnonzero(~self._sheet.on_rim(points))
            below = np.arange(len(points))
            below[free] = len(points) + np.arange(len(free))
            sewn = np.append(sewn, points[triangles].mean(axis=1)[:, 1] < self._seam / 2)
            triangles = np.vstack([triangles, below[triangles[:, [0, 2, 1]]]])
            points = np.vstack([points, points[free]])
        return points, triangles, sewn

    def _twisting(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The same of the whole, with triangles along the strips."""
        edges = self._strip_edges()
        levels = self.divided([0.0, *edges, self._sheet.extent])[1:-1]
        flat = self._sheet.triangles(levels, self.mesh_size, self.held)
        points, triangles = pillow(self._sheet, *flat)
        return points, triangles, np.zeros(len(triangles), dtype=bool)

    def _curves(
        self, points: np.ndarray, edges: np.ndarray, seam: np.ndarray
    ) -> dict[str, np.ndarray]:
        def along(axis: int, value: float) -> np.ndarray:
            return edges[(np.abs(points[edges][:, :, axis] - value) < 1e-9).all(axis=1)]

        curves = {self.ends[0]: along(0, 0.0), self.ends[1]: along(0, self._span)}
        sides_far = [along(1, self.w_i / 2)]
        if self.kind == "twisting":
            sides_far.append(along(1, -self.w_i / 2))
        else:
            curves["middle"] = along(1, 0.0)
        far = np.vstack(sides_far)
        if self.alone:
            return curves | {"rim": far}
        curves["rim"] = np.vstack([far, curves["clamp"], curves["tip"]])
        if self._bends:
            one, two, three = (self._next_edge(k * self.held) for k in (1, 2, 3))
            x, end = points[seam][:, :, 0], self.l_i
            held = seam[(x < one).all(axis=1)]
            curves["base"] = seam[((x > two - SMALL) & (x < three)).all(axis=1)]
            curves["tip"] = seam[((x > end - three) & (x < end - two + SMALL)).all(axis=1)]
        elif self.kind == "twisting":
            held = far[(points[far][:, :, 0] < self.held + SMALL).all(axis=1)]
        else:
            return curves
        both = np.sort(np.vstack([curves["clamp"], held]), axis=1)
        curves["clamp"] = np.unique(both, axis=0)
        return curves

    def _next_edge(self, x: float) -> float:
        """Where the next edge of a strip lies, and a little more, mm; alike from both ends."""
        edges = self._strip_edges()
        return float(edges[min(int(np.searchsorted(edges, x)), len(edges) - 1)]) + SMALL / 2

    def pattern(self) -> Pattern:
        """The two sheets of knit with the outlines of the strips that are bonded to them."""
        w, length = self.w_i / 2, self.l_i
        corners = [(0.0, -w), (length, -w), (length, w), (0.0, w), (0.0, -w)]
        strips = []
        for level in self._strip_edges():
            (x, y), (other_x, other_y) = self._sheet.ends(level)
            strips.append(((float(x), float(y)), (float(other_x), float(other_y))))
        return Pattern(tuple(pairwise(corners)), tuple(strips))


if __name__ == "__main__":
    from softact.geometry.base import main

    main(KnitStrips)
