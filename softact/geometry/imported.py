"""Base of the geometries that come out of a file of the user's: which names mean what."""

import os
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field

from softact.errors import NOT_UTF8, MeshError
from softact.files.text import NAMES_A_FILE, digest
from softact.geometry import part_axis
from softact.geometry.base import Geometry, ThroughWall, make_mesh
from softact.geometry.curved import are_curved
from softact.geometry.gmsh_groups import add_mesh
from softact.geometry.part_axis import Direction
from softact.geometry.part_names import PartName, PartNameOrNone
from softact.geometry.part_size import Drawn
from softact.geometry.periodic import match
from softact.geometry.saying import tell
from softact.geometry.subdivide import cut_mesh, fill
from softact.mesh.components import components, gap, part_names
from softact.mesh.file_mesh import FileMesh, of_model, only_named, without_inner_walls
from softact.mesh.joining import joined
from softact.mesh.layout import Layout, Repeats
from softact.units import Length, is_utf8

Names = Annotated[tuple[PartName, ...], Field(strict=False)]
Axis = Literal["x", "y", "z"]
Unit = Literal["um", "mm", "cm", "in", "ft", "m"]


class Imported(Geometry):
    """A solid with named parts out of a file. ``axis`` runs from the clamp to the tip; where it is
    x, z is up and y across."""

    file: Annotated[str, NAMES_A_FILE] = Field(description="path, seen from the file that names it")
    regions: Names = Field(("body",), description="names of the solids; each gets a material")
    surfaces: Names = Field((), description="further named surfaces, for layers, loads, contact")
    cavities: dict[PartName, Names] = Field(
        {"cavity": ("cavity",)}, description="cavity -> names of the surfaces that wall it"
    )
    clamp: PartNameOrNone = Field("clamp", description="surface at the clamped end; '' for none")
    tip: PartNameOrNone = Field("tip", description="surface at the tip; '' for none")
    repeats: tuple[PartName, PartName] | None = Field(
        None,
        strict=False,
        description="where the part is one module of a chain: its face at the module before and "
        "that at the module after, [left, right], in place of clamp and tip",
    )
    pitch: Length | None = Field(None, description="how far these two faces are apart along axis")
    axis: Direction = Field("x", description="runs from the clamp to the tip: x, -x, y, -y, z, -z")
    symmetry: dict[Axis, PartName] = Field(
        {}, description="coordinate that is zero in a symmetry plane -> surface in that plane"
    )
    separate: bool = Field(
        False, description="keep solids that touch apart; else they are joined where they touch"
    )
    unit: Unit | None = Field(
        None, description="in which the file is drawn, where it does not say so or says it wrong"
    )
    mesh_size: Length = Field(2.0, description="longest edge")
    through_wall: ThroughWall = None

    suffixes: ClassVar[tuple[str, ...]] = ()

    def faults(self) -> Iterator[tuple[str, str]]:
        """See ``Geometry.faults``."""
        yield from file_faults("file", self.file, self.suffixes)
        if not self.regions:
            yield "regions", "no solid is named; write the names of all solids of the file"
        if self.repeats and self.repeats[0] == self.repeats[1]:
            yield "repeats", f"'{self.repeats[0]}' is both faces; name the opposite one second"
        if (self.pitch is None) != (self.repeats is None):
            yield "pitch", "is the distance of the faces that repeats names; write both or none"
        for cavity, walls in self.cavities.items():
            if not walls:
                yield "cavities", f"'{cavity}' has no walls; write the names of its surfaces"

    def _too_many(self) -> Iterator[tuple[str, str]]:
        return iter(())  # nobody knows before the file is read

    def layout(self) -> Layout:
        """See ``Geometry.layout``."""
        planes = {name: "xyz".index(axis) for axis, name in self.symmetry.items()}
        walls = [name for names in self.cavities.values() for name in names]
        ends = [name for name in self.ends if name]
        return Layout(
            regions=tuple(self.regions),
            surfaces=tuple(dict.fromkeys((*ends, *walls, *self.surfaces, *planes))),
            cavities={name: tuple(walls) for name, walls in self.cavities.items()},
            clamp=self.ends[0],
            tip=self.ends[1],
            axis=part_axis.unit(self.axis),
            bending_axis=self._bending_axis(),
            symmetry=planes,
            length=self.pitch or 0.0,
            repeats=Repeats(*self.repeats) if self.repeats else None,
        )

    def module(self) -> Self:
        """See ``Geometry.module``: the part itself, where it is one."""
        return self if self.repeats else super().module()

    def _bending_axis(self) -> tuple[float, float, float] | None:
        if "y" not in self.symmetry:
            return None
        # One that runs the other way bends to the same side about the other way.
        return (0.0, -1.0 if self.axis.startswith("-") else 1.0, 0.0)

    def volumes(self) -> dict[str, float]:
        """See ``Geometry.volumes``: nobody knows them."""
        return {}

    def content(self) -> str:
        """A number that changes with the file's content, for what is kept by the spec's hash."""
        return digest(Path(self.file))

    @property
    def self_contained(self) -> bool:
        """Whether the mesh follows from the file's content and the parameters alone."""
        return False

    def drawn(self, gmsh: ModuleType) -> Drawn:
        """The size of the current model, which ``build`` has made."""
        return Drawn.of_model(gmsh)

    @property
    def scale(self) -> float:
        """mm of the unit of length in which ``build`` makes the current model."""
        return 1.0

    def mesh(self, gmsh: ModuleType) -> None:
        """See ``Geometry.mesh``; solids that touch are joined.

        Raises MeshError where there is no solid, or one has no name, or where the part and
        ``mesh_size`` do not fit each other.
        """
        self.build(gmsh)
        if not gmsh.model.getEntities(3):
            raise MeshError(
                "the file holds no solid: its surfaces, if any, do not close one (not watertight)"
            )
        drawn = self.drawn(gmsh)
        if not _tetrahedra(gmsh):
            drawn.refuse(self.mesh_size)
            gmsh.option.setNumber("Mesh.ElementOrder", 1)
            self._match_ends(gmsh)
            fill(gmsh, self.mesh_size, self.least_steps)
            if not _tetrahedra(gmsh):
                raise MeshError("gmsh made no tetrahedra in the solids of the file")
        if drawn.doubt:
            tell(drawn.doubt)
        cut_mesh(gmsh, self.least_steps)
        found = of_model(gmsh, self.scale, tell, are_curved())
        self._put_back(gmsh, only_named(found, self.layout(), _tetrahedra(gmsh)))

    def _match_ends(self, gmsh: ModuleType) -> None:
        """Have the two faces of a module meshed alike."""
        if self.repeats and self.pitch:
            shift = self.pitch * np.array(part_axis.unit(self.axis))
            match(gmsh, *self.repeats, shift)

    def look(self, gmsh: ModuleType) -> None:
        """See ``Geometry.look``: a finished mesh is read as for a run."""
        self.mesh(gmsh)

    def _put_back(self, gmsh: ModuleType, mesh: FileMesh) -> None:
        """Make the current model hold a mesh whose solids are joined where they touch."""
        if not self.separate:
            mesh, area = joined(mesh)
            if area:
                tell(f"solids of the mesh touch over {area:.4g} mm^2 and are joined there")
        walls = {name for names in self.layout().cavities.values() for name in names}
        mesh = without_inner_walls(mesh, walls)
        tell_parts(mesh)
        self._refuse_turned(mesh)
        add_mesh(gmsh, mesh.points, mesh.regions, mesh.by_names(), mesh.curves)

    def _refuse_turned(self, mesh: FileMesh) -> None:
        """Raises MeshError where the tip lies on the wrong side of the clamp: measures along
        ``axis`` would have the wrong sign."""
        surfaces = mesh.surfaces
        if not {*self.ends} <= surfaces.keys():
            return
        clamp, tip = (mesh.points[surfaces[name]].mean(axis=(0, 1)) for name in self.ends)
        way = tip - clamp
        if way @ part_axis.unit(self.axis) < -0.5 * np.linalg.norm(way):
            longest = int(np.argmax(np.abs(way)))
            wanted = ("-" if way[longest] < 0 else "") + "xyz"[longest]
            raise MeshError(
                f"'{self.ends[1]}' lies behind '{self.ends[0]}' along {self.axis}, which has to "
                f"run from the clamp to the tip; write axis: {wanted}"
            )

    @property
    def ends(self) -> tuple[str, str]:
        """Names of clamp and tip, or of the faces at which a module goes on."""
        left, right = self.repeats or (self.clamp, self.tip)
        return left, right


