"""Meshes of geometries as plain arrays, read back by meshio, and what OCC says of the solid."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest

from softact.geometry.base import Geometry, make_mesh
from softact.mesh.layout import Layout


@dataclass
class Solid:
    """A meshed geometry: points (n, 3), tetrahedra (m, 4), sorted triangles (k, 3) by surface."""

    geometry: Geometry
    layout: Layout
    points: np.ndarray
    cells: np.ndarray
    surfaces: dict[str, np.ndarray]

    @property
    def volumes(self) -> np.ndarray:
        """Signed volume of each tetrahedron."""
        a, b, c, d = (self.points[self.cells[:, i]] for i in range(4))
        return np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6

    @cached_property
    def faces(self) -> dict[tuple[int, ...], list[tuple[int, int]]]:
        """Sorted corners of each face -> its cells with the corner opposite to it."""
        found: dict[tuple[int, ...], list[tuple[int, int]]] = {}
        for number, cell in enumerate(self.cells.tolist()):
            for corner in cell:
                key = tuple(sorted(set(cell) - {corner}))
                found.setdefault(key, []).append((number, corner))
        return found

    def outward_areas(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Midpoints and area vectors of a surface's triangles, turned out of the solid."""
        faces, corners = self.faces, self.surfaces[name]
        opposite = [faces[tuple(triangle)][0][1] for triangle in corners.tolist()]
        a, b, c = (self.points[corners[:, i]] for i in range(3))
        areas = np.cross(b - a, c - a) / 2
        inward = np.einsum("ij,ij->i", areas, self.points[opposite] - a) > 0
        areas[inward] *= -1
        return (a + b + c) / 3, areas

    def area(self, name: str) -> float:
        """Of a surface, mm²."""
        return float(np.linalg.norm(self.outward_areas(name)[1], axis=1).sum())


def read(geometry: Geometry, path: Path) -> Solid:
    raw = meshio.read(path)
    cells = np.vstack([block.data for block in raw.cells if block.type == "tetra"])
    surfaces = {}
    for name in geometry.layout().surfaces:
        parts = [
            block.data[members]
            for block, members in zip(raw.cells, raw.cell_sets[name], strict=True)
            if block.type == "triangle" and len(members)
        ]
        surfaces[name] = np.sort(np.vstack(parts), axis=1)
    return Solid(geometry, geometry.layout(), raw.points, cells, surfaces)


@pytest.fixture(scope="session")
def meshed(tmp_path_factory):
    """Function that meshes a geometry (once in a session) and reads the file back."""
    known: dict[str, Solid] = {}

    def make(geometry: Geometry) -> Solid:
        key = geometry.model_dump_json()
        if key not in known:
            path = tmp_path_factory.mktemp("mesh") / "solid.msh"
            make_mesh(geometry, path, 60.0)
            known[key] = read(geometry, path)
        return known[key]

    return make


@pytest.fixture
def occ_volume():
    """Function that returns the volume that OCC gives to a geometry's solid."""
    gmsh.initialize(readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)

    def measure(geometry: Geometry) -> float:
        gmsh.clear()
        geometry.build(gmsh)
        return sum(gmsh.model.occ.getMass(3, tag) for _, tag in gmsh.model.getEntities(3))

    yield measure
    gmsh.finalize()
