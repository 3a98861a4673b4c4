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
    before: np.ndarray,
    after: np.ndarray,
    axis: np.ndarray,
    mirrored: Collection[int] = (),
    slices: int = SLICES,
) -> tuple[float, np.ndarray]:
    """Of slices across the undeformed axis, the largest growth of a radius: of the largest distance
    of a node from the line along the slice's fibres through its centre. NaN without a slice. And
    the nodes (k,) of that slice.

    before, after: (n, 3) mm, nodes. axis: (3,), unit. mirrored: coordinates in which a mirror image
    completes the nodes; their planes go through the origin.
    """
    own = len(before)
    for plane in mirrored:
        off = ~np.isclose(before[:, plane], 0.0, atol=1e-9)
        image = np.where(np.arange(3) == plane, -1.0, 1.0)
        before, after = (np.concatenate([p, image * p[off]]) for p in (before, after))
    along = before @ axis
    low, high = along.min(), along.max()
    # Nodes on a border belong to one slice, whatever rounding says of each.
    at = slices * (along - low) / max(high - low, 1e-300) + 1e-6
    number = np.minimum(at.astype(int), slices - 1)
    known = np.bincount(number, minlength=slices) >= FEWEST
    order = np.flatnonzero(known[number])
    order = order[np.argsort(number[order], kind="stable")]
    if not len(order):
        return float("nan"), order
    found = _Slices(number[order])
    arms, turned = found.arms(before[order]), found.arms(after[order])
    fibres = found.carried(arms, turned) @ axis
    start = found.radius(arms, np.broadcast_to(axis, fibres.shape))
    growth = np.full(len(start), -np.inf)
    np.divide(found.radius(turned, fibres), start, out=growth, where=start > 0)
    most = int(np.argmax(growth))
    if not start[most] > 0:
        return float("nan"), order[:0]
    return float(growth[most]) - 1, np.flatnonzero(number[:own] == np.unique(number[order])[most])


class _Slices:
    """Nodes one slice after the other. number (n,): of each one's slice, rising."""

    def __init__(self, number: np.ndarray):
        self._starts = np.flatnonzero(np.diff(number, prepend=-1))
        self._of = np.repeat(np.arange(len(self._starts)), np.diff([*self._starts, len(number)]))

    def _sums(self, values: np.ndarray) -> np.ndarray:
        return np.add.reduceat(values, self._starts, axis=0)

    def arms(self, points: np.ndarray) -> np.ndarray:
        """(n, 3) from the middles of the slices."""
        counts = np.bincount(self._of)[:, None]
        return points - (self._sums(points) / counts)[self._of]

    def carried(self, arms: np.ndarray, turned: np.ndarray) -> np.ndarray:
        """(k, 3, 3) what takes the arms (n, 3) of each slice to those that are turned, by least
        squares; nothing along a direction in which it has no arms."""
        moments = self._sums(arms[:, :, None] * arms[:, None])
        inverse = np.linalg.pinv(moments, rcond=1e-12, hermitian=True)
        return self._sums(turned[:, :, None] * arms[:, None]) @ inverse

    def radius(self, arms: np.ndarray, axes: np.ndarray) -> np.ndarray:
        """(k,) the longest arm of each slice across its axis (k, 3), of any length; an axis without
        a length is that of nodes of one plane, which have nothing along it."""
        length = np.linalg.norm(axes, axis=1, keepdims=True)
        units = np.where(length > 1e-6, axes / np.maximum(length, 1e-6), 0.0)[self._of]
        across = arms - (arms * units).sum(axis=1)[:, None] * units
        return np.maximum.reduceat(np.linalg.norm(across, axis=1), self._starts)


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    owned = snapshot.model.nodes.owned
    mine = snapshot.positions[:owned], snapshot.displacement[:owned]
    parts = zip(*snapshot.model.comm.allgather(mine), strict=True)
    before, moved = (np.concatenate(part) for part in parts)
    layout = snapshot.layout
    axis = np.asarray(layout.axis, float) / np.linalg.norm(layout.axis)
    mirrored = set(layout.symmetry.values())
    decided = snapshot.decided.growth if snapshot.decided else None
    if decided is None or not len(decided):
        growth, nodes = radial_growth(before, before + moved, axis, mirrored)
        snapshot.deciding.growth = nodes
    else:
        before, moved = before[decided], moved[decided]
        growth, _ = radial_growth(before, before + moved, axis, mirrored, slices=1)
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
