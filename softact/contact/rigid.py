"""Contact with a rigid obstacle: a term of the potential energy.

The pressure of ``pressure.py`` acts at the quadrature points of the body's curved facets, per
undeformed area, along the normal of the obstacle. There are no forces at single nodes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.facets import ContactFacets
from softact.contact.free_body import FreeBody
from softact.contact.friction import ELASTIC_SLIP, friction
from softact.contact.grasp import Grasp
from softact.contact.memory import remembered, stiffness_factor
from softact.contact.obstacles.base import Shape
from softact.contact.pose import Pose, pose_of
from softact.contact.pressure import pressure
from softact.contact.way import goes_deeper
from softact.system.term import Origin, State

if TYPE_CHECKING:
    from softact.contact.base import Contact
    from softact.model import Model

# What a step of Newton's method may press in on its way, of the element size and of the
# obstacle's room.
DEEPEST, ROOM = 0.05, 0.5
# ... and by how much what overlaps may overlap more.
DEEPER = 1.5
# How deep the straight way of a point may lead through the obstacle, of its room, where the point
# touches at both ends: it slides around (the chord of a right angle of a ball is 0.3 deep).
CHORD = 0.25


@dataclass(frozen=True)
class Obstacle:
    """A rigid body: shape (see ``obstacles``), Coulomb coefficient, whether it is there from the
    start, whether it is a load cell, and the surfaces that may touch it (None: all outside).

    mass: tonne, of one that moves freely; 0: it is where steps put it. held: whether a free one is
    held in place at first. turns: whether a step turns it.
    """

    name: str
    shape: Shape
    friction: float = 0.0
    active: bool = True
    load_cell: bool = False
    surfaces: tuple[str, ...] | None = None
    mass: float = 0.0
    held: bool = False
    turns: bool = False


@dataclass(frozen=True)
class _Touch:
    """Facets ``on`` (m,) in touch with an obstacle; at their points (m, 12): pressure p, slope
    −dp/dg, normals (..., 3) and curvatures (..., 3, 3) of the distance, as the obstacle sees
    them."""

    on: np.ndarray
    pressure: np.ndarray
    slope: np.ndarray
    normal: np.ndarray
    curvature: np.ndarray


class RigidContact:
    """Contact of some facets of the body with one obstacle.

    State: ``shift[name]`` (3,) mm how far the obstacle was moved and ``turn[name]`` (6,) how it was
    turned (``pose``); ``presence[name]`` 1 where it is there, 0 where not; between, it was removed
    and the force of the last equilibrium fades. ``memory[name.what]``: traction, and slip and place
    as the obstacle sees them, at the last equilibrium. body: the obstacle as one that moves freely,
    by the unknowns.
    """

    def __init__(
        self, obstacle: Obstacle, facets: ContactFacets, model: Model, body: FreeBody | None = None
    ):
        self.obstacle, self.facets, self.body = obstacle, facets, body
        self.name, self.symmetric = obstacle.name, obstacle.friction == 0
        self._grasp = None if body is None else Grasp(model, facets, body)

    def look_afresh(self, state: State, keep: bool = False) -> bool:
        """See ``Contact``: the closest point is asked for anew at each place."""
        return False

    def stands(self, state: State) -> bool:
        """See ``Contact``."""
        return self.presence(state) == 1.0

    def presence(self, state: State) -> float:
        """See the class."""
        return float(state["presence"].get(self.name, self.obstacle.active))

    def pose(self, state: State, x: np.ndarray | None = None) -> Pose:
        """Where the obstacle is, at the unknowns ``x`` (local,), by default those of the state."""
        if self.body is not None:
            return self.body.pose(state, x)
        return pose_of(state["shift"].get(self.name), state["turn"].get(self.name))

    def gaps(self, state: State) -> np.ndarray:
        """Signed gap (k, 12) mm at the quadrature points."""
        places = self._places(state, state.x)
        return self.obstacle.shape.gap(places.reshape(-1, 3)).reshape(places.shape[:2])

    def _places(self, state: State, x: np.ndarray) -> np.ndarray:
        """Places of the points (k, 12, 3) as seen from the obstacle."""
        return self.pose(state, x).seen(self.facets.places(x))

    def _stiffness(self, state: State) -> np.ndarray:
        return self.facets.stiffness * stiffness_factor(state, self.name)

    def _touch(self, state: State) -> _Touch:
        """The facets in touch."""
        places, shape = self._places(state, state.x), self.obstacle.shape
        on = np.flatnonzero((shape.gap(places.reshape(-1, 3)) < 0).reshape(places.shape[:2]).any(1))
        g, n, h = shape.distance(places[on].reshape(-1, 3))
        form = len(on), places.shape[1]
        g, n, h = g.reshape(form), n.reshape(*form, 3), h.reshape(*form, 3, 3)
        stiffness = np.broadcast_to(self._stiffness(state)[on, None], g.shape)
        p, slope, _ = pressure(g, stiffness, self.facets.onset[on, None])
        return _Touch(on, p, slope, n, h)

    def _traction(self, state: State, touch: _Touch) -> np.ndarray:
        """Tractions (m, 12, 3) on the body, as the obstacle sees them."""
        traction = touch.pressure[..., None] * touch.normal
        return traction + self._friction(state, touch)[0] if self.obstacle.friction else traction

    def _modulus(self, state: State, touch: _Touch) -> np.ndarray:
        """Their derivatives (m, 12, 3, 3) with respect to the places of the points."""
        p, slope, n = touch.pressure, touch.slope, touch.normal
        normals = n[..., :, None] * n[..., None, :]
        modulus = p[..., None, None] * touch.curvature - slope[..., None, None] * normals
        return modulus + self._friction(state, touch)[1] if self.obstacle.friction else modulus

    def _friction(self, state: State, touch: _Touch) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Tangential tractions (m, 12, 3), their moduli (m, 12, 3, 3) and the elastic slip."""
        p, n, h = touch.pressure, touch.normal, touch.curvature
        limit = np.broadcast_to(ELASTIC_SLIP * self.facets.size[touch.on, None], p.shape)
        arguments = (p, touch.slope, limit, n, h, self._trial_slip(state, touch.on))
        flat = (a.reshape(-1, *a.shape[2:]) for a in arguments)
        traction, modulus, slip = friction(self.obstacle.friction, *flat)
        return traction.reshape(n.shape), modulus.reshape(h.shape), slip.reshape(n.shape)

    def _trial_slip(self, state: State, on: np.ndarray) -> np.ndarray:
        now = self._places(state, state.x)[on]
        before = remembered(state, self.name, "place")
        slip = remembered(state, self.name, "slip")
        if before is None or slip is None:
            return np.zeros_like(now)
        return slip[on] + now - before[on]

    def tractions(self, state: State) -> np.ndarray:
        """Force per undeformed area (k, 12, 3) of the obstacle on the body, MPa."""
        everywhere = np.zeros((*self.facets.areas.shape, 3))
        presence = self.presence(state)
        if presence == 1.0:
            touch = self._touch(state)
            everywhere[touch.on] = self.pose(state).outward(self._traction(state, touch))
        elif presence > 0.0 and (last := remembered(state, self.name, "traction")) is not None:
            everywhere += presence * last
        return everywhere

    def pressures(self, state: State) -> np.ndarray:
        """See ``Contact``; none of an obstacle that is being taken away."""
        everywhere = np.zeros(self.facets.areas.shape)
        if self.presence(state) == 1.0:
            touch = self._touch(state)
            everywhere[touch.on] = touch.pressure
        return everywhere

    def force(self, state: State) -> np.ndarray:
        """Force (3,) N of the obstacle on this process's part of the body."""
        return np.einsum("kq,kqc->c", self.facets.areas, self.tractions(state))

    def rubbing(self, state: State) -> np.ndarray:
        """Of this process (3,), N: the sums of the sizes of what presses, of what rubs, and of what
        might rub at most."""
        if self.presence(state) != 1.0:
            return np.zeros(3)
        touch = self._touch(state)
        presses = float((touch.pressure * self.facets.areas[touch.on]).sum())
        if not self.obstacle.friction:
            return np.array([presses, 0.0, 0.0])
        rubs = np.linalg.norm(self._friction(state, touch)[0], axis=-1)
        sums = (rubs * self.facets.areas[touch.on]).sum(), self.obstacle.friction * presses
        return np.array([presses, *sums])

    def area(self, state: State) -> float:
        """Undeformed area in touch on this process, mm²."""
        if self.presence(state) != 1.0:
            return 0.0
        return float(self.facets.areas[self.gaps(state) < 0.0].sum())

    def add_force(self, state: State, out: np.ndarray) -> None:
        if self.presence(state) == 1.0:
            touch = self._touch(state)
            tractions = self._traction(state, touch)
            self.facets.add_force(-self.pose(state).outward(tractions), out, touch.on)
            if self._grasp is not None:
                self._grasp.add_force(state, tractions, out, touch.on)
        elif self.presence(state) > 0.0:
            self.facets.add_force(-self.tractions(state), out)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        if self.presence(state) == 1.0:
            touch = self._touch(state)
            moduli = self._modulus(state, touch)
            self.facets.add_tangent(-self.pose(state).outward_matrices(moduli), touch.on)
            if self._grasp is not None:
                tractions = self._traction(state, touch)
                self._grasp.add_tangent(state, tractions, moduli, touch.on)

    def energy(self, state: State) -> float:
        if self.presence(state) != 1.0:
            return 0.0
        g = self.gaps(state)
        stiffness = self._stiffness(state)[:, None]
        _, _, potential = pressure(g, stiffness, self.facets.onset[:, None])
        return float(np.sum(self.facets.areas * potential))

    def remember(self, state: State) -> dict[str, np.ndarray]:
        """Memory of this equilibrium."""
        if self.presence(state) != 1.0:
            return {}
        found = {f"{self.name}.traction": self.tractions(state)}
        if self.obstacle.friction:
            touch = self._touch(state)
            everywhere = np.zeros((*self.facets.areas.shape, 3))
            everywhere[touch.on] = self._friction(state, touch)[2]
            found[f"{self.name}.slip"] = everywhere
            found[f"{self.name}.place"] = self._places(state, state.x)
        return found

    def resume(self, state: State) -> None:
        """See ``Contacts.resume``: nothing is kept outside the state."""

    def stand_beside(self, other: Contact, state: State) -> None:
        """See ``Contact``: it looks at all of its points, which is quick."""

    def admissible(self, state: State, x: np.ndarray, to: np.ndarray) -> bool:
        """Whether Newton may go from ``x`` to ``to``: no point so deep that it is lost, nor on the
        other side."""
        if self.presence(state) != 1.0 or not len(self.facets):
            return True
        now, then = (self._places(state, u).reshape(-1, 3) for u in (x, to))
        return not self._went_through(now, then)

    def passed(self, before: State, after: State) -> bool:
        """Whether a point went through the obstacle on its way between two equilibria."""
        if not self._there(before, after):
            return False
        start, end = (self._places(s, s.x).reshape(-1, 3) for s in (before, after))
        return self._went_through(start, end)

    def overrun(self, before: State, after: State) -> bool:
        """Whether the obstacle, moved as between two states, has come so far over a body that
        stayed where it was that points would leave it on another side."""
        room = ROOM * self.obstacle.shape.room
        if not self._there(before, after) or not np.isfinite(room):
            return False
        start, end = (self._places(s, after.x).reshape(-1, 3) for s in (before, after))
        return bool(goes_deeper(self._gap, start, end, np.full(len(start), room)).any())

    def _there(self, before: State, after: State) -> bool:
        present = self.presence(before) == 1.0 == self.presence(after)
        return present and len(self.facets) > 0

    def _gap(self, places: np.ndarray) -> np.ndarray:
        return self.obstacle.shape.gap(places)

    def _went_through(self, start: np.ndarray, end: np.ndarray) -> bool:
        """Whether a point is lost on its straight way (n, 3), as seen from the obstacle."""
        size = np.repeat(self.facets.size, self.facets.areas.shape[1])
        room = self.obstacle.shape.room
        deepest = np.minimum(DEEPEST * size, ROOM * room)
        now, then = self._gap(start), self._gap(end)
        allowed = np.maximum(deepest, -DEEPER * now)
        if (then < -allowed).any():
            return True
        touches = (now < 0) & (then < 0)
        if np.isfinite(room):
            allowed = np.where(touches, np.maximum(allowed, CHORD * room), allowed)
        return bool(goes_deeper(self._gap, start, end, allowed).any())

    def strayed(self, state: State) -> float:
        """See ``SurfaceContact.strayed``: an obstacle is always seen."""
        return 0.0

    def met_unseen(self, state: State) -> bool:
        """See ``strayed``."""
        return False

    def overlap(self, state: State) -> tuple[float, float]:
        """See ``Contact``."""
        return self.smallest_gap(state)

    def smallest_gap(self, state: State) -> tuple[float, float]:
        """Smallest gap, and its smallest ratio to the element size (both below zero: overlap)."""
        if self.presence(state) != 1.0 or not len(self.facets):
            return np.inf, np.inf
        g = self.gaps(state)
        return float(g.min()), float((g / self.facets.size[:, None]).min())

    def deepest(self, state: State) -> tuple[float, np.ndarray]:
        """Smallest gap (mm) and where it is (3,), mm."""
        if not len(self.facets):
            return np.inf, np.zeros(3)
        g = self.gaps(state)
        return float(g.min()), self.facets.places(state.x).reshape(-1, 3)[g.argmin()]
