"""The named surfaces of a model: facets of its solids, its sheets, and curves along sheets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import cKDTree

from softact import compat
from softact.bodies.marks import Marked, Marks
from softact.bodies.sheet import SheetPart
from softact.mesh.node_order import facet_tables
from softact.mesh.tetrahedra import Mesh
from softact.mesh.triangles import areas_at
from softact.system.nodes import Nodes
from softact.system.term import shared_forces, unit_forces
from softact.system.unknowns import Unknowns

if TYPE_CHECKING:
    from softact.system.assembly import Assembler

SAME_PLACE = 1e-9  # of the body's size
MIDDLES = np.array([[1, 1, 0], [0, 1, 1], [1, 0, 1]]) / 2  # of the edges 01, 12, 20, barycentric
SIMPSON, TRAPEZIUM = (1 / 6, 1 / 6, 2 / 3), (1 / 2, 1 / 2)


def turned_round(nodes: np.ndarray) -> np.ndarray:
    """Nodes (k, 3 or 6) of facets whose normals point the other way."""
    return nodes[:, [0, 2, 1, 5, 4, 3] if nodes.shape[1] == 6 else [0, 2, 1]]


class Surfaces:
    """Nodes, areas and unit forces of what a spec can name on a body.

    cell_nodes: (cells, n) displacement nodes of each solid cell. curves: name -> (k, n) nodes of
    its edges.
    """

    def __init__(
        self,
        mesh: Mesh,
        unknowns: Unknowns,
        nodes: Nodes,
        cell_nodes: np.ndarray,
        degree: int,
        sheets: Mapping[str, SheetPart],
        curves: Mapping[str, np.ndarray],
    ):
        self._mesh, self._unknowns, self._nodes = mesh, unknowns, nodes
        self._cell_nodes, self._degree = cell_nodes, degree
        self._sheets, self.curves = sheets, curves
        self._points: dict[str, tuple[np.ndarray, np.ndarray]] = {}
        self._named: dict[str, np.ndarray] = {}
        self._marks = Marks(
            nodes, [*mesh.layout.symmetry.values()], cell_nodes, compat.reference_nodes(degree)
        )
        for sheet in sheets.values():
            self._marks.add_triangles(sheet.triangles.nodes)
        self._marked: dict[str, Marked] = {}
        for name, place in mesh.layout.points.items():
            self._marked[name] = self._marks.point(name, place)
        for name, line in mesh.layout.lines.items():
            self._marked[name] = self._marks.line(name, line, self)

    @property
    def notes(self) -> list[str]:
        """What to tell of the points that a spec names."""
        return self._marks.notes

    def is_sheet(self, name: str) -> bool:
        """Whether the name is that of a sheet, of a curve along one, or of a point or line."""
        return name in self._sheets or name in self.curves or name in self._marked

    def facets(self, *names: str) -> np.ndarray:
        """Cells and local facets (k, 2) of the named surfaces of solids together."""
        return np.vstack([self._mesh.facets[name] for name in names])

    def facet_nodes(self, facets: np.ndarray) -> np.ndarray:
        """Displacement nodes (k, n) of each facet in VTK's order, turned so that the normal
        points out of the facet's cell."""
        tables = facet_tables(compat.reference_nodes(self._degree))
        nodes = self._cell_nodes[facets[:, :1], tables[facets[:, 1]]]
        x = self._nodes.places
        a, b, c = (x[nodes[:, i]] for i in range(3))
        inside = x[self._cell_nodes[facets[:, 0], facets[:, 1]]]  # the vertex opposite the facet
        inward = np.einsum("ki,ki->k", np.cross(b - a, c - a), inside - a) > 0
        nodes[inward] = turned_round(nodes[inward])
        return nodes

    def points(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Nodes (k,) of this process's facets, sheets or edges of that name, and their shares of
        its area (mm²) or length (mm), of a point 1; a node counts once for each element."""
        if name not in self._points:
            self._points[name] = self._points_of(name)
        return self._points[name]

    def _points_of(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        if name in self._marked:
            return self._marked[name]
        if name in self.curves:
            nodes = self.curves[name]
            ends = self._nodes.places[nodes[:, 1]] - self._nodes.places[nodes[:, 0]]
            rule = SIMPSON if nodes.shape[1] == 3 else TRAPEZIUM
            return nodes.ravel(), (np.linalg.norm(ends, axis=1)[:, None] * rule).ravel()
        if name in self._sheets:
            nodes = self._sheets[name].triangles.nodes
        else:
            nodes = self.facet_nodes(self.facets(name))
        # The middles of the edges integrate a quadratic exactly; linear facets have corners only.
        points = np.eye(3) if nodes.shape[1] == 3 else MIDDLES
        return nodes[:, -3:].ravel(), (areas_at(self._nodes.places[nodes], points) / 3).ravel()

    def nodes(self, name: str) -> np.ndarray:
        """Displacement nodes on a surface, curve, line or point that this process holds, also where
        the facet itself belongs to another process. Collective."""
        if name not in self._named:
            self._named[name] = self._nodes_of(name)
        return self._named[name]

    def _nodes_of(self, name: str) -> np.ndarray:
        if name in self._marked:
            return self._held(self._marked[name][0])
        if name in self.curves:
            return np.unique(self.curves[name])
        if name in self._sheets:
            return np.unique(self._sheets[name].triangles.nodes)
        return self._held(self.facet_nodes(self.facets(name)))

    def _held(self, nodes: np.ndarray) -> np.ndarray:
        """Those of the nodes that any process names which this one holds."""
        mark = np.zeros(self._unknowns.local)
        mark[self._nodes.dofs[nodes, 0]] = 1.0
        return np.flatnonzero(self._unknowns.sum_shared(mark)[self._nodes.dofs[:, 0]])

    def covering(self, nodes: np.ndarray) -> np.ndarray:
        """Nodes of the sheets that lie on a solid (``Layout.covers``) at the places of these nodes
        of it, without those that are the solid's own."""
        covers = [self.nodes(sheet) for sheet in self._mesh.layout.covers]
        loose = np.setdiff1d(np.concatenate([*covers, np.empty(0, int)]), nodes)
        if not len(loose):
            return loose
        places = self._nodes.places
        gaps, _ = cKDTree(places[nodes]).query(places[loose])
        return loose[gaps < SAME_PLACE * np.ptp(places, axis=0).max()]

    def area(self, name: str) -> float:
        """Undeformed area of a surface of the meshed part, mm²; length of a curve, mm."""
        return self._mesh.comm.allreduce(float(self.points(name)[1].sum()))

    def shares(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Nodes (k,) of a surface, sheet or curve that this process owns, and the part of its area
        (length) that each has. A quadratic is integrated exactly by them."""
        nodes, areas = self.points(name)
        dofs = self._nodes.dofs[:, 0]
        whole = np.zeros(self._unknowns.local)
        np.add.at(whole, dofs[nodes], areas)
        share = self._unknowns.sum_shared(whole)[dofs[: self._nodes.owned]] / self.area(name)
        owned = np.flatnonzero(share)
        return owned, share[owned]

    def unit_forces(self, assembler: Assembler, name: str) -> np.ndarray:
        """Forces (3, local) of 1 N/mm² on a surface or a sheet, or 1 N/mm along a curve."""
        if self.is_sheet(name):
            nodes, shares = self.points(name)
            return shared_forces(self._nodes.dofs[nodes], shares, self._unknowns.local)
        return unit_forces(assembler, self.facets(name), self._degree)
