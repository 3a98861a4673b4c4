"""The parts of a model's potential energy: each adds its forces and its tangent to the system.

A term offers ``add_force(state, out)`` (derivative of its potential, N), ``add_tangent(state,
origin)`` (second derivative) and ``energy(state)`` (mJ, this process's share). New physics is a new
term; the solids' is ``softact.bodies.solid``.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from softact.system import forms
from softact.system.assembly import Assembler
from softact.system.kernels import Coefficient, Kernel

FUNCTIONS = {1: 4, 2: 10}  # shape functions of a tetrahedron by degree


@dataclass
class State:
    """Unknowns and loads at one moment, as this process holds them.

    x: (local,) unknowns, ghosts included. pressure: cavity -> MPa. gravity: (3,) mm/s².
    traction: surface -> (3,) MPa. surface_pressure: surface -> MPa. shift, presence: how far an
    obstacle was moved (3,) mm, and whether it is there. memory: what contacts keep from the last
    equilibrium (see ``softact.contact``).
    """

    x: np.ndarray
    pressure: dict[str, float] = field(default_factory=dict)
    gravity: np.ndarray = field(default_factory=lambda: np.zeros(3))
    traction: dict[str, np.ndarray] = field(default_factory=dict)
    surface_pressure: dict[str, float] = field(default_factory=dict)
    shift: dict[str, np.ndarray] = field(default_factory=dict)
    presence: dict[str, float] = field(default_factory=dict)
    memory: dict[str, np.ndarray | float] = field(default_factory=dict)


class InvertedElementError(Exception):
    """An element has turned inside out: the state is not admissible."""


@dataclass(frozen=True)
class Origin:
    """The states from which the stress in the geometric stiffness is carried on.

    At a state that Newton's method came to, the stress is that of the tangent before, linearised;
    at a guess that was extrapolated, the stress is extrapolated too. A tangent with such a stress
    is Newton's for the stress as an unknown of its own: stiff directions of large rotations then
    put no false stress into it (Magisano, Leonetti, Garcea, CMAME 313, 2017).

    states: (local,) unknowns of each; weights: theirs, with the sum 1. linearised: there is one
    state, and the stress is linearised at it.
    """

    states: tuple[np.ndarray, ...]
    weights: tuple[float, ...] = (1.0,)
    linearised: bool = False


class Term(Protocol):
    """What a model asks of each of its parts."""

    def add_force(self, state: State, out: np.ndarray) -> None: ...

    def add_tangent(self, state: State, origin: Origin | None) -> None: ...

    def energy(self, state: State) -> float: ...


class CavityPressure:
    """Follower pressure on the walls of a closed cavity: potential −p V(u)."""

    def __init__(self, assembler: Assembler, name: str, facets, degree: int):
        self.name = name
        self._size = 3 * FUNCTIONS[degree]
        self._table = assembler.unknowns.cell_dofs
        self._volume, self._force, self._tangent = (
            Kernel(assembler, k, facets) for k in assembler.kernels("cavity", degree)
        )

    def _u(self, x):
        return [Coefficient(x, self._size, self._table)]

    def volume(self, x) -> float:
        """This process's share of the enclosed volume, mm³."""
        return self._volume.scalar(self._u(x))

    def add_volume_gradient(self, x, factor: float, out: np.ndarray) -> None:
        """Add ``factor`` times the derivative of the volume by the unknowns to ``out`` (local,)."""
        self._force.add_vector(out, self._size, self._u(x), [-factor])

    def add_force(self, state, out):
        pressure = state.pressure.get(self.name, 0.0)
        if pressure:
            self._force.add_vector(out, self._size, self._u(state.x), [pressure])

    def add_tangent(self, state, origin):
        pressure = state.pressure.get(self.name, 0.0)
        if pressure:
            self._tangent.add_matrix(self._size, self._u(state.x), [pressure])

    def energy(self, state):
        return -state.pressure.get(self.name, 0.0) * self.volume(state.x)


class Layer:
    """Thin elastic sheet bonded to a surface: membrane energy; bending is ``softact.bodies.plate``.

    material: St. Venant-Kirchhoff with ``youngs_modulus`` (MPa), ``poissons_ratio``, ``density``
    (tonne/mm³); thickness in mm.
    """

    def __init__(self, assembler: Assembler, facets, material, thickness: float, degree: int):
        self.material, self.thickness = material, thickness
        self._size = 3 * FUNCTIONS[degree]
        self._table = assembler.unknowns.cell_dofs
        stiffness = material.youngs_modulus * thickness / (1 - material.poissons_ratio**2)
        self._constants = [stiffness, material.poissons_ratio]
        self._energy, self._force, self._tangent = (
            Kernel(assembler, k, facets) for k in assembler.kernels("layer", degree)
        )

    def _u(self, x):
        return Coefficient(x, self._size, self._table)

    def add_force(self, state, out):
        self._force.add_vector(out, self._size, [self._u(state.x)], self._constants)

    def add_tangent(self, state, origin):
        origin = origin or Origin((state.x,))
        states = [*origin.states, *[state.x] * (forms.LAYER_STATES - len(origin.states))]
        weights = [*origin.weights, *[0.0] * (forms.LAYER_STATES - len(origin.weights))]
        self._tangent.add_matrix(
            self._size,
            [self._u(x) for x in (state.x, *states)],
            [*self._constants, *weights, float(origin.linearised)],
        )

    def energy(self, state):
        return self._energy.scalar([self._u(state.x)], self._constants)


