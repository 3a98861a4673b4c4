"""A bending tube (tentacle): a round rod with one, two, three or more chambers beside its axis.

Suzumori, Iikura and Tanaka (1992), IEEE Control Systems 12:21 (three chambers); Cianchetti et al.
(2014), Soft Robotics 1:122 (chambers in sleeves of their own). Run by itself it writes a mesh:
``python geometries/bending_tube.py --chambers 3 -o tentacle.msh``.
"""

from dataclasses import dataclass
from math import cos, pi, sin
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from softact.boxes import Plane
from softact.geometry import THINNEST, Geometry, Layout, main
from softact.prisms import Prism, Prisms, Shapes
from softact.rounds import corner_radius
from softact.units import Length


@dataclass(frozen=True)
class Chamber:
    """Where a chamber lies in the section: y and z of its middle, mm; ``share``: how much of it is
    meshed."""

    y: float
    z: float
    share: float


class BendingTube(Geometry):
    """A round rod along x with round chambers around its axis, closed at both ends.

    cavity_1 (or ``cavity``, of one) is the topmost; the others follow towards y and down. A chamber
    in a soft rod swells instead of making it longer, and the rod hardly bends: give the chambers a
    ``lining`` or the rod a ``sleeve``, regions for a law with fibres that run around them.
    """

    type: Literal["bending_tube"] = "bending_tube"
    chambers: Annotated[int, Field(ge=1, le=12)] = Field(3, description="number of chambers")
    length: Length = Field(100.0, description="overall length")
    radius: Length = Field(12.0, description="radius of the outside")
    chamber_radius: Length = Field(3.0, description="radius of the air space of a chamber")
    eccentricity: Length = Field(6.5, description="from the axis to the middle of a chamber")
    lining: Length | None = Field(
        None, description="thickness of the region around each chamber; by default there is none"
    )
    sleeve: Length | None = Field(
        None, description="thickness of the region at the outside; by default there is none"
    )
    bore: Length | None = Field(
        None, description="radius of an open bore along the axis; by default there is none"
    )
    end: Length = Field(5.0, description="thickness of the solid ends")
    symmetry: bool = Field(
        False,
        description="model the half y >= 0 only: the cavities of the other half get the pressures "
        "of their mirror images",
    )
    mesh_size: Length = Field(4.0, description="longest edge")

    def faults(self):
        if self.length - 2 * self.end < THINNEST:
            yield "end", f"{self.end:g} mm on both sides fills the length: no chamber is left"
        filled, within = self.chamber_radius + (self.lining or 0.0), self.radius - self.skin
        if within - self.eccentricity - filled < THINNEST:
            yield (
                "radius",
                f"{self.radius:g} mm leaves no wall outside of the chambers, which reach to "
                f"{self.eccentricity + filled + self.skin:g} mm from the axis, lining and sleeve "
                "included",
            )
        apart = 2 * self.eccentricity * sin(pi / self.chambers)
        if self.chambers > 1 and apart - 2 * filled < THINNEST:
            yield (
                "eccentricity",
                f"puts the middles of chambers {apart:g} mm apart, which are {2 * filled:g} mm "
                "wide: the walls between them would vanish",
            )
        if self.bore is not None and self.eccentricity - filled - self.bore < THINNEST:
            yield "bore", f"{self.bore:g} mm reaches to the chambers: their walls would vanish"

    @property
    def skin(self) -> float:
        """Thickness of the sleeve, 0 where there is none."""
        return self.sleeve or 0.0

    def _meshed(self) -> dict[str, Chamber]:
        """Cavity -> its chamber, of the part that is meshed."""
        found = {}
        for number in range(self.chambers):
            angle = pi / 2 - 2 * pi * number / self.chambers
            y, z = self.eccentricity * cos(angle), self.eccentricity * sin(angle)
            cut = self.symmetry and abs(y) < THINNEST
            if not self.symmetry or cut or y > 0:
                name = f"cavity_{number + 1}" if self.chambers > 1 else "cavity"
                found[name] = Chamber(0.0 if abs(y) < THINNEST else y, z, 0.5 if cut else 1.0)
        return found

    def layout(self) -> Layout:
        cavities = tuple(self._meshed())
        further = {"lining": self.lining, "sleeve": self.sleeve}
        surfaces = ["clamp", "tip", "outer", *cavities]
        surfaces += ["bore"] if self.bore is not None else []
        in_plane = self.symmetry or self.chambers <= 2
        return Layout(
            regions=("body", *(name for name, there in further.items() if there is not None)),
            surfaces=(*surfaces, "symmetry") if self.symmetry else tuple(surfaces),
            cavities={name: (name,) for name in cavities},
            bending_axis=(0.0, 1.0, 0.0) if in_plane else None,
            symmetry={"symmetry": 1} if self.symmetry else {},
            length=self.length,
        )

    def wall_normal(self, region: str, points: np.ndarray) -> np.ndarray:
        """Along the radius: of the nearest chamber in the lining, of the rod elsewhere."""
        section = points * (0.0, 1.0, 1.0)
        if region != "lining":
            return section
        middles = np.array([(0.0, chamber.y, chamber.z) for chamber in self._meshed().values()])
        arms = section[:, None] - middles
        nearest = np.linalg.norm(arms, axis=2).argmin(axis=1)
        return arms[np.arange(len(points)), nearest]

    def volumes(self) -> dict[str, float]:
        half, inside = (0.5 if self.symmetry else 1.0), self.length - 2 * self.end
        whole = sum(chamber.share for chamber in self._meshed().values())
        air, wide = self.chamber_radius, self.chamber_radius + (self.lining or 0.0)
        bore = half * pi * (self.bore or 0.0) ** 2
        face = half * pi * self.radius**2 - bore
        core = half * pi * (self.radius - self.skin) ** 2 - bore
        found = {
            "body": core * self.length - whole * pi * wide**2 * inside,
            "clamp": face,
            "tip": face,
        }
        for name, chamber in self._meshed().items():
            found[name] = chamber.share * pi * air**2 * inside
        if self.lining is not None:
            found["lining"] = whole * pi * (wide**2 - air**2) * inside
        if self.sleeve is not None:
            found["sleeve"] = (face - core) * self.length
        return found

    def _shapes(self, occ, size: float | None = None) -> Shapes:
        """Discs of rod, chambers and bore; size: of the mesh, whose polygons have their areas."""
        box = 2 * self.radius

        def disc(y, z, radius):
            cut = self.symmetry and y == 0.0
            if size is not None:
                radius = corner_radius(radius, size, pi / 2 if cut else 2 * pi)
            face = [(2, occ.addDisk(y, z, 0, radius, radius))]
            if cut:
                face, _ = occ.intersect(face, [(2, occ.addRectangle(0, -box, 0, box, 2 * box))])
            return face

        shapes = {"rod": disc(0.0, 0.0, self.radius)}
        if self.sleeve is not None:
            shapes["core"] = disc(0.0, 0.0, self.radius - self.skin)
        for name, chamber in self._meshed().items():
            if self.lining is not None:
                wide = self.chamber_radius + self.lining
                shapes[f"lining of {name}"] = disc(chamber.y, chamber.z, wide)
            shapes[name] = disc(chamber.y, chamber.z, self.chamber_radius)
        if self.bore is not None:
            shapes["bore"] = disc(0.0, 0.0, self.bore)
        return shapes

    def solid(self, size: float | None = None) -> Prisms:
        """The rod as prisms painted over each other; size: see ``_shapes``."""
        whole, inside = (0.0, self.length), (self.end, self.length - self.end)
        prisms = [Prism("body", "rod", *whole)]
        if self.sleeve is not None:
            prisms = [Prism("sleeve", "rod", *whole), Prism("body", "core", *whole)]
        for name in self._meshed():
            if self.lining is not None:
                prisms.append(Prism("lining", f"lining of {name}", *inside))
            prisms.append(Prism(name, name, *inside))
        hollows = tuple(self._meshed())
        if self.bore is not None:  # open at both ends, but its wall has a name as those of cavities
            prisms.append(Prism("bore", "bore", *whole))
            hollows = (*hollows, "bore")
        planes = [Plane("clamp", 0, 0.0), Plane("tip", 0, self.length)]
        planes += [Plane("symmetry", 1, 0.0)] if self.symmetry else []
        return Prisms(
            lambda occ: self._shapes(occ, size),
            tuple(prisms),
            self.layout().regions,
            hollows,
            planes=tuple(planes),
        )

    def build(self, gmsh) -> None:
        self.solid().build(gmsh)

    def mesh(self, gmsh) -> None:
        self.solid(self.mesh_size).mesh(gmsh, self.mesh_size)


if __name__ == "__main__":
    main(BendingTube)
