"""Tetrahedra as arrays: how many can be solved, and which way round their corners go."""

import numpy as np

from softact.errors import MeshError

MOST_TETRAHEDRA = 3e6


def check_number(cells: float) -> None:
    """Raise MeshError where a mesh has more tetrahedra than can be solved."""
    if cells > MOST_TETRAHEDRA:
        raise MeshError(
            f"there would be {cells:.2e} tetrahedra, and {MOST_TETRAHEDRA:.0e} are the most; write "
            "a larger mesh_size or a smaller through_wall"
        )


def upright(points: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """The tetrahedra with two corners swapped where their volume was negative."""
    x = points[tets]
    negative = np.linalg.det(x[:, 1:] - x[:, :1]) < 0
    return np.where(negative[:, None], tets[:, [1, 0, 2, 3]], tets)
