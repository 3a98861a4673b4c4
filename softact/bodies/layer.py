"""Thin layers bonded to surfaces of a solid, without elements of their own."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.bodies.compiled_sheet_law import relaxed
from softact.bodies.inertia import SheetInertia
from softact.bodies.membrane import BondedMembrane, Membrane
from softact.bodies.plate import LayerBending, is_flat
from softact.bodies.remembering import RememberingLayer
from softact.bodies.weight import Weight
from softact.errors import SpecError
from softact.materials.laws.linear import Linear
from softact.materials.plane_stress import GreenLaw
from softact.materials.tension_field import KEPT_BONDED
from softact.mesh.triangles import Triangles
from softact.system import forms
from softact.system.kernels import Coefficient, Kernel
from softact.system.term import FUNCTIONS, Origin, State

if TYPE_CHECKING:
    from softact.model import Model
    from softact.system.assembly import Assembler
    from softact.system.term import Term


@dataclass(frozen=True)
class BondedLayer:
    """A thin layer on a surface: its material (see ``LayerMembrane``), thickness in mm.

    bending: part of a plate's bending stiffness E t³/12(1 − ν²); a woven fabric has little of it.
    relaxed: whether fine wrinkles take its compression (``softact.materials.tension_field``); None:
    where it has no bending stiffness.
    """

    surface: str
    material: Linear
    thickness: float
    bending: float = 1.0
    relaxed: bool | None = None


class Layer:
    """A bonded layer as a body: a membrane and, where it is flat, a plate.

    made_of: see ``BondedLayer``. bending: term of its bending energy, None where it has none.
    """

    slowness = 0.0  # the solid below decides
    external: Sequence[Term] = ()

    def __init__(self, model: Model, made_of: BondedLayer):
        self._model, self.made_of = model, made_of
        self.bending = self._bending()
        self.membrane = self._membrane()

    @property
    def surface(self) -> str:
        """Name of the surface that it covers."""
        return self.made_of.surface

    @property
    def wrinkles(self) -> bool:
        """Whether fine wrinkles take its compression."""
        return self.bending is None if self.made_of.relaxed is None else self.made_of.relaxed

    @property
    def slackens(self) -> bool:
        """See ``Body``."""
        return self.wrinkles

    @property
    def smooth(self) -> bool:
        """See ``Body``."""
        return not self.wrinkles

    @property
    def elastic(self) -> Sequence[Term]:
        """See ``Body``."""
        return [self.membrane, self.bending] if self.bending is not None else [self.membrane]

    @property
    def stiffness(self) -> float:
        """See ``Body``: the solid below decides."""
        return 0.0

    def weight(self) -> Weight | None:
        """See ``Body``."""
        density = self.made_of.material.density
        if not density:
            return None
        return Weight(density * self.made_of.thickness * self._model.unit_forces(self.surface))

    def inertia(self) -> SheetInertia | None:
        """See ``Body``."""
        density = self.made_of.material.density
        return SheetInertia(self._triangles, density * self.made_of.thickness) if density else None

    @functools.cached_property
    def _triangles(self) -> Triangles:
        model = self._model
        nodes = model.surfaces.facet_nodes(model.surfaces.facets(self.surface))
        table = model.assembler.add_table(model.nodes.blocks[nodes])
        return Triangles(nodes, model.nodes.places[nodes], model.nodes.dofs[nodes], table)

    def smallest_stress(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Undeformed areas (k,) mm² and smallest principal stresses (k,) MPa of this process's
        triangles with straight edges, of the layer as it is without wrinkles."""
        model = self._model
        nodes = model.surfaces.facet_nodes(model.mesh.facets[self.surface])[:, :3]
        before = model.nodes.places[nodes]
        after = before + x[model.displacement_dofs[nodes]]
        edges, moved = before[:, 1:] - before[:, :1], after[:, 1:] - after[:, :1]
        metric = edges @ np.swapaxes(edges, 1, 2)
        # Principal values of the Green strain: eigenvalues of G⁻¹ (g − G)/2, both metrics in edges.
        change = np.linalg.inv(metric) @ (moved @ np.swapaxes(moved, 1, 2) - metric) / 2
        trace, det = np.trace(change, axis1=1, axis2=2), np.linalg.det(change)
        gap = np.sqrt(np.maximum(trace**2 / 4 - det, 0.0))
        small, large = trace / 2 - gap, trace / 2 + gap
        nu = self.made_of.material.poissons_ratio
        stress = self.made_of.material.youngs_modulus / (1 - nu**2) * (small + nu * large)
        return np.sqrt(np.linalg.det(metric)) / 2, stress

    def wrinkling_stress(self) -> float:
        """MPa at which a film on a thick solid wrinkles, ¼ (3 Eₛ/E)^(2/3) E of the moduli in plane
        strain (Bowden et al. 1998, Nature 393:146); the solid is the stiffest of the model."""
        material = self.made_of.material
        film = material.youngs_modulus / (1 - material.poissons_ratio**2)
        shear = max(solid.material.shear_modulus for solid in self._model.solids.values())
        return float(0.25 * (3 * 4 * shear / film) ** (2 / 3) * film)

    def _bending(self) -> LayerBending | None:
        """The layer's bending term, None where it has none (see the docs)."""
        model, layer = self._model, self.made_of
        nodes = model.surfaces.facet_nodes(model.surfaces.facets(layer.surface))
        everywhere = np.concatenate(model.comm.allgather(model.nodes.places[nodes].reshape(-1, 3)))
        if not layer.bending or model.degree != 2 or not is_flat(everywhere):
            return None
        young, poisson = layer.material.youngs_modulus, layer.material.poissons_ratio
        rigidity = layer.bending * young * layer.thickness**3 / (12 * (1 - poisson**2))
        planes = tuple(model.mesh.layout.symmetry.values())
        return LayerBending(model.assembler, model.nodes, nodes, rigidity, poisson, planes)

    def _membrane(self) -> LayerMembrane | Membrane:
        model, layer, material = self._model, self.made_of, self.made_of.material
        facets = model.surfaces.facets(layer.surface)
        if not self.wrinkles and not material.remembers:
            return LayerMembrane(model.assembler, facets, material, layer.thickness, model.degree)
        triangles = self._triangles
        law = GreenLaw(material.youngs_modulus, material.poissons_ratio)
        if material.remembers:
            if self.wrinkles:
                raise SpecError(
                    f"layer on '{layer.surface}': without bending stiffness fine wrinkles take its "
                    "compression, and they remember nothing: write wrinkling: resolved"
                )
            plies = [(material, law, layer.thickness)]
            name, along = f"layer {layer.surface}", np.array([1.0, 0.0, 0.0])
            return RememberingLayer(name, triangles, along, plies, model.comm)
        relaxed_law = relaxed(law, material.poissons_ratio, KEPT_BONDED)
        return BondedMembrane(
            triangles, np.array([1.0, 0.0, 0.0]), [(relaxed_law, layer.thickness)]
        )


