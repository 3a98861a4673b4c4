"""A rod in space of equal pieces, each bent and stretched alike all along, under dead loads and
against obstacles, with friction or without.

Between the pieces stand frames, the first of them clamped. A piece's strains are the screw from
one frame to the next by its length: exact for any turn, and without locking, as a piece that is
bent and stretched evenly is one of its own shapes (Sonneville, Cardona and Brüls, CMAME 268, 2014).
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

from softact.modules.grip import Grip
from softact.modules.screws import Between, exponential, logarithm
from softact.system.rotation import cross_with

Array = NDArray[np.float64]
STIFFNESSES = (1.0, 10.0, 100.0, 1000.0)  # N/mm, of an obstacle: the last one counts
STILL = 1e-10  # rad, or of a piece's length: a Newton step below it is none
LARGEST = 0.2  # rad of a piece, or of its length, in one iteration
MOST = 80  # iterations
GRIPS = 40  # rounds of friction with the pressing forces of the last one
SETTLED = 1e-4  # of the largest pressing force, or N: its change in the last round
#: Signed distances (m,) of places (m, 3), their gradients (m, 3), second derivatives (m, 3, 3).
Distance = Callable[[Array], tuple[Array, Array, Array]]


class Law(Protocol):
    """Energy of a rod by its length, mJ/mm, over its strains: curvatures about x, y, z in 1/mm and
    stretches along them."""

    def energy(self, strains: Array) -> Array:
        """Of each of n pieces, from (n, 6), (n,)."""

    def conjugates(self, strains: Array) -> Array:
        """Moment and force (n, 6)."""

    def derivatives(self, strains: Array) -> tuple[Array, Array]:
        """The same, and their derivatives (n, 6, 6)."""


@dataclass(frozen=True)
class Linear:
    """An elastic rod: stiffness (6, 6), N mm², N mm and N; unstrained at natural strains (6,)."""

    stiffness: Array
    natural: Array

    def energy(self, strains: Array) -> Array:
        """As in Law."""
        strained = strains - self.natural
        return np.asarray(np.einsum("ni,ij,nj->n", strained, self.stiffness, strained) / 2)

    def conjugates(self, strains: Array) -> Array:
        """As in Law."""
        return np.asarray((strains - self.natural) @ self.stiffness)

    def derivatives(self, strains: Array) -> tuple[Array, Array]:
        """As in Law."""
        return self.conjugates(strains), np.broadcast_to(self.stiffness, (len(strains), 6, 6))


@dataclass(frozen=True)
class Frames:
    """How a rod stands: turns (n + 1, 3, 3), places (n + 1, 3) mm, from the clamp to the tip."""

    turns: Array
    places: Array

    def moved(self, screws: Array) -> Frames:
        """Each frame moved by a screw (n + 1, 6) in its own axes."""
        turns, shifts = exponential(screws)
        return Frames(self.turns @ turns, self.places + np.einsum("nij,nj->ni", self.turns, shifts))


@dataclass(frozen=True)
class Points:
    """Points (m,) that frames carry along: of which frame (0: the clamp), and where, beside it in
    its axes, (m, 3) mm."""

    at: NDArray[np.int64]
    arms: Array

    @classmethod
    def ends(cls, pieces: int, arm: Sequence[float] = (0.0, 0.0, 0.0)) -> Points:
        """One at the end of each piece."""
        return cls(np.arange(1, pieces + 1), np.tile(np.asarray(arm, float), (pieces, 1)))

    @classmethod
    def joined(cls, *parts: Points) -> Points:
        """All of several."""
        return cls(np.concatenate([p.at for p in parts]), np.concatenate([p.arms for p in parts]))

    @classmethod
    def none(cls) -> Points:
        """No points."""
        return cls(np.empty(0, int), np.empty((0, 3)))

    def places(self, frames: Frames) -> Array:
        """Where they are, (m, 3)."""
        turned = np.einsum("nij,nj->ni", frames.turns[self.at], self.arms)
        return np.asarray(frames.places[self.at] + turned)


@dataclass(frozen=True)
class Loads:
    """Dead forces (m, 3), N, on points; obstacles, which other points may not enter; grips: how
    they hold these by friction, one for each obstacle or none at all."""

    points: Points
    forces: Array
    touching: Points = field(default_factory=Points.none)
    obstacles: Sequence[Distance] = ()
    grips: Sequence[Grip] = ()

    def part(self, part: float) -> Loads:
        """The same, of the forces a part."""
        return replace(self, forces=part * self.forces)


@dataclass(frozen=True)
class Rod:
    """Pieces of a length, mm, or of lengths (pieces,), along an axis (3,) at first. free: (6,)
    which turns and shifts of a frame there are: a plane of symmetry leaves one and two."""

    law: Law
    pieces: int
    length: float | Array
    axis: Array
    free: NDArray[np.bool_]

    @functools.cached_property
    def lengths(self) -> Array:
        """Of the pieces (pieces, 1), mm."""
        return np.broadcast_to(self.length, self.pieces)[:, None]

    def straight(self) -> Frames:
        """Unstretched along the axis."""
        along = np.concatenate([[0.0], np.cumsum(self.lengths)])
        return Frames(np.tile(np.eye(3), (self.pieces + 1, 1, 1)), np.outer(along, self.axis))

    def alike(self, strains: Array) -> Frames:
        """All pieces at the same strains (6,)."""
        return self.chained(np.tile(strains, (self.pieces, 1)))

    def chained(self, strains: Array) -> Frames:
        """Pieces at strains (n, 6)."""
        turns, shifts = exponential(self.lengths * strains)
        frames = [(np.eye(3), np.zeros(3))]
        for turn, shift in zip(turns, shifts, strict=True):
            before, place = frames[-1]
            frames.append((before @ turn, place + before @ shift))
        return Frames(np.array([f[0] for f in frames]), np.array([f[1] for f in frames]))

    def strains(self, frames: Frames) -> Array:
        """Of the pieces, (n, 6)."""
        back = np.swapaxes(frames.turns[:-1], 1, 2)
        steps = np.einsum("nij,nj->ni", back, np.diff(frames.places, axis=0))
        return logarithm(back @ frames.turns[1:], steps) / self.lengths

    # --- energy, force, stiffness ---------------------------------------------------------------

    def energy(self, frames: Frames, loads: Loads, stiffness: float) -> float:
        """Potential energy, mJ: of the rod, of the forces, and of what enters obstacles."""
        stored = self.lengths[:, 0] @ self.law.energy(self.strains(frames))
        done = (loads.forces * loads.points.places(frames)).sum()
        for distance in loads.obstacles:
            gaps = distance(loads.touching.places(frames))[0]
            stored += stiffness / 2 * (np.minimum(gaps, 0) ** 2).sum()
        for grip in loads.grips:
            stored += grip.energy(loads.touching.places(frames))
        return float(stored - done)

    def balance(
        self, frames: Frames, loads: Loads, stiffness: float = STIFFNESSES[-1]
    ) -> tuple[Array, Array, Array]:
        """Out-of-balance wrench (n + 1, 6) of each frame in its axes, and its symmetric derivative:
        blocks on the diagonal (n + 1, 6, 6), and (n, 6, 6) between a frame and the next.

        Away from equilibrium the derivative is the second one of the energy along exp η.
        """
        residual, diagonal, beside = self.inner(frames)
        _push(residual, diagonal, frames, loads.points, -loads.forces)
        for distance in loads.obstacles:
            points = loads.touching
            gaps, normals, second = distance(points.places(frames))
            pressed = stiffness * np.maximum(-gaps, 0)
            inside = (gaps < 0)[:, None, None]
            springs = stiffness * normals[:, :, None] * normals[:, None] * inside
            _push(
                residual,
                diagonal,
                frames,
                points,
                -pressed[:, None] * normals,
                springs - pressed[:, None, None] * second,
            )
        for grip in loads.grips:
            slopes, second = grip.derivatives(loads.touching.places(frames))
            _push(residual, diagonal, frames, loads.touching, slopes, second)
        return residual, diagonal, beside

    def inner(self, frames: Frames) -> tuple[Array, Array, Array]:
        """``balance`` of the rod alone."""
        strains = self.strains(frames)
        screws = self.lengths * strains
        wrench, stiffness = self.law.derivatives(strains)
        between = Between(screws)
        one, two = between.at_start, between.at_end
        one_back, two_back = np.swapaxes(one, 1, 2), np.swapaxes(two, 1, 2)
        residual = np.zeros((self.pieces + 1, 6))
        residual[:-1] += np.einsum("nij,nj->ni", one_back, wrench)
        residual[1:] += np.einsum("nij,nj->ni", two_back, wrench)
        by_one, by_two = between.second(wrench)
        stiff = stiffness / self.lengths[:, None]
        diagonal = np.zeros((self.pieces + 1, 6, 6))
        diagonal[:-1] += _symmetric((one_back @ stiff + by_one) @ one)
        diagonal[1:] += _symmetric((two_back @ stiff + by_two) @ two)
        across = (one_back @ stiff + by_one) @ two
        back = (two_back @ stiff + by_two) @ one
        beside = (across + np.swapaxes(back, 1, 2)) / 2
        return residual, diagonal, beside

    def unbalanced(self, frames: Frames, loads: Loads) -> Array:
        """The out-of-balance wrench of ``balance`` alone."""
        strains = self.strains(frames)
        wrench, between = self.law.conjugates(strains), Between(self.lengths * strains)
        residual = np.zeros((self.pieces + 1, 6))
        residual[:-1] += np.einsum("nji,nj->ni", between.at_start, wrench)
        residual[1:] += np.einsum("nji,nj->ni", between.at_end, wrench)
        _pull(residual, frames, loads.points, -loads.forces)
        places = loads.touching.places(frames)
        for distance in loads.obstacles:
            gaps, normals, _ = distance(places)
            pressed = STIFFNESSES[-1] * np.maximum(-gaps, 0)
            _pull(residual, frames, loads.touching, -pressed[:, None] * normals)
        for grip in loads.grips:
            _pull(residual, frames, loads.touching, grip.derivatives(places)[0])
        return residual

    def pressed(self, frames: Frames, loads: Loads) -> list[Array]:
        """Forces (m, 3) of each obstacle on the touching points, N, friction among them."""
        places = loads.touching.places(frames)
        found = []
        for number, distance in enumerate(loads.obstacles):
            gaps, normals, _ = distance(places)
            found.append(STIFFNESSES[-1] * np.maximum(-gaps, 0)[:, None] * normals)
            if loads.grips:
                found[-1] = found[-1] - loads.grips[number].derivatives(places)[0]
        return found

    def held(self, frames: Frames, loads: Loads) -> Loads:
        """The loads with grips that press as the obstacles do here."""
        places, grips = loads.touching.places(frames), []
        for distance, grip in zip(loads.obstacles, loads.grips, strict=True):
            gaps, normals, _ = distance(places)
            grips.append(grip.pressed(normals, STIFFNESSES[-1] * np.maximum(-gaps, 0)))
        return replace(loads, grips=grips)

    def followed(self, frames: Frames, loads: Loads) -> list[Grip]:
        """The grips after an equilibrium."""
        places = loads.touching.places(frames)
        pairs = zip(loads.obstacles, loads.grips, strict=True)
        return [grip.followed(places, distance(places)[0] < 0) for distance, grip in pairs]

    # --- equilibrium ----------------------------------------------------------------------------

    def equilibrium(self, start: Frames, loads: Loads, steps: int = 10) -> Frames:
        """From frames without load, in steps of the load. Raises ArithmeticError where there is no
        equilibrium."""
        for part in np.linspace(0, 1, steps + 1)[1:]:
            start = self.settle(start, loads.part(part))
        return start

    def settle(self, frames: Frames, loads: Loads) -> Frames:
        """The least energy near frames, and with friction one that holds itself. Raises
        ArithmeticError where there is none."""
        for stiffness in STIFFNESSES if loads.obstacles else STIFFNESSES[-1:]:
            frames = self._newton(frames, loads, stiffness)
        if not loads.grips:
            return frames
        for _ in range(GRIPS):
            before = np.concatenate([grip.pressing for grip in loads.grips])
            loads = self.held(frames, loads)
            frames = self._newton(frames, loads, STIFFNESSES[-1])
            after = np.concatenate([grip.pressing for grip in loads.grips])
            if np.abs(after - before).max() <= SETTLED * max(float(after.max()), SETTLED):
                return frames
        raise ArithmeticError("friction and pressing forces do not settle")

    def _newton(self, frames: Frames, loads: Loads, stiffness: float) -> Frames:
        for _ in range(MOST):
            residual, diagonal, beside = self.balance(frames, loads, stiffness)
            change = self.downhill(residual, diagonal, beside)
            # The strains take the step, not the frames: a piece that turns carries all beyond it
            # along, so that what hardly stretches is not stretched on the way.
            screws = self.lengths * self.strains(frames)
            step = _change(screws, change)
            size = float(np.abs(step / self.scale[1:]).max())
            if not np.isfinite(size):
                break
            if size < STILL:
                return self.chained((screws + step) / self.lengths)
            part = min(1.0, LARGEST / size)
            slope = part * float((residual * change).sum())
            frames = self._lower(frames, (screws, part * step), slope, loads, stiffness)
        raise ArithmeticError("the rod finds no equilibrium under these loads")

    def _lower(
        self,
        frames: Frames,
        way: tuple[Array, Array],
        slope: float,
        loads: Loads,
        stiffness: float,
    ) -> Frames:
        """The longest part of a way (screws and their change) that lowers the energy as its slope
        promises."""
        before = self.energy(frames, loads, stiffness)
        rounding = 1e-12 * abs(before) + 1e-15
        screws, step = way
        for part in 0.5 ** np.arange(16):
            moved = self.chained((screws + part * step) / self.lengths)
            if self.energy(moved, loads, stiffness) <= before + 1e-4 * part * slope + rounding:
                return moved
        return self.chained((screws + step) / self.lengths)

    @functools.cached_property
    def scale(self) -> Array:
        """What moves of frames (n + 1, 6) count by: 1 rad, and the length of the piece before."""
        before = np.vstack([self.lengths[:1], self.lengths])
        return np.hstack([np.ones_like(before)] * 3 + [before] * 3)

    def downhill(self, residual: Array, diagonal: Array, beside: Array) -> Array:
        """Newton's step (n + 1, 6), or where the stiffness is indefinite one of a stiffer rod; the
        first frame stays."""
        free = np.flatnonzero(self.free)
        k, n = len(free), self.pieces
        pick = np.ix_(np.arange(n), free, free)
        middle, next_ones = diagonal[1:][pick], beside[1:][np.ix_(np.arange(n - 1), free, free)]
        band = np.zeros((2 * k, n * k))
        for i in range(k):
            for j in range(i + 1):
                band[i - j, j::k] = middle[:, i, j]
            for j in range(k):
                # Row i of the next frame, column j of this one.
                band[k + i - j, j : (n - 1) * k : k] = next_ones[:, j, i]
        right = -residual[1:][:, free].ravel()
        out = np.zeros_like(residual)
        shift, largest = 0.0, np.abs(band[0]).max()
        while True:
            try:
                factors = cholesky_banded(np.vstack([band[:1] + shift, band[1:]]), lower=True)
                break
            except np.linalg.LinAlgError:
                shift = max(1e-6 * largest, 4 * shift)
                if not shift < 1e3 * largest:
                    raise ArithmeticError("the rod's stiffness is not a number") from None
        out[1:, free] = cho_solve_banded((factors, True), right).reshape(n, k)
        return out


def _change(screws: Array, moves: Array) -> Array:
    """Of the screws (n, 6) between frames that move by screws (n + 1, 6) in their own axes."""
    between = Between(screws)
    return np.asarray(
        np.einsum("nij,nj->ni", between.at_start, moves[:-1])
        + np.einsum("nij,nj->ni", between.at_end, moves[1:])
    )


def _symmetric(matrices: Array) -> Array:
    return (matrices + np.swapaxes(matrices, -1, -2)) / 2


def _push(
    residual: Array,
    diagonal: Array,
    frames: Frames,
    points: Points,
    slopes: Array,
    second: Array | None = None,
) -> None:
    """Add what an energy of the points' places gives to frames: slopes (m, 3) are its derivatives
    by the places, second (m, 3, 3) its second ones."""
    local = _pull(residual, frames, points, slopes)
    turns, arms = frames.turns[points.at], cross_with(points.arms)
    blocks = np.zeros((len(points.at), 6, 6))
    # Along exp η a place moves by R (u + θ × s), and to second order by R θ × (u + θ × s) / 2.
    force = cross_with(local)
    blocks[:, :3, :3] = _symmetric(force @ arms)
    blocks[:, :3, 3:] = -force / 2
    blocks[:, 3:, :3] = force / 2
    if second is not None:
        inside = np.swapaxes(turns, 1, 2) @ second @ turns
        lever = np.concatenate([-arms, np.broadcast_to(np.eye(3), arms.shape)], axis=2)
        blocks += np.swapaxes(lever, 1, 2) @ inside @ lever
    np.add.at(diagonal, points.at, blocks)


def _pull(residual: Array, frames: Frames, points: Points, slopes: Array) -> Array:
    """Add the first derivatives alone; returns the slopes in the frames' axes (m, 3)."""
    local = np.einsum("nji,nj->ni", frames.turns[points.at], slopes)
    n = len(residual)
    wrenches = np.concatenate([(cross_with(points.arms) @ local[..., None])[..., 0], local], axis=1)
    residual += np.stack([np.bincount(points.at, w, n) for w in wrenches.T], axis=1)
    return local
