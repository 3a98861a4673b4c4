"""A geometry out of a user's STEP file, whose solids and faces have names.

Run by itself it writes a mesh: ``python geometries/from_step.py --file part.step -o part.msh``.
"""

from pathlib import Path
from typing import ClassVar, Literal

import numpy as np

from softact.errors import MeshError
from softact.geometry import main
from softact.imported import Imported
from softact.step_names import Face, StepFile


class FromStep(Imported):
    """A STEP file with named solids and faces.

    The names of its solids are those of ``regions``, the names of its faces those of all surfaces;
    several faces may share a name. A solid without a name of its own has that of its product; the
    only solid of a file may go without.
    """

    type: Literal["from_step"] = "from_step"
    suffixes: ClassVar[tuple[str, ...]] = (".step", ".stp")

    @property
    def self_contained(self) -> bool:
        """An assembly may refer to other files, by DOCUMENT_FILE (ISO 10303-41)."""
        return b"DOCUMENT_FILE" not in Path(self.file).read_bytes().upper()

    def build(self, gmsh) -> None:
        bodies = StepFile(Path(self.file).read_text(encoding="utf-8", errors="replace")).bodies()
        if not bodies:
            raise MeshError(
                f"{Path(self.file).name} holds no solid: its surfaces do not close one "
                "(not watertight)"
            )
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        gmsh.model.occ.importShapes(self.file)
        gmsh.model.occ.synchronize()
        solids = [tag for _, tag in gmsh.model.getEntities(3)]
        if len(solids) != len(bodies):
            raise MeshError(
                f"{Path(self.file).name} has {len(bodies)} solids, {len(solids)} of which can be "
                "read; an assembly that repeats a part has to be saved as separate solids"
            )
        groups = self._groups(gmsh, solids, bodies)
        if not any(dimension == 2 for dimension, _ in groups):
            raise MeshError(
                f"{Path(self.file).name}: no face has a name; name the faces in the CAD program "
                "and export with names, or write a from_script geometry"
            )
        for (dimension, name), tags in groups.items():
            group = gmsh.model.addPhysicalGroup(dimension, sorted(set(tags)))
            gmsh.model.setPhysicalName(dimension, group, name)

    def _groups(self, gmsh, solids, bodies) -> dict[tuple[int, str], list[int]]:
        groups: dict[tuple[int, str], list[int]] = {}
        for tag, body in zip(solids, bodies, strict=True):
            name = body.name
            if len(bodies) == 1 and len(self.regions) == 1:
                name = self.regions[0]
            groups.setdefault((3, name), []).append(tag)
            faces = [f for _, f in gmsh.model.getBoundary([(3, tag)], oriented=False)]
            if not _same_corners(gmsh, faces, body.faces):
                raise MeshError(
                    f"{Path(self.file).name}: the names in the solid '{name}' cannot be matched "
                    "with its faces; write a from_script geometry"
                )
            for tag_of_face, face in zip(faces, body.faces, strict=True):
                if face.name:
                    groups.setdefault((2, face.name), []).append(tag_of_face)
        return groups


def _same_corners(gmsh, faces: list[int], named: tuple[Face, ...]) -> bool:
    """Whether gmsh's faces have the corners of those in the file, in the same order."""
    if len(faces) != len(named):
        return False
    found = []
    for face in faces:
        corners = gmsh.model.getBoundary([(2, face)], oriented=False, recursive=True)
        found.append(np.array([gmsh.model.getValue(0, tag, []) for _, tag in corners]))
    wanted = [np.array(sorted(face.corners)) for face in named]
    if [len(corners) for corners in found] != [len(corners) for corners in wanted]:
        return False
    size = np.ptp(np.vstack(found), axis=0).max()
    scale = size / np.ptp(np.vstack(wanted), axis=0).max()  # gmsh converts to mm
    for places, expected in zip(found, wanted, strict=True):
        gaps = np.linalg.norm(places[:, None] - scale * expected[None], axis=2)
        if gaps.min(axis=1).max(initial=0.0) > 1e-5 * size:
            return False
    return True


if __name__ == "__main__":
    main(FromStep)
