"""How far places are from triangles in space."""

from __future__ import annotations

import numpy as np

# Triangles with the nearest middles, among which the nearest is sought: enough where sizes do not
# differ much.
CANDIDATES = 24


def nearest_triangle(places: np.ndarray, corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance (n,) of places (n, 3) to triangles (k, 3, 3), and the number of the nearest.

    Infinity and -1 where there are no triangles.
    """
    # Imported here: reading a spec shall not wait for it.
    from scipy.spatial import cKDTree

    distance: np.ndarray = np.full(len(places), np.inf)
    nearest: np.ndarray = np.full(len(places), -1)
    if not len(places) or not len(corners):
        return distance, nearest
    count = min(CANDIDATES, len(corners))
    _, near = cKDTree(corners.mean(axis=1)).query(places, k=count)
    for candidate in near.reshape(len(places), count).T:
        here = _distance(places, corners[candidate])
        nearest = np.where(here < distance, candidate, nearest)
        distance = np.minimum(distance, here)
    return distance, nearest


def _distance(places: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Distance (n,) of each place (n, 3) to its own triangle (n, 3, 3)."""
    ends = np.roll(corners, -1, axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = np.linalg.norm(normal, axis=1)
    unit = normal / np.where(size > 0, size, 1.0)[:, None]
    away = places[:, None] - corners
    inside = (np.einsum("nij,nj->ni", np.cross(ends - corners, away), unit) >= 0).all(axis=1)
    height = np.abs(np.einsum("ni,ni->n", away[:, 0], unit))
    along = np.einsum("nij,nij->ni", away, ends - corners)
    squares = np.einsum("nij,nij->ni", ends - corners, ends - corners)
    part = np.clip(along / np.where(squares > 0, squares, 1.0), 0.0, 1.0)
    foot = corners + part[:, :, None] * (ends - corners)
    to_edges = np.linalg.norm(places[:, None] - foot, axis=2).min(axis=1)
    return np.where(inside & (size > 0), height, to_edges)
