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
from itertools import chain, combinations

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
    return _seek(results, number, _undeformed(results))[0]


def first_overlap(results: Results, number: int) -> tuple[int, Overlap] | None:
    """The first state in which the parts that overlap in state ``number`` do so, and the overlap in
    that state; None where it has none. The interval between a state without and one with it is
    halved: what comes and goes before is not found."""
    undeformed = _undeformed(results)
    found, inside = _seek(results, number, undeformed)
    if found is None:
        return None
    without, with_one = -1, number
    while with_one - without > 1:
        middle = (without + with_one) // 2
        if _seek(results, middle, undeformed, inside)[0] is None:
            without = middle
        else:
            with_one = middle
    return with_one, found


def _undeformed(results: Results) -> _Undeformed | None:
    return _Undeformed(results) if results.layout.regions else None


def _seek(
    results: Results, number: int, undeformed: _Undeformed | None, only: np.ndarray | None = None
) -> tuple[Overlap | None, np.ndarray | None]:
    """The deepest overlap of a state or None, and which of the surface's points lie inside.
    undeformed: of a solid. only: those points alone are looked at."""
    moved = results.field(number, "displacement")
    found, inside = None, None
    if undeformed is not None:
        found, inside = _Body(undeformed, moved).deepest(only)
    if found is None and results.layout.sheets:
        crossing = deepest_crossing(results, moved)
        if crossing is not None:
            depth, place, other, seen, sheets = crossing
            found = Overlap(0.0, depth, place, other, seen, sheets, at_least=True)
            inside = None
    return found, inside


class _Undeformed:
    """What is the same in all states of a solid: its elements' nodes ``ten`` (m, 10, 3) mm, the
    faces (f, 6) or (f, 3) of its surface, and points of that.

    Of these: ``before`` (n, 3) mm; ``own`` (n, 3) nodes that are in the elements which have the
    point; ``area`` (n,) mm² of the face's points and 0 of nodes; ``size`` (n,) mm, of the face;
    ``face`` (n,) its number; ``side`` (n,) 0 on the outside, else the number of the cavity whose
    wall it is. The last of them are the ``nodes`` (k,) of the surface.
    """

    def __init__(self, results: Results):
        self.results, self.cells = results, results.cells
        self.ten = quadratic.ten_nodes(results.points, self.cells)
        planes = [results.surfaces[name] for name in results.layout.symmetry
                  if name in results.surfaces]  # fmt: skip
        faces = exterior(self.cells)
        faces = faces[~among(faces, planes)]
        # A node belongs to several faces: the first stands for it.
        self.faces, count = faces, len(faces)
        self.nodes, first = np.unique(faces, return_index=True)
        inside, outward = _on_faces(results.points, faces)
        self.before = np.vstack([inside, results.points[self.nodes]])
        self.own = np.vstack([np.repeat(faces[:, :3], 4, axis=0), np.tile(self.nodes[:, None], 3)])
        area = np.linalg.norm(outward, axis=2).reshape(-1) / 8
        self.area = np.concatenate([area, np.zeros(len(self.nodes))])
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

    def names(self, inside: np.ndarray) -> tuple[str, ...]:
        """Names of the surfaces with these points, by their area in these."""
        faces = np.flatnonzero(np.bincount(self.face[inside], minlength=len(self.faces)))
        areas, left = {}, np.bincount(self.face, self.area * inside, len(self.faces))
        for name, triangles in self.results.surfaces.items():
            if triangles.shape[1] >= 3:
                chosen = faces[among(self.faces[faces], [triangles])]
                areas[name] = left[chosen].sum()
                faces = np.setdiff1d(faces, chosen)
        return tuple(sorted((n for n in areas if areas[n] > 0), key=lambda n: -areas[n]))


