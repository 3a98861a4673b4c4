"""Bodies with inertia in real time: increments of the generalised-alpha method.

With R the internal less the external force, each with the loads of its own time, an increment is

    (1 − αf) R₁ + αf R₀ + M ((1 − αm) a₁ + αm a₀) = 0,

x₁ = x₀ + Δt v₀ + Δt² ((½ − β) a₀ + β a₁), v₁ = v₀ + Δt ((1 − γ) a₀ + γ a₁). Weighing forces and not
displacements leaves the state at the end of the increment, and materials with a memory as they are.
The acceleration at the start of a step, where loads may jump, is not known; its first increment is
a very short one of backward Euler (αm = αf = 0, β = γ = 1), which needs none. One such increment
leaves the method of second order.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from softact.loads.dynamics import Dynamics
from softact.model import Model
from softact.system.term import State, TimeStep

# The first increment of a step, by the next one.
START = 1e-3
# Displacements below this part of the body's diagonal do not count in the error in time.
STILL = 1e-4
VELOCITY, ACCELERATION, UNBALANCED, EXTERNAL, WORK, LARGEST = (
    f"inertia/{name}"
    for name in ("velocity", "acceleration", "unbalanced", "external", "work", "largest")
)
NAMES = (VELOCITY, ACCELERATION, UNBALANCED, EXTERNAL, WORK, LARGEST)


@dataclass(frozen=True)
class Weights:
    """αm, αf, β and γ of an increment."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float


BACKWARD_EULER = Weights(0.0, 0.0, 1.0, 1.0)


def forget(state: State) -> None:
    """Let the body be at rest, as in a step without inertia."""
    state.memory = {name: v for name, v in state.memory.items() if name not in NAMES}