class LayerMembrane:
    """Membrane energy of a thin elastic sheet bonded to a surface.

    material: St. Venant-Kirchhoff with ``youngs_modulus`` (MPa), ``poissons_ratio``, ``density``
    (tonne/mm³); thickness in mm.
    """

    def __init__(
        self,
        assembler: Assembler,
        facets: np.ndarray,
        material: Linear,
        thickness: float,
        degree: int,
    ):
        self._size = 3 * FUNCTIONS[degree]
        self._table = assembler.unknowns.cell_dofs
        stiffness = material.youngs_modulus * thickness / (1 - material.poissons_ratio**2)
        self._constants = [stiffness, material.poissons_ratio]
        self._energy, self._force, self._tangent = (
            Kernel(assembler, k, facets) for k in assembler.kernels("layer", degree)
        )

    def _u(self, x: np.ndarray) -> Coefficient:
        return Coefficient(x, self._size, self._table)

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        self._force.add_vector(out, self._size, [self._u(state.x)], self._constants)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        origin = origin or Origin((state.x,))
        states = [*origin.states, *[state.x] * (forms.LAYER_STATES - len(origin.states))]
        weights = [*origin.weights, *[0.0] * (forms.LAYER_STATES - len(origin.weights))]
        self._tangent.add_matrix(
            self._size,
            [self._u(x) for x in (state.x, *states)],
            [*self._constants, *weights, float(origin.linearised)],
        )

    def energy(self, state: State) -> float:
        """See ``Term``."""
        return self._energy.scalar([self._u(state.x)], self._constants)


def build(model: Model, parts: Sequence[BondedLayer]) -> list[Layer]:
    """The layers of a model, see ``BodyKind``."""
    return [Layer(model, layer) for layer in parts]
