"""Inertia of bodies while a time step acts on a state, as terms of the potential energy."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from softact.system.kernels import Coefficient, Kernel
from softact.system.term import FUNCTIONS, Origin, State

if TYPE_CHECKING:
    import scipy.sparse

    from softact.mesh.triangles import Triangles
    from softact.model import Model
    from softact.system.assembly import Assembler


class Inertia:
    """Force M c (x − away_from) of a state's ``TimeStep``; nothing where there is none.

    Subclasses know their mass.
    """

    def momentum(self, velocity: np.ndarray) -> np.ndarray:
        """This process's share of the mass matrix times a velocity (local,)."""
        raise NotImplementedError

    def add_mass(self, factor: float) -> None:
        """Add a multiple of the mass matrix to the assembler's."""
        raise NotImplementedError

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        if state.motion is not None:
            out += state.motion.factor * self.momentum(state.x - state.motion.away_from)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        if state.motion is not None:
            self.add_mass(state.motion.factor)

    def energy(self, state: State) -> float:
        """The potential of the step's inertia force, mJ."""
        if state.motion is None:
            return 0.0
        away = state.x - state.motion.away_from
        return state.motion.factor * float(away @ self.momentum(away)) / 2


class Carried:
    """The force that a state's ``TimeStep`` takes over from before."""

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        if state.motion is not None and state.motion.carried is not None:
            out += state.motion.carried

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``: the force is dead."""

    def energy(self, state: State) -> float:
        """See ``Term``."""
        if state.motion is None or state.motion.carried is None:
            return 0.0
        return float(state.motion.carried @ state.x)


class SolidInertia(Inertia):
    """Of a region of tetrahedra; density in tonne/mm³."""

    def __init__(self, assembler: Assembler, cells: np.ndarray, density: float, degree: int):
        self.density = density
        self._size = 3 * FUNCTIONS[degree]
        self._table = assembler.unknowns.cell_dofs
        self._force, self._tangent = (
            Kernel(assembler, k, np.asarray(cells)) for k in assembler.kernels("inertia", degree)
        )

    def momentum(self, velocity: np.ndarray) -> np.ndarray:
        """See ``Inertia``."""
        out = np.zeros_like(velocity)
        coefficient = Coefficient(np.ascontiguousarray(velocity), self._size, self._table)
        self._force.add_vector(out, self._size, [coefficient], [self.density])
        return out

    def add_mass(self, factor: float) -> None:
        """See ``Inertia``."""
        self._tangent.add_matrix(self._size, [], [factor * self.density])


class SheetInertia(Inertia):
    """Of a sheet; density per area, tonne/mm²."""

    def __init__(self, triangles: Triangles, density: float):
        self._triangles = triangles
        self._mass = density * triangles.mass()

    @functools.cached_property
    def _matrix(self) -> scipy.sparse.csr_matrix:
        """The mass matrix of the unknowns up to the sheet's last."""
        import scipy.sparse  # here: sweeps and their tables shall not wait for it

        dofs, n = self._triangles.dofs, self._mass.shape[1]
        rows, columns = np.repeat(dofs, n, axis=1), np.tile(dofs, (1, n, 1))
        values = np.repeat(self._mass.reshape(len(dofs), -1), 3)
        entries = values, (rows.ravel(), columns.ravel())
        return scipy.sparse.csr_matrix(entries, shape=(int(dofs.max(initial=-1)) + 1,) * 2)

    def momentum(self, velocity: np.ndarray) -> np.ndarray:
        """See ``Inertia``."""
        out, matrix = np.zeros_like(velocity), self._matrix
        out[: matrix.shape[0]] = matrix @ velocity[: matrix.shape[1]]
        return out

    def add_mass(self, factor: float) -> None:
        """See ``Inertia``."""
        self._triangles.table.add_scalar(self._mass, factor)


class RigidInertia(Inertia):
    """Of a rigid body by its unknowns (6,); matrix: (6, 6) tonne. It counts on the process that
    owns them; add: adds a matrix (6, 6) of theirs to the assembler's."""

    def __init__(
        self, dofs: np.ndarray, matrix: np.ndarray, add: Callable[[np.ndarray], None], mine: bool
    ):
        self._dofs, self._matrix, self._add, self._mine = dofs, matrix, add, mine

    def momentum(self, velocity: np.ndarray) -> np.ndarray:
        """See ``Inertia``."""
        out = np.zeros_like(velocity)
        if self._mine:
            out[self._dofs] = self._matrix @ velocity[self._dofs]
        return out

    def add_mass(self, factor: float) -> None:
        """See ``Inertia``."""
        if self._mine:
            self._add(factor * self._matrix)


class LumpedInertia(Inertia):
    """Of masses (k,) tonne at nodes whose unknowns are dofs (k, 3), each of one process."""

    def __init__(self, model: Model, dofs: np.ndarray, masses: np.ndarray):
        self._dofs, self._masses = dofs, masses[:, None]
        self._assembler = model.assembler
        numbers = model.unknowns.number[dofs].ravel()
        self._slots = model.assembler.couple(numbers, numbers)

    def momentum(self, velocity: np.ndarray) -> np.ndarray:
        """See ``Inertia``."""
        out = np.zeros_like(velocity)
        out[self._dofs] = self._masses * velocity[self._dofs]
        return out

    def add_mass(self, factor: float) -> None:
        """See ``Inertia``."""
        free = self._assembler.fixed[self._dofs] == 0
        self._assembler.extra_values[self._slots] += (factor * free * self._masses).ravel()
