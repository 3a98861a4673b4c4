"""Edges at which a surface ends or turns back."""

from __future__ import annotations

import numpy as np

# Product of normals below which a convex edge is one at which a surface turns back.
SHARP = 0.7


def open_edges(nodes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Whether the edges 01, 12, 20 of facets are open (k, 3): of one facet alone, or sharp and
    convex.

    nodes: (k, n) numbers of nodes, corners first; points: (k, n, 3) where they lie, mm.
    """
    count = len(nodes)
    if not count:
        return np.zeros((0, 3), dtype=bool)
    ends = np.sort(np.stack([nodes[:, [0, 1]], nodes[:, [1, 2]], nodes[:, [2, 0]]], axis=1), axis=2)
    key = (ends[..., 0].astype(np.int64) * (int(nodes.max()) + 1) + ends[..., 1]).ravel()
    order = np.argsort(key, kind="stable")
    facet, edge = np.divmod(order, 3)
    corners = points[:, :3]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    closed = np.zeros((count, 3), dtype=bool)
    # Facets around one edge follow each other; around one of sheets there may be more than two.
    for away in range(1, int(np.unique(key, return_counts=True)[1].max(initial=1))):
        same = np.flatnonzero(key[order][away:] == key[order][:-away])
        for a, b in ((same, same + away), (same + away, same)):
            mine, other = facet[a], facet[b]
            opposite = corners[other, (edge[b] + 2) % 3] - corners[mine, edge[a]]
            convex = np.einsum("mc,mc->m", opposite, normal[mine]) < 0.0
            turned = np.einsum("mc,mc->m", normal[mine], normal[other]) < SHARP
            closed[mine, edge[a]] |= ~(convex & turned)
    return ~closed
