"""Means at the nodes of what the cells around them say there, weighted by the cells' volumes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse

if TYPE_CHECKING:
    from softact.bodies.solid import Solid
    from softact.model import Model

#: A solid, or a part of one, and what its cells say at their nodes: (cells, nodes per cell, k).
Said = tuple["Solid", np.ndarray]


def nodal_means(model: Model, said: Sequence[Said]) -> np.ndarray:
    """Means (nodes, k) at the nodes that this process holds; zero where no solid is. Collective."""
    dofs = model.displacement_dofs
    sums = _sums(model, said, np.arange(len(dofs)))
    whole = np.empty_like(sums)
    for start in range(0, sums.shape[1], 3):  # three values a node travel as a displacement does
        columns = sums[:, start : start + 3]
        local = np.zeros(model.unknowns.local)
        local[dofs[:, : columns.shape[1]]] = columns
        summed = model.unknowns.sum_shared(local)
        whole[:, start : start + 3] = summed[dofs[:, : columns.shape[1]]]
    return _divided(whole)


def nodal_means_at(model: Model, said: Sequence[Said], nodes: np.ndarray) -> np.ndarray:
    """The same at some nodes (m,), of which processes may name the same; zero elsewhere."""
    own = model.nodes.number[nodes]
    parts = model.comm.allgather((own, _sums(model, said, nodes)))
    numbers, sums = (np.concatenate(part) for part in zip(*parts, strict=True))
    known, place = np.unique(numbers, return_inverse=True)
    whole = np.zeros((len(known), sums.shape[1]))
    np.add.at(whole, place, sums)
    found = np.zeros((len(model.displacement_dofs), sums.shape[1] - 1))
    found[nodes] = _divided(whole[np.searchsorted(known, own)])
    return found


def _divided(sums: np.ndarray) -> np.ndarray:
    return sums[:, :-1] / np.maximum(sums[:, -1:], 1e-300)


def _sums(model: Model, said: Sequence[Said], nodes: np.ndarray) -> np.ndarray:
    """Sums (m, k + 1) of what this process's cells say at nodes (m,), weighted by volume, and of
    the weights."""
    place = np.full(len(model.displacement_dofs), -1)
    place[nodes] = np.arange(len(nodes))
    sums = np.zeros((len(nodes), said[0][1].shape[-1] + 1))
    for solid, values in said:
        at = place[model.cell_nodes[solid.cells].ravel()]
        here = np.flatnonzero(at >= 0)
        weight = np.repeat(solid.volumes.sum(axis=1), values.shape[1])[here]
        # Much faster than np.add.at.
        add = scipy.sparse.csr_matrix(
            (weight, (at[here], np.arange(len(here)))), shape=(len(nodes), len(here))
        )
        sums[:, :-1] += add @ values.reshape(-1, values.shape[-1])[here]
        sums[:, -1] += np.asarray(add.sum(axis=1)).ravel()
    return sums
