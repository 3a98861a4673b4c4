"""Matrix entries between facets that are no neighbours in the mesh: they come and go."""

from __future__ import annotations

import numpy as np


class Coupling:
    """Blocks of the tangent between the nodes of facets that touch.

    ``make_room`` says between which facets there may be entries; the matrix is laid out anew where
    that is not within what it has room for already.
    """

    def __init__(self, assembler, facets):
        self._assembler = assembler
        self._nodes, self._first = facets.nodes, facets.dofs[..., 0]
        self._count = int(self._nodes.max(initial=0)) + 1
        # first unknown of each node, by its number
        self._dof = np.zeros(self._count, dtype=np.int64)
        self._dof[self._nodes] = self._first
        self._keys = np.empty(0, dtype=np.int64)
        self._groups = np.empty(0, dtype=np.int64)
        self._slots = assembler.couple_loosely()

    def make_room(self, groups) -> None:
        """groups: arrays (m, 2 or 3) of facets all of whose nodes may be coupled."""
        total = len(self._nodes)
        wanted = np.unique(
            np.concatenate(
                [
                    (np.minimum(g[:, a], g[:, b]) * total + np.maximum(g[:, a], g[:, b]))
                    for g in groups
                    for a in range(g.shape[1])
                    for b in range(a, g.shape[1])
                ]
            )
        )
        if np.isin(wanted, self._groups).all():
            return
        self._groups = wanted
        i, j = wanted // total, wanted % total
        rows = np.repeat(self._nodes[i], self._nodes.shape[1], axis=1).ravel().astype(np.int64)
        columns = np.tile(self._nodes[j], (1, self._nodes.shape[1])).ravel().astype(np.int64)
        keys = np.concatenate([rows * self._count + columns, columns * self._count + rows])
        self._keys = np.unique(keys)
        row, column = self._dof[self._keys // self._count], self._dof[self._keys % self._count]
        c = np.arange(3)
        shape = (len(row), 3, 3)
        self._rows = np.broadcast_to(row[:, None, None] + c[:, None], shape).ravel()
        self._columns = np.broadcast_to(column[:, None, None] + c, shape).ravel()
        self._slots.set(self._rows, self._columns)

    def add(self, pairs: np.ndarray, matrices: np.ndarray, columns: np.ndarray | None = None):
        """Add matrices (m, 2 n, 3, 2 n, 3) between the nodes of pairs (m, 2) of facets, or from
        those to the nodes of the facets ``columns``."""
        shape = len(pairs), 2 * self._nodes.shape[1]
        rows = self._nodes[pairs].reshape(shape).astype(np.int64)
        across = rows if columns is None else self._nodes[columns].reshape(shape)
        keys = rows[:, :, None] * self._count + across[:, None]
        block = np.searchsorted(self._keys, keys)
        c = np.arange(3)
        place = (9 * block)[:, :, None, :, None] + 3 * c[:, None, None] + c
        fixed = self._assembler.fixed
        free_rows = fixed[self._dof[rows][..., None] + c] == 0
        free_columns = fixed[self._dof[across][..., None] + c] == 0
        kept = matrices * free_rows[..., None, None] * free_columns[:, None, None]
        self._slots.values += np.bincount(
            place.ravel(), kept.ravel(), minlength=len(self._slots.values)
        )
