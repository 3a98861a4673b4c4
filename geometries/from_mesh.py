"""A geometry out of a mesh file of another program, or out of closed surfaces such as an STL.

Run by itself it writes a mesh: ``python geometries/from_mesh.py --file body.stl -o body.msh``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.errors import MeshError
from softact.files.text import NAMES_A_FILE, digest
from softact.geometry.base import main
from softact.geometry.curved import are_curved
from softact.geometry.imported import Imported, file_faults
from softact.geometry.mesh_files import SURFACES, VOLUMES, fill_shells, read, shells
from softact.geometry.mesh_names import automatic, chosen
from softact.geometry.part_size import Drawn
from softact.geometry.saying import tell
from softact.geometry.step_faces import AnySelection, Selection
from softact.geometry.step_names import UNITS
from softact.geometry.subdivide import cut_mesh, fill
from softact.mesh.file_mesh import FileMesh, of_model, only_named
from softact.units import show


class FromMesh(Imported):
    """A mesh of tetrahedra (.msh, .vtu, .vtk, .inp, .med, .bdf, .xdmf), with named groups or
    without, or closed surfaces (.stl, .ply, .off), which gmsh fills.

    The names of groups are those of ``regions`` and surfaces; solids without a name are
    ``solid_1``, ``solid_2``, ..., and the only one may have any. Whole numbers at the cells, as in
    .vtu, make groups such as ``region_0``. ``select`` names further triangles of the skin. Where
    the file names no surface, the flat parts at the two ends along ``axis`` are clamp and tip, the
    walls of rooms inside ``cavity`` (one by one ``cavity_1``, ...), and all else is ``outer``.
    """

    type: Literal["from_mesh"] = "from_mesh"
    air: tuple[Annotated[str, NAMES_A_FILE], ...] = Field(
        (),
        strict=False,
        description="files of the closed surfaces of the rooms inside, where `file` has none",
    )
    select: dict[str, AnySelection] = Field(
        {}, description="surface -> triangles of the skin, by {plane, normal, box}"
    )
    remesh: bool = Field(
        True, description="mesh closed surfaces anew with mesh_size; else their triangles stay"
    )
    suffixes: ClassVar[tuple[str, ...]] = (*VOLUMES, *SURFACES)

    def content(self) -> str:
        """See ``Imported.content``; the files of the air count too."""
        return " ".join(digest(Path(name)) for name in (self.file, *self.air))

    @property
    def self_contained(self) -> bool:
        """It is."""
        return True

    @property
    def scale(self) -> float:
        """mm of the unit in which the file is written."""
        return UNITS[self.unit or "mm"]

    def faults(self) -> Iterator[tuple[str, str]]:
        """See ``Geometry.faults``."""
        yield from super().faults()
        for name in self.air:
            yield from file_faults("air", name, SURFACES)
        if self.air and not self._of_surfaces:
            yield "air", f"{Path(self.file).name} holds tetrahedra: its rooms are those left free"
        for name, selection in self.select.items():
            if name not in self.layout().surfaces:
                yield "select", f"{show(name)} is no surface of this geometry; add it to surfaces"
            if selection.numbers or selection.beside:
                yield "select", f"{show(name)}: a mesh has no faces; write plane, normal or box"

    def mesh(self, gmsh: ModuleType) -> None:
        """See ``Geometry.mesh``; solids that touch are joined."""
        found = self._filled(gmsh) if self._of_surfaces else read(Path(self.file), self.scale)
        if not found.regions:
            raise MeshError(f"{Path(self.file).name} holds no tetrahedra; surfaces come as .stl")
        size = Drawn(np.ptp(found.points, axis=0), unit=self.unit or "mm")
        if size.doubt:
            tell(size.doubt)
        tell(f"{Path(self.file).name}: {len(found.cells)} tetrahedra, {size.sides}")
        named = self._named(found)
        self._put_back(gmsh, only_named(named, self.layout(), len(found.cells)))

    @property
    def _of_surfaces(self) -> bool:
        return Path(self.file).suffix.lower() in SURFACES

    def _filled(self, gmsh: ModuleType) -> FileMesh:
        """The room between the shells of a file, meshed."""
        points, found = shells([Path(name) for name in (self.file, *self.air)], self.scale)
        tell(f"{len(found)} closed shells")
        for anew in (self.remesh, False):
            gmsh.model.add("shells")
            try:
                fill_shells(gmsh, points, found, anew)
                gmsh.option.setNumber("Mesh.ElementOrder", 1)
                if anew:
                    fill(gmsh, self.mesh_size, self.least_steps)
                else:
                    gmsh.option.setNumber("Mesh.MeshSizeMax", self.mesh_size)
                    gmsh.model.mesh.generate(3)
                cut_mesh(gmsh, self.least_steps)
                break
            except MeshError:
                raise
            except Exception as error:  # gmsh's own are of this kind
                if not anew:
                    reason = " ".join(str(error).split())
                    raise MeshError(f"gmsh cannot fill the surfaces: {reason}") from None
                tell("gmsh cannot mesh the surfaces anew: their triangles stay")
        for number, (_, tag) in enumerate(gmsh.model.getEntities(3), start=1):
            gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [tag]), f"solid_{number}")
        return of_model(gmsh, 1.0, tell, are_curved())

    def _named(self, found: FileMesh) -> FileMesh:
        """With the names that the file does not give."""
        regions, surfaces = dict(found.regions), dict(found.surfaces)
        if len(regions) == 1 == len(self.regions):
            regions = {self.regions[0]: next(iter(regions.values()))}
        whole = replace(found, regions=regions)
        if not surfaces:
            surfaces = automatic(whole, *self.ends, self.axis)
            for name in self.layout().surfaces:
                if name in surfaces and name not in self.select:
                    tell(f"no surface has a name: '{name}' was found by its place")
        selections = {
            # Out of a job they come as plain data that has been checked.
            name: Selection.model_construct(**(s if isinstance(s, dict) else s.model_dump()))
            for name, s in self.select.items()
        }
        surfaces |= chosen(whole, selections)
        return replace(whole, surfaces=surfaces)


if __name__ == "__main__":
    main(FromMesh)
