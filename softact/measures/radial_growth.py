"""How far the actuator swells: growth of its slices' radius, however it bends."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot

SLICES = 64
# A slice with fewer nodes has no outline.
FEWEST = 8


def radial_growth(
    before: np.ndarray, after: np.ndarray, axis: np.ndarray, mirrored: Collection[int] = ()
) -> float:
    """Of slices across the undeformed axis, the largest growth of a radius: of the largest distance
    of a node from the line along the slice's fibres through its centre. NaN without a slice.

    before, after: (n, 3) mm, nodes. axis: (3,), unit. mirrored: coordinates in which a mirror image
    completes the nodes; their planes go through the origin.
    """
    for plane in mirrored:
        off = ~np.isclose(before[:, plane], 0.0, atol=1e-9)
        image = np.where(np.arange(3) == plane, -1.0, 1.0)
        before, after = (np.concatenate([p, image * p[off]]) for p in (before, after))
    along = before @ axis
    low, high = along.min(), along.max()
    # Nodes on a border belong to one slice, whatever rounding says of each.
    at = SLICES * (along - low) / max(high - low, 1e-300) + 1e-6
    number = np.minimum(at.astype(int), SLICES - 1)
    growth = [
        _growth(before[number == k], after[number == k], axis)
        for k in np.flatnonzero(np.bincount(number) >= FEWEST)
    ]
    return float(np.nanmax(growth)) if growth and not np.isnan(growth).all() else float("nan")


def _growth(before: np.ndarray, after: np.ndarray, axis: np.ndarray) -> float:
    arms, turned = before - before.mean(axis=0), after - after.mean(axis=0)
    fibre = np.linalg.lstsq(arms, turned, rcond=1e-6)[0].T @ axis
    size = np.linalg.norm(fibre)
    start = _radius(arms, axis)
    # Nodes of one plane say nothing of the fibres through it, and have nothing along them.
    end = _radius(turned, fibre / size) if size > 1e-6 else np.linalg.norm(turned, axis=1).max()
    return end / start - 1 if start > 0 else np.nan


def _radius(arms: np.ndarray, axis: np.ndarray) -> float:
    return float(np.linalg.norm(arms - np.outer(arms @ axis, axis), axis=1).max())


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    owned = snapshot.model.nodes.owned
    mine = snapshot.positions[:owned], snapshot.displacement[:owned]
    parts = zip(*snapshot.model.comm.allgather(mine), strict=True)
    before, moved = (np.concatenate(part) for part in parts)
    layout = snapshot.layout
    axis = np.asarray(layout.axis, float) / np.linalg.norm(layout.axis)
    growth = radial_growth(before, before + moved, axis, set(layout.symmetry.values()))
    return {"radial_growth_percent": 100 * growth}


RADIAL_GROWTH = Measure(
    "radial_growth",
    "how far the actuator swells",
    {
        "radial_growth_percent": f"of the radius of {SLICES} slices across the axis, the largest: "
        "of the largest distance of a node from the slice's middle, across its fibres"
    },
    _evaluate,
)
