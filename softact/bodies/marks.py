"""Points and lines that a spec names: nodes of the mesh, and what share of a load each has."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from softact.errors import SpecError
from softact.mesh.layout import Line
from softact.mesh.node_order import TET_EDGES, TRIANGLE_EDGES, vtk_order
from softact.system.nodes import Nodes

if TYPE_CHECKING:
    from softact.bodies.named_surfaces import Surfaces

SAME_PLACE = 1e-6  # of a line's length, within which a node lies on it
SNAPPED = 1e-6  # mm: farther from its node a point is told
# How far a point may be from its node, of the longest way from that to a node of its elements.
NEAR = 0.5

#: Nodes (k,) and their shares of a load, of which each process has a part.
Marked = tuple[np.ndarray, np.ndarray]


def here(nodes: Nodes, planes: Sequence[int], place: np.ndarray) -> np.ndarray:
    """A place (..., 3) of the whole actuator, or its mirror image in the part that is meshed."""
    means = nodes.comm.allreduce(nodes.places[: nodes.owned].sum(axis=0))
    found = np.array(place, dtype=float)
    for plane in planes:
        if means[plane] * np.mean(found[..., plane]) < 0:
            found[..., plane] *= -1
    return found


class Marks:
    """Nodes of the points and lines of a layout; sought in the elements of solids and sheets.

    cells: (m, n) displacement nodes of the solids' cells in dolfinx's order, ``reference``. notes:
    what to tell of points that are not at a node.
    """

    def __init__(
        self, nodes: Nodes, planes: Sequence[int], cells: np.ndarray, reference: np.ndarray
    ):
        self._nodes, self._planes = nodes, planes
        self._edges: list[np.ndarray] = []
        if cells.shape[1]:
            order = vtk_order(reference)
            edges = _with_middles(TET_EDGES, 4, len(order))
            self._edges = [cells[:, order[list(edge)]] for edge in edges]
        self.notes: list[str] = []

    def add_triangles(self, triangles: np.ndarray) -> None:
        """Know the elements (m, n) of a sheet too."""
        edges = _with_middles(TRIANGLE_EDGES, 3, triangles.shape[1])
        self._edges += [triangles[:, list(edge)] for edge in edges]

    def point(self, name: str, place: Sequence[float]) -> Marked:
        """The node nearest to a place (mm). Collective. Raises SpecError where none is near."""
        wanted = here(self._nodes, self._planes, np.asarray(place))
        owned = self._nodes.places[: self._nodes.owned]
        gaps = np.linalg.norm(owned - wanted, axis=1)
        best = int(gaps.argmin()) if len(gaps) else -1
        mine = (float(gaps[best]), int(self._nodes.number[best])) if len(gaps) else (np.inf, -1)
        found = self._nodes.comm.allgather(mine)
        gap, number = min(found)
        is_mine = mine == (gap, number)
        around = self._nodes.comm.allreduce(self._reach(best) if is_mine else 0.0)
        at = self._nodes.comm.bcast(owned[best] if is_mine else None, found.index(min(found)))
        where = ", ".join(f"{c:.4g}" for c in np.round(at, 9) + 0.0)
        if gap > NEAR * around:
            raise SpecError(
                f"points.{name}: the body has no node near; the nearest is at ({where}) mm, "
                f"{gap:.3g} mm away"
            )
        if gap > SNAPPED:
            self.notes.append(f"points.{name}: is the node at ({where}) mm, {gap:.3g} mm away")
        nodes = np.array([best] if is_mine else [], dtype=int)
        return nodes, np.ones(len(nodes))

    def _reach(self, node: int) -> float:
        """Longest way from a node to one with which it shares an edge, or half of one."""
        ways = [0.0]
        for edges in self._edges:
            on = edges[(edges == node).any(axis=1)]
            places = self._nodes.places[on]
            ways += list(np.linalg.norm(places - self._nodes.places[node], axis=2).max(axis=1))
        return max(ways)

    def line(self, name: str, line: Line, surfaces: Surfaces) -> Marked:
        """Nodes of the edges on a line, and their parts of its length (mm), by Simpson's rule. A
        node counts once for each edge. Collective. Raises SpecError where there are none."""
        on = self._on(line, surfaces)
        edges = np.concatenate([e[on[e].all(axis=1)] for e in self._edges])
        numbers = np.sort(self._nodes.number[edges], axis=1)
        _, first = np.unique(numbers, axis=0, return_index=True)
        edges, numbers = edges[first], numbers[first]
        if not self._nodes.comm.allreduce(len(edges)):
            raise SpecError(f"lines.{name}: no edge of the mesh lies on it")
        parts = self._nodes.comm.allgather(numbers)
        before = {tuple(row) for part in parts[: self._nodes.comm.rank] for row in part}
        new = np.array([tuple(row) not in before for row in numbers], dtype=bool)
        edges = edges[new]
        ends = self._nodes.places[edges[:, 1]] - self._nodes.places[edges[:, 0]]
        rule = (1 / 6, 1 / 6, 2 / 3) if edges.shape[1] == 3 else (1 / 2, 1 / 2)
        return edges.ravel(), (np.linalg.norm(ends, axis=1)[:, None] * rule).ravel()

    def _on(self, line: Line, surfaces: Surfaces) -> np.ndarray:
        """Whether each node is on a line."""
        count = len(self._nodes.places)
        if isinstance(line[0], str):
            found = np.zeros((2, count), dtype=bool)
            for mask, surface in zip(found, line, strict=True):
                mask[surfaces.nodes(str(surface))] = True
            return found.all(axis=0)
        start, end = here(self._nodes, self._planes, np.asarray(line))
        way, arms = end - start, self._nodes.places - start
        along = np.clip(arms @ way / (way @ way), 0.0, 1.0)
        gaps = np.linalg.norm(arms - along[:, None] * way, axis=1)
        return gaps <= SAME_PLACE * np.linalg.norm(way)


def _with_middles(
    edges: Sequence[tuple[int, int]], corners: int, count: int
) -> list[tuple[int, ...]]:
    """Ends of each edge and, of a quadratic element, its middle."""
    if count == corners:
        return list(edges)
    return [(*edge, corners + number) for number, edge in enumerate(edges)]
