"""Base of the geometries that come out of a file of the user's: which names mean what."""

import hashlib
from pathlib import Path
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from softact.errors import MeshError
from softact.geometry import Geometry, Layout, ThroughWall
from softact.subdivide import TETRAHEDRON, cut_mesh, fill
from softact.units import Length

Names = Annotated[tuple[str, ...], Field(strict=False)]
Axis = Literal["x", "y", "z"]


class Imported(Geometry):
    """A solid with named parts out of a file. x runs from the clamp to the tip, z up, y across."""

    file: str = Field(description="path; relative to the spec")
    regions: Names = Field(("body",), description="names of the solids; each gets a material")
    surfaces: Names = Field((), description="further named surfaces, for layers, loads, contact")
    cavities: dict[str, Names] = Field(
        {"cavity": ("cavity",)}, description="cavity -> names of the surfaces that wall it"
    )
    clamp: str = Field("clamp", description="surface at the clamped end; '' for none")
    tip: str = Field("tip", description="surface at the tip; '' for none")
    symmetry: dict[Axis, str] = Field(
        {}, description="coordinate that is zero in a symmetry plane -> surface in that plane"
    )
    mesh_size: Length = Field(2.0, description="longest edge")
    through_wall: ThroughWall = None

    suffixes: ClassVar[tuple[str, ...]] = ()

    def faults(self):
        path = Path(self.file)
        if path.suffix.lower() not in self.suffixes:
            yield "file", f"'{path.name}' is none of {', '.join(self.suffixes)}"
        elif not path.is_file():
            yield "file", f"there is no file '{path}'"
        if not self.regions:
            yield "regions", "no solid is named; write the names of all solids of the file"
        for cavity, walls in self.cavities.items():
            if not walls:
                yield "cavities", f"'{cavity}' has no walls; write the names of its surfaces"

    def _too_many(self):
        return iter(())  # nobody knows before it is meshed

    def layout(self) -> Layout:
        planes = {name: "xyz".index(axis) for axis, name in self.symmetry.items()}
        walls = [name for names in self.cavities.values() for name in names]
        ends = [name for name in (self.clamp, self.tip) if name]
        return Layout(
            regions=tuple(self.regions),
            surfaces=tuple(dict.fromkeys((*ends, *walls, *self.surfaces, *planes))),
            cavities={name: tuple(walls) for name, walls in self.cavities.items()},
            clamp=self.clamp,
            tip=self.tip,
            bending_axis=(0.0, 1.0, 0.0) if "y" in self.symmetry else None,
            symmetry=planes,
        )

    def volumes(self) -> dict[str, float]:
        return {}

    def content(self) -> str:
        """A number that changes with the file's content, for what is kept by the spec's hash."""
        return hashlib.sha256(Path(self.file).read_bytes()).hexdigest()[:16]

    def mesh(self, gmsh) -> None:
        """See ``Geometry.mesh``; raises MeshError where there is no solid, or one has no name."""
        self.build(gmsh)
        if not gmsh.model.getEntities(3):
            raise MeshError(
                "the file holds no solid: its surfaces, if any, do not close one (not watertight)"
            )
        if not len(gmsh.model.mesh.getElementsByType(TETRAHEDRON)[0]):
            fill(gmsh, self.mesh_size, self.least_steps)
        named = {
            entity
            for dimension, group in gmsh.model.getPhysicalGroups(3)
            if gmsh.model.getPhysicalName(dimension, group) in self.regions
            for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, group)
        }
        others = [tag for _, tag in gmsh.model.getEntities(3) if tag not in named]
        lost = sum(len(gmsh.model.mesh.getElementsByType(TETRAHEDRON, tag)[0]) for tag in others)
        if lost and named:
            raise MeshError(
                f"{lost} tetrahedra are in no solid named under regions "
                f"({', '.join(self.regions)}); name all solids"
            )
        cut_mesh(gmsh, self.least_steps)
