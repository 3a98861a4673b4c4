"""The faces of a mesh: which bound it, as flat triangles, and whose they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

_TET_FACES = ((0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (2, 0, 3, 6, 7, 9))
_PIECES = ((0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5))  # of a quadratic triangle


def exterior(cells: np.ndarray) -> np.ndarray:
    """Faces that belong to one tet only, (k, 6) or (k, 3), normals outward, VTK's order; sheets
    are their own faces."""
    if cells.shape[1] in (3, 6):
        return cells
    corners = cells.shape[1] == 4
    faces = np.vstack([cells[:, face[:3] if corners else face] for face in _TET_FACES])
    _, first, count = np.unique(face_keys(faces), return_index=True, return_counts=True)
    return faces[first[count == 1]]


def flat(triangles: np.ndarray) -> np.ndarray:
    """Each quadratic triangle (k, 6) as four flat ones (4k, 3); flat ones are left alone."""
    if triangles.shape[1] == 3:
        return triangles
    return np.stack([triangles[:, piece] for piece in _PIECES], axis=1).reshape(-1, 3)


def among(triangles: np.ndarray, groups: Sequence[np.ndarray]) -> np.ndarray:
    """(k,) whether each of ``triangles`` has its corners in one of the ``groups``."""
    if not groups:
        return np.zeros(len(triangles), bool)
    known = face_keys(np.vstack([part[:, :3] for part in (triangles, *groups)]))
    return np.isin(known[: len(triangles)], known[len(triangles) :])


def surface_of(face: np.ndarray, surfaces: Mapping[str, np.ndarray]) -> str:
    """Name of the first surface that has a face, "" where none has it."""
    for name, triangles in surfaces.items():
        if triangles.shape[1] >= 3 and among(face[None], [triangles])[0]:
            return name
    return ""


def face_keys(triangles: np.ndarray, count: int = 0) -> np.ndarray:
    """(k,) a number for each triangle (k, 3 or more) by its corners in any order; in the order of
    the sorted corners.

    count: of the points of the mesh, for numbers that are compared with those of other triangles.
    """
    low, middle, high = np.sort(triangles[:, :3], axis=1).astype(np.int64).T
    size = count or 1 + int(triangles.max(initial=0))
    sides = low * size + middle
    if size**3 >= 2**63:
        _, sides = np.unique(sides, return_inverse=True)
    return sides * size + high
