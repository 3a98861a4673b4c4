"""A rod with inertia in real time: increments of the generalised-alpha method on rigid motions.

Each frame carries the mass about it as a rigid body and moves by screws in its own axes, so that
turns of any size need no parameters (Brüls, Cardona and Arnold, Mech. Mach. Theory 48, 2012). With
v the velocity of a frame, M its inertia, r its out-of-balance wrench: M v̇ = ad(v)ᵀ M v − r.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softact.loads.dynamics import Dynamics
from softact.modules.rod import Frames, Loads, Rod
from softact.modules.screws import adjoints
from softact.system.rotation import cross_with

Array = NDArray[np.float64]
STILL = 1e-5  # rad, or of a piece's length: an iteration below it is the last
MOST = 12  # iterations
SLOW = 0.1  # of the last change: after one that is larger all want the stiffness anew


@dataclass(frozen=True)
class Motion:
    """Frames and, in their own axes, velocities and accelerations (n + 1, 6), rad/s and mm/s and by
    time again; held (n + 1, 6): the method's own acceleration, which lags behind."""

    frames: Frames
    velocity: Array
    acceleration: Array
    held: Array

    @classmethod
    def at_rest(cls, frames: Frames) -> Motion:
        """Nothing moves."""
        nothing = np.zeros((len(frames.places), 6))
        return cls(frames, nothing, nothing, nothing)


def inertias(at: NDArray[np.int64], masses: Array, arms: Array, spreads: Array, n: int) -> Array:
    """Of n frames in their axes (n, 6, 6), from lumps on frames ``at``: masses (s,), tonne, arms
    (s, 3), mm, second moments (s, 3, 3) about the lumps' middles, tonne mm²."""
    found = np.zeros((len(at), 6, 6))
    levers = cross_with(arms)
    trace = np.trace(spreads, axis1=1, axis2=2)
    found[:, :3, :3] = trace[:, None, None] * np.eye(3) - spreads
    found[:, :3, :3] -= masses[:, None, None] * (levers @ levers)
    found[:, :3, 3:] = masses[:, None, None] * levers
    found[:, 3:, :3] = -masses[:, None, None] * levers
    found[:, 3:, 3:] = masses[:, None, None] * np.eye(3)
    out = np.zeros((n, 6, 6))
    np.add.at(out, at, found)
    return out


class RodMotion:
    """A rod's increments in time. inertia: (n + 1, 6, 6), of its frames."""

    def __init__(self, rod: Rod, inertia: Array, dynamics: Dynamics):
        self.rod, self.inertia, self.dynamics = rod, inertia, dynamics
        self._free = np.flatnonzero(rod.free)

    def start(self, motion: Motion, loads: Loads) -> Motion:
        """With the accelerations that the loads give at once."""
        wrench = self._turning(motion.velocity) - self.rod.unbalanced(motion.frames, loads)
        found = np.zeros_like(wrench)
        free = self._free
        for number in range(1, len(found)):
            inertia = self.inertia[number][np.ix_(free, free)]
            found[number, free] = np.linalg.lstsq(inertia, wrench[number, free], rcond=1e-12)[0]
        return Motion(motion.frames, motion.velocity, found, found)

    def after(self, motion: Motion, loads: Loads, time: float) -> Motion:
        """The motion a time later, s, with the loads there. Raises ArithmeticError."""
        try:
            return self._increment(motion, loads, time, often=False)
        except ArithmeticError:
            return self._increment(motion, loads, time, often=True)

    def _increment(self, motion: Motion, loads: Loads, time: float, often: bool) -> Motion:
        """often: with a stiffness of its own at each iteration."""
        d, free = self.dynamics, self.rod.free
        beta, gamma = d.beta, d.gamma
        held = (d.alpha_f * motion.acceleration - d.alpha_m * motion.held) / (1 - d.alpha_m)
        velocity = motion.velocity + time * ((1 - gamma) * motion.held + gamma * held)
        move = time * motion.velocity + time**2 * ((0.5 - beta) * motion.held + beta * held)
        by_place = (1 - d.alpha_m) / (beta * time**2 * (1 - d.alpha_f))
        by_velocity = gamma / (beta * time)
        # As before is the best guess.
        acceleration = motion.acceleration.copy()
        move = move + acceleration / by_place
        velocity = velocity + by_velocity * acceleration / by_place
        for array in (velocity, move):
            array[0], array[:, ~free] = 0.0, 0.0
        frames = motion.frames.moved(move)
        stiffness: tuple[Array, Array] | None = None
        size, last, slow = np.inf, np.inf, often
        for _ in range(MOST):
            # One stiffness does for an increment, as long as it goes on well.
            slow = slow or size > SLOW * last
            if stiffness is None or slow:
                unbalanced, diagonal, beside = self.rod.balance(frames, loads)
                stiffness = diagonal + by_place * self.inertia, beside
            else:
                unbalanced = self.rod.unbalanced(frames, loads)
            residual = np.einsum("nij,nj->ni", self.inertia, acceleration) + unbalanced
            residual -= self._turning(velocity)
            assert stiffness is not None
            change = self.rod.downhill(residual, *stiffness)
            move = move + change
            velocity = velocity + by_velocity * change
            acceleration = acceleration + by_place * change
            # The increment is one screw from its start: what small changes add up to.
            frames = motion.frames.moved(move)
            last, size = size, float(np.abs(change / self.rod.scale).max())
            if not np.isfinite(size) or (size > last and not often):
                break
            if size < STILL:
                later = held + (1 - d.alpha_f) / (1 - d.alpha_m) * acceleration
                return Motion(frames, velocity, acceleration, later)
        raise ArithmeticError("the rod finds no motion in this increment")

    def _turning(self, velocity: Array) -> Array:
        """What the momentum of turning frames does (n + 1, 6)."""
        momentum = np.einsum("nij,nj->ni", self.inertia, velocity)
        return np.asarray(np.einsum("nji,nj->ni", adjoints(velocity), momentum))

    def energy(self, motion: Motion) -> float:
        """Of the motion, mJ."""
        v = motion.velocity
        return float(np.einsum("ni,nij,nj->", v, self.inertia, v)) / 2


def error_in_time(before: Motion, after: Motion, dynamics: Dynamics, time: float) -> float:
    """Of an increment's places, mm: Δt² (β − 1/6) (a₁ − a₀) (Zienkiewicz and Xie, Earthq. Eng.
    Struct. Dyn. 20 (1991) 871)."""
    change = (after.held - before.held)[:, 3:]
    return float(abs(dynamics.beta - 1 / 6) * time**2 * np.linalg.norm(change, axis=1).max())
