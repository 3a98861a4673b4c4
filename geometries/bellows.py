"""Round bellows: a wall that winds in and out along x, between two plates.

The profile is an S of two arcs and a straight flank, as that of most bellows; pressure makes it
longer, a vacuum shorter. Run by itself it writes a mesh:
``python geometries/bellows.py --convolutions 4 -o bellows.msh``.
"""

from collections.abc import Iterator
from itertools import pairwise
from math import pi
from types import ModuleType
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import THINNEST, Geometry, Layout, ThroughWall, main
from softact.geometry.curved import are_curved
from softact.geometry.prisms import Prism, Prisms
from softact.geometry.rounds import LACKING, SYMMETRY, Bent, Part, RoundSection, ends_and_planes
from softact.geometry.steps import steps
from softact.geometry.walls import Wall
from softact.geometry.waves import Wave
from softact.units import Length


class Bellows(Geometry):
    """A round bellows along x, closed by plates at its roots, with one cavity.

    Each convolution goes from a root out to a crest and back. Crests and roots are arcs, the flanks
    between them straight. The wall has one thickness all along.
    """

    type: Literal["bellows"] = "bellows"
    convolutions: Annotated[int, Field(ge=1, le=100)] = Field(5, description="number of crests")
    pitch: Length = Field(8.0, description="from one crest to the next")
    outer_radius: Length = Field(15.0, description="radius of the outside at the crests")
    inner_radius: Length = Field(8.0, description="radius of the air space at the roots")
    wall: Length = Field(1.0, description="thickness of the wall")
    fold_radius: Length | None = Field(
        None,
        description="radius of the wall's middle in crests and roots; by default a quarter of the "
        "pitch, which makes the flanks upright; less makes them lean",
    )
    end: Length = Field(3.0, description="thickness of the plates")
    part: Part = Field(
        "quarter", description="what is meshed; a quarter (y >= 0, z >= 0) cannot bend"
    )
    mesh_size: Length = Field(3.0, description="longest edge")
    through_wall: ThroughWall = None

    def faults(self) -> Iterator[tuple[str, str]]:
        least, thickest = self.inner_radius + self.wall, 2 * self.fold
        if self._wave.height < THINNEST:
            yield (
                "outer_radius",
                f"{self.outer_radius:g} mm is not more than inner_radius and the wall together: "
                f"the convolutions would vanish; write more than {least:g} mm",
            )
        if thickest - self.wall < 2 * THINNEST:
            right = (
                f"a pitch of more than {2 * self.wall:g} mm"
                if self.fold_radius is None
                else f"a radius of more than {self.wall / 2:g} mm"
            )
            yield (
                "fold_radius" if self.fold_radius is not None else "pitch",
                f"leaves {self.fold:g} mm for the radius of the folds, not more than half of the "
                f"wall ({self.wall:g} mm): the gaps in the folds would vanish; write {right}, or a "
                f"wall of less than {thickest:g} mm",
            )
        elif self.fold > self.pitch / 4 * (1 + 1e-9):
            yield (
                "fold_radius",
                f"{self.fold:g} mm is more than a quarter of the pitch: the flanks would lean over "
                f"into each other; write at most {self.pitch / 4:g} mm",
            )

    @property
    def fold(self) -> float:
        """Radius of the wall's middle in crests and roots."""
        return self.pitch / 4 if self.fold_radius is None else self.fold_radius

    @property
    def length(self) -> float:
        """Overall length."""
        return self.convolutions * self.pitch + 2 * self.end

    @property
    def _wave(self) -> Wave:
        """The middle of the wall between two plates, from its root on."""
        root, crest = self.inner_radius + self.wall / 2, self.outer_radius - self.wall / 2
        return Wave(self.convolutions, self.pitch, root, crest, self.fold)

    def layout(self) -> Layout:
        return Layout(
            regions=("body",),
            surfaces=("clamp", "tip", "cavity", "outer", *SYMMETRY[self.part]),
            cavities={"cavity": ("cavity",)},
            bending_axis=(0.0, 1.0, 0.0) if self.part != "whole" else None,
            symmetry=SYMMETRY[self.part],
            length=self.length,
        )

    def wall_normal(self, region: str, points: np.ndarray) -> np.ndarray:
        """Across the wall; along the radius in the plates."""
        radius = np.linalg.norm(points[:, 1:], axis=1)
        slope = self._wave.slope(points[:, 0] - self.end, radius)
        outward = points[:, 1:] / np.maximum(radius, THINNEST)[:, None]
        return np.column_stack([-np.sin(slope), np.cos(slope)[:, None] * outward])

    def volumes(self) -> dict[str, float]:
        share, wave, w = self._section.share, self._wave, self.wall
        plate = share * pi * (self.inner_radius + w) ** 2
        return {
            "body": share * wave.wall_volume(w) + 2 * self.end * plate,
            "cavity": share * wave.air_volume(w),
            "clamp": plate,
            "tip": plate,
        }

    def volume_tolerance(self, name: str) -> float:
        if are_curved():
            return self._tolerance_of_arcs(name)
        if name in ("clamp", "tip"):
            return 1e-9
        wave, w = self._wave, self.wall
        turn = wave.turn(self.mesh_size, w, self.least_steps)
        if name == "body":  # two arcs that are cut at the same angles: sin(turn)/turn of the area
            return turn**2 / 6
        # A chord cuts a² (turn − sin(turn))/2 off its arc: less air at crests, more at roots.
        cut = wave.crest * (wave.fold - w / 2) ** 2 + wave.root * (wave.fold + w / 2) ** 2
        arcs = 2 * pi * cut * 2 * wave.lean * turn**2 / 12
        return self.convolutions * arcs / wave.air_volume(w)

    def _tolerance_of_arcs(self, name: str) -> float:
        """Of quadratic edges, instead of straight ones."""
        section = self._section.lacking(self.mesh_size)
        if name in ("clamp", "tip"):
            return section
        wave, w = self._wave, self.wall
        turn = wave.turn(self.mesh_size, w, self.least_steps)
        if name == "body":  # two arcs that are cut at the same angles
            return section + LACKING * turn**4
        # A quadratic arc lacks a² turn LACKING turn⁴/2: less air at crests, more at roots.
        cut = wave.crest * (wave.fold - w / 2) ** 2 + wave.root * (wave.fold + w / 2) ** 2
        arcs = 2 * pi * cut * 2 * wave.lean * LACKING / 2 * turn**4
        return section + self.convolutions * arcs / wave.air_volume(w)

    @property
    def _section(self) -> RoundSection:
        radii = {"bore": self.inner_radius, "whole": self.inner_radius + self.wall}
        return RoundSection(radii, self.part, self.outer_radius)

    def walls(self) -> tuple[Wall, ...]:
        return self.walls_between_planes(wall=self.wall)

    def cells(self) -> int:
        size, least = self.mesh_size, self.least_steps
        section = self._section.triangles(size, least)
        plates = 2 * steps(self.end, size, least) * section["whole"]
        wall = self._wave.pieces(size, self.wall, least) * (section["whole"] - section["bore"])
        return 3 * (plates + wall)

    def build(self, gmsh: ModuleType) -> None:
        occ, length, end = gmsh.model.occ, self.length, self.end
        plate = self.inner_radius + self.wall
        inner, under, over = self._wave.add_outline(occ, -self.wall / 2, end)
        outer, left, right = self._wave.add_outline(occ, self.wall / 2, end)
        near = [occ.addPoint(x, r, 0) for x, r in ((0, plate), (0, 0), (end, 0))]
        far = [occ.addPoint(x, r, 0) for x, r in ((length - end, 0), (length, 0), (length, plate))]
        paths = [left, *near, under], [over, *far, right]
        lines = [occ.addLine(*pair) for path in paths for pair in pairwise(path)]
        before, after = lines[: len(lines) // 2], lines[len(lines) // 2 :]
        loop = [*before, *inner, *after, *outer[::-1]]
        face = [(2, occ.addPlaneSurface([occ.addCurveLoop(loop)]))]
        if self.part == "half":
            occ.rotate(face, 0, 0, 0, 1, 0, 0, -pi / 2)
        occ.revolve(face, 0, 0, 0, 1, 0, 0, 2 * pi * self._section.share)
        occ.remove(face, recursive=True)
        occ.synchronize()

    def mesh(self, gmsh: ModuleType) -> None:
        """A straight tube as long as its wall, bent into the wave."""
        wave, size, least = self._wave, self.mesh_size, self.least_steps
        wound = wave.length + 2 * self.end
        section, along = self._section, (self.end, wound - self.end)
        solid = Prisms(
            section.shapes,
            (Prism("body", "whole", 0.0, wound), Prism("cavity", "bore", *along)),
            ("body",),
            ("cavity",),
            planes=ends_and_planes(wound, self.part),
        )
        plate = np.linspace(0.0, self.end, steps(self.end, size, least) + 1)
        stations = self.end + wave.stations(size, self.wall, least)
        lines = np.concatenate([plate[:-1], stations, wound - plate[-2::-1]])
        wider = section.widening(size)
        Bent(solid, section.mesh(size, least), lines, wider, self._bend).add_to(gmsh)

    def _bend(self, x: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where a point of the straight tube is in the bellows, along the axis and the radius."""
        wave, x = self._wave, x - self.end
        along = np.clip(x, 0.0, wave.length)
        place, middle, slope = wave.place(along)
        out = radius - wave.root
        beyond = x - along  # in the plates
        return self.end + place - out * np.sin(slope) + beyond, middle + out * np.cos(slope)


if __name__ == "__main__":
    main(Bellows)
