"""Triangles of sheets in space: nodes, named parts and named curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import scipy.sparse.csgraph

from softact.errors import MeshError
from softact.mesh.curves import Curves

SIDES = ((0, 1), (1, 2), (2, 0))
SMALLEST_ANGLE = 1e-3  # sine; a triangle below it has no plane


@dataclass(frozen=True)
class SheetMesh:
    """Triangles that share their nodes where sheets are joined. Lengths in mm.

    points: (n, 3) corners. triangles: (m, 3); the normal, by the right-hand rule, points out of
    the cavity that the sheet walls. parts: name -> numbers of its triangles. curves: name ->
    (k, 2) edges. bonded: parts whose corners are those of a solid. hinges: (k, 2) edges, such as
    seams, over which no bending moment passes. continuous: parts of one sheet that goes on beneath
    such seams; between them no edge is a hinge. bent: edges of triangles that are not straight.
    """

    points: np.ndarray
    triangles: np.ndarray
    parts: Mapping[str, np.ndarray]
    curves: Mapping[str, np.ndarray]
    bonded: tuple[str, ...] = ()
    hinges: np.ndarray | None = None
    continuous: tuple[str, ...] = ()
    bent: Curves = field(default_factory=Curves)

    @classmethod
    def of_parts(
        cls,
        points: np.ndarray,
        parts: Mapping[str, np.ndarray],
        bonded: tuple[str, ...],
        bent: Curves | None = None,
    ) -> SheetMesh:
        """From points of which not all are used, and name -> (k, 3) triangles. bent: edges that are
        not straight."""
        used, triangles = np.unique(np.vstack(list(parts.values())), return_inverse=True)
        ends = np.cumsum([len(members) for members in parts.values()])
        numbers = np.split(np.arange(ends[-1]), ends[:-1])
        named = dict(zip(parts, numbers, strict=True))
        renumber = np.full(len(points), -1)
        renumber[used] = np.arange(len(used))
        points, triangles = points[used], triangles.reshape(-1, 3)
        curves = (bent or Curves()).renumbered(renumber)
        return cls(points, triangles, named, {}, bonded, creases(points, triangles), bent=curves)

    def patches(self) -> np.ndarray:
        """(m,) number of the piece of each triangle when the sheets are cut along the hinges."""
        directed = np.concatenate([self.triangles[:, list(side)] for side in SIDES])
        edges, place = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True)
        key = edges[:, 0] * len(self.points) + edges[:, 1]
        cut = np.empty((0, 2), dtype=int) if self.hinges is None else np.sort(self.hinges, axis=1)
        open_ = ~np.isin(key, cut[:, 0] * len(self.points) + cut[:, 1])
        owner = np.tile(np.arange(len(self.triangles)), 3)
        shape = (len(edges), len(self.triangles))
        on = scipy.sparse.csr_matrix((np.ones(len(owner)), (place.ravel(), owner)), shape=shape)
        through = np.zeros(len(self.triangles))
        for part in self.continuous:
            through[self.parts[part]] = 1.0
        beneath = on[~open_].multiply(through).tocsr()
        links = on[open_].T @ on[open_] + beneath.T @ beneath
        return scipy.sparse.csgraph.connected_components(links, directed=False)[1]

    def check(
        self,
        cavities: Mapping[str, Sequence[str]],
        symmetry: Sequence[int],
        flux: Sequence[float],
        open_at: Sequence[str] = (),
    ) -> None:
        """Raise MeshError for a triangle without area, an open seam of a cavity's walls outside
        the symmetry planes (and walls that ``flux`` does not count) and the curves ``open_at``, or
        walls whose normals do not agree."""
        a, b, c = (self.points[self.triangles[:, i]] for i in range(3))
        double = np.linalg.norm(np.cross(b - a, c - a), axis=1)
        longest = np.max([np.linalg.norm(e, axis=1) for e in (b - a, c - b, a - c)], axis=0)
        flat = double < SMALLEST_ANGLE * longest**2
        if flat.any():
            raise MeshError(f"{int(flat.sum())} triangles of the sheets have no area")
        for name, walls in cavities.items():
            if set(walls) & set(self.parts):
                self._check_closed(name, walls, list(symmetry), np.asarray(flux), open_at)

    def _check_closed(
        self,
        cavity: str,
        walls: Sequence[str],
        planes: list[int],
        flux: np.ndarray,
        open_at: Sequence[str],
    ) -> None:
        triangles = self.triangles[np.concatenate([self.parts[wall] for wall in walls])]
        directed = np.concatenate([triangles[:, list(side)] for side in SIDES])
        edges, place, counts = np.unique(
            np.sort(directed, axis=1), axis=0, return_inverse=True, return_counts=True
        )
        ends = self.points[edges[counts == 1]]
        small = 1e-6 * np.abs(self.points).max()
        mirrored = (np.abs(ends[:, :, planes]).max(axis=1) < small).any(axis=1)
        # A wall across an axis that is not counted: any plane.
        at = [
            np.abs(ends[:, :, c] - e).max(axis=1) < small
            for c in np.flatnonzero(flux == 0)
            for e in (self.points[:, c].min(), self.points[:, c].max())
        ]
        mirrored = np.logical_or.reduce([mirrored, *at, self._are_of(edges[counts == 1], open_at)])
        if not mirrored.all():
            where = ", ".join(f"{x:.3g}" for x in self.points[edges[counts == 1]][~mirrored][0, 0])
            raise MeshError(
                f"cavity '{cavity}' is not closed: {int((~mirrored).sum())} edges of its sheets "
                f"are open, one near ({where}) mm; a seam must join them before they hold pressure"
            )
        if counts.max() > 2:
            a, b = self.points[edges[np.argmax(counts)]]
            where = ", ".join(f"{x:.3g}" for x in (a + b) / 2)
            raise MeshError(
                f"cavity '{cavity}': more than two triangles of its sheets meet in an edge near "
                f"({where}) mm; a triangle with two corners on a seam needs its side there"
            )
        forward = np.bincount(place.ravel(), directed[:, 0] < directed[:, 1], len(edges))
        if np.any(2 * forward[counts == 2] != 2):
            raise MeshError(f"cavity '{cavity}': the normals of its sheets do not agree")

    def _are_of(self, edges: np.ndarray, curves: Sequence[str]) -> np.ndarray:
        """Whether edges (k, 2), the lower number first, are those of curves: (k,)."""
        known = [np.sort(self.curves[name], axis=1) for name in curves]
        pairs = np.concatenate([np.empty((0, 2), int), *known])
        count = len(self.points)
        return np.isin(edges[:, 0] * count + edges[:, 1], pairs[:, 0] * count + pairs[:, 1])


def creases(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Edges (k, 2) at which two triangles meet at an angle."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    sides = np.sort(triangles[:, list(SIDES)].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(triangles)), 3)
    order = np.lexsort(sides.T)
    sides, owner = sides[order], owner[order]
    pairs = np.flatnonzero((sides[1:] == sides[:-1]).all(axis=1))
    turn = np.linalg.norm(np.cross(normal[owner[pairs]], normal[owner[pairs + 1]]), axis=1)
    return sides[pairs[turn > SMALLEST_ANGLE]]


def on_facets(points: np.ndarray, triangles: np.ndarray, opposite: np.ndarray) -> np.ndarray:
    """Triangles (k, 3) on the facets of a solid, turned so that their normals point into it: then
    they and the solid face each other as two bodies in contact do. opposite: (k,) the corner of
    each facet's cell that is not on it."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    outward = np.einsum("ki,ki->k", np.cross(b - a, c - a), points[opposite] - a) < 0
    turned = triangles.copy()
    turned[outward] = triangles[outward][:, [0, 2, 1]]
    return turned


