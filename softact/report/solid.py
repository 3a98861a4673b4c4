"""The inside of an actuator for the 3-D view, which cuts through it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softact.results.folder import Results

#: More tets than this are not sent along: the page would become too large.
_MOST_TETS = 60_000
_CORNERS = 4


@dataclass(frozen=True)
class Solid:
    """nodes: (i,) corners of tets that no vertex of the skin has; their vertices follow the skin's.
    tets: (t, 4) vertices of the corners, in ascending order, and the tets in theirs: cuts ask for
    no orientation, and what is sorted takes less room."""

    nodes: np.ndarray
    tets: np.ndarray


def solid(results: Results, nodes: np.ndarray) -> Solid:
    """The tets of a result on the vertices of its skin, of a node with several on the last of them.
    nodes: (v,) of those. Without tets where the mesh has none or too many."""
    cells = results.cells
    if cells.shape[1] not in (4, 10) or not 0 < len(cells) <= _MOST_TETS:
        return Solid(np.zeros(0, int), np.zeros((0, _CORNERS), int))
    corners = cells[:, :_CORNERS]
    inside = np.setdiff1d(corners, nodes)
    vertex = np.zeros(len(results.points), int)
    vertex[nodes] = np.arange(len(nodes))
    vertex[inside] = len(nodes) + np.arange(len(inside))
    tets = np.sort(vertex[corners], axis=1)
    return Solid(inside, tets[np.lexsort(tets.T[::-1])])
