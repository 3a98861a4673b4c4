"""Meshes of geometries as plain arrays, read back by meshio, and what OCC says of the solid."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest

from softact.geometry.base import Geometry, make_mesh
from softact.mesh.curves import VTK_EDGES, Curves, of_quadratic
from softact.mesh.curves import volumes as curved_volumes
from softact.mesh.layout import Layout
from softact.mesh.triangles import VOLUME_RULE, shape_functions, tangents


@dataclass
class Solid:
    """A meshed geometry: points (n, 3), tetrahedra (m, 4), sorted triangles (k, 3) by surface,
    edges that are not straight."""

    geometry: Geometry
    layout: Layout
    points: np.ndarray
    cells: np.ndarray
    surfaces: dict[str, np.ndarray]
    curves: Curves

    @property
    def volumes(self) -> np.ndarray:
        """Signed volume of each tetrahedron."""
        return curved_volumes(self.curves.nodes(self.cells, self.points))

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

    def outward_elements(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Places and area vectors, turned out of the solid, at the quadrature points of a surface's
        triangles as they are curved."""
        corners, (rule, weights) = self.surfaces[name], VOLUME_RULE
        nodes = self.curves.triangles(corners, self.points)
        one, other = np.moveaxis(tangents(nodes, rule), -1, 0)
        areas = np.cross(one, other) * weights[:, None] / 2
        inward = np.einsum("ki,ki->k", areas.sum(axis=1), self.outward_areas(name)[1]) < 0
        areas[inward] *= -1
        places = shape_functions(rule, nodes.shape[1]) @ nodes
        return places.reshape(-1, 3), areas.reshape(-1, 3)


def read(geometry: Geometry, path: Path) -> Solid:
    raw = meshio.read(path)
    cells = np.vstack([block.data[:, :4] for block in raw.cells if block.type.startswith("tetra")])
    curved = [block.data for block in raw.cells if block.type == "tetra10"]
    curves = of_quadratic(raw.points, np.vstack(curved), VTK_EDGES) if curved else Curves()
    surfaces = {}
    for name in geometry.layout().surfaces:
        parts = [
            block.data[members][:, :3]
            for block, members in zip(raw.cells, raw.cell_sets[name], strict=True)
            if block.type.startswith("triangle") and len(members)
        ]
        surfaces[name] = np.sort(np.vstack(parts), axis=1)
    return Solid(geometry, geometry.layout(), raw.points, cells, surfaces, curves)


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