class GeneralisedAlpha:
    """The increments of one step, from what the memory of its state holds of the last one."""

    def __init__(self, model: Model, dynamics: Dynamics):
        model.add_inertia()
        self._model, self._moving = model, model.moving_dofs
        d = dynamics
        self._weights = Weights(d.alpha_m, d.alpha_f, d.beta, d.gamma)
        self._floor = STILL * model.diagonal * np.sqrt(model.sum(model.nodes.owned))

    def begin(self, state: State) -> None:
        """Begin at a state, with its velocity where it has one; at rest where not."""
        nothing = np.zeros_like(state.x)
        kept = {name: state.memory.get(name, nothing) for name in (VELOCITY, EXTERNAL)}
        if VELOCITY not in state.memory:
            kept[EXTERNAL] = self._forces(state)[1]
        kept |= {ACCELERATION: nothing, UNBALANCED: nothing}
        stored = self._model.strain_energy(state)  # counts as supplied
        numbers = {WORK: state.memory.get(WORK, stored), LARGEST: state.memory.get(LARGEST, 0.0)}
        state.memory = {**state.memory, **kept, **numbers}

    def _used(self, starts: bool) -> Weights:
        return BACKWARD_EULER if starts else self._weights

    def act(self, state: State, x: np.ndarray, time_step: float, starts: bool) -> None:
        """Let an increment from ``x`` (local,) of the time act on a state; starts: the first."""
        w, memory = self._used(starts), state.memory
        velocity, acceleration = memory[VELOCITY], memory[ACCELERATION]
        whole = w.beta * time_step**2
        share = (1 - w.alpha_m) / (1 - w.alpha_f)
        away = x + time_step * velocity + (0.5 - w.beta) * time_step**2 * acceleration
        away = away - w.alpha_m / (1 - w.alpha_m) * whole * acceleration
        if starts:  # x₁ = x₀ + Δt v₁
            away = x + time_step * velocity
        carried = w.alpha_f / (1 - w.alpha_f) * np.asarray(memory[UNBALANCED])
        state.motion = TimeStep(share / whole, away, x, carried=carried)

    def ended(
        self, state: State, x: np.ndarray, time_step: float, starts: bool
    ) -> dict[str, np.ndarray | float]:
        """The memory at the end of an increment that a state has come to from ``x``; without its
        time step from here on. Collective."""
        w, memory = self._used(starts), state.memory
        state.motion = None
        velocity, before = np.asarray(memory[VELOCITY]), np.asarray(memory[ACCELERATION])
        way = self._displacements(state.x - x)
        if starts:
            after = (way / time_step - velocity) / time_step
        else:
            free = time_step * velocity + (0.5 - w.beta) * time_step**2 * before
            after = (way - free) / (w.beta * time_step**2)
        onward = velocity + time_step * ((1 - w.gamma) * before + w.gamma * after)
        unbalanced, external = self._forces(state)
        held = np.where(self._model.assembler.fixed != 0, unbalanced, 0.0)
        external = external + self._displacements(held)
        external = external + np.where(self._model.assembler.fixed != 0, self._mass(after), 0.0)
        mean = (external + np.asarray(memory[EXTERNAL])) / 2
        owned = slice(self._model.unknowns.owned)
        work = self._model.sum(float(mean[owned] @ way[owned]))
        return {
            VELOCITY: onward,
            ACCELERATION: after,
            UNBALANCED: self._displacements(unbalanced),
            EXTERNAL: external,
            WORK: float(memory[WORK]) + work,
            LARGEST: max(float(memory[LARGEST]), self._norm(state.x)),
        }

    def error(
        self, state: State, ended: Mapping[str, np.ndarray | float], time_step: float
    ) -> float:
        """Error of an increment's displacements, Δt² (β − 1/6) (a₁ − a₀), by the largest so far
        (Zienkiewicz and Xie, Earthq. Eng. Struct. Dyn. 20 (1991) 871). Collective."""
        change = np.asarray(ended[ACCELERATION]) - np.asarray(state.memory[ACCELERATION])
        factor = abs(self._weights.beta - 1 / 6) * time_step**2
        return factor * self._norm(change) / max(float(ended[LARGEST]), self._floor)

    def _forces(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Out-of-balance and external force (local,) of a state, without inertia; zero at what
        other processes own."""
        unbalanced, internal = self._model.force(state)
        external = self._displacements(internal - unbalanced)
        unbalanced = self._displacements(unbalanced)
        for force in (unbalanced, external):
            force[self._model.unknowns.owned :] = 0.0
        return unbalanced, external

    def _mass(self, acceleration: np.ndarray) -> np.ndarray:
        return self._model.unknowns.sum_shared(self._model.momentum(acceleration))

    def _displacements(self, vector: np.ndarray) -> np.ndarray:
        """A vector (local,) with zeros for all that is no displacement."""
        out = np.zeros_like(vector)
        out[self._moving] = vector[self._moving]
        return out

    def _norm(self, vector: np.ndarray) -> float:
        mine = vector[self._moving[self._moving < self._model.unknowns.owned]]
        return float(np.sqrt(self._model.sum(float((mine**2).sum()))))


def kinetic_energy(model: Model, state: State) -> float:
    """Of the meshed part, mJ; 0 where nothing moves. Collective."""
    velocity = state.memory.get(VELOCITY)
    if velocity is None:
        return 0.0
    velocity = np.asarray(velocity)
    return model.sum(float(velocity @ model.momentum(velocity)) / 2)


def energies(model: Model, state: State) -> dict[str, float]:
    """Columns of curve.csv, of the whole actuator, mJ: the kinetic energy; what was there at the
    start of the motion and the work of all loads and moved supports since then; what of that is
    neither stored nor kinetic: dissipated by the scheme and by what creeps or rubs. Collective."""
    kinetic = kinetic_energy(model, state)
    stored = model.strain_energy(state)
    supplied = float(state.memory.get(WORK, stored))
    values = {
        "kinetic_energy_mJ": kinetic,
        "supplied_energy_mJ": supplied,
        "dissipated_energy_mJ": supplied - stored - kinetic,
    }
    return {name: model.mesh.layout.copies * value for name, value in values.items()}
