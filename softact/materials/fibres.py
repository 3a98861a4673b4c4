"""Which way the fibres of a region lie in the undeformed actuator."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from softact.materials.base import FibreLaw, Law

# Points (n, 3) mm of a region -> the wall's normal (n, 3) there.
WallNormal = Callable[[np.ndarray], np.ndarray]


def fibre_field(
    law: Law,
    axis: Sequence[float],
    wall_normal: WallNormal,
    origin: Sequence[float] = (0.0, 0.0, 0.0),
) -> Callable[[np.ndarray], np.ndarray] | None:
    """Return a function from points (n, 3) mm to unit vectors (n, families, 3).

    law: a law of the library; where it has no fibres, None is returned. axis: of the actuator,
    from which the law's angle counts. wall_normal: of the geometry; the fibres lie in the wall,
    unless the law has a ``normal`` of its own. origin: a point on the axis, mm.
    """
    if not isinstance(law, FibreLaw):
        return None

    def directions(points: np.ndarray) -> np.ndarray:
        shape = (len(points), 3)
        if law.normal == "radial":
            arms = points - np.asarray(origin)
            normal = arms - np.outer(arms @ axis, axis) / np.dot(axis, axis)
        else:
            normal = wall_normal(points) if law.normal is None else np.array(law.normal)
        return law.fibre_directions(np.broadcast_to(axis, shape), np.broadcast_to(normal, shape))

    return directions
