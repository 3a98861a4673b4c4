"""Whether sheets may have passed something between two searches for what they may touch."""

from __future__ import annotations

import numpy as np

ROWS = 256  # facets that are compared with all others at a time


def spheres(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres (k, 3) and radii (k,) of spheres around facets (k, n, 3)."""
    centre = nodes[:, :3].mean(axis=1)
    return centre, np.linalg.norm(nodes - centre[:, None], axis=2).max(axis=1)


def strayed(
    before: np.ndarray, now: np.ndarray, reach: np.ndarray, thin: np.ndarray, side: np.ndarray
) -> float:
    """How far the facets of sheets have moved towards or past others, by how far they were from
    them; above 1 a pair may have met that was out of reach at the search.

    before, now: (k, n, 3) nodes at the search and after it; reach: (k,) how far was looked;
    thin: (k,) whether a facet is one of a sheet, else it is not asked; side: (k,) see
    ``closest.candidates``. Only the motion of one facet against the other counts: a body that
    turns as a whole goes as far as it likes.
    """
    centre, radius = spheres(before)
    moved = now - before
    mean = moved[:, :3].mean(axis=1)
    radius = radius + np.linalg.norm(moved - mean[:, None], axis=2).max(axis=1)
    largest, asked = 0.0, np.flatnonzero(thin)
    for start in range(0, len(asked), ROWS):
        mine = asked[start : start + ROWS]
        apart = np.linalg.norm(centre[mine, None] - centre, axis=2)
        apart -= radius[mine, None] + radius
        # Nearer ones were looked at, and are watched from iteration to iteration.
        other = (side[mine, None] != side) | (side[mine, None] < 0)
        far = other & (apart > np.maximum(reach[mine, None], reach))
        way = np.linalg.norm(mean[mine, None] - mean, axis=2)
        largest = max(largest, float((way[far] / apart[far]).max(initial=0.0)))
    return largest
