"""Thin layers bonded to surfaces of a solid, without elements of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from softact.bodies.membrane import BondedMembrane, Membrane
from softact.bodies.plate import LayerBending, is_flat
from softact.materials.plane_stress import GreenLaw
from softact.materials.tension_field import KEPT_BONDED, relaxed
from softact.mesh.triangles import Triangles
from softact.system.term import Layer, Weight


@dataclass(frozen=True)
class BondedLayer:
    """A thin layer on a surface: its material (see ``softact.system.term.Layer``), thickness in mm.

    bending: part of a plate's bending stiffness E t³/12(1 − ν²); a woven fabric has little of it.
    relaxed: whether fine wrinkles take its compression (``softact.materials.tension_field``); None:
    where it has no bending stiffness.
    """

    surface: str
    material: object
    thickness: float
    bending: float = 1.0
    relaxed: bool | None = None


class BondedLayers:
    """The bonded layers of a model, in order, and their terms of the potential energy.

    membranes: a term for each layer. bending: terms of those that have bending stiffness.
    """

    def __init__(self, model, layers: Sequence[BondedLayer]):
        self._model, self._all = model, tuple(layers)
        terms = [(layer, self._bending(layer)) for layer in layers]
        self._bent = [layer for layer, term in terms if term is not None]
        self.bending = [term for _, term in terms if term is not None]
        self.membranes = [self._membrane(layer) for layer in layers]

    def __iter__(self):
        return iter(self._all)

    def bends(self, layer: BondedLayer) -> bool:
        """Whether the layer has bending stiffness."""
        return layer in self._bent

    def wrinkles(self, layer: BondedLayer) -> bool:
        """Whether fine wrinkles take the compression of the layer."""
        return not self.bends(layer) if layer.relaxed is None else layer.relaxed

    @property
    def slacken(self) -> bool:
        """Whether one of them can go slack."""
        return any(map(self.wrinkles, self._all))

    @property
    def elastic(self) -> list:
        """Terms of their stored energy."""
        return [*self.membranes, *self.bending]

    def weights(self) -> list[Weight]:
        """Weights of the layers that have a density."""
        model = self._model
        return [
            Weight(la.material.density * la.thickness * model.unit_forces(la.surface))
            for la in self._all
            if la.material.density
        ]

    def _bending(self, layer: BondedLayer) -> LayerBending | None:
        """The layer's bending term, None where it has none (see the docs)."""
        model = self._model
        nodes = model.surfaces.facet_nodes(model.surfaces.facets(layer.surface))
        everywhere = np.concatenate(model.comm.allgather(model.nodes.places[nodes].reshape(-1, 3)))
        if not layer.bending or model.degree != 2 or not is_flat(everywhere):
            return None
        young, poisson = layer.material.youngs_modulus, layer.material.poissons_ratio
        rigidity = layer.bending * young * layer.thickness**3 / (12 * (1 - poisson**2))
        planes = tuple(model.mesh.layout.symmetry.values())
        return LayerBending(model.assembler, model.nodes, nodes, rigidity, poisson, planes)

    def _membrane(self, layer: BondedLayer) -> Layer | Membrane:
        model, material = self._model, layer.material
        facets = model.surfaces.facets(layer.surface)
        if not self.wrinkles(layer):
            return Layer(model.assembler, facets, material, layer.thickness, model.degree)
        nodes = model.surfaces.facet_nodes(facets)
        table = model.assembler.add_table(model.nodes.blocks[nodes])
        places, dofs = model.nodes.places[nodes], model.nodes.dofs[nodes]
        triangles = Triangles(nodes, places, dofs, table)
        law = GreenLaw(material.youngs_modulus, material.poissons_ratio)
        frames = triangles.frames(np.array([1.0, 0.0, 0.0]))
        relaxed_law = relaxed(law, material.poissons_ratio, KEPT_BONDED)
        return BondedMembrane(triangles, frames, [(relaxed_law, layer.thickness)])
