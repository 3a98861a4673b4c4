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
from softact.contact.closest import derivatives
from softact.contact.coupling import Coupling, NodeCoupling
from softact.contact.crossing import Crossing
from softact.contact.faced import DEPTH, Faced, Seen
from softact.contact.gap_hessian import gap_hessian
from softact.contact.memory import faced_key, stiffness_factor
from softact.contact.pairs import Looking, Pairs
from softact.contact.pressure import pressure
from softact.contact.sight import LITTLE
from softact.contact.slip import InTouch, SurfaceFriction, Where
from softact.contact.whole_facets import WholeFacets
from softact.system.term import Origin, State

if TYPE_CHECKING:
    from softact.contact.base import Contact
    from softact.contact.facets import Facets
    from softact.contact.rigid import Obstacle
    from softact.model import Model

# How far away a partner is looked for, and from which gap on room in the matrix is
# kept for it; of the element size.
REACH, ROOM = 1.0, 0.1
# What a step of Newton's method may press in on its way, of the element size.
DEEPEST = 0.1
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


def _pressed(
    touch: InTouch, across: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pairs (m, 2) of facets in touch and the derivatives (m, 2 n, 3) of the energy of their
    pressure by the places of their nodes, N. across, normal: see ``SurfaceContact``."""
    push = touch.area * touch.pressure
    forces = -push[:, None, None] * across[:, :, None] * normal[:, None]
    return np.column_stack([touch.facet, touch.partner]), forces


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
        side = np.full(len(self.facets), -1)
        if len(touching.groups) == 2:
            second = WholeFacets(model, touching.groups[1])
            side = self.facets.all_among(second).astype(int)
        self.coupling = self._coupling(model)
        self.friction: SurfaceFriction | None = None
        if touching.friction:
            self.friction = SurfaceFriction(
                self.name, touching.friction, self.facets, self.coupling
            )
        self._crossed, self._backs = Crossing(model.comm), Backs(model, self.facets)
        self._faced = self._faced_by(side, model)
        self._faced.look_about(np.zeros(model.unknowns.local))
        self._beside = False  # another contact, which looks about for this one

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

    def _faced_by(self, side: np.ndarray, model: Model) -> Faced:
        """What faces what. side: (k,) see ``Pairs``."""
        reach, depth = self._reaches(self.facets), DEPTH * self.facets.size
        known = self.facets.nodes, side, reach, depth, self._backs, self._overlooks
        distance = self.touching.distance
        return Faced(model.comm, self.facets, Pairs(model.comm, *known), reach, distance)

    def stand_beside(self, other: Contact, state: State) -> None:
        """See ``Contact``: points that touch and the one with the smallest gap look at what they
        face there; the others face nothing."""
        assert isinstance(other, SurfaceContact)
        seen = other._faced.in_reach(state.x)
        wanted = seen.gap < 0.0
        for size in (seen.gap, seen.gap / self.facets.size[:, None]):
            wanted |= (size == size.min(initial=np.inf)) & np.isfinite(size)
        facet, point = np.nonzero(wanted)
        self._faced.look_only_at(facet, point, seen)
        self._beside = True

    def look_afresh(self, state: State, keep: bool = False) -> bool:
        """See ``Contact``."""
        found = None if self._beside else self._faced.afresh(state.x)
        kept = {n: v for n, v in state.memory.items() if n != faced_key(self.name)}
        if found is not None and keep:
            kept[faced_key(self.name)] = self._faced.faced
        elif found is not None:
            self._faced.take(found)
        state.memory = kept
        return found is not None and not keep

    def stands(self, state: State) -> bool:
        """See ``Contact``."""
        return False

    def deepest(self, state: State) -> tuple[float, np.ndarray]:
        """See ``Contact``: no obstacle stands."""
        return np.inf, np.zeros(3)

    def overrun(self, before: State, after: State) -> bool:
        """See ``Contact``."""
        return False

    def gaps(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Partner, place on it and gap (k, 12) of each quadrature point; see ``Seen``."""
        seen = self._faced.in_reach(x)
        return seen.partner, seen.place, seen.gap

    def _touch(self, state: State) -> InTouch:
        """The points in touch, of all processes."""
        seen = self._faced.touching(state.x)
        facet, point = np.nonzero(seen.gap < 0)
        partner, place, gap = (v[facet, point] for v in (seen.partner, seen.place, seen.gap))
        stiffness = self.facets.stiffness_between(facet, partner)
        stiffness *= stiffness_factor(state, self.name)
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
        seen = self._faced.touching(state.x)
        if not (seen.gap < 0).any():
            return
        touch = self._my_touch(state)
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
        seen, touch = self._faced.touching(state.x), self._my_touch(state)
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
        needed = self._coupled(state, self._faced.touching(state.x), np.zeros(len(self.facets)))
        if not self.facets.any_of(self.coupling.lacks(needed)):
            return
        every = self._faced.in_reach(state.x)
        self.coupling.make_room(needed, self._coupled(state, every, ROOM * self.facets.size))

    def _coupled(self, state: State, seen: Seen, below: np.ndarray) -> list[np.ndarray]:
        """Facets that points of this process's share couple with a gap below ``below`` (k,) mm,
        see ``Coupling.make_room``."""
        facet, point = np.nonzero((seen.gap < below[:, None]) & self.facets.mine[:, None])
        partner = seen.partner[facet, point]
        pairs = [np.column_stack([facet, partner])]
        if self.friction is not None:
            pairs += self.friction.pairs(state, facet, point, partner)
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
        seen = self._faced.in_reach(state.x)
        facet, point = np.nonzero(seen.partner >= 0)
        where = facet, point, seen.partner[facet, point], seen.place[facet, point]
        across, _, normal, _, _ = self._geometry(seen.nodes, where)
        faced = facet, point, across, normal
        touch = self._touch(state)
        return self.friction.remember(state, seen.nodes, touch, seen.partner, seen.place, faced)

    def pressed(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Normal (m,) and tangential (m, 3) forces at the quadrature points in touch, N, of all
        processes; only those with a partner at the last equilibrium, for the others have no
        friction yet."""
        if self.friction is None:
            raise ValueError(f"contact.{self.name}: there is no friction")
        touch = self._touch(state)
        found = self.friction.at(state, self._faced.touching(state.x).nodes, touch)
        return found.weight * touch.pressure[found.on], found.weight[:, None] * found.traction

    def resume(self, state: State) -> None:
        """See ``Contacts.resume``: looks for what may touch next."""
        kept = state.memory.get(faced_key(self.name))
        self._faced.look_about(state.x, None if kept is None else np.asarray(kept))

    # --- limits -----------------------------------------------------------------------------

    def presence(self, state: State) -> float:
        """1: surfaces are always there."""
        return 1.0

    def admissible(self, state: State, x: np.ndarray, to: np.ndarray) -> bool:
        """Whether Newton may go from ``x`` to ``to``: no point of this process's share so deep that
        it is lost."""
        moved = self.facets.node_places(to)
        seen = self._faced.before_touching(x, moved)
        facet, point = np.nonzero((seen.partner >= 0) & self.facets.mine[:, None])
        other = seen.partner[facet, point], seen.place[facet, point]
        values, first, _ = derivatives(other[1], moved.shape[1])
        mine = (self.facets.values[point][:, None] @ moved[facet])[:, 0]
        faced = moved[other[0]]
        theirs = (values[:, None] @ faced)[:, 0]
        a, b = np.moveaxis(first @ faced, 1, 0)
        normal = np.cross(a, b)
        then = np.einsum("mc,mc->m", mine - theirs, normal) / np.linalg.norm(normal, axis=1)
        lowest = np.minimum(DEEPER * seen.gap[facet, point], -DEEPEST * self.facets.size[facet])
        return bool((then - self.touching.distance >= lowest).all())

    def passed(self, before: State, after: State) -> bool:
        """Whether a point of this process's share went through a surface on its way between two
        equilibria, of which the first one is that of the last search."""
        places, moved = (self.facets.node_places(s.x) for s in (before, after))
        return self._went_through(places, moved, self._faced.ahead(moved))

    def strayed(self, state: State, least: float = LITTLE) -> float:
        """How much nearer facets have come to others since they looked for what they may touch,
        relative to how much they may without passing it unseen; at least ``least``."""
        return self._faced.strayed(self.facets.node_places(state.x), least)

    def met_unseen(self, state: State) -> bool:
        """Whether, since then, a point of any process went into a surface that was out of reach."""
        now = self.facets.node_places(state.x)
        if self._faced.strayed(now, 1.0) <= 1.0:
            return False
        i, j = self._faced.unseen(now)
        seen = ~self._overlooks(i, j) & ~self._backs(i, j)
        start = np.searchsorted(i[seen], np.arange(len(now) + 1))
        looking = Looking(start, j[seen])
        return self._went_through(self._faced.from_where, now, looking, touching=False)

    def _went_through(
        self, before: np.ndarray, after: np.ndarray, looking: Looking, touching: bool = True
    ) -> bool:
        """See ``Crossing``."""
        if not len(looking.candidate):
            return False
        numbers, looking = looking.involved()
        known = before[numbers], after[numbers], self.facets.values, *looking
        size, is_open = self.facets.size[numbers], self.facets.open[numbers]
        return self._crossed(*known, size, touching, is_open)

    def overlap(self, state: State) -> tuple[float, float]:
        """See ``Contact``."""
        return _smallest(self._faced.touching(state.x).gap, self.facets.size)

    def smallest_gap(self, state: State) -> tuple[float, float]:
        """Smallest gap, and its smallest ratio to the element size (both below zero: overlap)."""
        return _smallest(self._faced.in_reach(state.x).gap, self.facets.size)


def _smallest(gap: np.ndarray, size: np.ndarray) -> tuple[float, float]:
    """Smallest of the gaps (k, 12), and its smallest ratio to the sizes (k,)."""
    return float(gap.min(initial=np.inf)), float((gap / size[:, None]).min(initial=np.inf))
