"""Regions of tetrahedra: stress and tangent of a solid, as a term of the potential energy."""

from __future__ import annotations

import copy
import ctypes
import functools
import operator
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from softact import compat
from softact.bodies.anchor import Anchor
from softact.bodies.compiled_solid_law import compiled
from softact.bodies.inertia import SolidInertia
from softact.bodies.last_few import LastFew
from softact.bodies.weight import Weight
from softact.materials.base import Material
from softact.materials.tensors import (
    full,
    symmetric,
    symmetric_product,
    volumetric_response,
)
from softact.system import forms
from softact.system.assembly import Assembler
from softact.system.kernels import Coefficient, Kernel, pointer
from softact.system.term import (
    FUNCTIONS,
    InvertedElementError,
    Origin,
    State,
    Term,
    TimeStep,
    unit_forces,
)

#: Stress (n, 6), moduli (n, 6, 6) and J (n,), see ``Solid.second_piola``.
Response = tuple[np.ndarray, np.ndarray, np.ndarray]


class Solid:
    """One region of tetrahedra with one material.

    fibres: points (n, 3) mm -> unit vectors (n, families, 3), for a material with fibres.
    """

    def __init__(
        self,
        assembler: Assembler,
        name: str,
        cells: np.ndarray,
        material: Material,
        degree: int,
        pressure_degree: int | None,
        fibres: Callable[[np.ndarray], np.ndarray] | None = None,
    ):
        self.assembler, self.name = assembler, name
        self.cells = np.ascontiguousarray(cells, dtype=np.int32)
        self.material = material
        self._mixed = pressure_degree is not None
        self._size = assembler.unknowns.cell_dofs.shape[1]
        self.degree, self._functions = degree, FUNCTIONS[degree]
        points, self.weights = compat.quadrature_rule(forms.QUADRATURE_DEGREE)
        self._gradients = compat.tabulate_gradients(degree, points)
        self.pressure_values = (
            None if pressure_degree is None else compat.tabulate_values(pressure_degree, points)
        )
        (residual,) = assembler.kernels("solid", degree, pressure_degree)
        self._residual = Kernel(assembler, residual, self.cells)
        self.volumes = self._reference_volumes()
        self._kept: LastFew[Response] = LastFew()
        self._anchor: Anchor | None = None
        self._last: dict[str, tuple[np.ndarray, np.ndarray]] = {}  # see ``_once``
        self._began: tuple[TimeStep, np.ndarray, np.ndarray] | None = None  # see ``_viscous``
        self.fibres = None if fibres is None else fibres(self.places(points).reshape(-1, 3))
        self._compiled = compiled(assembler.unknowns.comm, material, self.fibres)

    def places(
        self, points: np.ndarray, chosen: slice | np.ndarray | int = slice(None)
    ) -> np.ndarray:
        """Undeformed places (..., n, 3) mm of reference points (n, 3) in each of the region's
        tetrahedra, or in chosen ones."""
        a = self.assembler
        shares = compat.tabulate_values(a.shape_degree, points)
        return shares @ a.points[a.geometry_nodes[self.cells[chosen]]]

    def centres(self) -> np.ndarray:
        """Undeformed centres of the elements (cells, 3) mm."""
        return self.places(np.full((1, 3), 0.25))[:, 0]

    def _reference_volumes(self) -> np.ndarray:
        """Undeformed volume that belongs to each quadrature point: (cells, points) mm³."""
        return np.abs(self.shape_determinant(self._gradients)) * self.weights

    def shape_determinant(
        self, gradients: np.ndarray, chosen: np.ndarray | None = None
    ) -> np.ndarray:
        """Determinant (cells, points) of the map from the reference tetrahedron to each undeformed
        one where ``gradients`` were taken, mm³; of all the region's cells, or of chosen ones."""
        cells = self.cells if chosen is None else np.ascontiguousarray(self.cells[chosen])
        out = np.empty((len(cells), len(gradients)))
        shapes = self._shapes(cells, gradients)
        self.assembler.library.shape_determinant(*shapes, pointer(gradients), pointer(out))
        return out

    def _shapes(self, cells: np.ndarray, gradients: np.ndarray) -> tuple[object, ...]:
        """What loops of ``_assembly.c`` over undeformed cells begin with."""
        a = self.assembler
        return (
            ctypes.c_int64(len(cells)),
            pointer(cells),
            pointer(a.geometry_nodes),
            a.geometry_nodes.shape[1],
            pointer(a.points),
            len(gradients),
        )

    def deformation_gradient(
        self, x: np.ndarray, gradients: np.ndarray | None = None, chosen: np.ndarray | None = None
    ) -> np.ndarray:
        """F (cells, points, 3, 3) at the quadrature points, or where ``gradients`` were taken; of
        all the region's cells, or of chosen ones."""
        if gradients is None and chosen is None:
            return self._once("gradient", x, lambda: self._gradient_at(x, self._gradients, None))
        return self._gradient_at(x, self._gradients if gradients is None else gradients, chosen)

    def _once(self, name: str, x: np.ndarray, find: Callable[[], np.ndarray]) -> np.ndarray:
        """What ``find`` says at the unknowns x, which is kept until it is asked elsewhere."""
        last = self._last.get(name)
        if last is None or not np.array_equal(last[0], x):
            last = self._last[name] = x.copy(), find()
            last[1].flags.writeable = False
        return last[1]

    def _gradient_at(
        self, x: np.ndarray, gradients: np.ndarray, chosen: np.ndarray | None
    ) -> np.ndarray:
        cells = self.cells if chosen is None else np.ascontiguousarray(self.cells[chosen])
        out = np.empty((len(cells), len(gradients), 3, 3))
        loop = self._loop(x, cells, gradients)
        self.assembler.library.deformation_gradient(*loop, pointer(out))
        return out

    def loop(self, x: np.ndarray) -> tuple[object, ...]:
        """What loops of ``_assembly.c`` over the deformed cells' quadrature points begin with."""
        return self._loop(x, self.cells, self._gradients)

    def _loop(self, x: np.ndarray, cells: np.ndarray, gradients: np.ndarray) -> tuple[object, ...]:
        dofs = self.assembler.unknowns.cell_dofs
        return (
            *self._shapes(cells, gradients),
            self._functions,
            pointer(gradients),
            pointer(dofs),
            dofs.shape[1],
            pointer(x),
        )

    def right_cauchy_green(self, x: np.ndarray, gradients: np.ndarray | None = None) -> np.ndarray:
        """C = FᵀF (cells, points, 6) where ``deformation_gradient`` gives F."""

        def find() -> np.ndarray:
            f = self.deformation_gradient(x, gradients)
            return self._strains(f).reshape(*f.shape[:2], 6)

        return self._once("strains", x, find) if gradients is None else find()

    def jacobian(
        self, x: np.ndarray, gradients: np.ndarray | None = None, chosen: np.ndarray | None = None
    ) -> np.ndarray:
        """J = det F (cells, points) where ``deformation_gradient`` gives F."""
        f = self.deformation_gradient(x, gradients, chosen)
        return self._jacobians(f).reshape(f.shape[:2])

    def _strains(self, f: np.ndarray) -> np.ndarray:
        """C (n, 6) of F (n, 3, 3), or of as many however they are arranged."""
        return self.at_points("right_cauchy_green", f.size // 9, f)

    def _jacobians(self, f: np.ndarray) -> np.ndarray:
        """J (n,) of F, as ``_strains``."""
        return self.at_points("jacobians", f.size // 9, f, entries=1)[:, 0]

    def at_points(
        self, loop: str, count: int, *known: np.ndarray | None, entries: int = 6
    ) -> np.ndarray:
        """What a loop of ``_assembly.c`` over points makes of arrays: (count, entries)."""
        out = np.empty((count, entries))
        arrays = [None if a is None else np.ascontiguousarray(a, float) for a in known]
        given = [None if a is None else pointer(a) for a in arrays]
        getattr(self.assembler.library, loop)(ctypes.c_int64(count), *given, pointer(out))
        return out

    def fibre_stretch(self, x: np.ndarray) -> np.ndarray:
        """Stretch along the fibres (cells · points, families), for a material that has some."""
        if self.fibres is None:
            raise ValueError(f"region {self.name}: its material has no fibres")
        f = self.deformation_gradient(x).reshape(-1, 1, 3, 3)
        return np.linalg.norm((f @ self.fibres[..., None])[..., 0], axis=-1)

    def hydrostatic_pressure(self, x: np.ndarray) -> np.ndarray:
        """p (cells, points) MPa at the quadrature points, positive in tension."""
        if self.pressure_values is None:
            return self._volumetric_stress(self.jacobian(x))
        dofs = self.assembler.unknowns.cell_dofs[self.cells, 3 * self._functions :]
        return x[dofs] @ self.pressure_values.T

    def _volumetric_stress(self, jacobian: np.ndarray) -> np.ndarray:
        extra = self._extra_volumetric(jacobian.ravel())[1].reshape(jacobian.shape)
        return self.material.bulk_modulus * (jacobian - 1) + extra

    def second_piola(self, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Stress S (n, 6), moduli D (n, 6, 6) and J (n,) at the quadrature points.

        Raises InvertedElementError where J is not positive.
        """
        f = self.deformation_gradient(state.x).reshape(-1, 3, 3)
        jacobian = self._jacobians(f)
        if not (jacobian > 0).all():  # also true of NaN
            raise InvertedElementError
        if self._anchor is not None:
            return self._anchor.stress_of(self, state.x), self._anchor.moduli, jacobian
        c = self.right_cauchy_green(state.x).reshape(-1, 6)
        stress, moduli = self._isochoric(c, state)
        if state.motion is not None and state.motion.resistance:
            more_stress, more_moduli = self._viscous(full(c), state.motion)
            stress, moduli = stress + more_stress, moduli + more_moduli
        return *self._add_volumetric(stress, moduli, c, jacobian), jacobian

    def _isochoric(self, c: np.ndarray, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Isochoric stress (n, 6) and moduli (n, 6, 6) at C (n, 6)."""
        return self._of_the_law(c)

    def _of_the_law(self, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The material's stress (n, 6) and moduli (n, 6, 6) at C (n, 6)."""
        if self._compiled is not None:
            return self._compiled.stress_tangent(c, self.fibres)
        return self.material.stress_tangent(full(c), self.fibres)

    def _stored(self, c: np.ndarray, state: State) -> np.ndarray:
        """Isochoric energy (n,) at C (n, 6), MPa."""
        return self.material.energy(full(c), self.fibres)

    def _viscous(self, c: np.ndarray, motion: TimeStep) -> tuple[np.ndarray, np.ndarray]:
        """Stress (n, 6) and moduli (n, 6, 6) at C (n, 3, 3) of a Newtonian fluid in one time step
        of backward Euler.

        With C₀ that of the state at its beginning the stress is η/Δt C₀⁻¹ (C − C₀) C₀⁻¹: 2 η times
        the rate of deformation, pulled back, whatever rotates.
        """
        if self._began is None or self._began[0] is not motion:
            f = self.deformation_gradient(motion.before).reshape(-1, 3, 3)
            before = np.matmul(f.transpose(0, 2, 1), f)
            self._began = motion, before, np.linalg.inv(before)
        _, before, inverse = self._began
        factor = motion.resistance * self.material.shear_modulus
        stress = factor * (inverse @ (c - before) @ inverse)
        return symmetric(stress), 2 * factor * symmetric_product(inverse)

    def _add_volumetric(
        self, stress: np.ndarray, moduli: np.ndarray, c: np.ndarray, jacobian: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """What the pressure unknown does not carry: all of U(J) without one, else its rest."""
        _, first, second = self._extra_volumetric(jacobian)
        if not self._mixed:
            first = first + self.material.bulk_modulus * (jacobian - 1)
            second = second + self.material.bulk_modulus
        elif not np.any(first) and not np.any(second):
            return stress, moduli
        inverse = np.linalg.inv(full(c))
        more_stress, more_moduli = volumetric_response(inverse, jacobian, first, second)
        return stress + more_stress, moduli + more_moduli

    def _extra_volumetric(self, jacobian: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """U, U', U'' of what neither the pressure unknown nor κ/2 (J − 1)² holds."""
        if self._mixed:
            return self.material.higher_volumetric(jacobian)
        return self.material.extra_volumetric(jacobian)

    def constants(self) -> list[float]:
        if not self._mixed:
            return []
        return [1 / self.material.bulk_modulus, float(self.material.logarithmic_volume)]

    def pressure_volume(self, pressure: np.ndarray) -> np.ndarray:
        """J at which the volumetric energy of the pressure unknown has the slope ``pressure``."""
        compliance, logarithmic = self.constants()
        swelling = compliance * pressure
        return swelling + np.sqrt(1 + logarithmic * swelling**2)

    def _unknowns(self, x: np.ndarray) -> Coefficient:
        return Coefficient(x, self._size, self.assembler.unknowns.cell_dofs)

    def add_force(self, state: State, out: np.ndarray) -> None:
        if self._anchor is not None:
            return self._anchor.add_force(self, state.x, out)
        stress, _, _ = self._evaluate(state)
        values = Coefficient(np.ascontiguousarray(stress), stress.shape[1] * len(self.weights))
        self._residual.add_vector(
            out, self._size, [self._unknowns(state.x), values], self.constants()
        )

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        stress, moduli, _ = self._evaluate(state)
        geometric = stress if origin is None else self._carried_stress(state, origin)
        self.assembler.add_solid(
            self.loop(state.x),
            self.weights,
            moduli,
            geometric,
            self.pressure_values,
            self.constants(),
        )

    def _carried_stress(self, state: State, origin: Origin) -> np.ndarray:
        """Stress (n, 6) of the geometric stiffness, see ``Origin``."""
        kept = [self._evaluate(replace(state, x=x)) for x in origin.states]
        if not origin.linearised:
            shares = (w * stress for w, (stress, _, _) in zip(origin.weights, kept, strict=True))
            return functools.reduce(operator.add, shares)
        stress, moduli, _ = kept[0]
        before = self._gradient_at(origin.states[0], self._gradients, None)
        now = self.deformation_gradient(state.x)
        return self.at_points("carried_stress", len(stress), before, now, stress, moduli)

    def _evaluate(self, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """``second_piola``, kept for the last few states: Newton asks for force and tangent at the
        same one, and for the stress of those that it came from; nobody does of one beside another.
        """
        if self._anchor is not None:
            return self.second_piola(state)
        return self._kept(state.x, self._key(state), lambda: self.second_piola(state))

    def _key(self, state: State) -> bytes:
        """Of all that the stress depends on but the unknowns."""
        resists = state.motion is not None and state.motion.resistance
        return state.motion.key if state.motion is not None and resists else b""

    def stand_beside(self, other: Solid, state: State) -> None:
        """Linearise the stress beside a state of another solid of the same cells, of which this one
        differs a little in the places of its points or in its material."""
        self.forget()
        stress, moduli, jacobian = other._evaluate(state)
        density = other.density(state)
        if not self._is_made_of(other):
            c = other.right_cauchy_green(state.x).reshape(-1, 6)
            own, _ = self._of_the_law(c)
            stress, _ = self._add_volumetric(own, np.zeros_like(moduli), c, jacobian)
            density = self._density_at(c, jacobian, state)
        strains = other.right_cauchy_green(state.x).reshape(-1, 6)
        known = (np.ascontiguousarray(a, float) for a in (strains, stress, moduli, density))
        self._anchor = Anchor(*known)

    def _is_made_of(self, other: Solid) -> bool:
        """Whether the material, and the direction of its fibres, is another solid's."""
        if self.material.law != other.material.law:
            return False
        if self.fibres is None or other.fibres is None:
            return self.fibres is other.fibres
        return bool(np.array_equal(self.fibres, other.fibres))

    def forget(self) -> None:
        """Let go what is kept of states: it is large."""
        self._anchor = None
        self._kept.clear()
        self._last.clear()

    def part(self, chosen: np.ndarray) -> Solid:
        """The solid of some of its cells (k,), numbers among ``cells``, linearised as it is; not of
        one that remembers."""
        part = copy.copy(self)
        part.cells = np.ascontiguousarray(self.cells[chosen])
        part.volumes = self.volumes[chosen]
        if self.fibres is not None:
            families = self.fibres.reshape(len(self.cells), -1, *self.fibres.shape[1:])[chosen]
            part.fibres = families.reshape(-1, *self.fibres.shape[1:])
        part._residual = Kernel(self.assembler, self._residual.address, part.cells)
        part._kept, part._last, part._began = LastFew(), {}, None
        if self._anchor is not None:
            part._anchor = self._anchor.part(chosen, self.volumes.shape[1])
        return part

    def cauchy(self, state: State) -> np.ndarray:
        """Cauchy stress (cells, points, 3, 3) MPa at the quadrature points: F S Fᵀ/J + p I."""
        f = self.deformation_gradient(state.x)
        pressure = self.hydrostatic_pressure(state.x) if self._mixed else None
        known = f, self._evaluate(state)[0], pressure
        pushed = self.at_points("cauchy_stress", self.volumes.size, *known, entries=9)
        return pushed.reshape(f.shape)

    def nominal(self, state: State, cauchy: np.ndarray) -> np.ndarray:
        """sym(J σ V⁻¹) (n, 6) at the quadrature points: its eigenvalues are the principal nominal
        stresses, force per undeformed area.

        cauchy: σ (cells, points, 3, 3). It is Biot's stress sym(Rᵀ P), turned by the rotation R of
        F = V R; where σ and V have the same axes, as in an isotropic material, its eigenvalues are
        J σᵢ/λᵢ.
        """
        f = self.deformation_gradient(state.x)
        return self.at_points("nominal_stress", self.volumes.size, f, cauchy)

    # --- as a body --------------------------------------------------------------------------------

    slackens = False
    smooth = True

    external: Sequence[Term] = ()

    @property
    def elastic(self) -> Sequence[Solid]:
        """See ``Body``."""
        return [self]

    @property
    def slowness(self) -> float:
        """See ``Body``: of shear waves."""
        return self.material.density / self.material.shear_modulus

    @property
    def stiffness(self) -> float:
        """See ``Body``."""
        volume = self.assembler.unknowns.comm.allreduce(float(self.volumes.sum()))
        return self.material.shear_modulus * volume ** (2 / 3)

    def weight(self) -> Weight:
        """See ``Body``."""
        unit = unit_forces(self.assembler, self.cells, self.degree)
        return Weight(self.material.density * unit)

    def inertia(self) -> SolidInertia:
        """See ``Body``."""
        return SolidInertia(self.assembler, self.cells, self.material.density, self.degree)

    def density(self, state: State) -> np.ndarray:
        """Stored energy (n,) MPa but for that of the pressure unknown, at the quadrature points."""

        def find() -> np.ndarray:
            f = self.deformation_gradient(state.x)
            c = self.right_cauchy_green(state.x).reshape(-1, 6)
            return self._density_at(c, self._jacobians(f), state)

        return self._once("density", state.x, find)

    def _density_at(self, c: np.ndarray, jacobian: np.ndarray, state: State) -> np.ndarray:
        """``density`` at C (n, 6) and J (n,)."""
        density = self._stored(c, state) + self._extra_volumetric(jacobian)[0]
        return density if self._mixed else density + self._of_volume(jacobian)

    def _of_volume(self, jacobian: np.ndarray) -> np.ndarray:
        return self.material.bulk_modulus * (jacobian - 1) ** 2 / 2

    def energy(self, state: State) -> float:
        anchor = self._anchor
        density = anchor.density_of(self, state.x) if anchor else self.density(state)
        if self._mixed:
            jacobian = self.pressure_volume(self.hydrostatic_pressure(state.x).ravel())
            excess = self.material.logarithmic_excess(jacobian)[0]
            density = density + excess + self._of_volume(jacobian)
        return float(density @ self.volumes.ravel())
