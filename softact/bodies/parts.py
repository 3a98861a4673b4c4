"""Parts of a model's solids: the cells at chosen nodes, for what is asked there alone."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING

import numpy as np

from softact.bodies.remembering import RememberingSolid
from softact.system.term import State

if TYPE_CHECKING:
    from softact.model import Model


class Parts:
    """Parts of the solids of a model."""

    def __init__(self, model: Model):
        self._model = model
        self._held: tuple[tuple[str, ...], dict[str, np.ndarray]] | None = None

    @functools.cached_property
    def nodes(self) -> dict[str, np.ndarray]:
        """Nodes (k,) of each solid that this process holds."""
        model = self._model
        return {name: np.unique(model.cell_nodes[s.cells]) for name, s in model.solids.items()}

    def cells_at(self, nodes: np.ndarray) -> dict[str, np.ndarray]:
        """Of each solid the cells (k,), numbers among its own, that have one of these nodes."""
        model = self._model
        is_one = np.zeros(len(model.displacement_dofs), dtype=bool)
        is_one[nodes] = True
        return {
            name: np.flatnonzero(is_one[model.cell_nodes[solid.cells]].any(axis=1))
            for name, solid in model.solids.items()
        }

    def force_at_supports(self, state: State) -> np.ndarray:
        """The out-of-balance force (local,) N of ``Model.force``, right at the points of supports
        alone: cells of solids that have none of these are left out."""
        model = self._model
        if model.repeat:
            return model.force(state)[0]
        surfaces = tuple(dict.fromkeys(support.surface for support in model.supports))
        if self._held is None or self._held[0] != surfaces:
            nodes = [model.surfaces.nodes(surface) for surface in surfaces]
            self._held = surfaces, self.cells_at(np.concatenate([np.empty(0, int), *nodes]))
        parts = {
            id(solid): solid.part(self._held[1][name])
            for name, solid in model.solids.items()
            if not isinstance(solid, RememberingSolid)
        }
        return model.sum_of_forces(state, [parts.get(id(term), term) for term in model.elastic])[0]
