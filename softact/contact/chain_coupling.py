"""Matrix entries between facets of a module and the images of others in the modules around it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse

from softact.contact.coupling import Coupling

if TYPE_CHECKING:
    from softact.bodies.images import Triplets
    from softact.contact.chain_facets import ChainFacets
    from softact.system.assembly import Assembler


class ChainCoupling(Coupling):
    """Between nodes that are images of others: what they couple are these and the chain's motion,
    by J, the derivative of the nodes' places by the unknowns: Jᵀ K J and the motion's second
    derivative times the forces."""

    def __init__(self, assembler: Assembler, facets: ChainFacets, size: int):
        """size: number of unknowns."""
        super().__init__(assembler, facets)
        self._facets, self._size = facets, size
        images = facets.images
        threes = np.concatenate([facets.dofs, images.dofs, [images.turns], [images.shifts]])
        self._first, self._component = np.arange(size), np.zeros(size, dtype=np.int64)
        self._first[threes], self._component[threes] = threes[:, :1], np.arange(3)
        self._there = np.empty(0, dtype=np.int64)

    def _lay_out(self) -> None:
        facets, images = self._facets, self._facets.images
        own, others = np.arange(facets.own), np.arange(facets.own, self._count)
        nodes = [own, others, others, others]
        motion = [np.full(len(others), three[0]) for three in (images.turns, images.shifts)]
        unknowns = [facets.dofs[:, 0], images.dofs[:, 0], *motion]
        entries = np.concatenate(nodes), np.concatenate(unknowns)
        shape = self._count, self._size
        depends = scipy.sparse.csr_matrix((np.ones(len(entries[0])), entries), shape=shape)
        pairs = np.divmod(self._keys, self._count)
        shape = self._count, self._count
        coupled = scipy.sparse.csr_matrix((np.ones(len(self._keys)), pairs), shape=shape)
        found = (depends.T @ coupled @ depends).tocoo()
        self._there = np.unique(self._key(found.row, found.col))
        self._set_blocks(*np.divmod(self._there, self._size))

    def _key(self, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """One number for each block of the matrix."""
        return rows.astype(np.int64) * self._size + columns

    def finish(self, x: np.ndarray, push: Callable[[], np.ndarray]) -> None:
        """See ``Coupling``."""
        images, beyond = self._facets.images, push()[self._facets.own :]
        both = zip(self._folded(x), images.second(x, beyond), strict=True)
        rows, columns, values = map(np.concatenate, both)
        free = (self._assembler.fixed[rows] == 0) & (self._assembler.fixed[columns] == 0)
        counts = free & (values != 0.0)  # images that touch nothing have no room
        rows, columns, values = rows[counts], columns[counts], values[counts]
        block = np.searchsorted(self._there, self._key(self._first[rows], self._first[columns]))
        place = 9 * block + 3 * self._component[rows] + self._component[columns]
        self._slots.values += np.bincount(place, values, len(self._slots.values))

    def _folded(self, x: np.ndarray) -> Triplets:
        """Rows, columns and values of Jᵀ K J."""
        row, column = np.divmod(self._keys, self._count)
        c, shape = np.arange(3), self._blocks.shape
        rows = np.broadcast_to(3 * row[:, None, None] + c[:, None], shape).ravel()
        columns = np.broadcast_to(3 * column[:, None, None] + c, shape).ravel()
        size = 3 * self._count
        between = scipy.sparse.csr_matrix(
            (self._blocks.ravel(), (rows, columns)), shape=(size, size)
        )
        jacobian = self._jacobian(x)
        found = (jacobian.T @ between @ jacobian).tocoo()
        return found.row, found.col, found.data

    def _jacobian(self, x: np.ndarray) -> scipy.sparse.csr_matrix:
        """J (3 count, size)."""
        facets, rows = self._facets, np.arange(3 * self._count).reshape(-1, 3)
        down, across, values = facets.images.jacobian(x, rows[facets.own :])
        entries = np.append(rows[: facets.own], down), np.append(facets.dofs, across)
        values = np.append(np.ones(facets.dofs.size), values)
        return scipy.sparse.csr_matrix((values, entries), shape=(rows.size, self._size))
