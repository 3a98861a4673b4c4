"""Contact of a body with itself and between bodies: a term of the potential energy.

Each quadrature point of a facet looks for the nearest point of the facets that it faces; the
pressure of ``pressure.py`` is a function of that gap. Both sides look at each other and count one
half, so that neither is master. Force and tangent are the exact derivatives, also of the place
that a point faces and of the curvature there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.backs import Backs
from softact.contact.closest import Closest, candidates, derivatives
from softact.contact.coupling import Coupling
from softact.contact.crossing import crossed
from softact.contact.facets import ContactFacets
from softact.contact.gap_hessian import gap_hessian
from softact.contact.memory import stiffness_factor
from softact.contact.pressure import pressure
from softact.contact.sight import strayed
from softact.contact.slip import InTouch, SurfaceFriction
from softact.errors import SpecError
from softact.system.term import Origin, State

if TYPE_CHECKING:
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


class SurfaceContact:
    """Contact between surfaces that deform. Only for one process.

    ``memory[name.stiffness]``: factor of the penalty. friction: None where there is none.
    """

    obstacle: Obstacle | None = None

    def __init__(self, touching: Touching, model: Model):
        if model.comm.size > 1:
            raise SpecError(f"contact.{touching.name}: runs on one process only; leave out -n")
        self.touching, self.name = touching, touching.name
        self.symmetric = touching.friction == 0
        surfaces = tuple(dict.fromkeys(name for group in touching.groups for name in group))
        self.facets = ContactFacets(model, surfaces)
        self._side: np.ndarray = np.full(len(self.facets), -1)
        if len(touching.groups) == 2:
            second = ContactFacets(model, touching.groups[1]).nodes
            self._side = np.isin(self.facets.nodes, second).all(axis=1).astype(int)
        self._closest = Closest(model.comm)
        self.coupling = Coupling(model.assembler, self.facets)
        self.friction: SurfaceFriction | None = None
        if touching.friction:
            self.friction = SurfaceFriction(
                self.name, touching.friction, self.facets, self.coupling
            )
        self._backs = Backs(model, self.facets)
        self._reach = REACH * self.facets.size + touching.distance
        self._depth = DEPTH * self.facets.size - touching.distance
        self._search(np.zeros(model.unknowns.local))
        self._last: tuple[bytes, Partners] | None = None

    def _overlooks(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Whether points of the facets i do not look at the facets j: of a sheet that lies on a
        solid only its own points look, for the solid's would lose it at once at its edge."""
        return ~self.facets.of_sheet[i] & self.facets.covering[j]

    def _search(self, x: np.ndarray) -> None:
        """Which facets may come to touch before the next equilibrium."""
        nodes = self.facets.node_places(x)
        numbers = self.facets.nodes
        self._candidates = candidates(
            nodes, numbers, self._side, self._reach, self._backs, self._overlooks
        )
        self._looked_from = nodes

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
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            places, nodes = self.facets.places(x), self.facets.node_places(x)
            before = None if self._last is None else self._last[1][0]
            start, candidate = self._candidates
            partner, place, gap = self._closest(
                places, nodes, start, candidate, self._reach, self._depth, before
            )
            self._last = (key, (partner, place, gap - self.touching.distance))
        return self._last[1]

    def _touch(self, state: State) -> InTouch:
        partner, place, gap = self.gaps(state.x)
        facet, point = np.nonzero(gap < 0)
        partner, place, gap = (values[facet, point] for values in (partner, place, gap))
        stiffness = self.facets.stiffness[facet] * stiffness_factor(state, self.name)
        found = pressure(gap, stiffness, self.facets.onset[facet])
        area = self.facets.counting_areas(facet, point, partner)
        return InTouch(facet, point, partner, place, gap, area, stiffness, *found)

    def _geometry(
        self,
        state: State,
        facet: np.ndarray,
        point: np.ndarray,
        partner: np.ndarray,
        place: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
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

    def add_force(self, state: State, out: np.ndarray) -> None:
        touch = self._touch(state)
        if not len(touch.facet):
            return
        across, _, normal, _, _ = self._geometry(state, *touch.where)
        push = touch.area * touch.pressure
        forces = -push[:, None, None] * across[:, :, None] * normal[:, None]
        dofs = np.hstack([self.facets.dofs[touch.facet], self.facets.dofs[touch.partner]])
        out += np.bincount(dofs.ravel(), forces.ravel(), len(out))
        if self.friction is not None:
            self.friction.add_force(state, touch, out)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        self._make_room(state)
        touch = self._touch(state)
        if not len(touch.facet):
            return
        across, tangents, normal, first, bend = self._geometry(state, *touch.where)
        weights = touch.area * touch.slope, -touch.area * touch.pressure
        apart = touch.gap + self.touching.distance
        factors = gap_hessian(apart, across, tangents, normal, first, bend, *weights)
        self.coupling.add(np.column_stack([touch.facet, touch.partner]), *factors)
        if self.friction is not None:
            self.friction.add_tangent(state, touch, across, normal)

    def _make_room(self, state: State) -> None:
        """Keep room in the matrix for what touches or nearly does."""
        partner, _, gap = self.gaps(state.x)
        facet, point = np.nonzero(gap < ROOM * self.facets.size[:, None])
        pairs = [np.column_stack([facet, partner[facet, point]])]
        if self.friction is not None:
            pairs += self.friction.pairs(state, facet, point, partner[facet, point])
        self.coupling.make_room(pairs)

    def pressures(self, state: State) -> np.ndarray:
        """See ``Contact``: as each side sees it, where both look."""
        everywhere = np.zeros(self.facets.areas.shape)
        touch = self._touch(state)
        everywhere[touch.facet, touch.point] = touch.pressure
        return everywhere

    def area(self, state: State) -> float:
        """Undeformed area in touch on this process, mm²."""
        return float(self._touch(state).area.sum())

    def force(self, state: State) -> np.ndarray:
        """See ``Contact``: what bodies do to each other adds up to nothing."""
        return np.zeros(3)

    def energy(self, state: State) -> float:
        touch = self._touch(state)
        return float(touch.area @ touch.potential)

    def remember(self, state: State) -> dict[str, np.ndarray]:
        """Memory of this equilibrium; also looks for what may touch next."""
        self.resume(state)
        if self.friction is None:
            return {}
        partner, place, _ = self.gaps(state.x)
        facet, point = np.nonzero(partner >= 0)
        partners = partner[facet, point]
        across, _, normal, _, _ = self._geometry(state, facet, point, partners, place[facet, point])
        return self.friction.remember(
            state, self._touch(state), partner, place, (facet, point, across, normal)
        )

    def pressed(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Normal (m,) and tangential (m, 3) forces at the quadrature points in touch, N; only
        those with a partner at the last equilibrium, for the others have no friction yet."""
        if self.friction is None:
            raise ValueError(f"contact.{self.name}: there is no friction")
        touch = self._touch(state)
        found = self.friction.at(state, touch)
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

    def passed(self, before: State, after: State) -> bool:
        """Whether a point went through a surface on its way between two equilibria, of which the
        first one is that of the last search."""
        places, moved = (self.facets.node_places(s.x) for s in (before, after))
        start, candidate = self._candidates
        return crossed(places, moved, self.facets.values, start, candidate, self.facets.size)

    def strayed(self, state: State) -> float:
        """How far facets have moved since they looked for what they may touch, relative to how far
        they may without passing it unseen."""
        now = self.facets.node_places(state.x)
        return strayed(self._looked_from, now, self._reach, self._side)

    def smallest_gap(self, state: State) -> tuple[float, float]:
        """Smallest gap, and its smallest ratio to the element size (both below zero: overlap)."""
        _, _, gap = self.gaps(state.x)
        ratio = gap / self.facets.size[:, None]
        return float(gap.min(initial=np.inf)), float(ratio.min(initial=np.inf))
