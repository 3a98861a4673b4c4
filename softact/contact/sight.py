"""Whether facets may have passed each other between two searches for what they may touch."""

from __future__ import annotations

import numpy as np

MEMBERS = 32  # facets of a group at most
ROWS = 4096  # pairs of groups that are compared at a time
LITTLE = 0.25  # what is less is not told apart


def spheres(nodes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres (k, 3) and radii (k,) of spheres around facets (k, n, 3)."""
    centre = nodes[:, :3].mean(axis=1)
    return centre, np.linalg.norm(nodes - centre[:, None], axis=2).max(axis=1)


def strayed(before: np.ndarray, now: np.ndarray, reach: np.ndarray, side: np.ndarray) -> float:
    """How far facets have moved towards or past others, relative to how far they were from them,
    LITTLE at least; above 1 a pair may have met that was out of reach at the search.

    before, now: (k, n, 3) nodes at the search and after it; reach: (k,) how far was looked;
    side: (k,) see ``closest.candidates``. Only the motion of one facet against the other counts: a
    body that turns as a whole goes as far as it likes. Facets are compared in groups first, whose
    distance and motion bound those of their members.
    """
    if not len(before):
        return LITTLE
    centre, radius = spheres(before)
    moved = now - before
    mean = moved[:, :3].mean(axis=1)
    radius = radius + np.linalg.norm(moved - mean[:, None], axis=2).max(axis=1)
    groups = _groups(centre)
    g_centre, g_mean, g_radius, g_spread = _bounds(groups, centre, mean, radius)
    apart = np.linalg.norm(g_centre[:, None] - g_centre, axis=2) - g_radius[:, None] - g_radius
    way = np.linalg.norm(g_mean[:, None] - g_mean, axis=2) + g_spread[:, None] + g_spread
    ratio = np.where(apart > 0, way / np.maximum(apart, 1e-300), np.inf)
    i, j = np.nonzero(np.triu(np.ones_like(apart, dtype=bool)))
    order = np.argsort(-ratio[i, j])
    i, j = i[order], j[order]
    largest = LITTLE
    for start in range(0, len(i), ROWS):
        rows = slice(start, start + ROWS)
        if ratio[i[start], j[start]] <= largest:
            break
        a, b = groups[i[rows]][:, :, None], groups[j[rows]][:, None]
        distance = np.linalg.norm(centre[a] - centre[b], axis=-1) - radius[a] - radius[b]
        # Nearer ones were looked at, and are watched from iteration to iteration.
        far = distance > np.maximum(reach[a], reach[b])
        far &= (side[a] != side[b]) | (side[a] < 0)
        gone = np.linalg.norm(mean[a] - mean[b], axis=-1)
        largest = max(largest, float((gone[far] / distance[far]).max(initial=0.0)))
    return largest


def _groups(centre: np.ndarray) -> np.ndarray:
    """Numbers (g, m) of points near each other, by halving at medians; a group that is not full
    has its first member several times."""
    groups = [np.arange(len(centre))]
    while len(groups[0]) > MEMBERS:
        halves: list[np.ndarray] = []
        for group in groups:
            axis = np.argmax(np.ptp(centre[group], axis=0))
            order = group[np.argsort(centre[group, axis], kind="stable")]
            middle = (len(order) + 1) // 2
            halves += [order[:middle], order[middle:]]
        groups = halves
    size = len(groups[0])
    return np.array([np.concatenate([g, np.repeat(g[:1], size - len(g))]) for g in groups])


def _bounds(
    groups: np.ndarray, centre: np.ndarray, mean: np.ndarray, radius: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Centres (g, 3) and mean motions (g, 3) of groups, radii (g,) around their members, and by how
    much (g,) the motion of one may differ from the mean."""
    g_centre, g_mean = centre[groups].mean(axis=1), mean[groups].mean(axis=1)
    away = np.linalg.norm(centre[groups] - g_centre[:, None], axis=2) + radius[groups]
    spread = np.linalg.norm(mean[groups] - g_mean[:, None], axis=2)
    return g_centre, g_mean, away.max(axis=1), spread.max(axis=1)
