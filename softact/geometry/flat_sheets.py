"""Geometries that are sheets alone: their mesh, their export, and the pattern to be cut."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from softact.errors import SpecError
from softact.geometry.base import MOST_THROUGH, Geometry
from softact.geometry.cutting_pattern import Pattern
from softact.geometry.steps import steps
from softact.mesh.layout import Layout
from softact.mesh.sheets import SheetMesh

BetweenLines = Annotated[
    int | None,
    Field(
        ge=1,
        le=MOST_THROUGH,
        description="least number of elements from one line to the next, such as seams and edges "
        "of strips; by default 1",
    ),
]
SUFFIXES = (".msh", ".vtu", ".stl", ".dxf", ".svg")


class SheetGeometry(Geometry):
    """Base of the geometries without a solid; ``layout`` has sheets and no regions.

    ``volumes`` gives the areas of the meshed sheets (mm²). ``build`` is not needed: flat sheets are
    meshed without gmsh.
    """

    def sheet_mesh(self) -> SheetMesh:
        """The sheets as they lie before the first load."""
        raise NotImplementedError

    def pattern(self) -> Pattern:
        """What is cut and where it is joined, of the whole actuator."""
        raise NotImplementedError

    def steps(self, length: float) -> int:
        """Into how many a length between two lines is divided."""
        return steps(length, self.mesh_size, self.least_steps)

    def divided(self, stops: Sequence[float]) -> np.ndarray:
        """Lines at the stops (ascending, mm) and between them."""
        parts = [np.linspace(a, b, self.steps(b - a) + 1)[:-1] for a, b in pairwise(stops)]
        return np.append(np.concatenate(parts), stops[-1])

    def checked_mesh(self) -> SheetMesh:
        """``sheet_mesh``; raises MeshError where it cannot be used."""
        mesh, layout = self.sheet_mesh(), self.layout()
        ends = layout.repeats
        open_at = (ends.left, ends.right) if ends else ()
        mesh.check(layout.cavities, list(layout.symmetry.values()), layout.flux, open_at)
        return mesh

    def export_sheets(self, path: Path, suffix: str) -> None:
        """Write the mesh (.msh, .vtu, .stl)."""
        import meshio

        if suffix not in SUFFIXES:
            raise SpecError(
                f"sheets have no solid to write as '{suffix}'; use one of {', '.join(SUFFIXES)}"
            )
        mesh = self.checked_mesh()
        data, number = {}, np.zeros(len(mesh.triangles), dtype=int)
        for i, members in enumerate(mesh.parts.values()):
            number[members] = i
        if suffix == ".msh":
            sets = {name: [members] for name, members in mesh.parts.items()}
            whole = meshio.Mesh(mesh.points, [("triangle", mesh.triangles)], cell_sets=sets)
            whole.write(path, file_format="gmsh", binary=False)
            return
        data = {"sheet": [number]} if suffix == ".vtu" else {}
        meshio.Mesh(mesh.points, [("triangle", mesh.triangles)], cell_data=data).write(path)


@dataclass(frozen=True)
class Lines:
    """A grid of lines that cut a flat sheet into rectangles, mm, ascending."""

    x: np.ndarray
    y: np.ndarray

    def points(self) -> np.ndarray:
        """(n, 3), row after row along y."""
        x, y = np.meshgrid(self.x, self.y, indexing="ij")
        return np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])

    def alternating(self, mirrored: bool = False) -> np.ndarray:
        """Diagonals (rectangles along x, along y) by turns: whether from the corner of the largest
        x and the smallest y, not from that of the smallest x and y.

        mirrored: those of the second half along x are mirror images of the first's. With an even
        number of divisions along y, no triangle then has all corners on the ends and the last line
        of y, so that two such sheets can be joined there.
        """
        i, j = np.indices((len(self.x) - 1, len(self.y) - 1))
        late = mirrored & (i >= i.shape[0] / 2)
        return np.where(late, i.shape[0] - i + j, i + j) % 2 == 1

    def triangles(self, mirrored: bool = False, diagonals: np.ndarray | None = None) -> np.ndarray:
        """(m, 3), normals up; diagonals: by default, see ``alternating``."""
        number = np.arange(len(self.x) * len(self.y)).reshape(len(self.x), len(self.y))
        p, q = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
        r, s = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
        odd = self.alternating(mirrored) if diagonals is None else diagonals
        odd = odd.ravel()[:, None]
        first = np.where(odd, np.column_stack([p, q, s]), np.column_stack([p, q, r]))
        second = np.where(odd, np.column_stack([q, r, s]), np.column_stack([p, r, s]))
        return np.stack([first, second], axis=1).reshape(-1, 3)


def sides(triangles: np.ndarray) -> np.ndarray:
    """Edges (k, 2) of triangles, each once."""
    return np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)


__all__ = ["BetweenLines", "Layout", "Lines", "SheetGeometry", "sides"]
