"""The parts of a model's potential energy: each adds its forces and its tangent to the system.

A term offers ``add_force(state, out)`` (derivative of its potential, N), ``add_tangent(state)``
(second derivative) and ``energy(state)`` (mJ, this process's share). New physics is a new term.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from softact import compat, forms
from softact.assembly import Assembler, Coefficient, Kernel

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


class Term(Protocol):
    """What a model asks of each of its parts."""

    def add_force(self, state: State, out: np.ndarray) -> None: ...

    def add_tangent(self, state: State, previous: State | None) -> None: ...

    def energy(self, state: State) -> float: ...


class Solid:
    """One region of tetrahedra with one material.

    fibres: points (n, 3) mm -> unit vectors (n, families, 3), for a material with fibres.
    """

    def __init__(self, assembler: Assembler, cells, material, degree, pressure_degree, fibres=None):
        self.assembler = assembler
        self.cells = np.ascontiguousarray(cells, dtype=np.int32)
        self.material = material
        self._mixed = pressure_degree is not None
        self._size = assembler.unknowns.cell_dofs.shape[1]
        self._functions = FUNCTIONS[degree]
        points, self.weights = compat.quadrature_rule(forms.QUADRATURE_DEGREE)
        self._gradients = compat.tabulate_gradients(degree, points)
        self.pressure_values = (
            compat.tabulate_values(pressure_degree, points) if self._mixed else None
        )
        kernels = assembler.kernels("solid", degree, pressure_degree)
        self._residual, self._tangent = (Kernel(assembler, k, self.cells) for k in kernels)
        self.volumes = self._reference_volumes()
        self.fibres = None if fibres is None else fibres(self._places(points))

    def _corners(self) -> np.ndarray:
        """Undeformed corners of the tetrahedra: (cells, 4, 3) mm."""
        return self.assembler.points[self.assembler.geometry_nodes[self.cells]]

    def _places(self, points: np.ndarray) -> np.ndarray:
        """Undeformed places of the quadrature points, cell after cell: (cells · points, 3) mm."""
        shares = np.column_stack([1 - points.sum(axis=1), points])
        return (shares @ self._corners()).reshape(-1, 3)

    def _reference_volumes(self) -> np.ndarray:
        """Undeformed volume that belongs to each quadrature point: (cells, points) mm³."""
        x = self._corners()
        determinant = np.abs(np.linalg.det(x[:, 1:] - x[:, :1]))
        return determinant[:, None] * self.weights

    def deformation_gradient(self, x: np.ndarray, gradients=None) -> np.ndarray:
        """F (cells, points, 3, 3) at the quadrature points, or where ``gradients`` were taken."""
        gradients = self._gradients if gradients is None else gradients
        out = np.empty((len(self.cells), len(gradients), 3, 3))
        a = self.assembler
        dofs = a.unknowns.cell_dofs

        def pointer(array):
            return ctypes.c_void_p(array.ctypes.data)

        a.library.deformation_gradient(
            ctypes.c_int64(len(self.cells)),
            pointer(self.cells),
            pointer(a.geometry_nodes),
            pointer(a.points),
            len(gradients),
            self._functions,
            pointer(gradients),
            pointer(dofs),
            dofs.shape[1],
            pointer(x),
            pointer(out),
        )
        return out

    def fibre_stretch(self, x: np.ndarray) -> np.ndarray:
        """Stretch along the fibres (cells · points, families), for a material that has some."""
        f = self.deformation_gradient(x).reshape(-1, 1, 3, 3)
        return np.linalg.norm((f @ self.fibres[..., None])[..., 0], axis=-1)

    def hydrostatic_pressure(self, x: np.ndarray) -> np.ndarray:
        """p (cells, points) MPa at the quadrature points, positive in tension."""
        if not self._mixed:
            jacobian = np.linalg.det(self.deformation_gradient(x))
            return self._volumetric_stress(jacobian)
        dofs = self.assembler.unknowns.cell_dofs[self.cells, 3 * self._functions :]
        return x[dofs] @ self.pressure_values.T

    def _volumetric_stress(self, jacobian):
        extra = self._extra_volumetric(jacobian.ravel())[1].reshape(jacobian.shape)
        return self.material.bulk_modulus * (jacobian - 1) + extra

    def second_piola(self, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stress S (n, 6), moduli D (n, 6, 6) and J (n,) at the quadrature points.

        Raises InvertedElementError where J is not positive.
        """
        f = self.deformation_gradient(state.x).reshape(-1, 3, 3)
        jacobian = np.linalg.det(f)
        if not (jacobian > 0).all():  # also true of NaN
            raise InvertedElementError
        c = np.matmul(f.transpose(0, 2, 1), f)
        stress, moduli = self.material.stress_tangent(c, self.fibres)
        return *self._add_volumetric(stress, moduli, c, jacobian), jacobian

    def _add_volumetric(self, stress, moduli, c, jacobian):
        """What the pressure unknown does not carry: all of U(J) without one, else its rest."""
        _, first, second = self._extra_volumetric(jacobian)
        if not self._mixed:
            first = first + self.material.bulk_modulus * (jacobian - 1)
            second = second + self.material.bulk_modulus
        elif not np.any(first) and not np.any(second):
            return stress, moduli
        inverse = np.linalg.inv(c)
        rows, columns = [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]
        v = inverse[:, rows, columns]
        # (C⁻¹ ⊙ C⁻¹)_ijkl = ½ (C⁻¹_ik C⁻¹_jl + C⁻¹_il C⁻¹_jk) in Voigt pairs
        i, j = np.array(rows)[:, None], np.array(columns)[:, None]
        k, m = np.array(rows)[None], np.array(columns)[None]
        product = (inverse[:, i, k] * inverse[:, j, m] + inverse[:, i, m] * inverse[:, j, k]) / 2
        stress = stress + (first * jacobian)[:, None] * v
        moduli = (
            moduli
            + (jacobian**2 * second + jacobian * first)[:, None, None] * v[:, :, None] * v[:, None]
            - (2 * jacobian * first)[:, None, None] * product
        )
        return stress, moduli

    def _extra_volumetric(self, jacobian):
        """U, U', U'' of what neither the pressure unknown nor κ/2 (J − 1)² holds."""
        if self._mixed:
            return self.material.higher_volumetric(jacobian)
        return self.material.extra_volumetric(jacobian)

    def _constants(self):
        if not self._mixed:
            return []
        return [1 / self.material.bulk_modulus, float(self.material.logarithmic_volume)]

    def pressure_volume(self, pressure: np.ndarray) -> np.ndarray:
        """J at which the volumetric energy of the pressure unknown has the slope ``pressure``."""
        compliance, logarithmic = self._constants()
        swelling = compliance * pressure
        return swelling + np.sqrt(1 + logarithmic * swelling**2)

    def _unknowns(self, x):
        return Coefficient(x, self._size, self.assembler.unknowns.cell_dofs)

    def add_force(self, state, out):
        stress, _, _ = self._evaluate(state)
        values = Coefficient(np.ascontiguousarray(stress), stress.shape[1] * len(self.weights))
        self._residual.add_vector(
            out, self._size, [self._unknowns(state.x), values], self._constants()
        )

    def add_tangent(self, state, previous):
        stress, moduli, _ = self._evaluate(state)
        points = len(self.weights)
        self._tangent.add_matrix(
            self._size,
            [
                self._unknowns(state.x),
                Coefficient(np.ascontiguousarray(moduli), 36 * points),
                Coefficient(np.ascontiguousarray(stress), 6 * points),
            ],
            self._constants(),
        )

    def _evaluate(self, state):
        """The last evaluated point is kept: Newton asks for force and tangent at the same one."""
        key = state.x.tobytes()
        if getattr(self, "_last", (None,))[0] != key:
            self._last = (key, self.second_piola(state))
        return self._last[1]

    def cauchy(self, state: State) -> np.ndarray:
        """Cauchy stress (cells, points, 3, 3) MPa at the quadrature points: F S Fᵀ/J + p I."""
        f = self.deformation_gradient(state.x)
        s = self._evaluate(state)[0].reshape(*f.shape[:2], 6)
        tensor = s[..., [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(f.shape)
        pushed = f @ tensor @ np.swapaxes(f, -1, -2) / np.linalg.det(f)[..., None, None]
        if self._mixed:
            pushed += self.hydrostatic_pressure(state.x)[..., None, None] * np.eye(3)
        return pushed

    def energy(self, state):
        f = self.deformation_gradient(state.x).reshape(-1, 3, 3)
        jacobian = np.linalg.det(f)
        c = np.matmul(f.transpose(0, 2, 1), f)
        density = self.material.energy(c, self.fibres) + self._extra_volumetric(jacobian)[0]
        if self._mixed:
            jacobian = self.pressure_volume(self.hydrostatic_pressure(state.x).ravel())
            density = density + self.material.logarithmic_excess(jacobian)[0]
        density = density + self.material.bulk_modulus * (jacobian - 1) ** 2 / 2
        return float(density @ self.volumes.ravel())


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

    def add_tangent(self, state, previous):
        pressure = state.pressure.get(self.name, 0.0)
        if pressure:
            self._tangent.add_matrix(self._size, self._u(state.x), [pressure])

    def energy(self, state):
        return -state.pressure.get(self.name, 0.0) * self.volume(state.x)


class Layer:
    """Thin elastic sheet bonded to a surface: membrane energy; bending is ``softact.bending``.

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

    def add_tangent(self, state, previous):
        before = state if previous is None else previous
        self._tangent.add_matrix(self._size, [self._u(state.x), self._u(before.x)], self._constants)

    def energy(self, state):
        return self._energy.scalar([self._u(state.x)], self._constants)


class Weight:
    """Gravity on a solid region (density per volume) or a layer (density times thickness)."""

    def __init__(self, assembler: Assembler, entities, density: float, degree: int):
        self._density = density
        self._size = 3 * FUNCTIONS[degree]
        form = "body_force" if np.ndim(entities) == 1 else "surface_force"
        kernel = Kernel(assembler, *assembler.kernels(form, degree), entities)
        self._unit = np.zeros((3, assembler.unknowns.local))
        for direction, out in zip(np.eye(3), self._unit, strict=True):
            kernel.add_vector(out, self._size, [], direction * density)

    def add_force(self, state, out):
        if np.any(state.gravity):
            out -= state.gravity @ self._unit

    def add_tangent(self, state, previous):
        """The weight does not depend on the displacement."""

    def energy(self, state):
        return -float(state.gravity @ self._unit @ state.x)


class SurfaceForce:
    """Dead force per undeformed area on a surface."""

    def __init__(self, assembler: Assembler, name: str, facets, degree: int):
        self.name = name
        kernel = Kernel(assembler, *assembler.kernels("surface_force", degree), facets)
        self._unit = np.zeros((3, assembler.unknowns.local))
        for direction, out in zip(np.eye(3), self._unit, strict=True):
            kernel.add_vector(out, 3 * FUNCTIONS[degree], [], direction)

    def add_force(self, state, out):
        if self.name in state.traction:
            out -= state.traction[self.name] @ self._unit

    def add_tangent(self, state, previous):
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

    def add_tangent(self, state, previous):
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

    def add_tangent(self, state, previous):
        if self.time_step is not None:
            self._tangent.add_matrix(self._size, [], [self.density / self.time_step**2])

    def energy(self, state):
        """The potential of the step's inertia force, mJ."""
        if self.time_step is None:
            return 0.0
        away = state.x - self.away_from
        return float(away @ self.momentum(away)) / (2 * self.time_step**2)
