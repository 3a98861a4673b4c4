"""Structured meshes for problems with a known answer: no gmsh, so that they are always the same."""

from __future__ import annotations

from collections.abc import Callable
from itertools import permutations

import numpy as np

from softact.mesh.curves import Curves, bent, edges_of, of_edges
from softact.mesh.msh_file import Tetrahedra
from softact.mesh.tetrahedra import FACET_VERTICES

FACES = ("x_min", "x_max", "y_min", "y_max", "z_min", "z_max")


def block(
    cells: tuple[int, int, int],
    size: tuple[float, float, float] = (1.0, 1.0, 1.0),
    mapping: Callable[[np.ndarray], np.ndarray] | None = None,
    keep: Callable[[np.ndarray], np.ndarray] | None = None,
    curved: bool = False,
) -> Tetrahedra:
    """A block from the origin to ``size`` of hexahedra cut into 6 tetrahedra each (Kuhn).

    mapping: (n, 3) points of the block -> (n, 3) points of the mesh. keep: (m, 3) centres of the
    hexahedra in the block -> (m,) which to keep; the walls of what is left out are the surface
    ``inside``. The sides of the block are the surfaces ``x_min`` to ``z_max``. curved: whether the
    middles of the edges are mapped, too; else these are straight.
    """
    counts = np.array(cells) + 1
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in counts), indexing="ij"), -1).reshape(-1, 3)
    points = grid / cells * np.array(size, float)
    strides = np.array([counts[1] * counts[2], counts[2], 1])
    hexahedra = grid[(grid < cells).all(axis=1)]
    if keep is not None:
        hexahedra = hexahedra[keep((hexahedra + 0.5) / cells * np.array(size, float))]
    tets = []
    for order in permutations(range(3)):  # one tetrahedron for each way from corner to corner
        path = np.cumsum(np.vstack([np.zeros(3, int), np.eye(3, dtype=int)[list(order)]]), axis=0)
        tets.append((hexahedra[:, None] + path) @ strides)
    tets = np.concatenate(tets)
    surfaces = _surfaces(tets, grid, np.array(cells))
    used, tets = np.unique(tets, return_inverse=True)
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    points, curves = points[used], Curves()
    if mapping is not None:
        flat, points = points, mapping(points)
        ends = edges_of(tets.reshape(-1, 4))
        if curved:
            curves = bent(ends, points, mapping(flat[ends].mean(axis=1)))
    return Tetrahedra(
        np.ascontiguousarray(points),
        tets.reshape(-1, 4),
        np.zeros(len(tets.reshape(-1, 4)), dtype=np.int32),
        {name: number[triangles] for name, triangles in surfaces.items()},
        curves,
    )


def _surfaces(tets, grid, cells):
    faces = np.sort(tets[:, FACET_VERTICES].reshape(-1, 3), axis=1)
    faces, count = np.unique(faces, axis=0, return_counts=True)
    outer = faces[count == 1]
    surfaces, rest = {}, np.ones(len(outer), dtype=bool)
    for axis in range(3):
        for side, place in (("min", 0), ("max", cells[axis])):
            on = (grid[outer, axis] == place).all(axis=1)
            surfaces[f"{'xyz'[axis]}_{side}"] = outer[on]
            rest &= ~on
    if rest.any():
        surfaces["inside"] = outer[rest]
    return surfaces


def disc(points: np.ndarray, radius: float) -> np.ndarray:
    """Map the unit square of x and y to a disc about the origin; z stays.

    Squares about the centre become circles whose points are equally spaced in angle, so the rim
    of an n by n mesh is a regular polygon of 4 n sides.
    """
    x, y = 2 * points[:, 0] - 1, 2 * points[:, 1] - 1
    r = np.maximum(np.abs(x), np.abs(y))
    steep = np.abs(y) > np.abs(x)
    near = np.where(steep, x, y)
    slope = near / np.where(r > 0, r, 1.0) * np.pi / 4
    along, across = r * np.cos(slope), r * np.sin(slope)
    mapped = np.column_stack(
        [
            np.where(steep, across, np.sign(x) * along),
            np.where(steep, np.sign(y) * along, across),
        ]
    )
    return np.column_stack([radius * mapped, points[:, 2]])


def with_image(half: Tetrahedra) -> Tetrahedra:
    """A body of this half and its mirror image beyond x = 0, where the half has its ``x_max``."""
    image, count = np.array([-1.0, 1.0, 1.0]), len(half.points)
    shared = np.isclose(half.points[:, 0], 0.0)
    number = np.where(shared, np.arange(count), count - 1 + np.cumsum(~shared))
    ends = np.concatenate([half.curves.edges, number[half.curves.edges]])
    middles = np.concatenate([half.curves.places, half.curves.places * image])
    surfaces = {
        name: np.concatenate([facets, number[facets]])
        for name, facets in half.surfaces.items()
        if name not in ("x_min", "x_max")
    }
    surfaces |= {"x_min": half.surfaces["x_min"], "x_max": number[half.surfaces["x_min"]]}
    return Tetrahedra(
        np.concatenate([half.points, half.points[~shared] * image]),
        np.concatenate([half.cells, number[half.cells][:, [1, 0, 2, 3]]]),
        np.tile(half.region, 2),
        surfaces,
        of_edges(ends, middles),
    )


def together(**parts: Tetrahedra) -> Tetrahedra:
    """Bodies of one mesh, each a region; their surfaces begin with their names."""
    points, cells, region, surfaces, edges, middles = [], [], [], {}, [], []
    for number, (name, part) in enumerate(parts.items()):
        begin = sum(map(len, points))
        points.append(part.points)
        cells.append(part.cells + begin)
        region.append(np.full(len(part.cells), number, np.int32))
        surfaces |= {f"{name}_{side}": f + begin for side, f in part.surfaces.items()}
        edges.append(part.curves.edges + begin)
        middles.append(part.curves.places)
    whole = (np.concatenate(p) for p in (points, cells, region))
    return Tetrahedra(*whole, surfaces, Curves(np.concatenate(edges), np.concatenate(middles)))
