"""Tetrahedra, triangles and edges cut into k parts along each of their edges.

The pieces of a simplex are those of the edgewise subdivision (Edelsbrunner and Grayson 2000,
Discrete Comput. Geom. 24:707): kᵈ of them, all of one volume, few in shape, and the same on a face
whichever of its two neighbours is cut. A mesh that has one element through each wall has k of them
afterwards, and is refined alike in all directions.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from itertools import permutations, product
from math import ceil
from types import ModuleType

import numpy as np

from softact.geometry.curved import EXACT, curves_of, is_curved, spread
from softact.geometry.gmsh_groups import add_mesh
from softact.mesh.cells import check_number

#: Sides of a gmsh circle in a mesh that is going to be cut, at least: or a side of a thin round
#: wall would cross the other one.
SIDES_OF_A_CIRCLE = 24
EDGE, TRIANGLE, TETRAHEDRON = 1, 2, 4  # gmsh's numbers
_STILL = 1e-7  # mm: what a point lies off its curve or surface by rounding


@cache
def pieces(dimension: int, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Points of a divided simplex as (n, d + 1) whole weights that add up to k, and its pieces
    (kᵈ, d + 1) as numbers of points.

    It is the simplex k ≥ x₁ ≥ … ≥ x_d ≥ 0 of the lattice, each cube of which is cut along its
    diagonal by the order of the coordinates.
    """
    places = [x for x in product(range(k, -1, -1), repeat=dimension) if list(x) == _falling(x)]
    number = {place: n for n, place in enumerate(places)}
    found = []
    for base in product(range(k), repeat=dimension):
        for order in permutations(range(dimension)):
            corners = [base]
            for axis in order:
                corners.append(tuple(c + (a == axis) for a, c in enumerate(corners[-1])))
            if all(corner in number for corner in corners):
                found.append([number[corner] for corner in corners])
    x = np.array(places).reshape(-1, dimension)
    ends = np.full((len(x), 1), k), np.zeros((len(x), 1), dtype=int)
    return -np.diff(np.hstack([ends[0], x, ends[1]])), np.array(found)


def _falling(x: tuple[int, ...]) -> list[int]:
    return sorted(x, reverse=True)


