"""A free body on an obstacle that stays in place: a ball on a table.

Points of the body's surface, or balls about them (``Filled``), press on the obstacle with the law
of ``pressure.py``, a force in place of a pressure. Friction counts the way of the point that
touched at the last equilibrium, so that a ball may roll.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from softact.contact.friction import slide
from softact.contact.memory import remembered
from softact.contact.pose import Pose, pose_of
from softact.contact.pressure import pressure
from softact.contact.way import goes_deeper
from softact.system.term import CONTACT, State

if TYPE_CHECKING:
    from softact.contact.free_body import FreeBody, Motion
    from softact.contact.rigid import Obstacle

# Stiffness of a point's penalty by the body's; overlap over which it sets in, largest elastic slip,
# and how deep a step of Newton's method may lead, all by the body's arm.
STIFFNESS, ONSET, ELASTIC_SLIP, DEEPEST = 100.0, 1e-4, 1e-3, 0.2
ROOM = 0.5  # of an obstacle's, how deep it may lead at most
OVERLAP = 0.02  # of the arm: deeper is no touch


@dataclass(frozen=True)
class _Touch:
    """Points ``on`` (m,) that touch: force p (N), slope −dp/dg, normals (m, 3) and curvatures
    (m, 3, 3) of the distance, and derivatives (m, 3, 6) of the points' places."""

    on: np.ndarray
    force: np.ndarray
    slope: np.ndarray
    normal: np.ndarray
    curvature: np.ndarray
    moved: np.ndarray


