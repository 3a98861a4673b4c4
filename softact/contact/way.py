"""Whether points went through an obstacle on their way from one place to another."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

# Steps from each end after which a way that is neither cleared nor barred counts as clear: it has
# led along the surface, within the depth that is allowed, so far.
MOST_STEPS = 100
# A way is barred where it is deeper than this part of what is allowed: so steps do not vanish.
NEARLY = 0.9


def goes_deeper(
    distance: Callable[[np.ndarray], np.ndarray],
    start: np.ndarray,
    end: np.ndarray,
    depth: np.ndarray,
) -> np.ndarray:
    """Whether (n,) the straight ways from ``start`` to ``end`` (n, 3) come deeper into an obstacle
    than ``depth`` (n,), all in mm.

    distance: places (n, 3) -> signed distances (n,), below zero inside. From a place at the
    distance g one may go g + depth without coming deeper: each way is cleared in such steps from
    both ends until they meet (sphere tracing, Hart 1996, Visual Computer 12:527).
    """
    length = np.linalg.norm(end - start, axis=1)
    which = np.flatnonzero(np.isfinite(length))
    found = np.zeros(len(start), dtype=bool)
    done = np.zeros((2, len(start)))  # how far the way is clear, from either end
    for _ in range(MOST_STEPS):
        if not len(which):
            break
        way = end[which] - start[which]
        unit = way / np.maximum(length[which], 1e-300)[:, None]
        for side, (place, direction) in enumerate(((start, unit), (end, -unit))):
            g = distance(place[which] + done[side, which, None] * direction)
            found[which[g < -depth[which] * NEARLY]] = True
            done[side, which] += np.maximum(g + depth[which], 0.0)
        unclear = ~found[which] & (done[:, which].sum(axis=0) < length[which])
        which = which[unclear]
    return found
