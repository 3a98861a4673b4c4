"""Facets of bodies that may touch something, with quadrature points on the curved facets."""

from __future__ import annotations

import functools
from abc import ABC, abstractmethod
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.edges import open_edges
from softact.contact.pressure import ONSET, SHEET_STIFFNESS, STIFFNESS
from softact.mesh.triangles import areas_at, shape_functions

if TYPE_CHECKING:
    from softact.bodies.sheet import SheetPart
    from softact.mesh.tetrahedra import Mesh
    from softact.model import Model
    from softact.system.assembly import BlockTable

# A quadratic facet is split into four triangles on its own nodes; each has the three points of
# the rule that integrates quadratics exactly. A uniform pressure then gives exact nodal forces.
PIECES = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))
CORNERS = np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]])
RULE = np.array([[4, 1, 1], [1, 4, 1], [1, 1, 4]]) / 6
HALF = 0.5
POINTS = np.vstack([RULE @ CORNERS[list(piece)] for piece in PIECES])  # barycentric (12, 3)

# Weights (12, 6) of a facet's nodes at its points, linear in each piece: none is below zero.
HATS = np.vstack([RULE @ np.eye(6)[list(piece)] for piece in PIECES])


# Facets are beside each other at rest whose middles are nearer than this, of their sizes together.
BESIDE = 2.0

#: Nodes (k, n), stiffness of the penalty (k,), whether of a sheet, whether that lies on a solid.
Group = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


class Facets(ABC):
    """Facets of solids and triangles of sheets that may touch something, as they lie undeformed.

    points: (k, n, 3) places, mm, corners then middles of the edges, normals outward (of a sheet:
    out of its cavity). areas: (k, 12) mm² of each quadrature point. size: (k,) mean edge length,
    mm. modulus: (k,) of the penalty, see ``Group``; stiffness: (k,) MPa/mm of it. onset: (k,) mm.
    of_sheet: (k,) whether a facet is one of a sheet; covering: (k,) of one that lies on a solid.
    nodes: (k, n) numbers of their nodes.
    """

    nodes: np.ndarray

    def __init__(
        self, points: np.ndarray, modulus: np.ndarray, of_sheet: np.ndarray, covering: np.ndarray
    ):
        self.points, self.modulus = points, modulus
        self.of_sheet, self.covering = of_sheet, covering
        self.values = shape_functions(POINTS, points.shape[1])
        a, b, c = (points[:, i] for i in range(3))
        self.areas = areas_at(points, POINTS) / len(POINTS)
        self.size = sum(np.linalg.norm(e, axis=1) for e in (b - a, c - b, a - c)) / 3
        loose = of_sheet & ~covering
        self.stiffness = modulus / np.where(loose, self.size**2, self.size)
        self.onset = ONSET * self.size

    def __len__(self) -> int:
        return len(self.points)

    @functools.cached_property
    def open(self) -> np.ndarray:
        """Which of their edges are open (k, 3), see ``edges``."""
        return open_edges(self.nodes, self.points)

    @functools.cached_property
    def lies(self) -> np.ndarray:
        """Their middles at rest, and how much each adds to the distance within which two are beside
        each other there (k, 4), mm."""
        middle = self.points[:, :3].mean(axis=1)
        return np.column_stack([middle, BESIDE * self.size])

    def counting_areas(
        self, facet: np.ndarray, point: np.ndarray, partner: np.ndarray
    ) -> np.ndarray:
        """Area (m,) that counts for each point: one half where the partner looks back, all of it
        where a sheet lies on a solid, which does not."""
        one_sided = self.covering[facet] & ~self.of_sheet[partner]
        return np.where(one_sided, 1.0, HALF) * self.areas[facet, point]

    def stiffness_between(self, facet: np.ndarray, partner: np.ndarray) -> np.ndarray:
        """Stiffness (m,) MPa/mm of the penalty at points that face a partner: of two solids that of
        the softer one, which gives way. A stiff one's own would hold the soft one's surface at more
        points than it has nodes."""
        own, other = self.modulus[facet], self.modulus[partner]
        solids = ~self.of_sheet[facet] & ~self.of_sheet[partner]
        return self.stiffness[facet] * np.where(solids, np.minimum(other / own, 1.0), 1.0)

    @abstractmethod
    def sums_at_nodes(self, values: np.ndarray, count: int) -> np.ndarray:
        """This process's share (2, count) of ``weighted_sums`` at the ``count`` nodes of the model
        that it holds."""

    def weighted_sums(self, values: np.ndarray, nodes: np.ndarray, count: int) -> np.ndarray:
        """What values (k, 12) at the points add up to at each of ``count`` nodes, weighted by area,
        and the area itself (2, count); of facets on which a value is not zero. nodes: (k, n)."""
        on = np.flatnonzero(values.any(axis=1))
        hats = HATS if nodes.shape[1] == 6 else self.values
        weighted = np.stack([values[on] * self.areas[on], self.areas[on]]) @ hats
        at = nodes[on].ravel()
        return np.stack([np.bincount(at, part.ravel(), count) for part in weighted])


