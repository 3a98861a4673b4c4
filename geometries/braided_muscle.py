"""A braided muscle (McKibben): a rubber tube in a sleeve of two helices that cross, between two
stiff ends.

Chou and Hannaford (1996), IEEE Transactions on Robotics and Automation 12:90; Tondu and Lopez
(2000), IEEE Control Systems Magazine 20:15. Run by itself it writes a mesh:
``python geometries/braided_muscle.py --radius "8 mm" -o muscle.msh``.
"""

from collections.abc import Iterator
from math import pi
from types import ModuleType
from typing import Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import THINNEST, Geometry, Layout, ThroughWall, main
from softact.geometry.curved import are_curved
from softact.geometry.prisms import Prism, PrismMesh, Prisms
from softact.geometry.rounds import SYMMETRY, Part, RoundSection, ends_and_planes
from softact.geometry.steps import steps
from softact.geometry.walls import Wall
from softact.units import Length


class BraidedMuscle(Geometry):
    """A round tube along x whose outer part is the region ``braid``, between two round ends.

    Give ``braid`` a law with two families of fibres: their angle to the axis decides whether the
    muscle shortens (below 54.7°) or grows longer. Tube and braid are glued to the region ``ends``.
    """

    type: Literal["braided_muscle"] = "braided_muscle"
    length: Length = Field(100.0, description="overall length")
    radius: Length = Field(7.0, description="radius of the outside")
    braid: Length = Field(0.6, description="thickness of the region that holds the braid")
    wall: Length = Field(1.2, description="thickness of the tube inside the braid")
    end: Length = Field(5.0, description="length of each of the two ends")
    part: Part = Field(
        "quarter", description="what is meshed; a quarter (y >= 0, z >= 0) cannot bend"
    )
    mesh_size: Length = Field(3.0, description="longest edge")
    through_wall: ThroughWall = None

    def faults(self) -> Iterator[tuple[str, str]]:
        if self.length - 2 * self.end < THINNEST:
            yield (
                "end",
                f"{self.end:g} mm on both sides fills the length: the tube would vanish; write "
                f"less than {self.length / 2:g} mm",
            )
        if self.bore < THINNEST:
            yield (
                "radius",
                f"{self.radius:g} mm less braid and wall leaves no room: the bore would vanish; "
                f"write more than {self.braid + self.wall:g} mm",
            )
        if self.mesh_size > 2 * self.radius:
            yield (
                "mesh_size",
                f"{self.mesh_size:g} mm is more than the muscle is wide: no element would show how "
                f"it opens at its ends; write at most {2 * self.radius:g} mm",
            )

    @property
    def bore(self) -> float:
        """Radius of the air space."""
        return self.radius - self.braid - self.wall

    @property
    def braid_radius(self) -> float:
        """Radius of the middle of the braid."""
        return self.radius - self.braid / 2

    def layout(self) -> Layout:
        return Layout(
            regions=("body", "braid", "ends"),
            surfaces=("clamp", "tip", "cavity", "outer", *SYMMETRY[self.part]),
            cavities={"cavity": ("cavity",)},
            bending_axis=(0.0, 1.0, 0.0) if self.part != "whole" else None,
            symmetry=SYMMETRY[self.part],
            length=self.length,
        )

    def wall_normal(self, region: str, points: np.ndarray) -> np.ndarray:
        """Along the radius, so that fibres at an angle to the axis are helices."""
        return points * (0.0, 1.0, 1.0)

    def volumes(self) -> dict[str, float]:
        share, tube = self._section.share, self.length - 2 * self.end
        bore, inside, outside = (share * pi * r**2 for r in self._section.discs.values())
        return {
            "body": (inside - bore) * tube,
            "braid": (outside - inside) * tube,
            "ends": outside * 2 * self.end,
            "cavity": bore * tube,
            "clamp": outside,
            "tip": outside,
        }

    def volume_tolerance(self, name: str) -> float:
        return self._section.lacking(self.mesh_size) if are_curved() else 1e-9

    def walls(self) -> tuple[Wall, ...]:
        parts = self.walls_between_planes(wall=self.wall, braid=self.braid)
        return (
            Wall("wall and braid", self.wall + self.braid, sum(part.elements for part in parts)),
        )

    def cells(self) -> int:
        size, least = self.mesh_size, self.least_steps
        section = self._section.triangles(size, least)
        ends = 2 * steps(self.end, size, least) * section["whole"]
        tube = steps(self.length - 2 * self.end, size, least)
        return 3 * (ends + tube * (section["whole"] - section["bore"]))

    @property
    def _section(self) -> RoundSection:
        discs = {"bore": self.bore, "tube": self.bore + self.wall, "whole": self.radius}
        return RoundSection(discs, self.part)

    def solid(self) -> Prisms:
        """The muscle as prisms painted over each other."""
        along = self.end, self.length - self.end
        prisms = (
            Prism("ends", "whole", 0.0, self.length),
            Prism("braid", "whole", *along),
            Prism("body", "tube", *along),
            Prism("cavity", "bore", *along),
        )
        planes = ends_and_planes(self.length, self.part)
        regions = self.layout().regions
        return Prisms(self._section.shapes, prisms, regions, ("cavity",), planes=planes)

    def build(self, gmsh: ModuleType) -> None:
        self.solid().build(gmsh)

    def mesh(self, gmsh: ModuleType) -> None:
        solid, size, least = self.solid(), self.mesh_size, self.least_steps
        section, lines = self._section.mesh(size, least), solid.lines(size, least)
        PrismMesh(solid, section, lines).add_to(gmsh)


if __name__ == "__main__":
    main(BraidedMuscle)
