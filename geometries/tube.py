"""A hollow cylinder between two end planes, or a quarter or half of it: the pressurised pipe.

Run by itself it writes a mesh: ``python geometries/tube.py --length "30 mm" -o tube.msh``.
"""

from collections.abc import Iterator
from math import pi
from types import ModuleType
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import Layout, ThroughWall, main
from softact.geometry.boxes import Plane
from softact.geometry.chains import Chain, OneModule
from softact.geometry.prisms import Entities, Prism, Prisms, Shapes, lacking
from softact.geometry.walls import Wall
from softact.units import Length

# Angle of each part about x, and the coordinate that is zero in its symmetry planes.
PARTS: dict[str, tuple[float, dict[str, int]]] = {
    "quarter": (pi / 2, {"symmetry_y": 1, "symmetry_z": 2}),
    "half": (pi, {"symmetry_y": 1}),
    "whole": (2 * pi, {}),
}


class Tube(Chain):
    """A quarter (y <= 0, z >= 0), half or all of a hollow cylinder along x, open at both ends.

    It has no closed cavity: press on its wall with ``surface_pressure: {bore: ...}``. A module is a
    slice as long as an element, extruded.
    """

    meets_itself: ClassVar[bool] = False

    type: Literal["tube"] = "tube"
    inner_radius: Length = Field(5.0, description="radius of the bore")
    outer_radius: Length = Field(7.0, description="radius of the outside")
    length: Length = Field(10.0, description="extent along x")
    part: Literal["quarter", "half", "whole"] = Field(
        "quarter",
        description="half: y <= 0; whole: for what is not symmetric, such as one family of fibres",
    )
    mesh_size: Length = Field(1.5, description="edge length of the tetrahedra")
    through_wall: ThroughWall = None
    module_alone: OneModule = None

    @property
    def pitches(self) -> float:
        """A module is a slice as long as an element."""
        return self.length / self.mesh_size

    @property
    def _span(self) -> float:
        """Length of what is meshed."""
        return self.mesh_size if self.alone else self.length

    def layout(self) -> Layout:
        symmetry, ends = PARTS[self.part][1], self.ends
        return Layout(
            regions=("body",),
            surfaces=("bore", "outer", *ends, *symmetry),
            cavities={},
            symmetry=symmetry,
            length=self._span,
            clamp=ends[0],
            tip=ends[1],
            repeats=self.repeats,
        )

    def walls(self) -> tuple[Wall, ...]:
        """None that bends."""
        return ()

    def volumes(self) -> dict[str, float]:
        a, b, length = self.inner_radius, self.outer_radius, self._span
        angle, symmetry = PARTS[self.part]
        cuts = 2 / max(len(symmetry), 1)  # in each plane
        return {
            "body": angle / 2 * (b**2 - a**2) * length,
            "bore": angle * a * length,
            "outer": angle * b * length,
            **dict.fromkeys(symmetry, cuts * (b - a) * length),
        }

    def wall_normal(self, region: str, points: np.ndarray) -> np.ndarray:
        """Along the radius, so that fibres at an angle to the axis are helices."""
        return points * (0.0, 1.0, 1.0)

    def faults(self) -> Iterator[tuple[str, str]]:
        if self.inner_radius >= self.outer_radius:
            yield (
                "inner_radius",
                f"{self.inner_radius:g} mm is not less than outer_radius "
                f"({self.outer_radius:g} mm): the wall would vanish",
            )

    def volume_tolerance(self, name: str) -> float:
        # A chord h lies at most h^2/(8 R) under its circle; chords may be longer than mesh_size.
        a, b = self.inner_radius, self.outer_radius
        depth = (1.5 * min(self.mesh_size, b)) ** 2 / (8 * a)
        if name in PARTS["quarter"][1]:
            return 1e-9
        if self.alone:
            lost = a**2 * lacking(a, self.mesh_size), b**2 * lacking(b, self.mesh_size)
            return sum(lost) / (b**2 - a**2) if name == "body" else lacking(a, self.mesh_size)
        return 2 * b * depth / (b**2 - a**2) if name == "body" else 2 * depth / a

    def _shapes(self, occ: Any) -> Shapes:
        """Sections of the outside and of the bore."""
        size, (_, symmetry) = 2 * self.outer_radius, PARTS[self.part]
        width = size if "symmetry_y" in symmetry else 2 * size
        low = 0.0 if "symmetry_z" in symmetry else -size

        def part(radius: float) -> Entities:
            disc = [(2, occ.addDisk(0, 0, 0, radius, radius))]
            box = [(2, occ.addRectangle(-size, low, 0, width, size - low))]
            return occ.intersect(disc, box)[0]

        return {"outside": part(self.outer_radius), "bore": part(self.inner_radius)}

    def extruded(self) -> Prisms:
        """It as prisms painted over each other."""
        prisms = (
            Prism("body", "outside", 0.0, self._span),
            Prism("bore", "bore", 0.0, self._span),
        )
        first, last = self.ends
        planes = [Plane(first, 0, 0.0), Plane(last, 0, self._span)]
        planes += [Plane(name, axis, 0.0) for name, axis in PARTS[self.part][1].items()]
        return Prisms(self._shapes, prisms, ("body",), ("bore",), planes=tuple(planes))

    def mesh(self, gmsh: ModuleType) -> None:
        if not self.alone:
            return super().mesh(gmsh)
        self.extruded().mesh(gmsh, self.mesh_size, self.least_steps)

    def build(self, gmsh: ModuleType) -> None:
        occ = gmsh.model.occ
        along = (0, 0, 0, self._span, 0, 0)
        angle, _ = PARTS[self.part]
        outer = occ.addCylinder(*along, self.outer_radius, angle=angle)
        inner = occ.addCylinder(*along, self.inner_radius, angle=angle)
        occ.cut([(3, outer)], [(3, inner)])
        occ.synchronize()
        names = self._names(gmsh)
        for name in self.layout().surfaces:
            tags = [tag for tag, found in names.items() if found == name]
            gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, tags), name)
        body = [tag for _, tag in gmsh.model.getEntities(3)]
        gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, body), "body")

    def _names(self, gmsh: ModuleType) -> dict[int, str]:
        names = {}
        for _, tag in gmsh.model.getEntities(2):
            lower, upper = np.reshape(gmsh.model.getBoundingBox(2, tag), (2, 3))
            flat = upper - lower < 1e-4
            if flat[0]:
                names[tag] = self.ends[int(upper[0] > self._span / 2)]
            elif flat.any():
                names[tag] = "symmetry_y" if flat[1] else "symmetry_z"
            else:
                middle = (self.inner_radius + self.outer_radius) / 2
                names[tag] = "bore" if upper[1:].max() < middle else "outer"
        return names


if __name__ == "__main__":
    main(Tube)
