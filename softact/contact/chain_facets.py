"""Facets of one module of a chain, and their images in the modules before and after it.

What a module touches may be a part of its neighbour: itself where the chain's motion takes it
(``softact.bodies.repeat``). The points of the module's own facets look about, the images are only
looked at. A pair of facets in two modules then counts once for each module: the point of the one
in this module that faces the image of the other, and the point of the other in this module that
faces the image of the one.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.contact.facets import Facets, sums_at
from softact.contact.whole_facets import WholeFacets

if TYPE_CHECKING:
    from softact.model import Model


class ChainFacets(Facets):
    """Those of a module first, then those of its images, module after module; for one process.

    Nodes on the right face are the images of those on the left one, so that facets on both sides of
    a face have their nodes there in common. nodes: (k, n) numbers of nodes among ``count``;
    numbers: (count,) of what they are images of, in the whole model. own: how many of them are the
    module's, the first ones, with the unknowns dofs (own, 3); images: the others. share, mine: see
    ``WholeFacets``, the module's own facets.
    """

    def __init__(self, own: WholeFacets, model: Model, around: int):
        """around: how many modules before and as many after are looked at."""
        assert model.repeat is not None  # it is a module
        self._module, self._repeat = own, model.repeat
        modules = _module(np.arange(2 * around + 1))
        points = own.points + model.repeat.pitch * modules[:, None, None, None]
        kind = (np.tile(each, len(modules)) for each in (own.modulus, own.of_sheet, own.covering))
        super().__init__(points.reshape(-1, *own.points.shape[1:]), *kind)
        self.mine = np.arange(len(self)) < len(own)
        self.share = np.flatnonzero(self.mine)
        self._number(model, own.numbers[own.nodes], modules)

    def _number(self, model: Model, nodes: np.ndarray, modules: np.ndarray) -> None:
        """Number the nodes, the module's own first. nodes: (m, n) of its own facets in the model.
        modules: (p,) in which the facets are."""
        repeat, count = self._repeat, len(model.nodes.places)
        base = np.arange(count)
        base[repeat.right_nodes] = repeat.left_nodes
        in_next = base[nodes] != nodes
        keys = _place(modules[:, None, None] + in_next) * count + base[nodes]
        known, inverse = np.unique(keys, return_inverse=True)
        self.nodes, self.count = inverse.reshape(-1, nodes.shape[1]), len(known)
        place, self.numbers = np.divmod(known, count)
        self.own = int((place == 0).sum())
        mine, others = np.split(self.numbers, [self.own])
        self._rest, self.dofs = model.nodes.places[mine], model.displacement_dofs[mine]
        self.images = repeat.images(others, _module(place[self.own :]))

    def node_places(self, x: np.ndarray) -> np.ndarray:
        """Deformed places (k, n, 3) of the nodes, mm. x: (local,) unknowns."""
        images = self._repeat.centre + self.images.places(x)
        return np.concatenate([self._rest + x[self.dofs], images])[self.nodes]

    def any_of(self, here: bool) -> bool:
        """See ``WholeFacets``."""
        return here

    def all_among(self, others: WholeFacets) -> np.ndarray:
        """See ``WholeFacets``."""
        return np.tile(self._module.all_among(others), len(self) // len(self._module))

    def from_shares(self, found: np.ndarray) -> np.ndarray:
        """Values (k, ...) of all facets from those (m, ...) of the module's own; the images face
        nothing."""
        nothing = -1 if np.issubdtype(found.dtype, np.integer) else np.inf
        whole = np.full((len(self), *found.shape[1:]), nothing, found.dtype)
        whole[self.share] = found
        return whole

    def at_nodes(self, nodes: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """See ``WholeFacets``."""
        return sums_at(nodes, forces, self.count)

    def add_forces(self, x: np.ndarray, sums: np.ndarray, out: np.ndarray) -> None:
        """See ``WholeFacets``: those on images act on the module's own nodes, and on the chain's
        motion."""
        out[self.dofs] += sums[: self.own]
        self.images.pull(x, sums[self.own :], out)

    def sums_at_nodes(self, values: np.ndarray, count: int) -> np.ndarray:
        """See ``Facets``: of the module's own facets."""
        return self._module.sums_at_nodes(values[self.share], count)


def _place(module: np.ndarray) -> np.ndarray:
    """0, 1, 2, 3, 4 and so on of the modules 0, 1, −1, 2, −2."""
    return 2 * np.abs(module) - (module > 0)


def _module(place: np.ndarray) -> np.ndarray:
    """The other way round."""
    return np.where(place % 2, 1, -1) * ((place + 1) // 2)
