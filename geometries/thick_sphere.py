"""One eighth of a hollow sphere: the balloon with an exact solution.

Run by itself it writes a mesh: ``python geometries/thick_sphere.py -o sphere.msh``.
"""

from collections.abc import Iterator
from math import pi
from types import ModuleType
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from softact.geometry.base import Geometry, Layout, ThroughWall, main
from softact.geometry.gmsh_groups import add_mesh, prism_sides, prism_tetrahedra
from softact.geometry.steps import steps
from softact.geometry.walls import Wall
from softact.mesh.curves import bent, edges_of
from softact.units import Length


class ThickSphere(Geometry):
    """One eighth of a hollow sphere around the origin, symmetric to the three planes.

    It has no clamp: the symmetry planes hold it.
    """

    meets_itself: ClassVar[bool] = False

    type: Literal["thick_sphere"] = "thick_sphere"
    inner_radius: Length = Field(10.0, description="radius of the cavity")
    outer_radius: Length = Field(11.0, description="radius of the outside")
    mesh_size: Length = Field(2.0, description="edge length of the tetrahedra")
    through_wall: ThroughWall = None

    def layout(self) -> Layout:
        planes = {f"symmetry_{axis}": i for i, axis in enumerate("xyz")}
        return Layout(
            regions=("body",),
            surfaces=("cavity", "outer", *planes),
            cavities={"cavity": ("cavity",)},
            clamp="",
            tip="",
            symmetry=planes,
            length=self.outer_radius,
        )

    def walls(self) -> tuple[Wall, ...]:
        """None that bends."""
        return ()

    def volumes(self) -> dict[str, float]:
        a, b = self.inner_radius, self.outer_radius
        return {"body": pi / 6 * (b**3 - a**3), "cavity": pi / 6 * a**3, "outer": pi / 2 * b**2}

    def wall_normal(self, region: str, points: np.ndarray) -> np.ndarray:
        """Along the radius."""
        return points

    def faults(self) -> Iterator[tuple[str, str]]:
        if self.inner_radius >= self.outer_radius:
            yield (
                "inner_radius",
                f"{self.inner_radius:g} mm is not less than outer_radius "
                f"({self.outer_radius:g} mm): the wall would vanish",
            )

    def volume_tolerance(self, name: str) -> float:
        # Both spheres become alike polyhedra with edges of this angle, so all volumes shrink by
        # one factor: 0.58 angle^2 for small ones.
        angle = pi / 2 / self._divisions()
        return 0.7 * angle**2

    def _divisions(self) -> int:
        return steps(self.outer_radius * pi / 2, self.mesh_size, 2)

    def build(self, gmsh: ModuleType) -> None:
        occ = gmsh.model.occ
        octant = (0.0, pi / 2, pi / 2)
        outer = occ.addSphere(0, 0, 0, self.outer_radius, -1, *octant)
        inner = occ.addSphere(0, 0, 0, self.inner_radius, -1, *octant)
        occ.cut([(3, outer)], [(3, inner)])
        occ.synchronize()

    def mesh(self, gmsh: ModuleType) -> None:
        """Layers of prisms over a triangle that is bulged to the sphere: similar at all mesh
        sizes, which makes orders of convergence plain."""
        n = self._divisions()
        thickness = self.outer_radius - self.inner_radius
        layers = steps(thickness, self.mesh_size, self.least_steps)
        lattice = [(i, j, n - i - j) for i in range(n + 1) for j in range(n + 1 - i)]
        number = {step: k for k, step in enumerate(lattice)}
        directions = np.sin(np.array(lattice) * pi / 2 / n)
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        upright = [
            [number[i, j, k], number[i + 1, j, k - 1], number[i, j + 1, k - 1]]
            for i, j, k in lattice
            if k
        ]
        turned = [
            [number[i, j, k], number[i - 1, j, k + 1], number[i, j - 1, k + 1]]
            for i, j, k in lattice
            if i and j
        ]
        triangles, count = np.array(upright + turned), len(lattice)
        radii = np.linspace(self.inner_radius, self.outer_radius, layers + 1)
        points = (radii[:, None, None] * directions).reshape(-1, 3)
        surfaces = [(frozenset({"cavity"}), triangles)]
        surfaces.append((frozenset({"outer"}), triangles + layers * count))
        for axis, name in enumerate(self.layout().symmetry):
            rim = [number[step] for step in lattice if step[axis] == 0]
            edges = np.column_stack([rim[:-1], rim[1:]])
            surfaces.append((frozenset({name}), prism_sides(edges, layers, count)))
        tets = prism_tetrahedra(triangles, layers, count)
        edges = edges_of(tets)
        towards = points[edges].mean(axis=1)
        radius = np.linalg.norm(points[edges], axis=2).mean(axis=1)
        middles = towards * (radius / np.linalg.norm(towards, axis=1))[:, None]
        add_mesh(gmsh, points, {"body": tets}, surfaces, bent(edges, points, middles))


if __name__ == "__main__":
    main(ThickSphere)
