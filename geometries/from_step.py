"""A geometry out of a user's STEP file.

Run by itself it writes a mesh: ``python geometries/from_step.py --file part.step -o part.msh``.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.errors import MeshError
from softact.geometry import step_drawing
from softact.geometry.base import main
from softact.geometry.imported import Imported
from softact.geometry.part_axis import component
from softact.geometry.saying import tell
from softact.geometry.step_faces import AnySelection, Face, Selection
from softact.geometry.step_part import StepPart, numbers_of
from softact.units import Length, show

#: Part of the mesh size, and of the size of the part, below which a face is a sliver.
NARROW, NARROW_PART = 0.05, 1e-3


class FromStep(Imported):
    """A STEP file, with names for its solids and faces or without.

    The names of its solids are those of ``regions``, the names of its faces those of all surfaces;
    several faces may share a name. A solid without a name of its own has that of its product, and
    is ``solid_1``, ``solid_2``, ... by its place in the file, too; the only solid may go without.
    ``select`` names further faces. Where no face of the file has a name, the flat faces at the
    two ends along ``axis`` are the clamp and the tip, the walls of the rooms inside ``cavity`` (one
    by one ``cavity_1``, ``cavity_2``, ...), and what is left outside is ``outer``.
    ``softact validate`` lists what it finds.
    """

    type: Literal["from_step"] = "from_step"
    select: dict[str, AnySelection] = Field(
        {}, description="surface -> numbers of its faces, or {numbers, plane, normal, box, beside}"
    )
    heal: Length | None = Field(
        None,
        description="OCC removes edges and faces narrower than this and closes gaps; names of the "
        "file may go, numbers count anew",
    )
    suffixes: ClassVar[tuple[str, ...]] = (".step", ".stp")

    @property
    def self_contained(self) -> bool:
        """It is: a file that refers to others is refused."""
        return True

    def faults(self) -> Iterator[tuple[str, str]]:
        """See ``Geometry.faults``."""
        yield from super().faults()
        for name in self.select:
            if name not in self.layout().surfaces:
                yield "select", f"{show(name)} is no surface of this geometry; add it to surfaces"

    def build(self, gmsh: ModuleType) -> None:
        """See ``Geometry.build``; tells what it found in the file."""
        part = self._read(gmsh)
        surfaces, alone = self._surfaces(part)
        for text in (*part.overview(), *part.slivers(NARROW * self.mesh_size)):
            tell(text)
        for name in alone:
            tell(f"no face has a name: '{name}' is {numbers_of(surfaces[name])}, by its place")
        tell_direction(part, alone, self.ends, self.axis)
        groups = {(3, name): tags for name, tags in part.regions(self.regions).items()}
        groups |= {(2, name): [face.tag for face in found] for name, found in surfaces.items()}
        for (dimension, name), tags in groups.items():
            group = gmsh.model.addPhysicalGroup(dimension, sorted(tags))
            gmsh.model.setPhysicalName(dimension, group, name)

    def look(self, gmsh: ModuleType) -> None:
        """See ``Geometry.look``: the names of all parts, and a list of the faces where one has
        none."""
        part = self._read(gmsh)
        for text in (*part.overview(), *part.apart(), *part.slivers(NARROW * self.mesh_size)):
            tell(text)
        try:
            part.regions(self.regions)
            surfaces, alone = self._surfaces(part)
        except MeshError:
            for text in part.list_of_faces():
                tell(text)
            raise
        for name, faces in surfaces.items():
            found = " (no face has a name: found by its place)" if name in alone else ""
            tell(f"'{name}' is {numbers_of(faces)}{found}")
        tell_direction(part, alone, self.ends, self.axis)
        if alone:
            for text in part.list_of_faces():
                tell(text)

    def draw(self, gmsh: ModuleType, path: Path) -> None:
        """See ``Geometry.draw``: all faces with their numbers, and with names as far as there are
        some; what is missing is said."""
        part = self._read(gmsh, meshed=False)
        narrow = NARROW_PART * float(np.linalg.norm(part.drawn.extents))
        for text in (*part.overview(), *part.apart(), *part.slivers(narrow)):
            tell(text)
        if part.drawn.doubt:
            tell(part.drawn.doubt)
        try:
            surfaces, alone = self._surfaces(part)
        except MeshError as error:
            surfaces, alone = {}, []
            for line in error.lines:
                tell(line)
        tell_direction(part, alone, self.ends, self.axis)
        step_drawing.write(gmsh, part, surfaces, path)

    def _read(self, gmsh: ModuleType, meshed: bool = True) -> StepPart:
        size = self.mesh_size if meshed else None
        return StepPart.read(gmsh, Path(self.file), self.unit, self.separate, size, self.heal)

    def _surfaces(self, part: StepPart) -> tuple[dict[str, list[Face]], list[str]]:
        """As ``StepPart.surfaces``."""
        select = {
            # Out of a job they come as plain data that has been checked.
            name: Selection.model_construct(**(s if isinstance(s, dict) else s.model_dump()))
            for name, s in self.select.items()
        }
        layout = self.layout()
        walls = [name for names in layout.cavities.values() for name in names]
        return part.surfaces(layout.surfaces, walls, select, self.ends, self.axis)


def tell_direction(part: StepPart, alone: Sequence[str], ends: Sequence[str], axis: str) -> None:
    """Doubt ends that were found by their place, where the part is longer across ``axis``."""
    longest = int(np.argmax(part.drawn.extents))
    if (
        set(alone) & set(ends)
        and part.drawn.extents[longest] > 1.5 * part.drawn.extents[component(axis)]
    ):
        tell(
            f"the part is longest along {'xyz'[longest]}; axis, here {axis}, has to run from the "
            f"clamp to the tip: write axis: {'xyz'[longest]} (or -{'xyz'[longest]}), or select "
            "the ends"
        )


if __name__ == "__main__":
    main(FromStep)
