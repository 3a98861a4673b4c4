"""Order of the nodes of tetrahedra and triangles: dolfinx's own, and VTK's for output."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# VTK orders the edges of a quadratic tetrahedron 01 12 20 03 13 23, those of a triangle 01 12 20.
TET_EDGES = ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))
TRIANGLE_EDGES = ((0, 1), (1, 2), (0, 2))


def vtk_order(
    reference: np.ndarray, edges: Sequence[tuple[int, int]] = TET_EDGES, corners: int = 4
) -> np.ndarray:
    """Places of the corners, then of the middles of ``edges``, among ``reference`` nodes.

    reference: (n, 3) reference coordinates of the element's nodes, corners first.
    """
    wanted = list(reference[:corners])
    if len(reference) > corners:
        wanted += [(reference[a] + reference[b]) / 2 for a, b in edges]
    gaps = np.linalg.norm(reference[None] - np.array(wanted)[:, None], axis=2)
    return np.argmin(gaps, axis=1)


def facet_tables(reference: np.ndarray) -> np.ndarray:
    """Nodes (4, 3 or 6) of each local facet of a tetrahedron in VTK's order.

    Facet f is opposite to vertex f, so its nodes are those where that barycentric coordinate is 0.
    """
    barycentric = np.column_stack([1 - reference.sum(axis=1), reference])
    tables = []
    for coordinate in barycentric.T:
        on_facet = np.flatnonzero(coordinate < 1e-9)
        tables.append(on_facet[vtk_order(reference[on_facet], TRIANGLE_EDGES, 3)])
    return np.array(tables)
