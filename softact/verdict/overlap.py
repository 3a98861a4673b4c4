"""Where a deformed solid passes through itself, which nothing prevents where contact is left out.

Points of its surface (the nodes, and four points inside of each face) are sought in the deformed
elements: a tree of places finds those that may hold a point (broad phase), Newton's method inverts
their quadratic map (narrow phase). A point of the surface that lies inside of an element that is
no neighbour is in two places of the material at once. How deep it lies is told by the place of the
surface that is nearest in the undeformed body, where no other part of it is in the way: of the
outer surface or of that cavity's walls, as the point itself, for through these it has come in.
Mirror images across symmetry planes are sought too, so a half that crosses its plane is found.

Sheets have no inside: see ``softact.verdict.crossing``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from softact.mesh.boundary import among, exterior
from softact.results.folder import Results
from softact.verdict import quadratic
from softact.verdict.crossing import deepest_crossing

# Least barycentric coordinate of a point that lies inside of an element and not on its face.
INSIDE = 0.01
# Depths below this part of the face's size are not told: contact is allowed less than half of it
# (docs/contact.md), and between its nodes a quadratic face is not known better.
NOTHING = 0.05
# How far outside of its straight-edged corners a quadratic element may reach, in barycentrics.
_BULGE = 0.3
_CHUNK = 4000  # elements looked at together, which bounds the memory

#: Barycentrics of four points inside of a face, one for each of its flat pieces.
_IN_FACE = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4], [2, 2, 2]]) / 6.0


@dataclass(frozen=True)
class Overlap:
    """How far an actuator passes through itself in one state.

    share: of its surface, by undeformed area, that lies inside; 0 where only single nodes do or
    sheets cross. depth: mm, of the deepest place. place, other: (3,) mm, where in the undeformed
    actuator the two parts are that meet there. seen: (3,) mm, where that is in the state. surfaces:
    names of the surfaces that lie inside, that with the largest part first. at_least: whether the
    depth is a lower bound, as it is for sheets.
    """

    share: float
    depth: float
    place: np.ndarray
    other: np.ndarray
    seen: np.ndarray
    surfaces: tuple[str, ...]
    at_least: bool = False


def overlap(results: Results, number: int) -> Overlap | None:
    """The deepest overlap of a state (a row of the curve), None where there is none."""
    return _seek(results, number)[0]


def first_overlap(results: Results, number: int) -> tuple[int, Overlap] | None:
    """The first state in which the parts that overlap in state ``number`` do so, and the overlap in
    that state; None where it has none. The interval between a state without and one with it is
    halved: what comes and goes before is not found."""
    found, inside = _seek(results, number)
    if found is None:
        return None
    without, with_one = -1, number
    while with_one - without > 1:
        middle = (without + with_one) // 2
        if _seek(results, middle, inside)[0] is None:
            without = middle
        else:
            with_one = middle
    return with_one, found


def _seek(
    results: Results, number: int, only: np.ndarray | None = None
) -> tuple[Overlap | None, np.ndarray | None]:
    """The deepest overlap of a state or None, and which of the surface's points lie inside. only:
    those points alone are looked at."""
    moved = results.field(number, "displacement")
    found, inside = None, None
    if results.layout.regions:
        found, inside = _Body(results, moved).deepest(only)
    if found is None and results.layout.sheets:
        crossing = deepest_crossing(results, moved)
        if crossing is not None:
            depth, place, other, seen, sheets = crossing
            found = Overlap(0.0, depth, place, other, seen, sheets, at_least=True)
            inside = None
    return found, inside


class _Body:
    """A solid in one state: its elements, and points of its surface.

    Of the surface's points: ``before``, ``after`` (n, 3) mm; ``normal`` (n, 3), of the deformed
    surface, to the outside; ``own`` (n, 3) nodes that are in the elements which have the point;
    ``area`` (n,) mm², undeformed, of the face's points and 0 of nodes; ``size`` (n,) mm, of the
    face; ``face`` (n,) its number; ``side`` (n,) 0 on the outside, else the number of the cavity
    whose wall it is.
    """

    def __init__(self, results: Results, moved: np.ndarray):
        self.results, self.cells = results, results.cells
        self.undeformed = quadratic.ten_nodes(results.points, results.cells)
        self.deformed = quadratic.ten_nodes(results.points + moved, results.cells)
        margin = _BULGE * np.ptp(self.deformed, axis=1)
        self.box = self.deformed.min(axis=1) - margin, self.deformed.max(axis=1) + margin
        edges = self.deformed[:, 1:4] - self.deformed[:, :1]
        self.flattened = quadratic.inverse(np.swapaxes(edges, 1, 2))
        planes = [results.surfaces[name] for name in results.layout.symmetry
                  if name in results.surfaces]  # fmt: skip
        faces = exterior(results.cells)
        self.faces = faces[~among(faces, planes)]
        self._place_points(results.points, results.points + moved)

    def _place_points(self, before: np.ndarray, after: np.ndarray) -> None:
        faces, count = self.faces, len(self.faces)
        inside, outward = [], []
        for places in (before, after):
            six = quadratic.six_nodes(places, faces)
            inside.append(
                np.einsum("pk,fki->fpi", quadratic.face_shapes(_IN_FACE), six).reshape(-1, 3)
            )
            along = np.einsum("pkj,fki->fpji", quadratic.face_slopes(_IN_FACE), six)
            outward.append(np.cross(along[:, :, 0], along[:, :, 1]))
        # A node belongs to several faces: the first stands for it, with the normals of all.
        nodes, first = np.unique(faces, return_index=True)
        at_nodes = np.zeros((len(before), 3))
        np.add.at(at_nodes, faces, outward[1].sum(axis=1)[:, None])
        self.before = np.vstack([inside[0], before[nodes]])
        self.after = np.vstack([inside[1], after[nodes]])
        self.normal = _unit(np.vstack([outward[1].reshape(-1, 3), at_nodes[nodes]]))
        self.own = np.vstack([np.repeat(faces[:, :3], 4, axis=0), np.tile(nodes[:, None], 3)])
        area = np.linalg.norm(outward[0], axis=2).reshape(-1) / 8
        self.area = np.concatenate([area, np.zeros(len(nodes))])
        self.face = np.concatenate([np.repeat(np.arange(count), 4), first // faces.shape[1]])
        self.size = np.sqrt(2 * area.reshape(count, 4).sum(axis=1))[self.face]
        self.side = self._sides()[self.face]

    def _sides(self) -> np.ndarray:
        """(f,) 0 for faces of the outside, else the number of the cavity whose wall it is."""
        sides = np.zeros(len(self.faces), int)
        for number, walls in enumerate(self.results.layout.cavities.values(), 1):
            there = [self.results.surfaces[name] for name in walls if name in self.results.surfaces]
            sides[among(self.faces, there)] = number
        return sides

    def deepest(self, only: np.ndarray | None = None) -> tuple[Overlap | None, np.ndarray]:
        """The deepest overlap or None, and which points lie inside (n,); only: of these points."""
        chosen = np.arange(len(self.before)) if only is None else np.flatnonzero(only)
        inside = np.zeros(len(self.before), bool)
        worst: tuple = (0.0,)
        for signs in _images(self.results):
            point, other = self._seek(chosen, signs)
            if not len(point):
                continue
            depth = self._depth(point, other, signs)
            deep = depth > NOTHING * self.size[point]
            inside[point[deep]] = True
            at = int(np.argmax(np.where(deep, depth, 0.0)))
            if deep[at] and depth[at] > worst[0]:
                worst = float(depth[at]), point[at], other[at]
        if len(worst) == 1:
            return None, inside
        depth, point, other = worst
        share = float(self.area[inside].sum() / self.area.sum())
        names, seen = self._names(inside), self.after[point]
        return Overlap(share, depth, self.before[point], other, seen, names), inside

    def _seek(self, chosen: np.ndarray, signs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (k,) of those chosen points of the surface whose image (coordinates times
        ``signs``) is inside of an element, and where that is in the undeformed body (k, 3)."""
        from scipy.spatial import cKDTree

        places = self.after * signs
        tree = cKDTree(places[chosen])
        middle = self.deformed.mean(axis=1)
        reach = 1.1 * np.linalg.norm(self.deformed - middle[:, None], axis=2).max(axis=1)
        points, others = [np.zeros(0, int)], [np.zeros((0, 3))]
        for start in range(0, len(middle), _CHUNK):
            part = slice(start, start + _CHUNK)
            near = tree.query_ball_point(middle[part], reach[part], return_sorted=False)
            cell = np.repeat(start + np.arange(len(near)), [len(some) for some in near])
            if len(cell):
                point = chosen[np.concatenate([some for some in near if some]).astype(int)]
                point, other = self._inside(places, point, cell, mirrored=bool((signs < 0).any()))
                points.append(point)
                others.append(other)
        return np.concatenate(points), np.vstack(others)

    def _inside(
        self, places: np.ndarray, point: np.ndarray, cell: np.ndarray, mirrored: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """Those pairs of points and elements of which one is inside of the other, as (k,) points
        and (k, 3) places in the undeformed body."""
        low, high = self.box
        boxed = ((places[point] > low[cell]) & (places[point] < high[cell])).all(axis=1)
        point, cell = point[boxed], cell[boxed]
        away = places[point] - self.deformed[cell, 0]
        bary = quadratic.barycentrics(np.einsum("nij,nj->ni", self.flattened[cell], away))
        near = bary.min(axis=1) > -_BULGE
        point, cell, bary = point[near], cell[near], bary[near]
        if not mirrored:
            same = self.own[point][:, :, None] == self.cells[cell][:, None, :]
            others = ~same.any(axis=(1, 2))
            point, cell, bary = point[others], cell[others], bary[others]
        found, bary = quadratic.invert(self.deformed[cell], places[point], bary, INSIDE)
        point, cell = point[found], cell[found]
        return point, np.einsum("nk,nki->ni", quadratic.shapes(bary), self.undeformed[cell])

    def _names(self, inside: np.ndarray) -> tuple[str, ...]:
        """Names of the surfaces with these points, by their area in these."""
        faces = np.flatnonzero(np.bincount(self.face[inside], minlength=len(self.faces)))
        areas, left = {}, np.bincount(self.face, self.area * inside, len(self.faces))
        for name, triangles in self.results.surfaces.items():
            if triangles.shape[1] >= 3:
                chosen = faces[among(self.faces[faces], [triangles])]
                areas[name] = left[chosen].sum()
                faces = np.setdiff1d(faces, chosen)
        return tuple(sorted((n for n in areas if areas[n] > 0), key=lambda n: -areas[n]))

    def _depth(self, point: np.ndarray, other: np.ndarray, signs: np.ndarray) -> np.ndarray:
        """How deep the points lie (k,) mm, by the points of the surface next to where they have got
        to in the undeformed body."""
        from scipy.spatial import cKDTree

        nearest = np.zeros(len(point), int)
        for side in np.unique(self.side[point]):
            mine, there = self.side[point] == side, np.flatnonzero(self.side == side)
            nearest[mine] = there[cKDTree(self.before[there]).query(other[mine])[1]]
        away = self.after[nearest] - self.after[point] * signs
        return np.abs(np.einsum("ni,ni->n", away, self.normal[nearest]))


def _images(results: Results) -> Iterator[np.ndarray]:
    """Signs (3,) of the coordinates of the whole actuator's parts, the meshed one first."""
    axes = sorted(set(results.layout.symmetry.values()))
    for count in range(len(axes) + 1):
        for chosen in combinations(axes, count):
            signs = np.ones(3)
            signs[list(chosen)] = -1.0
            yield signs


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)
