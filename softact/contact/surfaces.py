"""Contact of a body with itself and between bodies: a term of the potential energy.

Each quadrature point of a facet looks for the nearest point of the facets that it faces; the
pressure of ``pressure.py`` is a function of that gap. Both sides look at each other and count one
half, so that neither is master. Force and tangent are the exact derivatives, also of the place
that a point faces and of the curvature there. On several processes each looks after the points of
some facets and knows them all, see ``whole_facets``; all methods are collective.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.backs import Backs
from softact.contact.chain_coupling import ChainCoupling
from softact.contact.chain_facets import ChainFacets
from softact.contact.closest import Closest, candidates, derivatives, neighbours
from softact.contact.coupling import Coupling, NodeCoupling
from softact.contact.crossing import Crossing
from softact.contact.gap_hessian import gap_hessian
from softact.contact.memory import stiffness_factor
from softact.contact.pressure import pressure
from softact.contact.sight import Sight
from softact.contact.slip import InTouch, SurfaceFriction, Where
from softact.contact.whole_facets import WholeFacets
from softact.system.term import Origin, State

if TYPE_CHECKING:
    from softact.contact.base import Contact
    from softact.contact.facets import Facets
    from softact.contact.rigid import Obstacle
    from softact.model import Model

Partners = tuple[np.ndarray, np.ndarray, np.ndarray]

# How far away a partner is looked for, and from which gap on room in the matrix is
# kept for it; of the element size.
REACH, ROOM = 1.0, 0.5
# How deep inside a partner is looked for, of the element size: what is deeper may be on the other
# side of a sheet or of a thin wall.
DEPTH = 0.25
# What a step of Newton's method may press in on its way, of the element size.
DEEPEST = 0.05
# ... and by how much what overlaps may overlap more.
DEEPER = 1.5


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


@dataclass(frozen=True)
class _Seen:
    """What was found for facets at the places ``nodes`` (k, n, 3) mm."""

    nodes: np.ndarray
    partners: Partners


def _pressed(
    touch: InTouch, across: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (m, 2) of facets in touch and the derivatives (m, 2 n, 3) of the energy of their
    pressure by the places of their nodes, N. across, normal: see ``SurfaceContact``."""
    push = touch.area * touch.pressure
    forces = -push[:, None, None] * across[:, :, None] * normal[:, None]
    return np.column_stack([touch.facet, touch.partner]), forces


def _nothing(gap: np.ndarray) -> Partners:
    """What points face where they face nothing; gap: (k, 12) of as many."""
    return np.full(gap.shape, -1, np.int32), np.zeros((*gap.shape, 2)), np.full(gap.shape, np.inf)