def subdivided(
    points: np.ndarray, parts: Sequence[np.ndarray], k: int
) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """All points and parts of a mesh whose edges are cut into ``k``.

    points: (n, 3). parts: (m, 2), (m, 3) or (m, 4) corners of edges, triangles or tetrahedra, those
    of one mesh. Returns points (those that a part uses), which of them were there before, and parts
    in the same order; a piece has its corners in some order.
    """
    width = max(part.shape[1] for part in parts)
    keys = [_keys(part, k, width) for part in parts]
    rows = np.vstack([key.reshape(-1, width) for key in keys])
    known, place = np.unique(rows, axis=0, return_inverse=True)
    ends = np.cumsum([key.shape[0] * key.shape[1] for key in keys])
    numbers = np.split(place.ravel(), ends[:-1])
    cut = [
        number.reshape(key.shape[:2])[:, pieces(part.shape[1] - 1, k)[1]].reshape(-1, part.shape[1])
        for number, key, part in zip(numbers, keys, parts, strict=True)
    ]
    weight = np.where(known < 0, 0, known % (k + 1)) / k
    corner = np.where(known < 0, 0, known // (k + 1))
    old = (weight == 1.0).any(axis=1)
    return np.einsum("nc,ncx->nx", weight, points[corner]), old, cut


def _keys(part: np.ndarray, k: int, width: int) -> np.ndarray:
    """(m, l, width) what tells the points of each divided simplex: corners and their weights as one
    number, -1 where a corner has no weight."""
    weights = pieces(part.shape[1] - 1, k)[0]
    corners = np.sort(part, axis=1).astype(np.int64)[:, None, :]
    keys = np.where(weights > 0, corners * (k + 1) + weights, -1)
    missing = np.full((*keys.shape[:2], width - part.shape[1]), -1)
    return np.sort(np.concatenate([keys, missing], axis=2), axis=2)


class Pieces:
    """The mesh of the current gmsh model, cut into ``k`` along each edge, by gmsh's entities.

    points: (n, 3) mm, on the curves and surfaces of the geometry, as far as the model has one.
    of: (dimension, tag) -> its pieces.
    """

    def __init__(self, gmsh: ModuleType, dimension: int, k: int):
        tags, coordinates, _ = gmsh.model.mesh.getNodes()
        number = np.zeros(int(tags.max(initial=0)) + 1, dtype=np.int64)
        number[tags] = np.arange(len(tags))
        kinds = (EDGE, TRIANGLE, TETRAHEDRON)[:dimension]
        found = {}
        for d, kind in enumerate(kinds, start=1):
            for _, tag in gmsh.model.getEntities(d):
                corners = gmsh.model.mesh.getElementsByType(kind, tag)[1].astype(np.int64)
                if len(corners):
                    found[d, tag] = number[corners].reshape(-1, d + 1)
        self.points, self._old, cut = subdivided(
            coordinates.reshape(-1, 3), list(found.values()), k
        )
        self.of = dict(zip(found, cut, strict=True))
        self._bulge(gmsh, dimension)

    def _bulge(self, gmsh: ModuleType, dimension: int) -> None:
        """Move points onto curves and surfaces, and those inside with them."""
        moved, fixed = np.zeros_like(self.points), np.zeros(len(self.points), dtype=bool)
        for d in range(dimension - 1, 0, -1):  # curves last: their points are on surfaces, too
            for (of, tag), part in self.of.items():
                if of != d:
                    continue
                own = np.unique(part)
                fixed[own], moved[own] = True, 0.0
                if not gmsh.model.getType(d, tag).startswith(EXACT):
                    near, _ = gmsh.model.getClosestPoint(d, tag, self.points[own].ravel())
                    moved[own] = np.reshape(near, (-1, 3)) - self.points[own]
        moved[self._old] = 0.0  # they lie where they should but for gmsh's rounding
        if np.abs(moved).max(initial=0.0) > _STILL:
            inside = [part for (d, _), part in self.of.items() if d == dimension]
            self.points = self.points + spread(np.vstack(inside), moved, fixed)


def fill(gmsh: ModuleType, size: float, k: int, around: int = 0) -> None:
    """Mesh the solid in the current gmsh model with tetrahedra of about ``size`` (mm), at least
    ``k`` through each wall once they are cut into ``k``. around: least number of edges around a
    full circle, once they are."""
    # Only the size counts: gmsh's own defaults differ from version to version.
    gmsh.option.setNumber("Mesh.MeshSizeFromPoints", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", k * size)
    sides = max(ceil(around / k), SIDES_OF_A_CIRCLE if k > 1 else 0)
    if sides:
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", sides)
    gmsh.model.mesh.generate(3)
    gmsh.model.mesh.optimize("")


def cut_mesh(gmsh: ModuleType, k: int) -> None:
    """Put the tetrahedra of the current gmsh model, cut into ``k`` along each edge and curved along
    curved walls, and its named groups into a new, discrete model; nothing where k is 1 and all
    walls are flat, or where there are no straight tetrahedra.

    Raises MeshError where there would be too many.
    """
    count = len(gmsh.model.mesh.getElementsByType(TETRAHEDRON)[0])
    if not count or (k == 1 and not is_curved(gmsh, 3)):
        return
    check_number(count * k**3)
    regions, names = _groups(gmsh)
    cut = Pieces(gmsh, 3, k)
    parts = {
        name: [cut.of[3, tag] for tag in tags if (3, tag) in cut.of]
        for name, tags in regions.items()
    }
    solids = {name: np.vstack(found) for name, found in parts.items() if found}
    surfaces = [
        (frozenset(of), cut.of[2, tag]) for tag, of in sorted(names.items()) if (2, tag) in cut.of
    ]
    if solids:
        add_mesh(gmsh, cut.points, solids, surfaces, curves_of(gmsh, cut.points, cut.of, 3))


def _groups(gmsh: ModuleType) -> tuple[dict[str, list[int]], dict[int, set[str]]]:
    """Tags of the solids by name of their group, and names of each surface's groups."""
    regions: dict[str, list[int]] = {}
    names: dict[int, set[str]] = {}
    for dimension, group in gmsh.model.getPhysicalGroups():
        name = gmsh.model.getPhysicalName(dimension, group)
        for tag in map(int, gmsh.model.getEntitiesForPhysicalGroup(dimension, group)):
            if dimension == 3:
                regions.setdefault(name, []).append(tag)
            elif dimension == 2:
                names.setdefault(tag, set()).add(name)
    return regions, names
