"""The wall of round bellows: arcs and straight flanks that wind in and out along x.

The middle of the wall starts at a root, parallel to the axis. Each half of a convolution is the arc
of a root, a flank and the arc of a crest. Both arcs have the same radius and turn by the same
angle, the lean, so that the flank touches both.
"""

from dataclasses import dataclass
from math import asin, atan2, cos, hypot, pi, sin, sqrt
from typing import Any

import numpy as np

from softact.geometry.steps import steps

# The most that an arc turns between two stations: 12 edges of a full circle.
MOST_TURN = pi / 6


@dataclass(frozen=True)
class Wave:
    """Middle of the wall of ``count`` convolutions from root to root; lengths in mm.

    root, crest: its radii about the axis; fold: radius of its arcs, at most a quarter of the pitch.
    """

    count: int
    pitch: float
    root: float
    crest: float
    fold: float

    @property
    def height(self) -> float:
        """From root to crest."""
        return self.crest - self.root

    @property
    def lean(self) -> float:
        """Angle of the flanks to the axis, radians: that of the tangent from the inside of one
        circle to the other's."""
        across, along = self.height - 2 * self.fold, self.pitch / 2
        sine = min(1.0, 2 * self.fold / hypot(across, along))
        return asin(sine) + atan2(across, along)

    @property
    def flank(self) -> float:
        """Length of a flank."""
        across, along = self.height - 2 * self.fold, self.pitch / 2
        return sqrt(max(0.0, across**2 + along**2 - 4 * self.fold**2))

    @property
    def half(self) -> float:
        """Length of the wall of half a convolution."""
        return 2 * self.fold * self.lean + self.flank

    @property
    def length(self) -> float:
        """Length of the whole wall."""
        return 2 * self.count * self.half

    def wall_volume(self, wall: float) -> float:
        """Volume of a wall of some thickness, mm³: what roots lack, crests have (Pappus)."""
        return pi * (self.root + self.crest) * wall * self.length

    def air_volume(self, wall: float) -> float:
        """Volume inside a wall of some thickness, mm³, between the two ends."""
        mean, a, lean = (self.root + self.crest) / 2, self.height / 2 - self.fold, self.lean
        arc = self.fold * (
            a**2 * sin(lean)
            + 2 * a * self.fold * (lean / 2 + sin(2 * lean) / 4)
            + self.fold**2 * (sin(lean) - sin(lean) ** 3 / 3)
        )
        slope = sin(lean) ** 2 * cos(lean) * (self.flank / 2) ** 3 / 3
        middle = pi * (mean**2 * self.pitch / 2 + 2 * (arc + slope))
        # Radii and directions of the wall's inner half, to the second order in its thickness.
        turned = self.pitch / 2 + 2 * a * lean + 2 * self.fold * sin(lean)
        inner = pi * mean * self.half * wall - pi / 4 * turned * wall**2
        return 2 * self.count * (middle - inner)

    def turn(self, size: float, wall: float, least: int = 1) -> float:
        """Angle, radians, between two stations in an arc, see ``stations``."""
        return self.lean / self._steps(size, wall, least)[0]

    def _steps(self, size: float, wall: float, least: int) -> tuple[int, int]:
        """Number of steps in an arc, and in a flank."""
        longest = self.lean * (self.fold + wall / 2)
        arc = steps(longest, size, max(least, steps(self.lean, MOST_TURN)))
        return arc, steps(self.flank, size, least) if self.flank > 0 else 0

    def pieces(self, size: float, wall: float, least: int = 1) -> int:
        """Number of steps between ``stations``, before there are any."""
        arc, flank = self._steps(size, wall, least)
        return 2 * self.count * (2 * arc + flank)

    def stations(self, size: float, wall: float, least: int = 1) -> np.ndarray:
        """Where the wall is cut, along it from 0 to ``length``: at most ``size`` apart on both of
        its sides, with at least ``least`` steps in each arc and flank."""
        arc, flank = self.fold * self.lean, self.flank
        turns, straight = self._steps(size, wall, least)
        half = np.concatenate(
            [
                np.linspace(0.0, arc, turns + 1)[:-1],
                np.linspace(arc, arc + flank, straight + 1)[:-1],
                np.linspace(arc + flank, self.half, turns + 1)[:-1],
            ]
        )
        starts = self.half * np.arange(2 * self.count)
        return np.append((starts[:, None] + half).ravel(), self.length)

    def place(self, along: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of places along the wall: x, radius (mm), and the angle of the wall to the axis."""
        turns, rest = np.divmod(along, 2 * self.half)
        falls = rest > self.half
        rest = np.where(falls, 2 * self.half - rest, rest)  # a crest's other side is its mirror
        beyond = rest > self.half / 2
        rest = np.where(beyond, self.half - rest, rest)  # a crest is a root that is turned over
        angle = np.minimum(rest / self.fold, self.lean)
        straight = rest - self.fold * angle
        x = self.fold * np.sin(angle) + straight * np.cos(angle)
        r = self.fold * (1 - np.cos(angle)) + straight * np.sin(angle)
        x = np.where(beyond, self.pitch / 2 - x, x)
        r = np.where(beyond, self.height - r, r)
        x = np.where(falls, self.pitch - x, x)
        return turns * self.pitch + x, self.root + r, np.where(falls, -angle, angle)

    def slope(self, x: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """Angle to the axis of the wall's surface through a point of the wall."""
        x = np.clip(x, 0.0, self.count * self.pitch)
        rest = np.mod(x, self.pitch)
        falls = rest > self.pitch / 2
        rest = np.where(falls, self.pitch - rest, rest)
        of_root = np.arctan2(rest, self.root + self.fold - radius)
        of_crest = np.arctan2(self.pitch / 2 - rest, radius - self.crest + self.fold)
        angle = np.minimum(self.lean, np.minimum(of_root, of_crest))
        return np.where(falls, -angle, angle)

    def add_outline(self, occ: Any, offset: float, start: float) -> tuple[list[int], int, int]:
        """The curve at a distance outside of the wall's middle in the plane z = 0, from x =
        ``start`` on: OCC tags of its pieces, of its first and of its last point."""
        arc, halves = self.fold * self.lean, range(2 * self.count)
        joints = [k * self.half + at for k in halves for at in (0.0, arc, arc + self.flank)]
        places = zip(*self.place(np.array([*joints, self.length])), strict=True)
        points = [
            occ.addPoint(start + x - offset * sin(angle), r + offset * cos(angle), 0.0)
            for x, r, angle in places
        ]
        radii = self.root + self.fold, self.crest - self.fold
        middles = [
            occ.addPoint(start + k * self.pitch / 2, radii[k % 2], 0.0)
            for k in (*halves, len(halves))
        ]
        curves = []
        for k in halves:
            a, b, c, d = points[3 * k : 3 * k + 4]
            flank = [occ.addLine(b, c)]
            rising, falling = (a, middles[k], b), (c, middles[k + 1], d)
            curves += [occ.addCircleArc(*rising), *flank, occ.addCircleArc(*falling)]
        occ.remove([(0, middle) for middle in middles])
        return curves, points[0], points[-1]
