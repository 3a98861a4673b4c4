"""How an actuator is bent, twisted and stretched along its axis, from a run's fields.

The actuator is taken in slices across its undeformed axis. Each slice has a centre, and slopes of
its motion by least squares over its nodes. The polar decomposition of the slopes is its rotation;
as in Kabsch 1976 (Acta Cryst. A32:922), they count by the second moments of the slice. Between two
slices lies a piece of a rod: its curvature and twist are the rotation vector from one slice to the
next over the distance of their undeformed centres (Antman 2005, Nonlinear Problems of Elasticity,
chapter 8), in a frame that is carried along; so they add up to the whole angle.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from softact.results.folder import Results, load, load_name

MOST_SLICES, FEWEST = 24, 4
#: Degrees over the whole length below which nothing is bent or twisted.
STRAIGHT_DEG = 1.0
COLUMNS = {
    "axis_mm": "place on the undeformed axis, from the clamp",
    "curvature_per_m": "about the bending axis, by undeformed length",
    "curvature_across_per_m": "about the axis across that one, by undeformed length",
    "twist_deg_per_m": "about the actuator's axis, by undeformed length",
    "stretch": "of the line through the slices' centres",
}


@dataclass(frozen=True)
class Slices:
    """An undeformed actuator in slices. points (n, 3) mm, of the whole, halves completed; weights
    (n,): their shares of the volume; slice (n,): number of the one that each belongs to; mirrors:
    indices of the coordinates that were mirrored, in that order."""

    points: np.ndarray
    weights: np.ndarray
    slice: np.ndarray
    mirrors: tuple[int, ...]
    axis: np.ndarray
    origin: np.ndarray

    @cached_property
    def places(self) -> np.ndarray:
        """(slices − 1,) mm along the axis, in the middle of two neighbours."""
        at = (self._centres(self.points) - self.origin) @ self.axis
        return (at[1:] + at[:-1]) / 2

    def _sums(self, values: np.ndarray) -> np.ndarray:
        """Weighted sums (slices, ...) of values (n, ...) over each slice."""
        return (self._adding @ values.reshape(len(values), -1)).reshape(-1, *values.shape[1:])

    @cached_property
    def _adding(self) -> csr_array:
        """Matrix (slices, n) that adds up weighted values."""
        return csr_array((self.weights, (self.slice, np.arange(len(self.slice)))))

    def _centres(self, points: np.ndarray) -> np.ndarray:
        return self._sums(points) / self._sums(np.ones((len(points), 1)))

    def _arms(self, points: np.ndarray) -> np.ndarray:
        return points - self._centres(points)[self.slice]

    @cached_property
    def _squares(self) -> tuple[np.ndarray, np.ndarray]:
        """Second moments (slices, 3, 3) of the slices' points: as inverse, and without those of the
        axis with what is across it. With these as weights, a slice that is stretched alike
        everywhere is not turned, however its points lie."""
        arms = self._arms(self.points)
        moments = self._sums(arms[:, :, None] * arms[:, None])
        along = np.outer(self.axis, self.axis)
        across = np.eye(3) - along
        return np.linalg.pinv(moments, rcond=1e-9, hermitian=True), (
            along @ moments @ along + across @ moments @ across
        )

    def _slopes(self, values: np.ndarray) -> np.ndarray:
        """Slopes (slices, 3, 3) of a field (n, 3) in each slice, by least squares, times the
        weights of ``_squares``."""
        inverse, weights = self._squares
        mixed = self._sums(self._arms(values)[:, :, None] * self._arms(self.points)[:, None])
        return mixed @ inverse @ weights

    @cached_property
    def _levers(self) -> np.ndarray:
        """(slices − 1, 3, 3) mm: what a small uniform strain (twist and two curvatures) turns a
        slice beside the one before. Where walls are thicker on one side of a slice than on the
        other, it turns as if it stood there, and not in its middle."""
        at = (self.points - self.origin) @ self.axis
        across = self.points - self.origin - at[:, None] * self.axis
        _, weights = self._squares
        inertia = np.trace(weights, axis1=1, axis2=2)[:, None, None] * np.eye(3) - weights
        turned = [_axial(self._slopes(_bent(unit, self.axis, at, across))) for unit in np.eye(3)]
        stations = np.linalg.pinv(inertia, hermitian=True) @ np.stack(turned, axis=-1)
        return np.diff(stations, axis=0)

    def rod(self, displacement: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rotation vectors (slices − 1, 3) rad/mm and stretches (slices − 1,) between neighbours.

        displacement: (m, 3) mm of the nodes of the meshed part.
        """
        moved = self.points + _mirrored(displacement, self.mirrors)
        turned = self._turned(moved)
        between = np.swapaxes(turned[:-1], 1, 2) @ turned[1:]
        vectors = Rotation.from_matrix(between).as_rotvec()
        chords, straight = (
            np.linalg.norm(np.diff(self._centres(points), axis=0), axis=1)
            for points in (moved, self.points)
        )
        half = np.linalg.norm(vectors, axis=1) / 2  # of an arc, whose chord is shorter
        strains = (np.linalg.pinv(self._levers) @ vectors[:, :, None])[:, :, 0]
        return strains, chords / np.sinc(half / np.pi) / straight

    def _turned(self, moved: np.ndarray) -> np.ndarray:
        """Rotations (slices, 3, 3) of the slices."""
        u, _, vt = np.linalg.svd(self._slopes(moved))
        flip = np.ones(u.shape[:2])
        flip[:, 2] = np.sign(np.linalg.det(u) * np.linalg.det(vt))
        return u @ (flip[:, :, None] * vt)