@dataclass(frozen=True)
class SheetNodes:
    """Nodes of the displacement on a ``SheetMesh``.

    places: (n, 3) mm. elements: (m, 3) or (m, 6), corners then middles of 01, 12, 20. curves:
    name -> (k, 2) or (k, 3) nodes of each edge, ends then middle.
    """

    places: np.ndarray
    elements: np.ndarray
    curves: Mapping[str, np.ndarray]


def nodes_of(mesh: SheetMesh, degree: int) -> SheetNodes:
    """Nodes of Lagrange elements of ``degree`` 1 or 2."""
    if degree == 1:
        return SheetNodes(mesh.points, mesh.triangles, mesh.curves)
    count = len(mesh.points)
    sides = np.sort(mesh.triangles[:, list(SIDES)], axis=-1).reshape(-1, 2)
    edges, place = np.unique(sides, axis=0, return_inverse=True)
    places = np.vstack([mesh.points, mesh.bent.middles_of(edges, mesh.points[edges])])
    keys = edges[:, 0] * count + edges[:, 1]

    def with_middles(pairs: np.ndarray) -> np.ndarray:
        low, high = np.sort(pairs, axis=1).T
        found = np.searchsorted(keys, low * count + high)
        if len(pairs) and not np.array_equal(keys[found], low * count + high):
            raise MeshError("an edge of a curve is no edge of the sheets")
        return np.column_stack([pairs, count + found])

    curves = {name: with_middles(np.asarray(pairs)) for name, pairs in mesh.curves.items()}
    elements = np.hstack([mesh.triangles, count + place.reshape(-1, 3)])
    return SheetNodes(places, elements, curves)
