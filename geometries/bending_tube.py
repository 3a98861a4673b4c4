"""A round tube with one, two or three chambers beside its axis: a tentacle.

Pressure in one chamber bends it away from that chamber, in all of them it grows longer. Run by
itself it writes a mesh: ``python geometries/bending_tube.py --chambers 3 -o tube.msh``.
"""

from collections.abc import Iterator
from math import cos, pi, sin
from types import ModuleType
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import THINNEST, Geometry, Layout, ThroughWall, main
from softact.geometry.boxes import Plane
from softact.geometry.prisms import Entities, Prism, Prisms, Shapes, lacking
from softact.geometry.walls import Wall
from softact.units import Length


class BendingTube(Geometry):
    """A round solid along x with round chambers whose axes lie beside its own.

    The chambers are spread evenly around the axis, the first on top, the others following towards
    y and down: ``cavity``, or ``cavity_1``, ``cavity_2``, ``cavity_3``. A sleeve is a region of its
    own outside, for a winding.
    """

    type: Literal["bending_tube"] = "bending_tube"
    chambers: Annotated[int, Field(ge=1, le=3)] = Field(3, description="number of chambers")
    length: Length = Field(80.0, description="overall length")
    radius: Length = Field(10.0, description="radius of the outside")
    chamber_radius: Length = Field(3.0, description="radius of a chamber")
    eccentricity: Length = Field(5.0, description="from the axis to that of a chamber")
    sleeve: Length | None = Field(
        None, description="thickness of an outer region for a winding; default: none"
    )
    end: Length = Field(5.0, description="thickness of the solid ends")
    symmetry: bool = Field(
        True,
        description="model the half y >= 0 only: cavity_3 gets the pressure of cavity_2",
    )
    mesh_size: Length = Field(3.0, description="longest edge")
    through_wall: ThroughWall = None

    def faults(self) -> Iterator[tuple[str, str]]:
        if self.length - 2 * self.end < THINNEST:
            yield "end", f"{self.end:g} mm on both sides fills the length: chambers would vanish"
        if self._outer_wall < THINNEST:
            yield (
                "eccentricity",
                f"{self.eccentricity:g} mm and chambers of {self.chamber_radius:g} mm reach the "
                f"sleeve or the outside at {self._core:g} mm: the wall would vanish",
            )
        if self.chambers > 1 and self._between < THINNEST:
            yield (
                "chamber_radius",
                f"{self.chambers} chambers of {self.chamber_radius:g} mm, {self.eccentricity:g} mm "
                "from the axis, run into each other: the walls between them would vanish",
            )

    @property
    def _core(self) -> float:
        """Radius of what is inside the sleeve."""
        return self.radius - (self.sleeve or 0.0)

    @property
    def _outer_wall(self) -> float:
        return self._core - self.eccentricity - self.chamber_radius

    @property
    def _between(self) -> float:
        """Wall between two chambers."""
        return 2 * self.eccentricity * sin(pi / self.chambers) - 2 * self.chamber_radius

    def centres(self) -> dict[str, tuple[float, float]]:
        """Cavity -> y and z of its axis; without those whose mirror images are meshed."""
        found = {}
        for number in range(self.chambers):
            turn = 2 * pi * number / self.chambers
            y, z = self.eccentricity * sin(turn), self.eccentricity * cos(turn)
            name = f"cavity_{number + 1}" if self.chambers > 1 else "cavity"
            if not self.symmetry or y > -THINNEST:
                found[name] = (y if abs(y) > THINNEST else 0.0), z
        return found

    def layout(self) -> Layout:
        cavities = tuple(self.centres())
        return Layout(
            regions=("body", "sleeve") if self.sleeve else ("body",),
            surfaces=("clamp", "tip", *cavities, "outer", *(["symmetry"] * self.symmetry)),
            cavities={name: (name,) for name in cavities},
            bending_axis=(0.0, 1.0, 0.0) if self.symmetry or self.chambers < 3 else None,
            symmetry={"symmetry": 1} if self.symmetry else {},
            length=self.length,
        )

    def wall_normal(self, region: str, points: np.ndarray) -> np.ndarray:
        """Along the radius, so that fibres in the sleeve are helices."""
        return points * [0.0, 1.0, 1.0]

    def walls(self) -> tuple[Wall, ...]:
        thick = {"outer wall": self._outer_wall}
        if self.chambers > 1:
            thick["wall between chambers"] = self._between
        return self.walls_between_curves(**thick)

    def volumes(self) -> dict[str, float]:
        half = 0.5 if self.symmetry else 1.0
        whole, core = half * pi * self.radius**2, half * pi * self._core**2
        inside = self.length - 2 * self.end
        found = {
            name: pi * self.chamber_radius**2 * inside * (1.0 if y or not self.symmetry else 0.5)
            for name, (y, _) in self.centres().items()
        }
        body = core * self.length - sum(found.values())
        sleeve = {"sleeve": (whole - core) * self.length} if self.sleeve else {}
        return {"body": body, **sleeve, **found, "clamp": whole, "tip": whole}

    def volume_tolerance(self, name: str) -> float:
        half = 0.5 if self.symmetry else 1.0

        def lost(radius: float, length: float) -> float:
            return half * pi * radius**2 * lacking(radius, self.mesh_size) * length

        if name in ("clamp", "tip"):
            return lacking(self.radius, self.mesh_size)
        if name.startswith("cavity"):
            return lacking(self.chamber_radius, self.mesh_size)
        off = lost(self.radius, self.length) + lost(self._core, self.length)
        off += self.chambers * lost(self.chamber_radius, self.length)
        return off / self.volumes()[name]

    def _shapes(self, occ: Any) -> Shapes:
        size = 2 * self.radius

        def disc(radius: float, y: float = 0.0, z: float = 0.0) -> Entities:
            whole = [(2, occ.addDisk(y, z, 0, radius, radius))]
            if not self.symmetry:
                return whole
            return occ.intersect(whole, [(2, occ.addRectangle(0, -size, 0, size, 2 * size))])[0]

        shapes = {"outside": disc(self.radius)}
        if self.sleeve:
            shapes["core"] = disc(self._core)
        return shapes | {
            name: disc(self.chamber_radius, y, z) for name, (y, z) in self.centres().items()
        }

    def solid(self) -> Prisms:
        """The tube as prisms painted over each other."""
        along = self.end, self.length - self.end
        prisms = [Prism("sleeve" if self.sleeve else "body", "outside", 0.0, self.length)]
        if self.sleeve:
            prisms.append(Prism("body", "core", 0.0, self.length))
        prisms += [Prism(name, name, *along) for name in self.centres()]
        planes = [Plane("clamp", 0, 0.0), Plane("tip", 0, self.length)]
        if self.symmetry:
            planes.append(Plane("symmetry", 1, 0.0))
        cavities, regions = tuple(self.centres()), self.layout().regions
        return Prisms(self._shapes, tuple(prisms), regions, cavities, planes=tuple(planes))

    def build(self, gmsh: ModuleType) -> None:
        self.solid().build(gmsh)

    def mesh(self, gmsh: ModuleType) -> None:
        self.solid().mesh(gmsh, self.mesh_size, self.least_steps)


if __name__ == "__main__":
    main(BendingTube)
