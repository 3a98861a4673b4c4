"""The faces of a STEP file as triangles, to be looked at before anything is chosen among them."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

import numpy as np

from softact.geometry.step_faces import Face
from softact.geometry.step_part import StepPart

_ACROSS, _AROUND = 25.0, 16  # triangles along the part, and around a full turn


@dataclass(frozen=True)
class FaceDrawing:
    """number: as text, of one face of the file or of several that lie on each other; names: of the
    surfaces that it is of by now; said: a line about it; triangles (k, 3)."""

    number: str
    names: tuple[str, ...]
    said: str
    triangles: np.ndarray


def write(
    gmsh: ModuleType, part: StepPart, surfaces: Mapping[str, Sequence[Face]], path: Path
) -> None:
    """Mesh the faces of a part coarsely and write them for ``read`` (.npz)."""
    size = float(np.linalg.norm(part.drawn.extents))
    for name, value in (
        ("Mesh.MeshSizeMax", size / _ACROSS),
        ("Mesh.MeshSizeFromCurvature", _AROUND),
        ("Mesh.ElementOrder", 1),
    ):
        gmsh.option.setNumber(name, value)
    gmsh.model.mesh.generate(2)
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    number = np.zeros(int(tags.max(initial=0)) + 1, dtype=np.int64)
    number[tags] = np.arange(len(tags))
    owners = part.owners()
    arrays, story = {"points": coordinates.reshape(-1, 3)}, []
    for count, face in enumerate(part.faces):
        members = gmsh.model.mesh.getElementsByType(2, face.tag)[1].astype(np.int64)
        arrays[f"triangles_{count}"] = number[members].reshape(-1, 3)
        numbers = " and ".join(map(str, sorted(face.numbers)))
        names = [name for name, faces in surfaces.items() if face in faces]
        of = " and ".join(filter(None, (owners[solid] for solid in face.solids)))
        story.append([numbers, names, face.look + (f", of {of}" if of else "")])
    with open(path, "wb") as file:
        np.savez(file, story=np.array(json.dumps(story)), allow_pickle=False, **arrays)


def read(path: Path) -> tuple[np.ndarray, list[FaceDrawing]]:
    """Points (n, 3) mm and the faces on them."""
    with np.load(path) as arrays:
        faces = [
            FaceDrawing(number, tuple(names), said, arrays[f"triangles_{count}"])
            for count, (number, names, said) in enumerate(json.loads(str(arrays["story"])))
        ]
        return arrays["points"], faces