class Rest:
    """Contact of a free body with one obstacle that steps may move.

    ``memory``: the points (k, 3) of the body that touched, or would have, where the obstacle saw
    them, its normals there and the slips, at the last equilibrium; the force (6,) on the unknowns.
    """

    def __init__(self, body: FreeBody, own: Obstacle, other: Obstacle):
        filled = own.shape.filled
        assert filled is not None  # it is a body
        self.name = f"{own.name} {other.name}"
        self.other, self._shape, self._body = other, other.shape, body
        self.friction = min(own.friction, other.friction)
        self._arms, self._radius = filled.points - body.centre, filled.radius
        self._stiffness = STIFFNESS * body.stiffness

    def presence(self, state: State) -> float:
        """1 where the obstacle is there, 0 where not, between where it is taken away."""
        return float(state["presence"].get(self.other.name, self.other.active))

    def _pose(self, state: State) -> Pose:
        return pose_of(state["shift"].get(self.other.name), state["turn"].get(self.other.name))

    def _kept(self, state: State, what: str) -> np.ndarray | None:
        return remembered(state, f"{CONTACT}{self.name}", what)

    def _places(self, motion: Motion) -> np.ndarray:
        """Places (k, 3) of the points, or of the middles of the balls, mm."""
        return self._body.centre + motion.shift + self._arms @ motion.turn.T

    def gaps(self, state: State, x: np.ndarray | None = None) -> np.ndarray:
        """Gap (k,) mm of each point, below zero: overlap."""
        places = self._pose(state).seen(self._places(self._body.motion(state, x)))
        return self._shape.distance(places)[0] - self._radius

    def _law(self, gaps: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        stiffness = np.full_like(gaps, self._stiffness)
        return pressure(gaps, stiffness, np.full_like(gaps, ONSET * self._body.arm))

    def _touch(self, state: State) -> _Touch:
        motion, pose = self._body.motion(state), self._pose(state)
        g, n, h = self._shape.distance(pose.seen(self._places(motion)))
        on = np.flatnonzero(g < self._radius)
        p, slope, _ = self._law(g[on] - self._radius)
        moved = _moved(motion, self._arms[on])
        return _Touch(on, p, slope, pose.outward(n[on]), pose.outward_matrices(h[on]), moved)

    def _rubbing(
        self, state: State, touch: _Touch
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None:
        """Arms (m, 3) of the points that rub, and what ``slide`` says of them, of the forces as
        they are; None where none do."""
        kept = {what: self._kept(state, what) for what in ("arm", "place", "normal", "slip")}
        if not self.friction or any(value is None for value in kept.values()):
            return None
        arm, place, normal, slip = (np.asarray(value)[touch.on] for value in kept.values())
        motion, pose = self._body.motion(state), self._pose(state)
        now = pose.seen(self._body.centre + motion.shift + arm @ motion.turn.T)
        limit = np.full(len(touch.on), ELASTIC_SLIP * self._body.arm)
        law = self.friction, touch.force, touch.slope, limit
        traction, modulus, by_gap, elastic = slide(*law, normal, slip + now - place)
        found = pose.outward(traction), pose.outward_matrices(modulus), pose.outward(by_gap)
        return arm, *found, elastic

    def force(self, state: State) -> np.ndarray:
        """Out-of-balance force (6,) N of the body's unknowns."""
        presence = self.presence(state)
        if presence < 1.0:
            last = self._kept(state, "force")
            return np.zeros(6) if last is None else presence * last
        touch = self._touch(state)
        found = -np.einsum("m,ma,maj->j", touch.force, touch.normal, touch.moved)
        rubbing = self._rubbing(state, touch)
        if rubbing is not None:
            arm, traction = rubbing[:2]
            found -= np.einsum("ma,maj->j", traction, _moved(self._body.motion(state), arm))
        return found

    def tangent(self, state: State) -> np.ndarray:
        """Its derivatives (6, 6), N/mm."""
        if self.presence(state) < 1.0:
            return np.zeros((6, 6))
        touch, motion = self._touch(state), self._body.motion(state)
        normals = np.einsum("ma,maj->mj", touch.normal, touch.moved)
        found = np.einsum("m,mi,mj->ij", touch.slope, normals, normals)
        bent = touch.force[:, None, None] * touch.curvature
        found -= np.einsum("mai,mab,mbj->ij", touch.moved, bent, touch.moved)
        pushes = touch.force[:, None] * touch.normal
        found[3:, 3:] -= np.einsum("ijac,ma,mc->ij", motion.second, pushes, self._arms[touch.on])
        rubbing = self._rubbing(state, touch)
        if rubbing is not None:
            arm, traction, modulus, by_gap, _ = rubbing
            moved = _moved(motion, arm)
            change = modulus @ moved + by_gap[:, :, None] * normals[:, None]
            found -= np.einsum("mai,maj->ij", moved, change)
            found[3:, 3:] -= np.einsum("ijac,ma,mc->ij", motion.second, traction, arm)
        return found

    def energy(self, state: State) -> float:
        """Potential of what presses, mJ."""
        if self.presence(state) < 1.0:
            return 0.0
        return float(self._law(self.gaps(state))[2].sum())

    def rubs(self, state: State) -> np.ndarray:
        """What presses, rubs, and might rub at most (3,), N; see ``RigidContact.rubbing``."""
        if self.presence(state) < 1.0:
            return np.zeros(3)
        touch = self._touch(state)
        rubbing, presses = self._rubbing(state, touch), float(touch.force.sum())
        rubs = 0.0 if rubbing is None else float(np.linalg.norm(rubbing[1], axis=1).sum())
        return np.array([presses, rubs, self.friction * presses])

    def remember(self, state: State) -> dict[str, np.ndarray]:
        """What is to be kept of an equilibrium."""
        if self.presence(state) < 1.0:
            return {}
        motion, pose = self._body.motion(state), self._pose(state)
        places = self._places(motion)
        normal = self._shape.distance(pose.seen(places))[1]
        arm = self._arms - self._radius * pose.outward(normal) @ motion.turn
        seen = pose.seen(self._body.centre + motion.shift + arm @ motion.turn.T)
        kept = {"arm": arm, "place": seen, "normal": np.array(normal), "force": self.force(state)}
        kept["slip"] = np.zeros_like(arm)
        touch = self._touch(state)
        rubbing = self._rubbing(state, touch)
        if rubbing is not None:
            kept["slip"][touch.on] = rubbing[4]
        return {f"{CONTACT}{self.name}.{what}": value for what, value in kept.items()}

    def touches(self, state: State) -> bool:
        """Whether any point does."""
        return self.presence(state) == 1.0 and bool((self.gaps(state) < 0.0).any())

    def overlap(self, state: State) -> float:
        """How deep (mm) it overlaps where that is too deep for a touch, else 0."""
        deepest = -float(self.gaps(state).min()) if self.presence(state) == 1.0 else 0.0
        return deepest if deepest > OVERLAP * self._body.arm else 0.0

    def admissible(self, state: State, x: np.ndarray, to: np.ndarray) -> bool:
        """Whether Newton may go from ``x`` to ``to``: not too deep into the obstacle, nor through
        it."""
        if self.presence(state) < 1.0:
            return True
        pose = self._pose(state)
        now, then = (pose.seen(self._places(self._body.motion(state, u))) for u in (x, to))
        deepest = min(DEEPEST * self._body.arm, ROOM * self._shape.room)
        allowed = np.maximum(deepest, 1.5 * -self._gap(now))
        return not goes_deeper(self._gap, now, then, allowed).any()

    def _gap(self, places: np.ndarray) -> np.ndarray:
        return self._shape.distance(places)[0] - self._radius


def _moved(motion: Motion, arms: np.ndarray) -> np.ndarray:
    """Derivatives (m, 3, 6) of the places of points of a body, with arms (m, 3) mm as it was
    placed, by its unknowns."""
    found = np.zeros((len(arms), 3, 6))
    found[:, :, :3] = np.eye(3)
    found[:, :, 3:] = np.einsum("jac,mc->maj", motion.first, arms)
    return found
