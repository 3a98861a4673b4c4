"""How well tetrahedra are shaped."""

import numpy as np


def signed_volumes(points: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Volume of each tetrahedron (m,), negative where it is inside out."""
    x = points[tets]
    return np.linalg.det(x[:, 1:] - x[:, :1]) / 6


def quality(points: np.ndarray, tets: np.ndarray) -> np.ndarray:
    """Mean ratio of each tetrahedron (m,): 12 (3 V)^(2/3) / sum of squared edges, 1 if regular
    (Liu and Joe, BIT 34, 1994)."""
    x = points[tets]
    edges = [x[:, i] - x[:, j] for i in range(4) for j in range(i)]
    squares = sum((edge**2).sum(axis=1) for edge in edges)
    return 12 * np.cbrt(3 * signed_volumes(points, tets).clip(min=0)) ** 2 / squares
