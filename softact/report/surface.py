"""What of a mesh can be seen: its skin, cut into flat triangles, creases kept sharp."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from softact.mesh.boundary import among, exterior, flat
from softact.mesh.components import connected
from softact.results.folder import Results

_CREASE_DEG = 35.0
_LIFT = 4e-3  # of the actuator's size


@dataclass(frozen=True)
class Skin:
    """Triangles to draw, on vertices that are copies of mesh nodes.

    nodes: (v,) node of each vertex; a node on a crease has a vertex for each smooth patch.
    outer: (a, 3) vertices of the triangles that are seen from outside.
    inner: (b, 3) of the walls of cavities and the symmetry planes, seen in a cut only.
    edges: (e, 2) vertices of the outer creases. mirrors: coordinates (0, 1, 2) whose change of
    sign gives the other parts of the actuator.
    """

    nodes: np.ndarray
    outer: np.ndarray
    inner: np.ndarray
    edges: np.ndarray
    mirrors: tuple[int, ...]


def skin(results: Results, most: int | None = None) -> Skin:
    """The skin of a result's mesh.

    most: where the outside has more flat triangles than this, the quadratic triangles are drawn
    by their corners alone.
    """
    outside = np.vstack([exterior(results.cells), *_sliding(results)])
    hidden = among(outside, [results.surfaces[name] for name in _hidden(results)])
    if most and 4 * np.count_nonzero(~hidden) > most:
        outside = outside[:, :3]
    outer, inner = flat(outside[~hidden]), flat(outside[hidden])
    patch = _patches(results.points, np.vstack([outer, inner]))
    # The two sets may share a patch number but never a vertex: their common border is a crease.
    patch[len(outer) :] += patch.max(initial=0) + 1
    patches = patch.max(initial=0) + 1
    key = np.vstack([outer, inner]).astype(np.int64) * patches + patch[:, None]
    vertices, where = np.unique(key, return_inverse=True)
    where, nodes = where.reshape(-1, 3), vertices // patches
    return Skin(
        nodes=nodes,
        outer=where[: len(outer)],
        inner=where[len(outer) :],
        edges=_creases(where[: len(outer)], _planes(results, nodes)),
        mirrors=tuple(results.layout.symmetry.values()),
    )


def _sliding(results: Results) -> list[np.ndarray]:
    """Triangles of the sheets that lie on a solid and are not bonded to it."""
    layout = results.layout
    return [results.surfaces[name] for name in layout.covers if name not in layout.bonded]


def drawn(results: Results, moved: np.ndarray) -> np.ndarray:
    """Places (n, 3) of all nodes where they are drawn, mm. moved: their displacements.

    A sheet that slides on a solid is drawn a little above it: in contact the two cross by less than
    can be seen, and would show through each other.
    """
    places = results.points + moved
    lift = _LIFT * np.ptp(results.points, axis=0).max()
    for triangles in _sliding(results):
        a, b, c = (places[triangles[:, i]] for i in range(3))
        normal = np.zeros_like(places)
        np.add.at(normal, triangles, -np.cross(b - a, c - a)[:, None])  # theirs point into it
        loose = np.setdiff1d(triangles, results.cells)
        length = np.linalg.norm(normal[loose], axis=1, keepdims=True)
        places[loose] += lift * normal[loose] / np.maximum(length, 1e-300)
    return places


def _hidden(results: Results) -> list[str]:
    """Surfaces that cannot be seen from outside, of those the mesh has."""
    layout = results.layout
    if not layout.regions:
        return []
    names = [*layout.symmetry, *(name for walls in layout.cavities.values() for name in walls)]
    return [name for name in names if name in results.surfaces]


def _patches(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(k,) number of the smooth patch of each flat triangle: neighbours at less than 35 deg."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    sides = pair_keys(_sides(triangles), len(points))
    order = np.argsort(sides, kind="stable")
    same = sides[order[1:]] == sides[order[:-1]]
    one, other = order[:-1][same] // 3, order[1:][same] // 3
    smooth = (normal[one] * normal[other]).sum(axis=1) > np.cos(np.radians(_CREASE_DEG))
    return connected(one[smooth], other[smooth], len(triangles)).astype(np.int64)


def _sides(triangles: np.ndarray) -> np.ndarray:
    """(3k, 2) ends of the triangles' sides, the lower number first."""
    return np.sort(triangles[:, ((0, 1), (1, 2), (2, 0))].reshape(-1, 2), axis=1)


def pair_keys(sides: np.ndarray, count: int) -> np.ndarray:
    """(n,) a number for each pair, in their order; count: of the points that they are of."""
    low, high = sides.astype(np.int64).T
    return low * count + high


def _planes(results: Results, nodes: np.ndarray) -> np.ndarray:
    """(s, v) for each symmetry plane whether a vertex lies in it."""
    size = np.ptp(results.points, axis=0).max()
    axes = list(results.layout.symmetry.values())
    return np.abs(results.points[nodes][:, axes].T) < 1e-6 * size


def _creases(triangles: np.ndarray, planes: np.ndarray) -> np.ndarray:
    """(e, 2) sides of one triangle only, but for those in a symmetry plane, which are cuts."""
    sides = _sides(triangles)
    _, first, count = np.unique(
        pair_keys(sides, planes.shape[1]), return_index=True, return_counts=True
    )
    border = sides[first[count == 1]]
    cut = planes[:, border].all(axis=2).any(axis=0) if len(planes) else np.zeros(len(border), bool)
    return border[~cut]


def mirrored(
    points: np.ndarray, triangles: np.ndarray, mirrors: Sequence[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles (or edges) of the whole from those of the part that was meshed."""
    for axis in mirrors:
        image = points.copy()
        image[:, axis] *= -1
        triangles = np.vstack([triangles, triangles[:, ::-1] + len(points)])
        points = np.vstack([points, image])
    return points, triangles
