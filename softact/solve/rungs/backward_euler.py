"""Bodies on the move: implicit time steps of backward Euler.

M (c (x − x₀) − v₀/Δt) + f(x) = 0 with c = 1/Δt² + α/Δt: unconditionally stable, and the longer the
time step the more of the motion it damps. Each time step is a solve of Newton's method with the
``TimeStep`` as part of its state.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from softact.model import Model
from softact.solve import acceptance, settling
from softact.solve.newton import NewtonOutcome, SolveOptions
from softact.solve.path import Drive
from softact.solve.walk import Walk
from softact.system.term import State, TimeStep


class BackwardEuler:
    """The time steps of one motion. While one acts, it is part of the walk's state; ``still`` takes
    it out again."""

    def __init__(self, walk: Walk, drive: Drive):
        self.walk, self.drive = walk, drive
        walk.model.add_inertia()

    @property
    def model(self) -> Model:
        """What moves."""
        return self.walk.model

    def move(
        self,
        x: np.ndarray,
        velocity: np.ndarray,
        time_step: float,
        damping: float = 0.0,
        resistance: float = 0.0,
    ) -> None:
        """Let a time step from ``x`` at ``velocity`` (local,) act from here on.

        damping: α, by mass, 1/s. resistance: viscosity of the solids by their shear modulus and the
        time step.
        """
        factor = 1 / time_step**2 + damping / time_step
        away_from = x + velocity / (time_step * factor)
        self.walk.state.motion = TimeStep(factor, away_from, x, resistance)

    def still(self) -> None:
        """Without inertia and resistance from here on."""
        self.walk.state.motion = None

    def solve(
        self,
        x: np.ndarray,
        s: float,
        q: np.ndarray,
        options: SolveOptions | None = None,
        before: State | None = None,
        settled: bool = False,
    ) -> NewtonOutcome:
        """Seek the end of the time step that acts, or an equilibrium where none does, from ``x``
        under the loads of the place ``s``.

        before: where the time step began, with other loads than it has; what is passed through on
        the way from there makes the outcome fail. settled: see ``settling``.
        """
        walk = self.walk
        held, control = self.drive.set(walk.state, s, q)
        walk.state.x = x.copy()
        outcome = walk.newton.solve(walk.state, held, control, options=options)
        if settled:
            outcome = settling.settled(walk.newton, walk.state, outcome, held, control, options)
        if not outcome.converged:
            return outcome
        begun = replace(before or walk.state, x=x)
        fault = acceptance.way_fault(self.model, begun, walk.state)
        return replace(outcome, converged=False, reason=fault) if fault else outcome

    def kinetic_ratio(self, velocity: np.ndarray) -> float:
        """Ratio of the kinetic energy at a velocity (local,) to the internal energy."""
        kinetic = self.model.sum(float(velocity @ self.model.momentum(velocity)) / 2)
        return kinetic / max(self.model.strain_energy(self.walk.state), 1e-300)
