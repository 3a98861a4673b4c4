"""Which triangles of sheets can never touch: the two sides of one pouch."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse.csgraph

if TYPE_CHECKING:
    from softact.contact.chain_facets import ChainFacets
    from softact.contact.whole_facets import WholeFacets
    from softact.model import Model

# Planes nearer than this coincide, of the element size.
COINCIDENT = 1e-6
# How near triangles of sheets that are not joined lie to be sides of one body, of the element size.
NEAR = 2.0


class Backs:
    """Pairs of sheets' triangles that look away from each other as they lie.

    A sheet has no thickness in the mesh, so that the outer sides of a flat pouch coincide, or lie
    behind each other by less than an element: as an overlap does. Two triangles are held for the
    two sides of a body where their undeformed normals are opposed and each lies behind the other's
    plane or in it, and they are joined by sheets, or near each other.
    """

    def __init__(self, model: Model, facets: WholeFacets | ChainFacets):
        points = facets.points
        self._sheet, self._size = facets.of_sheet, facets.size
        self._centre = points[:, :3].mean(axis=1)
        normal = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
        self._normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        self._piece = np.zeros(len(facets), dtype=int)
        if model.sheets:  # in a model of one process, where numbers are those of its nodes
            self._piece = _pieces(model)[facets.numbers[facets.nodes[:, 0]]]

    def __call__(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Whether the facets i (m,) and j (m,) are such a pair."""
        if not self._sheet.any():
            return np.zeros(len(i), dtype=bool)
        way, size = self._centre[i] - self._centre[j], self._size[i] + self._size[j]
        n, m = self._normal[i], self._normal[j]
        small = COINCIDENT * size
        ahead = np.maximum(np.einsum("mc,mc->m", way, m), -np.einsum("mc,mc->m", way, n))
        near = np.linalg.norm(way, axis=1) < NEAR * size
        joined = self._piece[i] == self._piece[j]
        opposed = np.einsum("mc,mc->m", n, m) < 0
        return self._sheet[i] & self._sheet[j] & opposed & (ahead <= small) & (joined | near)


def _pieces(model: Model) -> np.ndarray:
    """Number (nodes,) of the piece of sheets that hang together, of each node."""
    count = len(model.nodes.places)
    parts = [part.triangles.nodes for part in model.sheets.values()]
    rows = [np.repeat(nodes[:, 0], nodes.shape[1]) for nodes in parts]
    ends = (np.concatenate([*side, np.empty(0, int)]) for side in (rows, map(np.ravel, parts)))
    i, j = ends
    links = scipy.sparse.csr_matrix((np.ones(len(i)), (i, j)), shape=(count, count))
    return scipy.sparse.csgraph.connected_components(links, directed=False)[1]
