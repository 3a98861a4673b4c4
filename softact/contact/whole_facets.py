"""The facets that may touch something, of all processes together: the same on each of them.

Contact between surfaces joins any facet with any other, whichever process holds them. So each
process knows all of these facets and, at each evaluation, the places of their nodes; it looks after
the points of a share of the facets, and the forces and stiffnesses that follow are sent to where
their unknowns are. What is gathered is the same everywhere to the last bit, and only on such
numbers depends who talks to whom.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np
from mpi4py import MPI

from softact import compat
from softact.contact.facets import ContactFacets, Facets, sums_at

if TYPE_CHECKING:
    from softact.model import Model

RECENT = 3  # places of nodes that are kept, since each is asked for several times
_NONE = -1  # in the place of a corner's number, of sheets


def gathered(comm: MPI.Comm, rows: np.ndarray, counts: np.ndarray | None = None) -> np.ndarray:
    """Rows (k, ...) of all processes, one process after another. Collective.

    counts: (processes,) how many each has, where that is known.
    """
    if comm.size == 1:
        return rows
    if counts is None:
        counts = np.array(comm.allgather(len(rows)))
    width = int(np.prod(rows.shape[1:]))
    found = np.empty((int(counts.sum()), *rows.shape[1:]), rows.dtype)
    comm.Allgatherv(np.ascontiguousarray(rows), (found, counts * width))
    return found


class WholeFacets(Facets):
    """All facets of these surfaces, ordered as their corners are numbered in the file of the mesh,
    so that their order does not depend on the number of processes; those of sheets come last.

    nodes: (k, n) numbers of their nodes among ``count``, which are ``numbers`` (count,) in the
    whole model. first: (count,) first unknown of each node, as numbered in the whole model. share:
    (m,) facets whose points this process looks after; mine: (k,) whether it is one of those.
    """

    def __init__(self, model: Model, surfaces: Iterable[str]):
        own, self._comm = ContactFacets(model, surfaces), model.comm
        corners = _corners(model, own)
        turn = _turn(corners, own.nodes.shape[1])
        nodes = np.take_along_axis(model.nodes.number[own.nodes], turn, axis=1)
        points = np.take_along_axis(own.points, turn[..., None], axis=1)
        corners = np.take_along_axis(corners, turn[:, :3], axis=1)
        kind = own.of_sheet.astype(np.int8), own.covering.astype(np.int8)
        parts = (nodes.astype(np.int64), points, corners, own.modulus, *kind)
        nodes, points, corners, modulus, of_sheet, covering = (self._gather(p) for p in parts)
        order = np.lexsort((*corners.T[::-1], of_sheet))
        super().__init__(points[order], modulus[order], of_sheet[order] > 0, covering[order] > 0)
        self.numbers, inverse = np.unique(nodes[order], return_inverse=True)
        self.nodes, self.count = inverse.reshape(nodes.shape), len(self.numbers)
        self.mine = np.arange(len(self)) % self._comm.size == self._comm.rank
        self.share = np.flatnonzero(self.mine)
        self._find_own_nodes(model)
        self._recent: list[tuple[np.ndarray, np.ndarray]] = []

    def _gather(self, rows: np.ndarray) -> np.ndarray:
        return gathered(self._comm, rows)

    def _find_own_nodes(self, model: Model) -> None:
        """Which of the nodes this process owns, and in which order those of all are gathered."""
        number = model.nodes.number[: model.nodes.owned]
        self._held = np.flatnonzero(np.isin(number, self.numbers))
        self._place = np.searchsorted(self.numbers, number[self._held])
        self._dofs = model.displacement_dofs[self._held]
        self._counts = np.array(self._comm.allgather(len(self._held)))
        self._order = self._gather(self._place)
        self.first = self._at_nodes(model.unknowns.number[self._dofs[:, 0]].astype(np.int64))

    def _at_nodes(self, rows: np.ndarray) -> np.ndarray:
        """Values (count, ...) of all nodes, of which each process has those that it owns."""
        found = np.empty((self.count, *rows.shape[1:]), rows.dtype)
        found[self._order] = gathered(self._comm, rows, self._counts)
        return found

    def node_places(self, x: np.ndarray) -> np.ndarray:
        """Deformed places (k, n, 3) of the nodes, mm, not to be written to. x: (local,) unknowns.
        Collective."""
        moved = self._at_nodes(x[self._dofs])
        for known, places in self._recent:
            if np.array_equal(known, moved):
                return places
        places = self.points + moved[self.nodes]
        self._recent = [(moved, places), *self._recent[: RECENT - 1]]
        return places

    def free(self, fixed: np.ndarray) -> np.ndarray:
        """Whether the unknowns (count, 3) of the nodes are free. fixed: (local,) which are not.
        Collective."""
        return self._at_nodes(fixed[self._dofs]) == 0

    def all_among(self, others: WholeFacets) -> np.ndarray:
        """Whether (k,) all nodes of a facet are among those of others."""
        return np.isin(self.numbers, others.numbers)[self.nodes].all(axis=1)

    def any_of(self, here: bool) -> bool:
        """Whether something is so on any process. Collective."""
        return bool(self._comm.allreduce(here, op=MPI.LOR))

    def from_shares(self, found: np.ndarray) -> np.ndarray:
        """Values (k, ...) of all facets, of which each process has those (m, ...) of its share.
        Collective."""
        whole = np.empty((len(self), *found.shape[1:]), found.dtype)
        size = self._comm.size
        counts = np.array([len(range(rank, len(self), size)) for rank in range(size)])
        ends = np.cumsum(counts)
        every = gathered(self._comm, found, counts)
        for rank in range(size):
            whole[rank::size] = every[ends[rank] - counts[rank] : ends[rank]]
        return whole

    def at_nodes(self, nodes: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Sums (count, 3) of the forces (m, n, 3) on nodes (m, n) that each process has found.
        Collective."""
        sums = sums_at(nodes, forces, self.count)
        if self._comm.size > 1:
            self._comm.Allreduce(MPI.IN_PLACE, sums)
        return sums

    def add_forces(self, x: np.ndarray, sums: np.ndarray, out: np.ndarray) -> None:
        """Add the forces ``sums`` (count, 3) on the nodes to this process's own unknowns ``out``
        (local,). x: (local,) the unknowns."""
        out[self._dofs] += sums[self._place]

    def sums_at_nodes(self, values: np.ndarray, count: int) -> np.ndarray:
        """See ``Facets``: of all facets, at the nodes that this process owns."""
        found = np.zeros((2, count))
        found[:, self._held] = self.weighted_sums(values, self.nodes, self.count)[:, self._place]
        return found


def _corners(model: Model, facets: ContactFacets) -> np.ndarray:
    """Numbers (k, 3) of the facets' corners in the file of the mesh, ``_NONE`` of sheets."""
    number = np.full(len(model.nodes.places), _NONE, dtype=np.int64)
    domain = model.mesh.domain
    if domain is not None:
        vertices = model.mesh.original_points[compat.geometry_dofs(domain)]
        number[model.cell_nodes[:, :4]] = vertices
    return np.where(facets.of_sheet[:, None], _NONE, number[facets.nodes[:, :3]])


def _turn(corners: np.ndarray, nodes: int) -> np.ndarray:
    """Order (k, n) of the nodes in which the corner with the lowest number comes first."""
    turned = (np.arange(3) + corners.argmin(axis=1)[:, None]) % 3
    return turned if nodes == 3 else np.hstack([turned, 3 + turned])