def _axial(slopes: np.ndarray) -> np.ndarray:
    """Axial vectors (k, 3) of the skew parts, times two."""
    pairs = ((2, 1), (0, 2), (1, 0))
    return np.stack([slopes[:, i, j] - slopes[:, j, i] for i, j in pairs], axis=-1)


def _bent(unit: np.ndarray, axis: np.ndarray, at: np.ndarray, across: np.ndarray) -> np.ndarray:
    """Displacements (n, 3) of a rod with a small strain of one about ``unit``, at places (n,) along
    the axis and (n, 3) across it."""
    sway = at[:, None] ** 2 / 2 * np.cross(unit, axis)
    return sway + at[:, None] * np.cross(unit, across)


def _mirrored(values: np.ndarray, mirrors: tuple[int, ...]) -> np.ndarray:
    for index in mirrors:
        sign = np.where(np.arange(3) == index, -1.0, 1.0)
        values = np.vstack([values, sign * values])
    return values


def slices(results: Results) -> Slices | None:
    """The slices of a run's mesh: as many as its elements along the axis allow, up to 24; None
    where it has no axis, or too few elements along it."""
    layout = results.layout
    if not (results.has_mesh and layout.tip and layout.length > 0):
        return None
    axis, origin = np.asarray(layout.axis, float), np.asarray(layout.origin, float)
    along = (results.points - origin) @ axis
    extent = np.ptp(along[results.cells], axis=1).mean()
    count = min(MOST_SLICES, int(layout.length / extent))
    number = np.clip((along / layout.length * count).astype(int), 0, count - 1)
    shares = _shares(results)
    if count < FEWEST or len(np.unique(number[shares > 0])) < count:
        return None
    mirrors, copies = tuple(layout.symmetry.values()), layout.copies
    points, each = _mirrored(results.points, mirrors), np.tile(number, copies)
    return Slices(points, np.tile(shares, copies), each, mirrors, axis, origin)


def _shares(results: Results) -> np.ndarray:
    """Share (n,) that each node has of the volume, or of the area of sheets; 0 of no cell."""
    cells = results.cells
    count = 4 if cells.shape[1] in (4, 10) else 3
    corners = results.points[cells[:, :count]]
    edges = corners[:, 1:] - corners[:, :1]
    if edges.shape[1] == 3:
        sizes = np.abs(np.linalg.det(edges)) / 6
    else:
        sizes = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
    each = np.repeat(sizes / cells.shape[1], cells.shape[1])
    return np.bincount(cells.ravel(), each, minlength=len(results.points))


@dataclass(frozen=True)
class Along:
    """Of every state. places (k,) mm on the undeformed axis; curvature, across (rad/mm), twist
    (rad/mm) and stretch: (states, k)."""

    places: np.ndarray
    curvature: np.ndarray
    across: np.ndarray
    twist: np.ndarray
    stretch: np.ndarray

    @property
    def turns_deg(self) -> tuple[float, float]:
        """Largest angles over the whole length by bending and by twisting, sizes added."""
        length = float(np.ptp(self.places))
        bent = np.hypot(self.curvature, self.across).mean(axis=1).max(initial=0.0)
        twisted = np.abs(self.twist).mean(axis=1).max(initial=0.0)
        return float(np.degrees(bent * length)), float(np.degrees(twisted * length))

    def columns(self, row: int) -> dict[str, np.ndarray]:
        """``COLUMNS`` of a state."""
        return {
            "axis_mm": self.places,
            "curvature_per_m": 1e3 * self.curvature[row],
            "curvature_across_per_m": 1e3 * self.across[row],
            "twist_deg_per_m": np.degrees(1e3 * self.twist[row]),
            "stretch": self.stretch[row],
        }


def along(results: Results) -> Along | None:
    """What the states of a run are like along the axis; None where ``slices`` is.

    Curvature is about the layout's bending axis or, where it has none, about the direction across
    the axis in which the last state is bent most. Raises DamagedResultError.
    """
    cut = slices(results)
    if cut is None or not results.increments:
        return None
    found = [cut.rod(results.field(n, "displacement")) for n in range(len(results.increments))]
    vectors, stretch = (np.array(part) for part in zip(*found, strict=True))
    bending = _bending_axis(results, cut.axis, vectors[-1])
    across = np.cross(cut.axis, bending)
    return Along(cut.places, vectors @ bending, vectors @ across, vectors @ cut.axis, stretch)


def _bending_axis(results: Results, axis: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    if results.layout.bending_axis is not None:
        return np.asarray(results.layout.bending_axis, float)
    flat = vectors - np.outer(vectors @ axis, axis)
    found = np.linalg.svd(flat)[2][0]
    if np.linalg.norm(flat) == 0:
        found = np.roll(axis, 1)
    found = found - (found @ axis) * axis
    return found / np.linalg.norm(found) * (1.0 if flat.sum(axis=0) @ found >= 0 else -1.0)


def rows(results: Results, found: Along) -> list[Mapping[str, float]]:
    """A row for each state and place: the state's number, its load where it has a pressure, and
    ``COLUMNS``."""
    name, loads = load_name(results), load(results)
    table: list[Mapping[str, float]] = []
    for number in range(len(found.curvature)):
        head = {"state": number} | ({name: float(loads[number])} if name else {})
        columns = found.columns(number)
        for place in range(len(found.places)):
            table.append(head | {key: float(values[place]) for key, values in columns.items()})
    return table