class SurfaceContact:
    """Contact between surfaces that deform.

    friction: None where there is none.
    """

    obstacle: Obstacle | None = None

    def __init__(self, touching: Touching, model: Model):
        self.touching, self.name = touching, touching.name
        self.symmetric = touching.friction == 0
        surfaces = tuple(dict.fromkeys(name for group in touching.groups for name in group))
        self.facets = self._of_chain(WholeFacets(model, surfaces), model)
        self._side: np.ndarray = np.full(len(self.facets), -1)
        if len(touching.groups) == 2:
            second = WholeFacets(model, touching.groups[1])
            self._side = self.facets.all_among(second).astype(int)
        self._closest, self._crossed = Closest(model.comm), Crossing(model.comm)
        self._sight = Sight(model.comm)
        self.coupling = self._coupling(model)
        self.friction: SurfaceFriction | None = None
        if touching.friction:
            self.friction = SurfaceFriction(
                self.name, touching.friction, self.facets, self.coupling
            )
        self._backs, self._adjoining = Backs(model, self.facets), neighbours(self.facets.nodes)
        self._reach = self._reaches(self.facets)
        self._depth = DEPTH * self.facets.size - touching.distance
        self._beside = False  # another contact, which looks about for this one
        self._blind = False  # nothing faces anything there
        self._search(np.zeros(model.unknowns.local))
        self._last: _Seen | None = None

    def _reaches(self, facets: Facets) -> np.ndarray:
        """How far facets look for what they face (k,), mm."""
        return REACH * facets.size + self.touching.distance

    def _of_chain(self, own: WholeFacets, model: Model) -> WholeFacets | ChainFacets:
        """The facets; of a module also the images of those that they may reach."""
        if model.repeat is None:
            return own
        around = 1 + int(self._reaches(own).max(initial=0.0) // model.repeat.length)
        return ChainFacets(own, model, around)

    def _coupling(self, model: Model) -> Coupling:
        if isinstance(self.facets, ChainFacets):
            return ChainCoupling(model.assembler, self.facets, model.unknowns.local)
        return NodeCoupling(model.assembler, self.facets)

    def _overlooks(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Whether points of the facets i do not look at the facets j: of a sheet that lies on a
        solid only its own points look, for the solid's would lose it at once at its edge."""
        return ~self.facets.of_sheet[i] & self.facets.covering[j]

    def _search(self, x: np.ndarray) -> None:
        """Which facets those of this process's share may come to touch before the next
        equilibrium."""
        nodes = self.facets.node_places(x)
        start, candidate = candidates(
            nodes, self._adjoining, self._side, self._reach, self._backs, self._overlooks
        )
        counts, mine = np.diff(start), self.facets.mine
        start = np.concatenate([[0], np.cumsum(counts * mine)])
        self._candidates = start, candidate[np.repeat(mine, counts)]
        self._looked_from = nodes

    def stand_beside(self, other: Contact, state: State) -> None:
        """See ``Contact``: points that touch and the one with the smallest gap look at what they
        face there; the others face nothing."""
        assert isinstance(other, SurfaceContact)
        seen = other._see(state.x)
        partner, _, gap = seen.partners
        wanted = gap < 0.0
        for size in (gap, gap / self.facets.size[:, None]):
            wanted |= (size == size.min(initial=np.inf)) & np.isfinite(size)
        facet, point = np.nonzero(wanted & self.facets.mine[:, None])
        i, j = np.unique(np.column_stack([facet, partner[facet, point]]), axis=0).T
        start = np.searchsorted(i, np.arange(len(self.facets) + 1))
        self._candidates = start.astype(np.int64), j.astype(np.int32)
        self._beside = True
        self._last = seen if self.facets.any_of(len(j) > 0) else _Seen(seen.nodes, _nothing(gap))
        self._blind = self._last is not seen

    def stands(self, state: State) -> bool:
        """See ``Contact``."""
        return False

    def deepest(self, state: State) -> tuple[float, np.ndarray]:
        """See ``Contact``: no obstacle stands."""
        return np.inf, np.zeros(3)

    def overrun(self, before: State, after: State) -> bool:
        """See ``Contact``."""
        return False

    def gaps(self, x: np.ndarray) -> Partners:
        """Partner, place on it and gap (k, 12) of each quadrature point; see ``Closest``."""
        return self._see(x).partners

    def _see(self, x: np.ndarray) -> _Seen:
        """Where the facets are and what their points face. Whether that is known already is the
        same on all processes, as the places are."""
        if self._blind and self._last is not None:
            return self._last
        nodes = self.facets.node_places(x)
        if self._last is None or not np.array_equal(self._last.nodes, nodes):
            before = None if self._last is None else self._last.partners[0]
            self._last = _Seen(nodes, self._faced(nodes, before))
        return self._last

    def _faced(self, nodes: np.ndarray, before: np.ndarray | None) -> Partners:
        """What the points of facets at the places ``nodes`` (k, n, 3) face."""
        share, (start, candidate) = self.facets.share, self._candidates
        some = np.flatnonzero(np.diff(start)[share])  # the others face nothing
        on = share[some]
        own = nodes[on]
        partner = np.full((len(share), len(self.facets.values)), -1, np.int32)
        found = np.full((*partner.shape, 3), np.inf)
        partner[some], place, gap = self._closest(
            self.facets.values @ own,
            own,
            nodes,
            np.append(start[on], start[-1]),
            candidate,
            self._reach[on],
            self._depth[on],
            None if before is None else before[on],
        )
        found[some, :, :2], found[some, :, 2] = place, gap - self.touching.distance
        partner, found = self.facets.from_shares(partner), self.facets.from_shares(found)
        return partner, found[..., :2], found[..., 2]

    def _touch(self, state: State) -> InTouch:
        """The points in touch, of all processes."""
        partner, place, gap = self.gaps(state.x)
        facet, point = np.nonzero(gap < 0)
        partner, place, gap = (values[facet, point] for values in (partner, place, gap))
        stiffness = self.facets.stiffness[facet] * stiffness_factor(state, self.name)
        found = pressure(gap, stiffness, self.facets.onset[facet])
        area = self.facets.counting_areas(facet, point, partner)
        return InTouch(facet, point, partner, place, gap, area, stiffness, *found)

    def _my_touch(self, state: State) -> InTouch:
        """The points in touch that this process looks after."""
        touch = self._touch(state)
        return touch.of(np.flatnonzero(self.facets.mine[touch.facet]))

    def _geometry(
        self,
        facets: np.ndarray,
        where: Where,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Values (m, 2 n) of the shape functions of the gap vector (own nodes, then minus the
        partner's), tangents (m, 2, 3), normal (m, 3), derivatives, second derivatives. facets:
        (k, n, 3) places of the nodes."""
        _, point, partner, place = where
        nodes = facets[partner]
        values, first, second = derivatives(place, nodes.shape[1])
        across = np.hstack([self.facets.values[point], -values])
        tangents = first @ nodes
        normal = np.cross(tangents[:, 0], tangents[:, 1])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        bend = np.einsum("kn,mnc,mc->mk", second, nodes, normal)
        return across, tangents, normal, first, bend

    def add_force(self, state: State, out: np.ndarray) -> None:
        if self._blind:
            return
        seen, touch = self._see(state.x), self._my_touch(state)
        across, _, normal, _, _ = self._geometry(seen.nodes, touch.where)
        pairs, forces = _pressed(touch, across, normal)
        if self.friction is not None:
            rubbed, more = self.friction.forces(state, seen.nodes, touch)
            pairs, forces = np.concatenate([pairs, rubbed]), np.concatenate([forces, more])
        self.facets.add_forces(state.x, self._at_nodes(pairs, forces), out)

    def _at_nodes(self, pairs: np.ndarray, forces: np.ndarray) -> np.ndarray:
        """Sums (count, 3) of forces (m, 2 n, 3) on the nodes of pairs (m, 2) of facets."""
        return self.facets.at_nodes(self.facets.nodes[pairs].reshape(forces.shape[:2]), forces)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        self._make_room(state)
        self.coupling.begin()
        seen, touch = self._see(state.x), self._my_touch(state)
        if not len(touch.facet):
            return
        across, tangents, normal, first, bend = self._geometry(seen.nodes, touch.where)
        weights = touch.area * touch.slope, -touch.area * touch.pressure
        apart = touch.gap + self.touching.distance
        factors = gap_hessian(apart, across, tangents, normal, first, bend, *weights)
        self.coupling.add(np.column_stack([touch.facet, touch.partner]), *factors)
        if self.friction is not None:
            self.friction.add_tangent(state, seen.nodes, touch, across, normal)
        self.coupling.finish(state.x, lambda: self._at_nodes(*_pressed(touch, across, normal)))

    def _make_room(self, state: State) -> None:
        """Keep room in the matrix for what touches or nearly does."""
        partner, _, gap = self.gaps(state.x)
        near = (gap < ROOM * self.facets.size[:, None]) & self.facets.mine[:, None]
        self.coupling.make_room(
            self._coupled(state, partner, near & (gap < 0)), self._coupled(state, partner, near)
        )

    def _coupled(self, state: State, partner: np.ndarray, on: np.ndarray) -> list[np.ndarray]:
        """Facets that points couple, see ``Coupling.make_room``; on: (k, 12) which points."""
        facet, point = np.nonzero(on)
        pairs = [np.column_stack([facet, partner[facet, point]])]
        if self.friction is not None:
            pairs += self.friction.pairs(state, facet, point, partner[facet, point])
        return pairs

    def pressures(self, state: State) -> np.ndarray:
        """See ``Contact``: as each side sees it, where both look."""
        everywhere = np.zeros(self.facets.areas.shape)
        touch = self._touch(state)
        everywhere[touch.facet, touch.point] = touch.pressure
        return everywhere

    def area(self, state: State) -> float:
        """Undeformed area in touch of this process's share, mm²."""
        return float(self._my_touch(state).area.sum())

    def force(self, state: State) -> np.ndarray:
        """See ``Contact``: what bodies do to each other adds up to nothing."""
        return np.zeros(3)

    def energy(self, state: State) -> float:
        touch = self._my_touch(state)
        return float(touch.area @ touch.potential)

    def remember(self, state: State) -> dict[str, np.ndarray]:
        """Memory of this equilibrium; also looks for what may touch next."""
        if not self._beside:
            self.resume(state)
        if self.friction is None:
            return {}
        seen = self._see(state.x)
        partner, place, _ = seen.partners
        facet, point = np.nonzero(partner >= 0)
        where = facet, point, partner[facet, point], place[facet, point]
        across, _, normal, _, _ = self._geometry(seen.nodes, where)
        faced = facet, point, across, normal
        return self.friction.remember(state, seen.nodes, self._touch(state), partner, place, faced)

    def pressed(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Normal (m,) and tangential (m, 3) forces at the quadrature points in touch, N, of all
        processes; only those with a partner at the last equilibrium, for the others have no
        friction yet."""
        if self.friction is None:
            raise ValueError(f"contact.{self.name}: there is no friction")
        touch = self._touch(state)
        found = self.friction.at(state, self._see(state.x).nodes, touch)
        return found.weight * touch.pressure[found.on], found.weight[:, None] * found.traction

    def resume(self, state: State) -> None:
        """See ``Contacts.resume``: looks for what may touch next."""
        self._search(state.x)
        self._last = None

    # --- limits -----------------------------------------------------------------------------

    def presence(self, state: State) -> float:
        """1: surfaces are always there."""
        return 1.0

    def admissible(self, state: State, x: np.ndarray, to: np.ndarray) -> bool:
        """Whether Newton may go from ``x`` to ``to``: no point of this process's share so deep that
        it is lost."""
        partner, place, now = self.gaps(x)
        facet, point = np.nonzero((partner >= 0) & self.facets.mine[:, None])
        other = partner[facet, point], place[facet, point]
        moved = self.facets.node_places(to)
        values, first, _ = derivatives(other[1], moved.shape[1])
        mine, faced = (self.facets.values @ moved)[facet, point], moved[other[0]]
        theirs = (values[:, None] @ faced)[:, 0]
        a, b = np.moveaxis(first @ faced, 1, 0)
        normal = np.cross(a, b)
        then = np.einsum("mc,mc->m", mine - theirs, normal) / np.linalg.norm(normal, axis=1)
        lowest = np.minimum(DEEPER * now[facet, point], -DEEPEST * self.facets.size[facet])
        return bool((then - self.touching.distance >= lowest).all())

    def passed(self, before: State, after: State) -> bool:
        """Whether a point of this process's share went through a surface on its way between two
        equilibria, of which the first one is that of the last search."""
        places, moved = (self.facets.node_places(s.x) for s in (before, after))
        start, candidate = self._candidates
        return self._crossed(places, moved, self.facets.values, start, candidate, self.facets.size)

    def strayed(self, state: State) -> float:
        """How much nearer facets have come to others since they looked for what they may touch,
        relative to how much they may without passing it unseen."""
        now = self.facets.node_places(state.x)
        return self._sight(self._looked_from, now, self._reach, self._side)

    def met_unseen(self, state: State) -> bool:
        """Whether, since then, a point of any process went into a surface that was out of reach."""
        now = self.facets.node_places(state.x)
        i, j = self._sight.met(self._looked_from, now, self._reach, self._side)
        seen = ~self._overlooks(i, j) & ~self._backs(i, j)
        start = np.searchsorted(i[seen], np.arange(len(now) + 1))
        return self._crossed(
            self._looked_from, now, self.facets.values, start, j[seen], self.facets.size,
            touching=False,
        )  # fmt: skip

    def smallest_gap(self, state: State) -> tuple[float, float]:
        """Smallest gap, and its smallest ratio to the element size (both below zero: overlap)."""
        _, _, gap = self.gaps(state.x)
        ratio = gap / self.facets.size[:, None]
        return float(gap.min(initial=np.inf)), float(ratio.min(initial=np.inf))
