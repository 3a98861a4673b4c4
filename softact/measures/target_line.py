"""How far a line of the actuator is from the points that it is to pass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.errors import SpecError
from softact.measures.base import Measure

if TYPE_CHECKING:
    from softact.measures.points import Probe
    from softact.measures.snapshot import Snapshot
    from softact.model import Model

#: Points of the line, evenly from end to end: straight between them it is some 0.01 mm beside an
#: arc of a radius of 10 mm, on a finger of 100 mm.
POINTS = 101


@dataclass(frozen=True)
class Followed:
    """A line of the actuator, and what it is to pass: points (n, 3), mm."""

    probes: Sequence[Probe]
    target: np.ndarray

    def line(self, snapshot: Snapshot) -> np.ndarray:
        """Where the line is (k, 3), mm. Collective."""
        model, places = snapshot.model, snapshot.positions + snapshot.displacement
        return np.array([p.mirror * model.sum(p.weights @ places[p.nodes]) for p in self.probes])

    def distances(self, snapshot: Snapshot) -> np.ndarray:
        """Of each point (n,) to the line, mm. Collective."""
        line = self.line(snapshot)
        return distances(self.target, line[:-1], line[1:])


def distances(points: np.ndarray, starts: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Of points (n, 3) to the nearest of the straight pieces from (k, 3) to (k, 3): (n,)."""
    along = ends - starts
    square = np.maximum((along**2).sum(axis=1), 1e-300)
    there = points[:, None] - starts
    part = np.clip(np.einsum("nki,ki->nk", there, along) / square, 0.0, 1.0)
    gaps = np.linalg.norm(there - part[..., None] * along, axis=2)
    nearest: np.ndarray = gaps.min(axis=1)
    return nearest


def followed(model: Model, through: Sequence[float], target: np.ndarray) -> Followed:
    """The line through a point (3,) of the undeformed actuator, along all of it. Collective.

    Raises SpecError where it is outside.
    """
    from softact.measures.points import locate

    layout = model.mesh.layout
    axis, point = np.asarray(layout.axis), np.asarray(through, dtype=float)
    start = point - (point @ axis) * axis
    places = [start + part * layout.length * axis for part in np.linspace(0.0, 1.0, POINTS)]
    names = {str(number): (x, y, z) for number, (x, y, z) in enumerate(places)}
    try:
        return Followed(list(locate(model, names).values()), target)
    except SpecError as error:
        _, _, why = error.lines[0].partition(": ")
        raise SpecError(f"target_line.through: the line leaves the body: {why}") from None


def _power_mean(values: np.ndarray, power: int) -> float:
    largest = float(values.max())
    if largest == 0.0:
        return 0.0
    return largest * float(((values / largest) ** power).mean() ** (1.0 / power))


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    if snapshot.followed is None:
        return {}
    found = snapshot.followed.distances(snapshot)
    return {
        "target_distance_rms_mm": float(np.sqrt((found**2).mean())),
        "target_distance_p8_mm": _power_mean(found, 8),
        "target_distance_max_mm": float(found.max()),
    }


TARGET_LINE = Measure(
    "target_line",
    "how far the line that target_line of the spec names is from the points of its file",
    {
        "target_distance_rms_mm": "root of the mean square of the points' distances to the line",
        "target_distance_p8_mm": "eighth root of the mean of their eighth powers: near the largest "
        "where that jumps from point to point, and smooth",
        "target_distance_max_mm": "largest of these distances",
    },
    _evaluate,
)
