"""The air of one module of a chain, whose cavity goes on into its neighbours.

The walls leave the cavity open at both faces. A rigid motion takes the left opening to the right
one (``softact.bodies.repeat``). What closes both adds ⅓ v · a to the volume, whatever its shape:
a = ½ ∮ x × dx is the area vector of the left opening, and v = Rᵀ (c + t) − c. The derivative by ω
and t is the thrust on the cross-section.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.loads.cavity_pressure import CavityPressure
from softact.loads.sheet_cavity import SheetCavity
from softact.system.rotation import RotationVector, cross_with
from softact.system.term import Origin, State

if TYPE_CHECKING:
    from softact.bodies.repeat import Repeat
    from softact.model import Model

# ∫ N_a N_b' along an edge, of which only what changes its sign with a and b counts: straight edges
# (ends), quadratic ones (ends, middle).
STRAIGHT = np.array([[0.0, 1.0], [-1.0, 0.0]]) / 2
QUADRATIC = np.array([[0.0, -1.0, 4.0], [1.0, 0.0, -4.0], [-4.0, 4.0, 0.0]]) / 6
EDGES = {3: [[0, 1], [1, 2], [2, 0]], 6: [[0, 1, 3], [1, 2, 4], [2, 0, 5]]}  # of a facet


class Opening:
    """The rim of the walls of a cavity in a face. dofs: (n, 3) of its nodes. weights: (n, n) w.

    walls: (m, n) nodes of facets, whose normals point into the air. face: nodes of the face.
    """

    def __init__(self, model: Model, walls: np.ndarray, face: np.ndarray):
        rim = _rim(walls, face)
        nodes, at = np.unique(rim, return_inverse=True)
        self._places, self.dofs = model.nodes.places[nodes], model.displacement_dofs[nodes]
        self.weights = np.zeros((len(nodes), len(nodes)))
        for edge in at.reshape(rim.shape):
            self.weights[np.ix_(edge, edge)] += STRAIGHT if len(edge) == 2 else QUADRATIC

    def at(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Places (n, 3) of the rim's nodes, and Σ_b w_ab x_b (n, 3)."""
        places = self._places + x[self.dofs]
        return places, self.weights @ places


def area_vector(places: np.ndarray, partners: np.ndarray) -> np.ndarray:
    """a (3,), mm², of an ``Opening``."""
    return np.cross(places, partners).sum(axis=0) / 2


class RepeatedCavity:
    """A cavity's volume and pressure; for one process. Offers what ``CavityPressure`` does.

    walls: what they enclose without their openings. nodes: (m, n) of the walls, see ``Opening``.
    """

    def __init__(
        self, model: Model, repeat: Repeat, walls: CavityPressure | SheetCavity, nodes: np.ndarray
    ):
        self.name, self._walls, self._repeat = walls.name, walls, repeat
        self._assembler = model.assembler
        left = model.surfaces.nodes(repeat.faces.left)
        self._opening = Opening(model, nodes, left)
        self._dofs, self._weights = self._opening.dofs, self._opening.weights
        self._all = np.concatenate([self._dofs.ravel(), repeat.dofs])
        size = len(self._all)
        self._slots = model.assembler.couple(np.repeat(self._all, size), np.tile(self._all, size))

    def _across(self, x: np.ndarray) -> tuple[RotationVector, np.ndarray, np.ndarray]:
        """R, c + t and v."""
        rotation = self._repeat.turned(x)
        end = self._repeat.centre + self._repeat.motion(x)[1]
        return rotation, end, end @ rotation.matrix - self._repeat.centre

    def volume(self, x: np.ndarray) -> float:
        """Volume of the module's air, mm³."""
        places, partners = self._opening.at(x)
        area = area_vector(places, partners)
        return self._walls.volume(x) + float(self._across(x)[2] @ area) / 3

    def _first(self, x: np.ndarray) -> np.ndarray:
        """Derivative of the closing volume by the rim's nodes, ω and t, flat."""
        places, partners = self._opening.at(x)
        rotation, end, v = self._across(x)
        area = area_vector(places, partners)
        turns = np.einsum("a,iab,b->i", end, rotation.first, area)
        parts = [np.cross(partners, v).ravel(), turns, rotation.matrix @ area]
        return np.concatenate(parts) / 3 * self._scale

    @property
    def _scale(self) -> np.ndarray:
        return np.concatenate([np.ones(self._dofs.size), self._repeat.scale])

    def _second(self, x: np.ndarray) -> np.ndarray:
        """The second derivative."""
        places, partners = self._opening.at(x)
        rotation, end, v = self._across(x)
        area = area_vector(places, partners)
        n = self._dofs.size
        found = np.zeros((n + 6, n + 6))
        found[:n, :n] = np.einsum("ab,ij->aibj", self._weights, -cross_with(v)).reshape(n, n)
        by_v = cross_with(partners).reshape(n, 3)
        found[:n, n : n + 3] = by_v @ np.einsum("a,iab->bi", end, rotation.first)
        found[:n, n + 3 :] = by_v @ rotation.matrix.T
        found[n : n + 3, n : n + 3] = np.einsum("a,ijab,b->ij", end, rotation.second, area)
        found[n : n + 3, n + 3 :] = np.einsum("iab,b->ia", rotation.first, area)
        found[n:, :n] = found[:n, n:].T
        found[n + 3 :, n : n + 3] = found[n : n + 3, n + 3 :].T
        return found / 3 * np.outer(self._scale, self._scale)

    def add_volume_gradient(self, x: np.ndarray, factor: float, out: np.ndarray) -> None:
        """Add ``factor`` times the derivative of the volume by the module's unknowns to ``out``
        (local,)."""
        raw = np.zeros_like(out)
        self._walls.add_volume_gradient(x, factor, raw)
        np.add.at(raw, self._all, factor * self._first(x))
        out += self._repeat.condense(x, raw)

    def _pressure(self, state: State) -> float:
        return float(state["pressure"].get(self.name, 0.0))

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        self._walls.add_force(state, out)
        if pressure := self._pressure(state):
            np.add.at(out, self._all, -pressure * self._first(state.x))

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        self._walls.add_tangent(state, origin)
        if pressure := self._pressure(state):
            free = self._assembler.fixed[self._all] == 0
            values = self._second(state.x) * np.outer(free, free)
            self._assembler.extra_values[self._slots] -= pressure * values.ravel()

    def energy(self, state: State) -> float:
        """See ``Term``."""
        return -self._pressure(state) * self.volume(state.x)


def _rim(facets: np.ndarray, face: np.ndarray) -> np.ndarray:
    """Edges (k, 2 or 3) of facets (m, n) that lie in a face, one way round; none between two."""
    edges = facets[:, EDGES[facets.shape[1]]].reshape(-1, 3 if facets.shape[1] == 6 else 2)
    edges = edges[np.isin(edges, face).all(axis=1)]
    ends = np.sort(edges[:, :2], axis=1)
    _, at, counts = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    edges = edges[counts[at.ravel()] == 1]
    edges[:, :2] = edges[:, 1::-1]  # round the opening, whose normal is that of the module
    return edges