class _Body:
    """A solid in one state: its elements, and the points of its surface.

    Of these: ``after`` (n, 3) mm; ``normal`` (n, 3), of the deformed surface, to the outside.
    """

    def __init__(self, undeformed: _Undeformed, moved: np.ndarray):
        self.rest, self.cells = undeformed, undeformed.cells
        after, faces = undeformed.results.points + moved, undeformed.faces
        self.deformed = quadratic.ten_nodes(after, self.cells)
        by_node = np.ascontiguousarray(np.moveaxis(self.deformed, 1, 0))
        low, high = by_node.min(axis=0), by_node.max(axis=0)
        self.box = low - _BULGE * (high - low), high + _BULGE * (high - low)
        self.middle = by_node.mean(axis=0)
        self.reach = 1.1 * np.sqrt(((by_node - self.middle) ** 2).sum(axis=2).max(axis=0))
        edges = self.deformed[:, 1:4] - self.deformed[:, :1]
        self.flattened = quadratic.inverse(np.swapaxes(edges, 1, 2))
        inside, outward = _on_faces(after, faces)
        self.after = np.vstack([inside, after[undeformed.nodes]])
        at_nodes = np.zeros((len(after), 3))  # the normals of all faces of a node
        np.add.at(at_nodes, faces, outward.sum(axis=1)[:, None])
        self.normal = _unit(np.vstack([outward.reshape(-1, 3), at_nodes[undeformed.nodes]]))

    def deepest(self, only: np.ndarray | None = None) -> tuple[Overlap | None, np.ndarray]:
        """The deepest overlap or None, and which points lie inside (n,); only: of these points."""
        chosen = np.arange(len(self.after)) if only is None else np.flatnonzero(only)
        inside = np.zeros(len(self.after), bool)
        worst: tuple = (0.0,)
        for signs in _images(self.rest.results):
            point, other = self._seek(chosen, signs)
            if not len(point):
                continue
            depth = self._depth(point, other, signs)
            deep = depth > NOTHING * self.rest.size[point]
            inside[point[deep]] = True
            at = int(np.argmax(np.where(deep, depth, 0.0)))
            if deep[at] and depth[at] > worst[0]:
                worst = float(depth[at]), point[at], other[at]
        if len(worst) == 1:
            return None, inside
        depth, point, other = worst
        share = float(self.rest.area[inside].sum() / self.rest.area.sum())
        names, seen = self.rest.names(inside), self.after[point]
        return Overlap(share, depth, self.rest.before[point], other, seen, names), inside

    def _seek(self, chosen: np.ndarray, signs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Numbers (k,) of those chosen points of the surface whose image (coordinates times
        ``signs``) is inside of an element, and where that is in the undeformed body (k, 3)."""
        from scipy.spatial import cKDTree

        places = self.after * signs
        low, high = self.box
        # Of a mirror image most is on the other side of its plane, away from all elements.
        chosen = chosen[_within(places[chosen], low.min(axis=0), high.max(axis=0))]
        points, others = [np.zeros(0, int)], [np.zeros((0, 3))]
        if not len(chosen):
            return points[0], others[0]
        tree, there = cKDTree(places[chosen]), places[chosen]
        cells = np.flatnonzero(_meeting(low, high, there.min(axis=0), there.max(axis=0)))
        for part in np.split(cells, range(_CHUNK, len(cells), _CHUNK)):
            near = tree.query_ball_point(self.middle[part], self.reach[part], return_sorted=False)
            count = np.fromiter(map(len, near), int, len(near))
            point = np.fromiter(chain.from_iterable(near), int, count.sum())
            point, other = self._inside(
                places, chosen[point], np.repeat(part, count), mirrored=bool((signs < 0).any())
            )
            points.append(point)
            others.append(other)
        return np.concatenate(points), np.vstack(others)

    def _inside(
        self, places: np.ndarray, point: np.ndarray, cell: np.ndarray, mirrored: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """Those pairs of points and elements of which one is inside of the other, as (k,) points
        and (k, 3) places in the undeformed body."""
        low, high = self.box
        for axis in range(3):
            at = places[point, axis]
            boxed = (at > low[cell, axis]) & (at < high[cell, axis])
            point, cell = point[boxed], cell[boxed]
        # One barycentric coordinate after the other: most pairs are soon seen to be apart.
        for axis in range(3):
            away = places[point] - self.deformed[cell, 0]
            near = np.einsum("nj,nj->n", self.flattened[cell, axis], away) > -_BULGE
            point, cell = point[near], cell[near]
        away = places[point] - self.deformed[cell, 0]
        bary = quadratic.barycentrics(np.einsum("nij,nj->ni", self.flattened[cell], away))
        near = bary[:, 0] > -_BULGE
        point, cell, bary = point[near], cell[near], bary[near]
        if not mirrored:
            same = self.rest.own[point][:, :, None] == self.cells[cell][:, None, :]
            others = ~same.any(axis=(1, 2))
            point, cell, bary = point[others], cell[others], bary[others]
        found, bary = quadratic.invert(self.deformed[cell], places[point], bary, INSIDE)
        point, cell = point[found], cell[found]
        return point, np.einsum("nk,nki->ni", quadratic.shapes(bary), self.rest.ten[cell])

    def _depth(self, point: np.ndarray, other: np.ndarray, signs: np.ndarray) -> np.ndarray:
        """How deep the points lie (k,) mm, by the points of the surface next to where they have got
        to in the undeformed body."""
        from scipy.spatial import cKDTree

        nearest, sides = np.zeros(len(point), int), self.rest.side
        for side in np.unique(sides[point]):
            mine, there = sides[point] == side, np.flatnonzero(sides == side)
            nearest[mine] = there[cKDTree(self.rest.before[there]).query(other[mine])[1]]
        away = self.after[nearest] - self.after[point] * signs
        return np.abs(np.einsum("ni,ni->n", away, self.normal[nearest]))


def _on_faces(places: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Four points inside of each face (4f, 3), and vectors (f, 4, 3) along the normals there, as
    long as twice the area that belongs to each would be large."""
    six = quadratic.six_nodes(places, faces)
    inside = np.einsum("pk,fki->fpi", quadratic.face_shapes(_IN_FACE), six)
    along = np.einsum("pkj,fki->fpji", quadratic.face_slopes(_IN_FACE), six)
    return inside.reshape(-1, 3), np.cross(along[:, :, 0], along[:, :, 1])


def _images(results: Results) -> Iterator[np.ndarray]:
    """Signs (3,) of the coordinates of the whole actuator's parts, the meshed one first."""
    axes = sorted(set(results.layout.symmetry.values()))
    for count in range(len(axes) + 1):
        for chosen in combinations(axes, count):
            signs = np.ones(3)
            signs[list(chosen)] = -1.0
            yield signs


def _within(places: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(n,) whether places (n, 3) lie in a box with the corners ``low`` and ``high`` (3,)."""
    return ((places > low) & (places < high)).all(axis=1)


def _meeting(lows: np.ndarray, highs: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(n,) whether boxes with the corners ``lows`` and ``highs`` (n, 3) meet another one."""
    return ((lows < high) & (highs > low)).all(axis=1)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)
