"""Matrix entries between facets that are no neighbours in the mesh: they come and go."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from softact.contact.chain_facets import ChainFacets
    from softact.contact.whole_facets import WholeFacets
    from softact.system.assembly import Assembler

MOST_ROOM = 2  # times what is wanted, together with what was


class Coupling(ABC):
    """Blocks of the tangent between the nodes of facets that touch, of this process's share.

    ``make_room`` says between which facets there may be entries; the matrix is laid out anew where
    that is not within what it has room for already, on any process.
    """

    def __init__(self, assembler: Assembler, facets: WholeFacets | ChainFacets):
        self._assembler = assembler
        self._nodes, self._count = facets.nodes, facets.count
        self._keys = np.empty(0, dtype=np.int64)
        self._groups = np.empty(0, dtype=np.int64)
        self._blocks = np.empty((0, 3, 3))  # of each key
        self._slots = assembler.couple_loosely()

    def lacks(self, needed: Sequence[np.ndarray]) -> bool:
        """Whether there is no room for ``needed``: arrays (m, 2 or 3) of facets all of whose nodes
        are coupled now."""
        return not np.isin(self._pairs(needed), self._groups).all()

    def make_room(self, needed: Sequence[np.ndarray], near: Sequence[np.ndarray]) -> None:
        """Have room for what is needed, where it is lacking; near: such as may be needed soon, for
        which there is room after the next layout."""
        if not self.lacks(needed):
            return
        total = len(self._nodes)
        # What was there may come back, and a layout costs as much as two factorisations; but a
        # body that slides on and on would fill the matrix.
        wanted = self._pairs([*needed, *near])
        both = np.union1d(self._groups, wanted)
        self._groups = both if len(both) <= MOST_ROOM * len(wanted) else wanted
        i, j = self._groups // total, self._groups % total
        rows = np.repeat(self._nodes[i], self._nodes.shape[1], axis=1).ravel().astype(np.int64)
        columns = np.tile(self._nodes[j], (1, self._nodes.shape[1])).ravel().astype(np.int64)
        keys = np.concatenate([rows * self._count + columns, columns * self._count + rows])
        self._keys = np.unique(keys)
        self._lay_out()

    @abstractmethod
    def _lay_out(self) -> None:
        """Have room in the matrix for the keys."""

    def _set_blocks(self, row: np.ndarray, column: np.ndarray) -> None:
        """Have room for blocks of three by three whose first entries have these numbers (m,)."""
        c, shape = np.arange(3), (len(row), 3, 3)
        rows = np.broadcast_to(row[:, None, None] + c[:, None], shape).ravel()
        columns = np.broadcast_to(column[:, None, None] + c, shape).ravel()
        self._slots.set(rows, columns)

    def _pairs(self, groups: Sequence[np.ndarray]) -> np.ndarray:
        """Sorted numbers of all pairs of facets of each row of ``groups``."""
        total = len(self._nodes)
        return np.unique(
            np.concatenate(
                [
                    (np.minimum(g[:, a], g[:, b]) * total + np.maximum(g[:, a], g[:, b]))
                    for g in groups
                    for a in range(g.shape[1])
                    for b in range(a, g.shape[1])
                ]
            )
        )

    def begin(self) -> None:
        """Start with nothing added. Collective."""
        self._blocks = np.zeros((len(self._keys), 3, 3))

    @abstractmethod
    def finish(self, x: np.ndarray, push: Callable[[], np.ndarray]) -> None:
        """Put what was added into the matrix. x: (local,) unknowns. push: asked for the gradient
        (count, 3) of the energy by the nodes' places, N, where these are no unknowns."""

    def add(
        self,
        pairs: np.ndarray,
        left: np.ndarray,
        right: np.ndarray,
        columns: np.ndarray | None = None,
    ) -> None:
        """Add leftᵀ right of each of m points, left and right (m, r, 6 n), between the nodes of its
        pair (m, 2) of facets, or from those to the nodes of its facets ``columns`` (m, 2)."""
        if columns is None:
            columns = pairs
        groups, left, right = _grouped(np.hstack([pairs, columns]), left, right)
        shape = len(groups), 2 * self._nodes.shape[1]
        matrices = np.matmul(left.transpose(0, 2, 1), right)
        matrices = matrices.reshape(shape[0], shape[1], 3, shape[1], 3)
        rows = self._nodes[groups[:, :2]].reshape(shape).astype(np.int64)
        across = self._nodes[groups[:, 2:]].reshape(shape)
        keys = rows[:, :, None] * self._count + across[:, None]
        block = np.searchsorted(self._keys, keys)
        c = np.arange(3)
        place = (9 * block)[:, :, None, :, None] + 3 * c[:, None, None] + c
        found = np.bincount(place.ravel(), matrices.ravel(), minlength=self._blocks.size)
        self._blocks += found.reshape(-1, 3, 3)


class NodeCoupling(Coupling):
    """Between nodes whose displacements are unknowns."""

    def __init__(self, assembler: Assembler, facets: WholeFacets):
        super().__init__(assembler, facets)
        self._facets = facets
        self._free = np.ones((self._count, 3), dtype=bool)
        self._kept: np.ndarray | None = None  # of each block's entries, where both are free

    def begin(self) -> None:
        """See ``Coupling``."""
        super().begin()
        free = self._facets.free(self._assembler.fixed)
        if not np.array_equal(free, self._free):
            self._free, self._kept = free, None

    def _lay_out(self) -> None:
        self._kept = None
        first = self._facets.first
        row, column = np.divmod(self._keys, self._count)
        self._set_blocks(first[row], first[column])

    def finish(self, x: np.ndarray, push: Callable[[], np.ndarray]) -> None:
        """See ``Coupling``."""
        if self._kept is None:
            row, column = np.divmod(self._keys, self._count)
            self._kept = self._free[row][:, :, None] & self._free[column][:, None]
        self._slots.values += (self._blocks * self._kept).ravel()


def _grouped(
    facets: np.ndarray, left: np.ndarray, right: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of the same facets (m, 4) put together: the facets (g, 4) of each group, and its left
    and right (g, k r, 6 n), filled up with zeros. Of one facet's points many face the same one."""
    groups, number, counts = np.unique(facets, axis=0, return_inverse=True, return_counts=True)
    number = number.ravel()
    order = np.argsort(number, kind="stable")
    within = np.empty(len(facets), dtype=np.int64)
    within[order] = np.arange(len(facets)) - np.repeat(np.cumsum(counts) - counts, counts)
    filled = np.zeros((2, len(groups), counts.max(initial=0), *left.shape[1:]))
    filled[0, number, within], filled[1, number, within] = left, right
    left, right = filled.reshape(2, len(groups), -1, left.shape[2])
    return groups, left, right
