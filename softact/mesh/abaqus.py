"""A mesh as the input of Abaqus and CalculiX: nodes, C3D4 elements, sets and surfaces by name."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from softact.mesh.boundary import face_keys
from softact.mesh.layout import Layout
from softact.mesh.msh_file import Tetrahedra

#: Corners of the faces S1 to S4 of a C3D4.
_FACES = np.array([[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]])
_IN_A_LINE = 12


def inp_text(mesh: Tetrahedra, layout: Layout) -> str:
    """Nodes in mm from 1 on, tetrahedra, an ELSET for each region, and for each surface an NSET and
    a SURFACE (of the faces of its elements), under the names of the layout."""
    return "\n".join(_lines(mesh, layout)) + "\n"


def _lines(mesh: Tetrahedra, layout: Layout) -> Iterator[str]:
    yield "** written by softact: mm; first-order tetrahedra (C3D4)"
    yield "*NODE, NSET=ALL"
    for number, (x, y, z) in enumerate(mesh.points.tolist(), 1):
        yield f"{number}, {x:.10g}, {y:.10g}, {z:.10g}"
    for region, name in enumerate(layout.regions):
        yield f"*ELEMENT, TYPE=C3D4, ELSET={name}"
        for cell in np.flatnonzero(mesh.region == region).tolist():
            yield f"{cell + 1}, " + ", ".join(str(node + 1) for node in mesh.cells[cell].tolist())
    count = len(mesh.points)
    keys = face_keys(mesh.cells[:, _FACES].reshape(-1, 3), count)
    for name, triangles in mesh.surfaces.items():
        yield f"*NSET, NSET={name}"
        yield from _listed(np.unique(triangles) + 1)
        yield f"*SURFACE, NAME={name}_SURFACE, TYPE=ELEMENT"
        faces = np.flatnonzero(np.isin(keys, face_keys(triangles, count)))
        yield from (f"{face // 4 + 1}, S{face % 4 + 1}" for face in faces.tolist())


def _listed(numbers: np.ndarray) -> Iterator[str]:
    for start in range(0, len(numbers), _IN_A_LINE):
        yield ", ".join(map(str, numbers[start : start + _IN_A_LINE].tolist())) + ","