def unit_forces(assembler: Assembler, entities, degree: int) -> np.ndarray:
    """Nodal forces (3, local) of 1 N/mm³ in cells, or 1 N/mm² on facets, along x, y and z."""
    form = "body_force" if np.ndim(entities) == 1 else "surface_force"
    kernel = Kernel(assembler, *assembler.kernels(form, degree), entities)
    forces = np.zeros((3, assembler.unknowns.local))
    for direction, out in zip(np.eye(3), forces, strict=True):
        kernel.add_vector(out, 3 * FUNCTIONS[degree], [], direction)
    return forces


def shared_forces(dofs: np.ndarray, shares: np.ndarray, size: int) -> np.ndarray:
    """Forces (3, size) along x, y and z, of which each node of ``dofs`` (..., 3) has a share."""
    forces = np.zeros((3, size))
    for c in range(3):
        np.add.at(forces[c], dofs[..., c], shares)
    return forces


class Weight:
    """Gravity on a body; unit: nodal forces (3, local) N of 1 mm/s² along x, y and z."""

    def __init__(self, unit: np.ndarray):
        self._unit = unit

    def add_force(self, state, out):
        if np.any(state.gravity):
            out -= state.gravity @ self._unit

    def add_tangent(self, state, origin):
        """The weight does not depend on the displacement."""

    def energy(self, state):
        return -float(state.gravity @ self._unit @ state.x)


class SurfaceForce:
    """Dead force per undeformed area on a surface; unit: nodal forces (3, local) N of 1 N/mm²
    along x, y and z."""

    def __init__(self, name: str, unit: np.ndarray):
        self.name, self._unit = name, unit

    def add_force(self, state, out):
        if self.name in state.traction:
            out -= state.traction[self.name] @ self._unit

    def add_tangent(self, state, origin):
        """A dead force does not depend on the displacement."""

    def energy(self, state):
        if self.name not in state.traction:
            return 0.0
        return -float(state.traction[self.name] @ self._unit @ state.x)


class SurfacePressure:
    """Follower pressure on a surface that need not be closed, such as one face of a block."""

    def __init__(self, assembler: Assembler, name: str, facets, degree: int):
        self.name = name
        self._size = 3 * FUNCTIONS[degree]
        self._table = assembler.unknowns.cell_dofs
        self._force, self._tangent = (
            Kernel(assembler, k, facets) for k in assembler.kernels("surface_pressure", degree)
        )

    def _arguments(self, state):
        pressure = state.surface_pressure.get(self.name, 0.0)
        return self._size, [Coefficient(state.x, self._size, self._table)], [pressure]

    def add_force(self, state, out):
        self._force.add_vector(out, *self._arguments(state))

    def add_tangent(self, state, origin):
        self._tangent.add_matrix(*self._arguments(state))

    def energy(self, state):
        """Such a pressure has no potential; it counts as zero."""
        return 0.0


class Inertia:
    """Inertia of a region in one implicit time step; without one, ``time_step`` is None.

    Backward Euler: v = (x − x₀)/Δt, a = (v − v₀)/Δt, so that the force is ρ/Δt² (x − x₀ − Δt v₀).
    It is stable at any step and damps what moves quickly. away_from: (local,) x₀ + Δt v₀.
    """

    def __init__(self, assembler: Assembler, cells, density: float, degree: int):
        self.density = density
        self._size = 3 * FUNCTIONS[degree]
        self._table = assembler.unknowns.cell_dofs
        self._force, self._tangent = (
            Kernel(assembler, k, np.asarray(cells)) for k in assembler.kernels("inertia", degree)
        )
        self.time_step: float | None = None
        self.away_from = np.zeros(assembler.unknowns.local)

    def momentum(self, velocity: np.ndarray) -> np.ndarray:
        """This process's share of the mass matrix times a velocity (local,)."""
        out = np.zeros_like(velocity)
        self._add(velocity, self.density, out)
        return out

    def _add(self, field, factor, out):
        coefficient = Coefficient(np.ascontiguousarray(field), self._size, self._table)
        self._force.add_vector(out, self._size, [coefficient], [factor])

    def add_force(self, state, out):
        if self.time_step is not None:
            self._add(state.x - self.away_from, self.density / self.time_step**2, out)

    def add_tangent(self, state, origin):
        if self.time_step is not None:
            self._tangent.add_matrix(self._size, [], [self.density / self.time_step**2])

    def energy(self, state):
        """The potential of the step's inertia force, mJ."""
        if self.time_step is None:
            return 0.0
        away = state.x - self.away_from
        return float(away @ self.momentum(away)) / (2 * self.time_step**2)