def sums_at(nodes: np.ndarray, forces: np.ndarray, count: int) -> np.ndarray:
    """Sums (count, 3) of the forces (m, n, 3) on nodes (m, n)."""
    at = 3 * nodes.ravel()[:, None] + np.arange(3)
    sums = np.zeros(3 * count)
    sums += np.bincount(at.ravel(), forces.ravel(), len(sums))  # whole numbers where none are
    return sums.reshape(-1, 3)


class ContactFacets(Facets):
    """The facets that one process holds.

    nodes: (k, n) displacement nodes. dofs: (k, n, 3) local unknowns.
    """

    def __init__(self, model: Model, surfaces: Iterable[str]):
        sheets = [model.sheets[name] for name in surfaces if name in model.sheets]
        others = [name for name in surfaces if name not in model.sheets]
        groups = [_of_sheet(model, sheet) for sheet in sheets]
        if others or not sheets:
            groups.insert(0, _of_solids(model, others))
        self.nodes, *kind = map(np.concatenate, zip(*groups, strict=True))
        super().__init__(model.nodes.places[self.nodes], *kind)
        self.dofs = model.displacement_dofs[self.nodes]
        self._assembler, self._blocks = model.assembler, model.nodes.blocks[self.nodes]

    @functools.cached_property
    def _table(self) -> BlockTable:
        return self._assembler.add_table(self._blocks)

    def node_places(self, x: np.ndarray) -> np.ndarray:
        """Deformed places (k, n, 3) of the nodes, mm. x: (local,) unknowns."""
        return self.points + x[self.dofs]

    def places(self, x: np.ndarray) -> np.ndarray:
        """Deformed places (k, 12, 3) of the quadrature points, mm."""
        return self.values @ self.node_places(x)

    def sums_at_nodes(self, values: np.ndarray, count: int) -> np.ndarray:
        """See ``Facets``: of its own facets."""
        return self.weighted_sums(values, self.nodes, count)

    def add_force(
        self, tractions: np.ndarray, out: np.ndarray, on: np.ndarray | slice = slice(None)
    ) -> None:
        """Add the nodal forces of tractions (k', 12, 3), force per area, of the facets ``on``."""
        forces = self.values.T @ (tractions * self.areas[on][..., None])
        out += np.bincount(self.dofs[on].ravel(), forces.ravel(), len(out))

    def add_tangent(self, moduli: np.ndarray, on: np.ndarray) -> None:
        """Add the tangent of moduli (k', 12, 3, 3), d traction / d place, of the facets ``on``."""
        weighted = moduli * self.areas[on][..., None, None]
        matrices = np.einsum("qi,qj,kqab->kiajb", self.values, self.values, weighted, optimize=True)
        self._table.add(matrices, on)


def _of_solids(model: Model, names: Iterable[str]) -> Group:
    """Nodes (k, n), stiffness of the penalty times size (k,) MPa, and that they are no sheets."""
    facets = outside(model.mesh, np.unique(model.surfaces.facets(*names), axis=0))
    nodes, none = model.surfaces.facet_nodes(facets), np.zeros(len(facets), dtype=bool)
    return nodes, _of_rubber(model, facets), none, none


def _of_rubber(model: Model, facets: np.ndarray) -> np.ndarray:
    """Stiffness of the penalty times size (k,), MPa, of a solid's facets."""
    shear = np.array([s.material.shear_modulus for s in model.solids.values()])
    return STIFFNESS * shear[model.mesh.region[facets[:, 0]]]


def _of_sheet(model: Model, part: SheetPart) -> Group:
    """Nodes (k, n), stiffness of the penalty times size² (k,) N/mm, that they are a sheet, and
    whether on a solid; then the stiffness is the solid's, times size."""
    nodes, covered = part.triangles.nodes, model.mesh.layout.covers.get(part.name)
    modulus = SHEET_STIFFNESS * part.sheet.stiffness
    if covered is not None:
        modulus = _of_rubber(model, model.surfaces.facets(covered)).min()
    every = np.ones(len(nodes), dtype=bool)
    return nodes, np.full(len(nodes), modulus), every, every & (covered is not None)


def outside(mesh: Mesh, facets: np.ndarray) -> np.ndarray:
    """Those of ``facets`` (k, 2: cell, local facet) that lie on the boundary of the body."""
    import dolfinx

    topology = mesh.domain.topology
    topology.create_entities(2)
    topology.create_connectivity(2, 3)
    topology.create_connectivity(3, 2)
    table = topology.connectivity(3, 2)
    boundary = dolfinx.mesh.exterior_facet_indices(topology)
    numbers = table.array.reshape(-1, 4)[facets[:, 0], facets[:, 1]]
    return facets[np.isin(numbers, boundary)]
