"""Parts of the energy that keep a face in shape, see ``softact.bodies.constraints``.

Each is ½ k c² of something c(u) that is to be zero, with a k so large that it is. The geometric
stiffness takes its force k c from the tangent before, as that of solids does (``Origin``): turned
faces would else be as stiff as k for an iteration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from softact.bodies.face_nodes import FaceNodes
from softact.system.rotation import cross_with
from softact.system.term import Origin, State


class Follow:
    """All nodes follow the masters as an affine map does, in the directions of a projector (3, 3).

    c = P (u − Σ N u_i), with shares N (k, m), such as ``FaceNodes.shares``. stiffness: N/mm of a
    node.
    """

    def __init__(self, face: FaceNodes, stiffness: float, shares: np.ndarray, along: np.ndarray):
        self._face, self._stiffness = face, stiffness
        self._shares, self._along = shares, along

    def _errors(self, state: State) -> np.ndarray:
        followers, masters = self._face.displacements(state.x)
        return (followers - self._shares @ masters) @ self._along

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        forces = self._stiffness * self._errors(state)
        self._face.add_force(forces, -self._shares.T @ forces, out)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        shares, block = self._shares, self._stiffness * self._along
        own = np.broadcast_to(block, (len(shares), 3, 3))
        cross = -np.einsum("km,ab->kamb", shares, block)
        self._face.add_tangent(own, cross, np.einsum("km,kn,ab->manb", shares, shares, block))

    def energy(self, state: State) -> float:
        """See ``Term``."""
        return self._stiffness / 2 * float(np.sum(self._errors(state) ** 2))


class Form(Protocol):
    """A number c of r edges (n, r, 3), mm, zero in the undeformed state.

    Its value is taken from the undeformed edges and how they have moved: from the deformed ones
    alone the small change would be the difference of large numbers, whose rounding a stiff tie
    would multiply beyond the solver's tolerance.
    """

    def value(self, rest: np.ndarray, moved: np.ndarray) -> np.ndarray:
        """C (n,), mm."""

    def gradient(self, edges: np.ndarray) -> np.ndarray:
        """Its first derivatives (n, r, 3)."""

    def curvature(self, edges: np.ndarray) -> np.ndarray:
        """Its second derivatives (n, r, 3, r, 3)."""


@dataclass(frozen=True)
class Length:
    """Change of the length of one edge, (l² − L²)/2L; lengths: (n,) mm undeformed."""

    lengths: np.ndarray

    def value(self, rest: np.ndarray, moved: np.ndarray) -> np.ndarray:
        """See ``Form``."""
        along = np.einsum("ni,ni->n", rest[:, 0] + moved[:, 0] / 2, moved[:, 0])
        return along / self.lengths

    def gradient(self, edges: np.ndarray) -> np.ndarray:
        """See ``Form``."""
        return edges / self.lengths[:, None, None]

    def curvature(self, edges: np.ndarray) -> np.ndarray:
        """See ``Form``."""
        blocks = np.eye(3) / self.lengths[:, None, None]
        return blocks[:, None, :, None]


@dataclass(frozen=True)
class Height:
    """Height of the third edge over the plane of the first two, times the change of the area that
    they span, ``area`` (mm²) undeformed."""

    area: float

    def value(self, rest: np.ndarray, moved: np.ndarray) -> np.ndarray:
        """See ``Form``: det(E + d) − det E, edge by edge."""
        (b, c, _), (_, now, last) = np.moveaxis(rest, 1, 0), np.moveaxis(rest + moved, 1, 0)
        first, second, third = np.moveaxis(moved, 1, 0)
        products = (first, now, last), (b, second, last), (b, c, third)
        return sum(np.einsum("ni,ni->n", x, np.cross(y, z)) for x, y, z in products) / self.area

    def gradient(self, edges: np.ndarray) -> np.ndarray:
        """See ``Form``."""
        b, c, d = np.moveaxis(edges, 1, 0)
        return np.stack([np.cross(c, d), np.cross(d, b), np.cross(b, c)], axis=1) / self.area

    def curvature(self, edges: np.ndarray) -> np.ndarray:
        """See ``Form``."""
        found = np.zeros((len(edges), 3, 3, 3, 3))
        for i in range(3):
            # With j, k cyclic: the derivative of e_j × e_k by e_j is −[e_k]×, by e_k it is [e_j]×.
            j, k = (i + 1) % 3, (i + 2) % 3
            found[:, i, :, j] = -cross_with(edges[:, k])
            found[:, i, :, k] = cross_with(edges[:, j])
        return found / self.area


class Tie:
    """½ k Σ c² of a form of edges between masters, or from them to each follower.

    edges: (n, r, m, 3, 3) by which the places of the masters give each edge; for followers n is 1,
    and each one's own place is added to the last edge. stiffness: k, N/mm.
    """

    def __init__(
        self, face: FaceNodes, stiffness: float, form: Form, edges: np.ndarray, follow: bool = False
    ):
        self._face, self._stiffness, self._form = face, stiffness, form
        self._map, self._follow = edges, follow
        self._rest = self._between(face.followers, face.masters)

    def _between(self, followers: np.ndarray, masters: np.ndarray) -> np.ndarray:
        """Edges (n, r, 3) between places, or what they have moved by from displacements."""
        edges = np.einsum("nrmab,mb->nra", self._map, masters)
        if self._follow:
            edges = np.repeat(edges, len(followers), axis=0)
            edges[:, -1] += followers
        return edges

    def _moved(self, x: np.ndarray) -> np.ndarray:
        return self._between(*self._face.displacements(x))

    def _value(self, x: np.ndarray) -> np.ndarray:
        return self._form.value(self._rest, self._moved(x))

    def _carried(self, state: State, origin: Origin | None) -> np.ndarray:
        """C (n,) for the geometric stiffness, see ``Origin``."""
        if origin is None:
            return self._value(state.x)
        if origin.linearised:
            before = self._moved(origin.states[0])
            gradient = self._form.gradient(self._rest + before)
            way = np.sum(gradient * (self._moved(state.x) - before), axis=(1, 2))
            return self._form.value(self._rest, before) + way
        return np.tensordot(origin.weights, [self._value(x) for x in origin.states], 1)

    def add_force(self, state: State, out: np.ndarray) -> None:
        """See ``Term``."""
        moved = self._moved(state.x)
        c = self._form.value(self._rest, moved)[:, None, None]
        push = self._stiffness * c * self._form.gradient(self._rest + moved)
        if self._follow:
            masters = np.einsum("ra,rmab->mb", push.sum(axis=0), self._map[0])
            self._face.add_force(push[:, -1], masters, out)
        else:
            masters = np.einsum("nra,nrmab->mb", push, self._map)
            self._face.add_force(self._face.none, masters * self._face.counts, out)

    def add_tangent(self, state: State, origin: Origin | None) -> None:
        """See ``Term``."""
        edges = self._rest + self._moved(state.x)
        g, c = self._form.gradient(edges), self._carried(state, origin)
        block = np.einsum("nra,nqb->nraqb", g, g)
        block = self._stiffness * (
            block + c[:, None, None, None, None] * self._form.curvature(edges)
        )
        face, first = self._face, self._map[0]
        if self._follow:
            cross = np.einsum("naqb,qpbd->napd", block[:, -1], first)
            among = np.einsum(
                "raqb,rmac,qpbd->mcpd", block.sum(axis=0), first, first, optimize=True
            )
            face.add_tangent(block[:, -1, :, -1], cross, among)
        else:
            maps = self._map, self._map
            among = np.einsum("nraqb,nrmac,nqpbd->mcpd", block, *maps, optimize=True)
            shape = (len(face.followers), 3, *face.masters.shape)
            face.add_tangent(np.zeros((*shape[:2], 3)), np.zeros(shape), among * face.counts)

    def energy(self, state: State) -> float:
        """See ``Term``."""
        found = self._stiffness / 2 * float(np.sum(self._value(state.x) ** 2))
        return found if self._follow else found * self._face.counts
