"""Weight and payload on the way through a spec's steps: how far they alone bend a module."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softact.estimate.weight import loads_of_steps, mass
from softact.mesh.layout import free_components
from softact.modules.driven import Driven
from softact.modules.rod import Linear, Loads, Points, Rod
from softact.spec import Spec

Array = NDArray[np.float64]
PARTS = 8  # of a step
PIECES = 12  # of the linear rod that says how far weight bends
STEPS = 4  # of its load
SWUNG = 3.0  # times weight and payload pull where they swing
CENTRES = 2  # so many of a table's pressures make room for a load


@dataclass(frozen=True)
class Dead:
    """pressures (s, m), MPa, of any segment on the way, and there gravity (s, 3), mm/s², and force
    (s, 3), N, on the tip of an actuator: its mass, tonne, length, mm, axis (3,), which turns and
    shifts symmetry leaves it (6,), and whether a step has inertia."""

    pressures: Array
    gravity: Array
    force: Array
    mass: float
    length: float
    axis: Array
    free: NDArray[np.bool_]
    swings: bool

    @classmethod
    def of(cls, spec: Spec, loads: Driven) -> Dead:
        """Of a spec, whose pressures are ``loads``."""
        layout = spec.geometry.layout()
        before = np.zeros_like(loads.goals[0]), np.zeros(3), np.zeros(3)
        found = []
        for pressures, dead in zip(loads.goals, loads_of_steps(spec), strict=True):
            after = pressures, *dead
            for part in np.arange(PARTS + 1) / PARTS:
                ends = zip(before, after, strict=True)
                here, *weight = ((1 - part) * a + part * b for a, b in ends)
                found += [(segment, *weight) for segment in here]
            before = after
        pressures, gravity, force = (np.array(column) for column in zip(*found, strict=True))
        return cls(
            pressures,
            gravity,
            force,
            mass(spec),
            layout.length,
            np.asarray(layout.axis, dtype=float),
            free_components(layout.symmetry).ravel(),
            any(step.timing(layout) for step in spec.steps),
        )

    @property
    def moments(self) -> Array:
        """About the clamp of the straight actuator (s,), N mm."""
        weight = self.mass * np.linalg.norm(self.gravity, axis=1) / 2
        return np.asarray((weight + np.linalg.norm(self.force, axis=1)) * self.length)

    @property
    def pull(self) -> float:
        """Weight and payload together at most, and more of them where the actuator swings, N."""
        weight = self.mass * np.linalg.norm(self.gravity, axis=1)
        largest = float((weight + np.linalg.norm(self.force, axis=1)).max(initial=0.0))
        return (SWUNG if self.swings else 1.0) * largest

    def near(self, centres: Array) -> list[NDArray[np.int64]]:
        """For each of a table's pressures (c, m), which loads are met near it."""
        span = np.ptp(centres, axis=0)
        gaps = np.linalg.norm((self.pressures[:, None] - centres) / span, axis=2)
        nearest = np.argsort(gaps, axis=1)[:, :CENTRES]
        return [np.flatnonzero((nearest == c).any(axis=1)) for c in range(len(centres))]

    def room(self, centres: Array) -> Array:
        """The largest moment near each of a table's pressures (c,), N mm."""
        moments = self.moments
        return np.array([moments[met].max(initial=0.0) for met in self.near(centres)])

    def sags(self, stiffness: Array, met: NDArray[np.int64]) -> tuple[Array, Array]:
        """The least and the largest change of the strains (6,) of a linear rod of a stiffness
        (6, 6) that some of the loads alone bend."""
        natural = np.concatenate([np.zeros(3), self.axis])
        rod = Rod(Linear(stiffness, natural), PIECES, self.length / PIECES, self.axis, self.free)
        changes = [np.zeros((1, 6))]
        given = np.hstack([self.mass * self.gravity[met], self.force[met]])
        # Loads ramp from state to state: what bends most is among the ends of these ways.
        ends = np.unique([given.argmin(axis=0), given.argmax(axis=0)]) if len(given) else []
        for weight, force in given[ends].reshape(-1, 2, 3):
            forces = np.tile(weight / PIECES, (PIECES, 1))
            forces[-1] += force
            loads = Loads(Points.ends(PIECES), forces * self.free[3:])
            if np.any(loads.forces):
                bent = rod.strains(rod.equilibrium(rod.straight(), loads, STEPS))
                changes.append(bent - natural)
        found = np.vstack(changes)
        return found.min(axis=0), found.max(axis=0)
