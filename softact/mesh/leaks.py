"""Cavities whose walls leave a hole: which edges are open, where, and why."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from softact.mesh.components import Skin, components, part_names, place
from softact.mesh.joining import lying_on
from softact.mesh.layout import Layout


def open_edges(points: np.ndarray, triangles: np.ndarray, planes: Sequence[int]) -> np.ndarray:
    """Edges (k, 2) of triangles (m, 3) that close no surface, those in symmetry planes left out.

    planes: indices of the coordinates that are zero in them.
    """
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, counts = np.unique(sides, axis=0, return_counts=True)
    edges = edges[counts % 2 == 1]
    ends = np.abs(points[edges])
    in_plane = ends[:, :, list(planes)].max(axis=1) < 1e-6 * ends.max(initial=1.0)
    return edges[~in_plane.any(axis=1)]


def within_repeats(
    layout: Layout, surfaces: Mapping[str, np.ndarray], edges: np.ndarray
) -> np.ndarray:
    """Which edges (k, 2) lie in a face at which the next module of a chain goes on."""
    faces = (layout.repeats.left, layout.repeats.right) if layout.repeats else ()
    inside = [np.isin(edges, surfaces[face]).all(axis=1) for face in faces]
    return np.any(inside, axis=0) if inside else np.zeros(len(edges), dtype=bool)


def line(cavity: str, points: np.ndarray, edges: np.ndarray) -> str:
    """The line about the open edges (k, 2) of a cavity."""
    where = place(points[edges[0]].mean(axis=0))
    return (
        f"the walls of the cavity '{cavity}' do not close: {len(edges)} edges are open, one near "
        f"{where}"
    )


def reason(
    points: np.ndarray, regions: dict[str, np.ndarray], walls: np.ndarray, edges: np.ndarray
) -> str:
    """Why edges (k, 2) of a cavity's walls (m, 3) are open, as the end of ``line``.

    regions: name -> tetrahedra.
    """
    cells = np.vstack(list(regions.values()))
    region = np.repeat(np.arange(len(regions)), [len(tets) for tets in regions.values()])
    labels, skin = components(points, cells), Skin.of(cells)
    part = labels[skin.cell]
    for label in range(int(labels.max()) + 1):
        mine = edges[np.isin(edges, cells[labels == label]).all(axis=1)]
        others = np.flatnonzero(part != label)
        on = lying_on(points, points[mine].mean(axis=1), skin.corners[others])
        if (on >= 0).any():
            names = part_names(points, cells, region, list(regions), labels)
            touched = names[part[others[on[on >= 0][0]]]]
            return (
                f"; {touched} lies against {names[label]} there, and the two are not joined: leave "
                "separate: true out"
            )
    known = {tuple(triangle) for triangle in np.sort(walls, axis=1).tolist()}
    beside = np.flatnonzero(np.isin(skin.corners, edges[0]).sum(axis=1) == 2)
    strange = [i for i in beside if tuple(np.sort(skin.corners[i]).tolist()) not in known]
    if not strange:
        return ""
    owner = list(regions)[region[skin.cell[strange[0]]]]
    middle = place(points[skin.corners[strange[0]]].mean(axis=0))
    return f"; the face of '{owner}' beside it, near {middle}, is none of its walls"
