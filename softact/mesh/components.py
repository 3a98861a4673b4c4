"""Which tetrahedra hang together: the parts of a mesh, their names, what lies between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from softact.mesh.boundary import face_keys
from softact.mesh.nearest_triangle import nearest_triangle

TOUCHES = 1e-6  # of the size of the whole
FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])  # outward for positive volume


@dataclass(frozen=True)
class Skin:
    """The triangles of a mesh that belong to one tetrahedron only.

    corners: (k, 3) turned outward; cell: (k,) the tetrahedron of each.
    """

    corners: np.ndarray
    cell: np.ndarray

    @classmethod
    def of(cls, cells: np.ndarray) -> Skin:
        """The skin of tetrahedra (m, 4) of positive volume."""
        faces = cells[:, FACES].reshape(-1, 3)
        _, first, counts = np.unique(face_keys(faces), return_index=True, return_counts=True)
        members = np.sort(first[counts == 1])
        return cls(faces[members], members // 4)


def components(points: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """The number of the part (m,) to which each tetrahedron (m, 4) belongs.

    Tetrahedra hang together where they share a face, or where two pieces share nodes that are not
    all on one line. A common edge or corner alone is a hinge: the two sides of it are two parts.
    """
    keys = face_keys(cells[:, FACES].reshape(-1, 3), len(points))
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(np.diff(keys[order]) == 0)
    pieces = connected(order[same] // 4, order[same + 1] // 4, len(cells))
    if pieces.max(initial=0) == 0:
        return pieces
    return connected(*_rigidly_linked(points, cells, pieces), pieces.max() + 1)[pieces]


def connected(one: np.ndarray, other: np.ndarray, count: int) -> np.ndarray:
    """The number of the group (count,) to which each of ``count`` things belongs that are linked
    pairwise: one[i] with other[i]."""
    # Imported here: reading a spec, and a page of many runs, shall not wait for it.
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    links = coo_array((np.ones(len(one), dtype=bool), (one, other)), shape=(count, count))
    return connected_components(links, directed=False)[1]


def _rigidly_linked(
    points: np.ndarray, cells: np.ndarray, pieces: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of pieces that share at least three nodes that span a plane."""
    members = np.unique(np.column_stack([cells.ravel(), np.repeat(pieces, 4)]), axis=0)
    nodes, counts = np.unique(members[:, 0], return_counts=True)
    shared: dict[tuple[int, int], list[int]] = {}
    for node in nodes[counts > 1].tolist():
        at = np.searchsorted(members[:, 0], [node, node + 1])
        known = members[slice(*at), 1].tolist()
        for i, first in enumerate(known):
            for second in known[i + 1 :]:
                shared.setdefault((first, second), []).append(node)
    linked = [pair for pair, nodes in shared.items() if _spans_a_plane(points[nodes])]
    one, other = np.array(linked, dtype=np.int64).reshape(-1, 2).T
    return one, other


def _spans_a_plane(points: np.ndarray) -> bool:
    if len(points) < 3:
        return False
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[1] > 1e-6 * spread[0])


def part_names(
    points: np.ndarray,
    cells: np.ndarray,
    region: np.ndarray,
    names: Sequence[str],
    labels: np.ndarray,
) -> list[str]:
    """What to call each part: by its regions, and by its middle where several have the same.

    region: (m,) number of the region of each tetrahedron, into ``names``; labels: see
    ``components``.
    """
    called = [
        " and ".join(f"'{names[number]}'" for number in np.unique(region[labels == label]))
        for label in range(int(labels.max(initial=-1)) + 1)
    ]
    return [
        f"{name} near {place(points[cells[labels == label]].mean(axis=(0, 1)))}"
        if called.count(name) > 1
        else name
        for label, name in enumerate(called)
    ]


def place(point: np.ndarray) -> str:
    """A point as text, for messages."""
    return f"({', '.join(f'{c + 0.0:.4g}' for c in np.round(point, 6))}) mm"


def gap(points: np.ndarray, cells: np.ndarray, labels: np.ndarray, label: int) -> str:
    """Where a part is nearest to the others, to which it is not joined, in words."""
    skin = Skin.of(cells)
    own = labels[skin.cell] == label
    found = []
    for these, those in ((own, ~own), (~own, own)):
        places = points[np.unique(skin.corners[these])]
        distance, _ = nearest_triangle(places, points[skin.corners[those]])
        nearest = int(np.argmin(distance))
        found.append((float(distance[nearest]), places[nearest]))
    least, where = min(found, key=lambda pair: pair[0])
    if least < TOUCHES * np.ptp(points, axis=0).max():
        return f"touches another near {place(where)} without being joined to it"
    return f"is joined to no other, the next is {least:.2g} mm away at {place(where)}"
