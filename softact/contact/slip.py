"""Friction between surfaces: slip against the place that was faced at the last equilibrium."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from softact.contact.chain_facets import ChainFacets
from softact.contact.closest import derivatives
from softact.contact.coupling import Coupling
from softact.contact.friction import ELASTIC_SLIP, slide
from softact.contact.memory import remembered
from softact.contact.whole_facets import WholeFacets
from softact.system.term import CONTACT, State

#: Facet, number of a point of it, the facet it faces and the place on that.
Where = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
#: Facet and number of points, their shape functions of the gap vector and their normals.
Faced = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


@dataclass(frozen=True)
class InTouch:
    """Quadrature points in touch (m,): facet, number, the facet they face, the place on it, gap
    (mm), area that counts (mm²), stiffness of the penalty, and ``pressure.pressure`` of the gap."""

    facet: np.ndarray
    point: np.ndarray
    partner: np.ndarray
    place: np.ndarray
    gap: np.ndarray
    area: np.ndarray
    stiffness: np.ndarray
    pressure: np.ndarray
    slope: np.ndarray
    potential: np.ndarray

    @property
    def where(self) -> Where:
        """Facet, number, partner and place on it."""
        return self.facet, self.point, self.partner, self.place

    def of(self, which: np.ndarray) -> InTouch:
        """Those of these numbers."""
        return InTouch(*(getattr(self, f.name)[which] for f in fields(self)))


@dataclass(frozen=True)
class Slipping:
    """Friction at the points ``on`` of those in touch; pairs: own facet and the one faced at the
    last equilibrium; the rest as in ``friction.slide``."""

    on: np.ndarray
    pairs: np.ndarray
    across: np.ndarray
    weight: np.ndarray
    traction: np.ndarray
    modulus: np.ndarray
    gap_derivative: np.ndarray
    elastic: np.ndarray


class SurfaceFriction:
    """Coulomb friction of one ``SurfaceContact``, by the return mapping of ``friction.slide``.

    ``memory[contact name.what]``: partner, place, offset, normal and slip of each quadrature point
    at the last equilibrium, the same on all processes and on any number of them. Points without a
    partner then have no friction yet. ``nodes``: (k, n, 3) where the facets are.
    """

    def __init__(
        self,
        name: str,
        coefficient: float,
        facets: WholeFacets | ChainFacets,
        coupling: Coupling,
    ):
        self._name, self._coefficient = f"{CONTACT}{name}", coefficient
        self._facets, self._coupling = facets, coupling

    def _last(self, state: State, what: str, width: int = 3) -> np.ndarray:
        """What was kept of each quadrature point (k, 12, width), zeros where nothing was."""
        kept = remembered(state, self._name, what)
        return np.zeros((*self._facets.areas.shape, width)) if kept is None else kept

    def pairs(
        self, state: State, facet: np.ndarray, point: np.ndarray, partner: np.ndarray
    ) -> list[np.ndarray]:
        """(m', 3) own facet, partner now and partner at the last equilibrium, where both are; none
        where nothing is remembered."""
        before = remembered(state, self._name, "partner")
        if before is None:
            return []
        old = before[facet, point]
        return [np.column_stack([facet, partner, old])[old >= 0]]

    def at(self, state: State, nodes: np.ndarray, touch: InTouch) -> Slipping:
        """Friction of the points in touch that had a partner at the last equilibrium."""
        old = remembered(state, self._name, "partner")
        if old is None:
            old = np.full(self._facets.areas.shape, -1)
        on = np.flatnonzero(old[touch.facet, touch.point] >= 0)
        facet, point = touch.facet[on], touch.point[on]
        old = old[facet, point]
        place = self._last(state, "place", 2)[facet, point]
        offset, normal, slip = (
            self._last(state, what)[facet, point] for what in ("offset", "normal", "slip")
        )
        values, _, _ = derivatives(place, self._facets.nodes.shape[1])
        across = np.hstack([self._facets.values[point], -values])
        pairs = np.column_stack([facet, old])
        both = nodes[pairs].reshape(*across.shape, 3)
        trial = slip + np.einsum("mn,mnc->mc", across, both) - offset
        limit = ELASTIC_SLIP * self._facets.size[facet]
        found = slide(self._coefficient, touch.pressure[on], touch.slope[on], limit, normal, trial)
        weight = self._facets.counting_areas(facet, point, old)
        return Slipping(on, pairs, across, weight, *found)

    def forces(
        self, state: State, nodes: np.ndarray, touch: InTouch
    ) -> tuple[np.ndarray, np.ndarray]:
        """Pairs (m', 2) of facets, and the forces (m', 2 n, 3) of friction on their nodes."""
        found = self.at(state, nodes, touch)
        weighted = -found.weight[:, None, None] * found.across[:, :, None]
        return found.pairs, weighted * found.traction[:, None]

    def add_tangent(
        self,
        state: State,
        nodes: np.ndarray,
        touch: InTouch,
        across: np.ndarray,
        normal: np.ndarray,
    ) -> None:
        """Add their derivatives. across, normal: of the points in touch, see ``SurfaceContact``."""
        found = self.at(state, nodes, touch)
        on, count = found.on, len(found.on)
        weighted = -found.weight[:, None, None, None] * found.across[:, None, :, None]
        moved = found.across[:, None, :, None] * found.modulus[:, :, None]
        along = (weighted * np.eye(3)[:, None]).reshape(count, 3, -1)
        self._coupling.add(found.pairs, along, moved.reshape(count, 3, -1))
        # The bound follows the pressure, so the traction follows the gap: dt = (dt/dg) dg.
        traction = (weighted * found.gap_derivative[:, None, None]).reshape(count, 1, -1)
        gap_change = (across[on, :, None] * normal[on, None]).reshape(count, 1, -1)
        now = np.column_stack([touch.facet[on], touch.partner[on]])
        self._coupling.add(found.pairs, traction, gap_change, now)

    def remember(
        self,
        state: State,
        nodes: np.ndarray,
        touch: InTouch,
        partner: np.ndarray,
        place: np.ndarray,
        faced: Faced,
    ) -> dict[str, np.ndarray]:
        """What is to be kept of an equilibrium. partner, place: of all quadrature points;
        faced: of those with a partner."""
        shape = self._facets.areas.shape
        slip, offset, normal = np.zeros((3, *shape, 3))
        found = self.at(state, nodes, touch)
        slip[touch.facet[found.on], touch.point[found.on]] = found.elastic
        facet, point, across, normals = faced
        both = np.concatenate([nodes[facet], nodes[partner[facet, point]]], axis=1)
        offset[facet, point] = np.einsum("mn,mnc->mc", across, both)
        normal[facet, point] = normals
        kept = {"slip": slip, "partner": partner, "place": place}
        kept |= {"offset": offset, "normal": normal}
        return {f"{self._name}.{what}": value for what, value in kept.items()}
