"""How many elements lie through a wall, and what is said of walls with too few.

A quadratic element bends, but its stress through the thickness is linear: one element through a
wall is too few where the wall bends far.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

ENOUGH = 2
#: Part of a wall's thickness by which a flat facet on a round wall may be nearer or further.
ALIKE = 0.25
#: Part of a cavity's walls under which a spot of one element is not worth a word.
SPOT = 0.01
#: Cosine of the angle between the normals of the two sides of a wall.
OPPOSITE = -0.7
# Corners of the face opposite to each corner of a tetrahedron.
_OPPOSITE_FACES = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])


@dataclass(frozen=True)
class Wall:
    """name: of the parameter that says how thick it is. thickness: mm. elements: through it."""

    name: str
    thickness: float
    elements: int


@dataclass(frozen=True)
class Thin:
    """Where a cavity's walls are one element thick: (k,) thickness in mm and area in mm² of their
    facets; whole: area of all walls of the cavity, mm²."""

    cavity: str
    thickness: np.ndarray
    area: np.ndarray
    whole: float


def expected(walls: Iterable[Wall] | None) -> str:
    """What to say of walls with too few elements before anything is meshed; "" where all is well
    or nothing is known."""
    few = [f"{w.name} ({w.thickness:g} mm)" for w in walls or () if w.elements < ENOUGH]
    return _said(_listed(few)) if few else ""


def remark(walls: Sequence[Wall] | None, thin: Sequence[Thin]) -> str:
    """The same of a mesh. walls: those that count, None where the geometry knows none."""
    if walls is None:
        return _said(_listed([_of_cavity(t) for t in thin])) if thin else ""
    named: dict[str, float] = {}
    for t in thin:
        gap = np.array([abs(t.thickness / wall.thickness - 1) for wall in walls])
        for wall, off in zip(walls, gap, strict=True):
            # Walls of one thickness cannot be told from each other: all of them are meant.
            own = (off < ALIKE) & (off <= gap.min(axis=0) + 1e-9)
            if t.area[own].sum() > SPOT * t.whole:
                named[wall.name] = wall.thickness
    return _said(_listed([f"{n} ({t:g} mm)" for n, t in named.items()])) if named else ""


def _said(what: str) -> str:
    return (
        f"one element through {what}: walls that bend need two or more, as through_wall: 2 "
        "makes them"
    )


def _of_cavity(thin: Thin) -> str:
    low, high = (f"{t:.3g}" for t in np.percentile(thin.thickness, [5, 95]))
    thick = f"{low} mm" if low == high else f"{low} to {high} mm"
    return f"{thin.area.sum() / thin.whole:.0%} of the walls of '{thin.cavity}' ({thick} thick)"


def _listed(words: Sequence[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def one_element_thick(
    points: np.ndarray,
    cells: np.ndarray,
    cavities: Mapping[str, np.ndarray],
    left_out: Sequence[np.ndarray],
) -> list[Thin]:
    """Where an element reaches from a cavity's wall to the other side of it.

    points: (n, 3) mm. cells: (m, 4) tetrahedra. cavities: name -> (k, 3) triangles of the walls.
    left_out: triangles (k, 3) of surfaces that are no sides of walls, such as symmetry planes.

    Such an element has its face on the wall and its fourth corner on a facet that looks the other
    way.
    """
    faces = cells[:, _OPPOSITE_FACES].reshape(-1, 3)
    key = _keys(faces, len(points))
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    skin = first[count == 1]
    apex = cells.ravel()[skin]
    corners = points[faces[skin]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(normal, axis=1)
    height = np.einsum("ij,ij->i", normal, points[apex] - corners[:, 0]) / double
    normal *= -np.sign(height)[:, None] / double[:, None]  # out of the solid
    aside = [_keys(triangles, len(points)) for triangles in left_out]
    sides = ~np.isin(key[skin], np.concatenate(aside)) if aside else np.full(len(skin), True)
    reached = _looks_back(faces[skin][sides], normal[sides], apex, normal)
    found = []
    for name, triangles in cavities.items():
        wall = np.isin(key[skin], _keys(triangles, len(points)))
        own = wall & reached
        area = double / 2
        if area[own].sum() > SPOT * area[wall].sum():
            found.append(Thin(name, abs(height[own]), area[own], float(area[wall].sum())))
    return found


def _keys(triangles: np.ndarray, count: int) -> np.ndarray:
    """A number for each triangle (k, 3), whatever the order of its corners."""
    a, b, c = np.sort(triangles, axis=1).astype(np.int64).T
    return (a * count + b) * count + c


def _looks_back(
    facets: np.ndarray, normals: np.ndarray, apex: np.ndarray, own: np.ndarray
) -> np.ndarray:
    """Whether at ``apex`` (k,) there is a facet (n, 3) with a normal (n, 3) that looks against that
    of ``own`` (k, 3)."""
    order = np.argsort(facets.ravel(), kind="stable")
    corner, owner = facets.ravel()[order], np.repeat(np.arange(len(facets)), 3)[order]
    start, end = np.searchsorted(corner, apex), np.searchsorted(corner, apex, side="right")
    against = np.zeros(len(apex), dtype=bool)
    for further in range(int((end - start).max(initial=0))):
        here = np.flatnonzero(start + further < end)
        other = normals[owner[start[here] + further]]
        against[here] |= np.einsum("ij,ij->i", other, own[here]) < OPPOSITE
    return against
