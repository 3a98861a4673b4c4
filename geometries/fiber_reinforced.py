"""A fibre-reinforced bending actuator: a half-round tube with a double-helix winding and a base
that does not stretch.

Polygerinos et al. (2015), IEEE Transactions on Robotics 31:778. Run by itself it writes a mesh:
``python geometries/fiber_reinforced.py --radius "9 mm" -o tube.msh``.
"""

from collections.abc import Iterator
from math import acos, pi, sqrt
from types import ModuleType
from typing import Any, Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import THINNEST, Layout, ThroughWall, main
from softact.geometry.boxes import Plane
from softact.geometry.chains import Chain, OneModule
from softact.geometry.prisms import Entities, Prism, Prisms, Shapes, lacking
from softact.geometry.walls import Wall
from softact.units import Length

SHORT = 6  # radii of a chamber whose middle knows nothing of the ends


class FiberReinforced(Chain):
    """A half-round tube along x, round above and flat below, with closed ends.

    Its outer part is the region ``sleeve``, all around: give it a law with fibres for the winding.
    The flat underside is the surface ``base``: give it a layer that does not stretch.
    """

    type: Literal["fiber_reinforced"] = "fiber_reinforced"
    length: Length = Field(160.0, description="overall length")
    radius: Length = Field(9.0, description="radius of the round outside")
    sleeve: Length = Field(1.0, description="thickness of the region that holds the winding")
    wall: Length = Field(2.0, description="thickness of the round wall inside the sleeve")
    base_wall: Length = Field(2.0, description="thickness of the flat wall inside the sleeve")
    end: Length = Field(5.0, description="thickness of the solid ends")
    symmetry: bool = Field(True, description="model the half y >= 0 only")
    mesh_size: Length = Field(4.0, description="longest edge")
    through_wall: ThroughWall = None
    module_alone: OneModule = None

    @property
    def pitches(self) -> float:
        """A module is a slice as long as an element."""
        return (self.length - 2 * self.end) / self.mesh_size

    def short(self) -> dict[str, Any]:
        steps = np.ceil(SHORT * self.radius / self.mesh_size)
        return {"length": f"{2 * self.end + steps * self.mesh_size!r} mm"}

    @property
    def _span(self) -> float:
        """Length of what is meshed."""
        return self.mesh_size if self.alone else self.length

    @property
    def _chamber(self) -> tuple[float, float]:
        """Where the chamber begins and ends."""
        return (0.0, self._span) if self.alone else (self.end, self.length - self.end)

    def faults(self) -> Iterator[tuple[str, str]]:
        if self.length - 2 * self.end < THINNEST:
            yield "end", f"{self.end:g} mm on both sides fills the length: the chamber would vanish"
        if self._inside - self._floor < THINNEST:
            yield (
                "radius",
                f"{self.radius:g} mm less sleeve, wall and base_wall leaves no room: the chamber "
                "would vanish",
            )

    @property
    def _inside(self) -> float:
        """Radius of the chamber."""
        return self.radius - self.sleeve - self.wall

    @property
    def _floor(self) -> float:
        """Height of the chamber's floor over the underside."""
        return self.sleeve + self.base_wall

    def layout(self) -> Layout:
        surfaces = (*self.ends, "cavity", "outer", "base")
        return Layout(
            regions=("body", "sleeve"),
            surfaces=(*surfaces, "symmetry") if self.symmetry else surfaces,
            cavities={"cavity": ("cavity",)},
            bending_axis=(0.0, 1.0, 0.0),
            symmetry={"symmetry": 1} if self.symmetry else {},
            length=self._span,
            clamp=self.ends[0],
            tip=self.ends[1],
            repeats=self.repeats,
        )

    def wall_normal(self, region: str, points: np.ndarray) -> np.ndarray:
        round_part = points * [0.0, 1.0, 1.0]
        flat = points[:, 2] < self.sleeve
        return np.where(flat[:, None], [0.0, 0.0, -1.0], round_part)

    def walls(self) -> tuple[Wall, ...]:
        walls = self.walls_between_curves(
            sleeve=self.sleeve, wall=self.wall, base_wall=self.base_wall
        )
        sleeve, *inside = walls
        return tuple(
            Wall(
                f"{w.name} and sleeve", w.thickness + sleeve.thickness, w.elements + sleeve.elements
            )
            for w in inside
        )

    def volumes(self) -> dict[str, float]:
        def above(radius: float, height: float) -> float:
            """Area of a circle above a height."""
            return radius**2 * acos(height / radius) - height * sqrt(radius**2 - height**2)

        half = 0.5 if self.symmetry else 1.0
        outside, core = above(self.radius, 0.0), above(self.radius - self.sleeve, self.sleeve)
        opening, (start, end) = above(self._inside, self._floor), self._chamber
        cavity = opening * (end - start)
        face = outside - opening if self.alone else outside
        return {
            "body": half * (core * self._span - cavity),
            "sleeve": half * (outside - core) * self._span,
            "cavity": half * cavity,
            **dict.fromkeys(self.ends, half * face),
            "base": half * 2 * self.radius * self._span,
        }

    def volume_tolerance(self, name: str) -> float:
        if name == "base":
            return 1e-9
        half = 0.5 if self.symmetry else 1.0

        def lost(radius: float, length: float) -> float:
            share = lacking(radius, self.mesh_size)
            return half * pi * radius**2 * share * length

        if name in self.ends:
            return lost(self.radius, 1.0) / self.volumes()[name]
        chamber = lost(self._inside, self._span)
        if name != "cavity":
            chamber += lost(self.radius - self.sleeve, self._span)
        if name == "sleeve":
            chamber += lost(self.radius, self._span)
        return chamber / self.volumes()[name]

    def _shapes(self, occ: Any) -> Shapes:
        size = 2 * self.radius

        def above(radius: float, height: float) -> Entities:
            disc = [(2, occ.addDisk(0, 0, 0, radius, radius))]
            left = 0.0 if self.symmetry else -size
            box = [(2, occ.addRectangle(left, height, 0, size - left, size))]
            return occ.intersect(disc, box)[0]

        return {
            "outside": above(self.radius, 0.0),
            "core": above(self.radius - self.sleeve, self.sleeve),
            "chamber": above(self._inside, self._floor),
        }

    def solid(self) -> Prisms:
        """The actuator as prisms painted over each other."""
        prisms = (
            Prism("sleeve", "outside", 0.0, self._span),
            Prism("body", "core", 0.0, self._span),
            Prism("cavity", "chamber", *self._chamber),
        )
        first, last = self.ends
        planes = [Plane(first, 0, 0.0), Plane(last, 0, self._span), Plane("base", 2, 0.0, True)]
        if self.symmetry:
            planes.append(Plane("symmetry", 1, 0.0))
        regions = self.layout().regions
        return Prisms(self._shapes, prisms, regions, ("cavity",), planes=tuple(planes))

    def build(self, gmsh: ModuleType) -> None:
        self.solid().build(gmsh)

    def mesh(self, gmsh: ModuleType) -> None:
        self.solid().mesh(gmsh, self.mesh_size, self.least_steps)


if __name__ == "__main__":
    main(FiberReinforced)
