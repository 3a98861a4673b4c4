"""Contact of a body with itself and between bodies: a term of the potential energy.

Each quadrature point of a facet looks for the nearest point of the facets that it faces; the
pressure of ``pressure.py`` is a function of that gap. Both sides look at each other and count one
half, so that neither is master. Force and tangent are the exact derivatives, also of the place
that a point faces and of the curvature there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from softact.contact.backs import Backs
from softact.contact.closest import Closest, candidates, derivatives
from softact.contact.coupling import Coupling
from softact.contact.facets import ContactFacets
from softact.contact.friction import STICK, slide
from softact.contact.gap_hessian import gap_hessian
from softact.contact.pressure import pressure
from softact.errors import SpecError

# How far away a partner is looked for, and from which gap on room in the matrix is
# kept for it; of the element size.
REACH, ROOM = 1.0, 0.5
# How deep inside a partner is looked for, of the element size: what is deeper may be on the other
# side of a sheet or of a thin wall.
DEPTH = 0.25
# How far the facets of sheets may move until they look for partners again, of their reach.
SIGHT = 0.5
# What a step of Newton's method may press in on its way, of the element size.
DEEPEST = 0.05
# ... and by how much what overlaps may overlap more.
DEEPER = 1.5
HALF = 0.5


@dataclass(frozen=True)
class Touching:
    """Surfaces that may touch: each other (two groups), or themselves (one).

    groups: one or two tuples of surface names. friction: Coulomb coefficient. distance: gap below
    which they press, mm.
    """

    name: str
    groups: tuple[tuple[str, ...], ...]
    friction: float = 0.0
    distance: float = 0.0


class SurfaceContact:
    """Contact between surfaces that deform. Only for one process.

    ``memory[name.what]``: stiffness (factor); with friction partner, place, offset, normal and
    slip at the last equilibrium.
    """

    rigid = False

    def __init__(self, touching: Touching, model):
        if model.comm.size > 1:
            raise SpecError(f"contact.{touching.name}: runs on one process only; leave out -n")
        self.touching, self.name = touching, touching.name
        self.symmetric = touching.friction == 0
        surfaces = tuple(dict.fromkeys(name for group in touching.groups for name in group))
        self.facets = ContactFacets(model, surfaces)
        self._side = np.full(len(self.facets), -1)
        if len(touching.groups) == 2:
            second = ContactFacets(model, touching.groups[1]).nodes
            self._side = np.isin(self.facets.nodes, second).all(axis=1).astype(int)
        self._closest = Closest(model.comm)
        self.coupling = Coupling(model.assembler, self.facets)
        self._backs = Backs(model, self.facets)
        self._reach = REACH * self.facets.size + touching.distance
        self._depth = DEPTH * self.facets.size - touching.distance
        self._search(np.zeros(model.unknowns.local))
        self._last = (None, None)

    def _memory(self, state, what, default=None):
        return state.memory.get(f"{self.name}.{what}", default)

    def _search(self, x) -> None:
        """Which facets may come to touch before the next equilibrium."""
        nodes = self.facets.node_places(x)
        numbers = self.facets.nodes
        self._candidates = candidates(nodes, numbers, self._side, self._reach, self._backs)
        self._looked_from = nodes

    def gaps(self, x):
        """Partner, place on it and gap (k, 12) of each quadrature point; see ``Closest``."""
        key = x.tobytes()
        if self._last[0] != key:
            places, nodes = self.facets.places(x), self.facets.node_places(x)
            before = None if self._last[1] is None else self._last[1][0]
            reach, depth = self._reach, self._depth
            found = self._closest(places, nodes, *self._candidates, reach, depth, before)
            partner, place, gap = found
            self._last = (key, (partner, place, gap - self.touching.distance))
        return self._last[1]

    def _stiffness(self, state, facet):
        return self.facets.stiffness[facet] * self._memory(state, "stiffness", 1.0)

    def _points(self, state):
        """Quadrature points in touch: their facet, number, partner, place and gap."""
        partner, place, gap = self.gaps(state.x)
        facet, point = np.nonzero(gap < 0)
        return facet, point, partner[facet, point], place[facet, point], gap[facet, point]

    def _pressures(self, state, facet, gap):
        stiffness = self._stiffness(state, facet)
        return stiffness, *pressure(gap, stiffness, self.facets.onset[facet])

    def _geometry(self, state, facet, point, partner, place):
        """Values (m, 2 n) of the shape functions of the gap vector (own nodes, then minus the
        partner's), tangents (m, 2, 3), normal (m, 3), derivatives, second derivatives."""
        nodes = self.facets.node_places(state.x)[partner]
        values, first, second = derivatives(place, nodes.shape[1])
        across = np.hstack([self.facets.values[point], -values])
        tangents = np.einsum("man,mnc->mac", first, nodes)
        normal = np.cross(tangents[:, 0], tangents[:, 1])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        bend = np.einsum("kn,mnc,mc->mk", second, nodes, normal)
        return across, tangents, normal, first, bend

    def add_force(self, state, out):
        facet, point, partner, place, gap = self._points(state)
        if not len(facet):
            return
        _, p, slope, _ = self._pressures(state, facet, gap)
        across, _, normal, _, _ = self._geometry(state, facet, point, partner, place)
        push = HALF * self.facets.areas[facet, point] * p
        forces = -push[:, None, None] * across[:, :, None] * normal[:, None]
        dofs = np.hstack([self.facets.dofs[facet], self.facets.dofs[partner]])
        out += np.bincount(dofs.ravel(), forces.ravel(), len(out))
        if self.touching.friction:
            found = self._friction(state, facet, point, gap, p, slope)
            forces = -found.weight[:, None, None] * found.across[:, :, None]
            forces = forces * found.traction[:, None]
            dofs = self.facets.dofs[found.pairs].reshape(forces.shape)
            out += np.bincount(dofs.ravel(), forces.ravel(), len(out))

    def add_tangent(self, state, origin):
        self._make_room(state)
        facet, point, partner, place, gap = self._points(state)
        if not len(facet):
            return
        _, p, slope, _ = self._pressures(state, facet, gap)
        across, tangents, normal, first, bend = self._geometry(state, facet, point, partner, place)
        weight = HALF * self.facets.areas[facet, point]
        matrices = gap_hessian(
            gap, across, tangents, normal, first, bend, weight * slope, -weight * p
        )
        self.coupling.add(np.column_stack([facet, partner]), matrices)
        if self.touching.friction:
            self._add_friction_tangent(state, facet, point, partner, gap, across, normal, p, slope)

    def _make_room(self, state):
        """Keep room in the matrix for what touches or nearly does."""
        partner, _, gap = self.gaps(state.x)
        facet, point = np.nonzero(gap < ROOM * self.facets.size[:, None])
        pairs = [np.column_stack([facet, partner[facet, point]])]
        if self.touching.friction and self._memory(state, "partner") is not None:
            pairs.append(self._old_pairs(state, facet, point, partner[facet, point]))
        self.coupling.make_room(pairs)

    def energy(self, state):
        facet, point, _, _, gap = self._points(state)
        _, _, _, potential = self._pressures(state, facet, gap)
        return float(HALF * self.facets.areas[facet, point] @ potential)

    # --- friction ---------------------------------------------------------------------------

    def _old_pairs(self, state, facet, point, partner):
        """(m', 3) own facet, partner now and partner at the last equilibrium, where both are."""
        old = self._memory(state, "partner")[facet, point]
        return np.column_stack([facet, partner, old])[old >= 0]

    def _friction(self, state, facet, point, gap, p, slope) -> Slipping:
        """Friction of the points in touch that had a partner at the last equilibrium."""
        old = self._memory(state, "partner")
        if old is None:
            old = np.full(self.facets.areas.shape, -1)
        on = np.flatnonzero(old[facet, point] >= 0)
        facet, point = facet[on], point[on]
        old = old[facet, point]
        if len(on):
            then = [self._memory(state, w) for w in ("place", "offset", "normal", "slip")]
            place, offset, normal, slip = (array[facet, point] for array in then)
        else:
            place, (offset, normal, slip) = np.zeros((0, 2)), np.zeros((3, 0, 3))
        values, _, _ = derivatives(place, self.facets.nodes.shape[1])
        across = np.hstack([self.facets.values[point], -values])
        pairs = np.column_stack([facet, old])
        nodes = self.facets.node_places(state.x)[pairs].reshape(*across.shape, 3)
        trial = slip + np.einsum("mn,mnc->mc", across, nodes) - offset
        stick = STICK * self._stiffness(state, facet)
        found = slide(self.touching.friction, p[on], slope[on], stick, normal, trial)
        weight = HALF * self.facets.areas[facet, point]
        return Slipping(on, pairs, across, weight, *found)

    def _add_friction_tangent(self, state, facet, point, partner, gap, across, normal, p, slope):
        found = self._friction(state, facet, point, gap, p, slope)
        weight = -found.weight[:, None, None, None, None]
        left = found.across[:, :, None, None, None]
        direct = weight * left * found.modulus[:, None, :, None]
        self.coupling.add(found.pairs, direct * found.across[:, None, None, :, None])
        # The bound follows the pressure, so the traction follows the gap: dt = (dt/dg) dg.
        on = found.on
        by_gap = found.by_gap[:, None, :, None, None] * normal[on][:, None, None, None]
        now = np.column_stack([facet[on], partner[on]])
        matrices = weight * left * by_gap * across[on][:, None, None, :, None]
        self.coupling.add(found.pairs, matrices, now)

    def remember(self, state) -> dict[str, np.ndarray]:
        """Memory of this equilibrium; also looks for what may touch next."""
        self.resume(state)
        if not self.touching.friction:
            return {}
        shape = self.facets.areas.shape
        slip = np.zeros((*shape, 3))
        facet, point, partner, _, gap = self._points(state)
        if len(facet):
            _, p, slope, _ = self._pressures(state, facet, gap)
            found = self._friction(state, facet, point, gap, p, slope)
            slip[facet[found.on], point[found.on]] = found.elastic
        partner, place, _ = self.gaps(state.x)
        facet, point = np.nonzero(partner >= 0)
        geometry = (facet, point, partner[facet, point], place[facet, point])
        across, _, normals, _, _ = self._geometry(state, *geometry)
        nodes = self.facets.node_places(state.x)
        nodes = np.concatenate([nodes[facet], nodes[partner[facet, point]]], axis=1)
        offset, normal = np.zeros((*shape, 3)), np.zeros((*shape, 3))
        offset[facet, point] = np.einsum("mn,mnc->mc", across, nodes)
        normal[facet, point] = normals
        found = {"slip": slip, "partner": partner, "place": place}
        found |= {"offset": offset, "normal": normal}
        return {f"{self.name}.{what}": value for what, value in found.items()}

    def pressed(self, state) -> tuple[np.ndarray, np.ndarray]:
        """Normal (m,) and tangential (m, 3) forces at the quadrature points in touch, N; only
        those with a partner at the last equilibrium, for the others have no friction yet."""
        facet, point, _, _, gap = self._points(state)
        _, p, slope, _ = self._pressures(state, facet, gap)
        found = self._friction(state, facet, point, gap, p, slope)
        return found.weight * p[found.on], found.weight[:, None] * found.traction

    def resume(self, state) -> None:
        """See ``Contacts.resume``: looks for what may touch next."""
        self._search(state.x)
        self._last = (None, None)

    # --- limits -----------------------------------------------------------------------------

    def presence(self, state) -> float:
        """1: surfaces are always there."""
        return 1.0

    def admissible(self, state, x, to) -> bool:
        """Whether Newton may go from ``x`` to ``to``: no point so deep that it is lost."""
        partner, place, now = self.gaps(x)
        facet, point = np.nonzero(partner >= 0)
        other = partner[facet, point], place[facet, point]
        moved = self.facets.node_places(to)
        values, first, _ = derivatives(other[1], moved.shape[1])
        mine = np.einsum("mn,mnc->mc", self.facets.values[point], moved[facet])
        theirs = np.einsum("mn,mnc->mc", values, moved[other[0]])
        a, b = np.moveaxis(np.einsum("man,mnc->mac", first, moved[other[0]]), 1, 0)
        normal = np.cross(a, b)
        then = np.einsum("mc,mc->m", mine - theirs, normal) / np.linalg.norm(normal, axis=1)
        lowest = np.minimum(DEEPER * now[facet, point], -DEEPEST * self.facets.size[facet])
        return bool((then - self.touching.distance >= lowest).all())

    def strayed(self, state) -> float:
        """How far sheets have moved since they looked for what they may touch, by how far they may
        without passing it unseen."""
        thin = self.facets.of_sheet
        way = self.facets.node_places(state.x)[thin] - self._looked_from[thin]
        moved = np.linalg.norm(way, axis=2) / (SIGHT * self._reach[thin, None])
        return float(moved.max(initial=0.0))

    def smallest_gap(self, state) -> tuple[float, float]:
        """Smallest gap, and its smallest ratio to the element size (both below zero: overlap)."""
        _, _, gap = self.gaps(state.x)
        ratio = gap / self.facets.size[:, None]
        return float(gap.min(initial=np.inf)), float(ratio.min(initial=np.inf))


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
    by_gap: np.ndarray
    elastic: np.ndarray