def file_faults(field: str, name: str, suffixes: Sequence[str]) -> Iterator[tuple[str, str]]:
    """What is wrong with a name of a file in a field, see ``Geometry.faults``."""
    path = Path(name)
    if not is_utf8(name):
        yield field, NOT_UTF8
    elif path.suffix.lower() not in suffixes:
        yield field, f"'{path.name}' is none of {', '.join(suffixes)}"
    elif not os.path.isfile(path):  # False, not an error, for what no file can be named
        yield field, f"there is no file '{path}'"


def _tetrahedra(gmsh: ModuleType) -> int:
    return sum(len(tags) for tags in gmsh.model.mesh.getElements(3)[1])


def tell_parts(mesh: FileMesh) -> None:
    """Say of how many parts a mesh is, and how far apart they are."""
    cells = mesh.cells
    labels = components(mesh.points, cells)
    count = int(labels.max()) + 1
    if count == 1:
        tell(f"1 part of {len(cells)} tetrahedra")
        return
    names = part_names(mesh.points, cells, mesh.region, list(mesh.regions), labels)
    for label, name in enumerate(names):
        tell(
            f"part {label + 1} of {count}, {name}, {int(np.sum(labels == label))} tetrahedra, "
            f"{gap(mesh.points, cells, labels, label)}"
        )


_digests: dict[str, str] = {}


def mesh_digest(geometry: Imported, curved: bool) -> str:
    """Digest of the mesh of a geometry, or why there is none; made once in a process. curved: see
    ``make_mesh``."""
    name = f"{type(geometry).__name__} {geometry.model_dump_json()} {curved}"
    if name not in _digests:
        with tempfile.TemporaryDirectory(prefix="softact-key-") as folder:
            path = Path(folder) / "mesh.msh"
            try:
                make_mesh(geometry, path, curved=curved)
                _digests[name] = digest(path)
            except MeshError as error:
                _digests[name] = "; ".join(error.lines)
    return _digests[name]
