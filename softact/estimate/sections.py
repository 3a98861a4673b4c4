"""Sections of a beam under the pressure of the cavities that they cut.

Sections stay plane: the stretch at y, z is 1 + e + b z + c y. Wall and layers carry what the
pressure pushes on the cavity's section: its area times the pressure, and its first moments, which
generalises the moment of equations 4 and 5 of Polygerinos et al. (2013).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from softact.estimate.uniaxial import Stress

#: Which points y, z (n,) belong to a region.
Inside = Callable[[np.ndarray, np.ndarray], np.ndarray]
SMALL = 1e-6
MOST_ITERATIONS, TOLERANCE = 60, 1e-7


@dataclass(frozen=True)
class Patch:
    """Points of a section: y, z (n,) mm and areas (n,) mm²."""

    y: np.ndarray
    z: np.ndarray
    area: np.ndarray

    @property
    def moments(self) -> np.ndarray:
        """(3,) area, first moment in z, first moment in y."""
        return np.array([self.area.sum(), self.area @ self.z, self.area @ self.y])


@dataclass(frozen=True)
class Film:
    """A layer across a section: height z and width in mm, modulus times thickness in N/mm."""

    z: float
    width: float
    stiffness: float


@dataclass(frozen=True)
class Section:
    """A section that goes on for a length (mm), all of its kind together.

    walls: pairs of a patch and the law of its stress. cavities: name -> patch. films: layers.
    """

    length: float
    walls: Sequence[tuple[Patch, Stress]]
    cavities: Mapping[str, Patch] = field(default_factory=dict)
    films: Sequence[Film] = ()

    def largest_stretch(self, strain: np.ndarray) -> float:
        """Of all walls, at a strain (e, b, c)."""
        places = ((patch.z, patch.y) for patch, _ in self.walls if len(patch.area))
        return max(
            (1 + strain[0] + float(np.max(strain[1] * z + strain[2] * y)) for z, y in places),
            default=1.0,
        )

    def wall_load(self, strain: np.ndarray) -> np.ndarray:
        """(3,) force and moments that the walls carry at a strain (e, b, c)."""
        total = np.zeros(3)
        for patch, stress in self.walls:
            stretch = 1 + strain[0] + strain[1] * patch.z + strain[2] * patch.y
            forces = stress(np.maximum(stretch, 0.05)) * patch.area
            total += [forces.sum(), forces @ patch.z, forces @ patch.y]
        for film in self.films:
            pull = film.stiffness * film.width * (strain[0] + strain[1] * film.z)
            bending = film.stiffness * film.width**3 / 12 * strain[2]
            total += [pull, pull * film.z, bending]
        return total

    def pressed(self, pressures: Mapping[str, float]) -> np.ndarray:
        """(3,) force and moments by pressures (MPa) in the cavities."""
        return sum(
            (pressures.get(name, 0.0) * patch.moments for name, patch in self.cavities.items()),
            np.zeros(3),
        )

    def tangent(self, strain: np.ndarray) -> np.ndarray:
        """(3, 3) derivative of ``wall_load`` by the strain, by central differences."""
        steps = SMALL * np.array([1.0, 0.1, 0.1])
        columns = [
            (self.wall_load(strain + step) - self.wall_load(strain - step)) / (2 * size)
            for size, step in zip(steps, np.diag(steps), strict=True)
        ]
        return np.column_stack(columns)

    def solve(self, load: np.ndarray, start: np.ndarray) -> np.ndarray | None:
        """Strain (e, b, c) whose walls carry a load; None where there is none near by."""
        strain, scale = start.copy(), np.abs(load).max() + 1e-3
        for _ in range(MOST_ITERATIONS):
            apart = load - self.wall_load(strain)
            if np.abs(apart / [1.0, 10.0, 10.0]).max() < TOLERANCE * scale:
                return strain
            slope = self.tangent(strain)
            # A section that is symmetric and thin may not know how to bend across.
            change = np.linalg.lstsq(slope, apart, rcond=1e-12)[0]
            largest = max(abs(change[0]), 20 * np.abs(change[1:]).max())
            strain = strain + change * min(1.0, 0.3 / max(largest, 1e-30))
            if not np.isfinite(strain).all() or abs(strain[0]) > 20:
                return None
        return None


def rectangle(y0: float, y1: float, z0: float, z1: float, rows: int = 24) -> Patch:
    """A rectangle, as Gauss points across and rows in height; empty where it has no extent."""
    if y1 <= y0 or z1 <= z0:
        return Patch(np.zeros(0), np.zeros(0), np.zeros(0))
    at, weight = np.polynomial.legendre.leggauss(4)
    edges = np.linspace(z0, z1, rows + 1)
    z = (edges[:-1] + edges[1:]) / 2
    y = (y0 + y1) / 2 + at * (y1 - y0) / 2
    area = np.outer(weight * (y1 - y0) / 2, np.full(rows, (z1 - z0) / rows))
    grid_y, grid_z = np.meshgrid(y, z, indexing="ij")
    return Patch(grid_y.ravel(), grid_z.ravel(), area.ravel())


def region(inside: Inside, radius: float, count: int = 120) -> Patch:
    """Points of a region within a radius about the axis, where ``inside(y, z)`` is true."""
    step = 2 * radius / count
    line = -radius + step * (np.arange(count) + 0.5)
    y, z = (part.ravel() for part in np.meshgrid(line, line, indexing="ij"))
    chosen = inside(y, z)
    return Patch(y[chosen], z[chosen], np.full(int(chosen.sum()), step**2))


def joined(patches: Sequence[Patch]) -> Patch:
    """Several patches as one, such as cavities that have the same pressure."""
    return Patch(
        *(np.concatenate([getattr(p, name) for p in patches]) for name in ("y", "z", "area"))
    )
