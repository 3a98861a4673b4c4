"""A module held at strains of its cross-section and pressures: what it answers there.

The strains are those of ``softact.measures.cross_section``; moment, force and air come with their
derivatives, which the factors of the last tangent give. They also say where the unknowns of the
next state are, so that Newton's method has little left to do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from softact.errors import NoEquilibriumError
from softact.measures.cross_section import CrossSection
from softact.model import Model
from softact.modules.presser import FEW, HALVINGS, Presser
from softact.system.rotation import RotationVector
from softact.system.term import State

Array = NDArray[np.float64]
ALIKE = 0.9  # cosine between two ways from state to state from which on one tells of the other
TINY = 1e-300  # no length
LONGER = 2.0  # times the way that it is told of, at most


@dataclass(frozen=True)
class Held:
    """A module in equilibrium, held at k strains under pressures of m groups of cavities.

    unknowns: (local,). strain, load: (k,) the strains that symmetry leaves, rad/mm and 1, and the
    moment in N mm and force in N that hold them. pressures: (m,) MPa; air: (m,) volume by length,
    mm². second: (k + m, k + m) second derivatives of the energy by length, by strains and
    pressures, whose first are (load, −air). rates: (local, k + m) of the unknowns.
    """

    unknowns: Array
    strain: Array
    load: Array
    pressures: Array
    air: Array
    second: Array
    rates: Array

    @property
    def place(self) -> Array:
        """Strains and pressures (k + m,)."""
        return np.concatenate([self.strain, self.pressures])

    @property
    def first(self) -> Array:
        """First derivatives (k + m,) of the energy by length."""
        return np.concatenate([self.load, -self.air])

    def mixed(self, turns: NDArray[np.bool_], rest: Array) -> tuple[Array, Array, Array]:
        """The same over curvatures, forces and pressures: places (k + m,), and the first
        (k + m,) and second (k + m, k + m) derivatives of W − F · (ν − ν₀), which are (moment,
        −(ν − ν₀), −air). turns: (k,) which strains are curvatures; rest: (k,) ν₀ among them."""
        n = len(self.second)
        b = np.flatnonzero(~turns)
        a = np.setdiff1d(np.arange(n), b)
        place, first = self.place, self.first
        place[b], first[b] = self.load[b], rest[b] - self.strain[b]
        soft = np.linalg.inv(self.second[np.ix_(b, b)])
        across = self.second[np.ix_(a, b)] @ soft
        second = np.zeros((n, n))
        second[np.ix_(a, a)] = self.second[np.ix_(a, a)] - across @ self.second[np.ix_(b, a)]
        second[np.ix_(a, b)] = across
        second[np.ix_(b, a)] = across.T
        second[np.ix_(b, b)] = -soft
        return place, first, (second + second.T) / 2

    def stable(self, turns: NDArray[np.bool_]) -> bool:
        """Whether it keeps its curvatures and forces by itself: more of them take more."""
        k, b = len(self.strain), np.flatnonzero(~turns)
        _, _, second = self.mixed(turns, self.strain)
        bent = np.linalg.eigvalsh(second[:k, :k][np.ix_(turns, turns)])
        pulled = np.linalg.eigvalsh(-second[np.ix_(b, b)])
        return bool((bent > 0).all() and (pulled > 0).all())

    @property
    def compliance(self) -> Array:
        """Derivatives (k, k) of the strains by the loads."""
        k = len(self.strain)
        return np.linalg.inv(self.second[:k, :k])


@dataclass(frozen=True)
class Way:
    """From one state to the next: a change (k + m,) of strains and pressures, and by how much the
    unknowns (local,) came elsewhere than the first state's rates said. given: (k,) which strains
    were."""

    given: NDArray[np.bool_]
    change: Array
    missed: Array


class Walker(Presser):
    """Takes one module to strains and pressures. rest: (k,) its strains without load."""

    def __init__(self, model: Model, groups: Sequence[Mapping[str, float]]):
        super().__init__(model, groups)
        assert model.repeat is not None  # it is a module
        self.repeat = model.repeat
        self.free = np.flatnonzero(self.repeat.free)
        self._dofs = self.repeat.dofs[self.free]
        self._scale = self.repeat.scale[self.free]
        self._size = self.repeat.length
        pitch = self.repeat.pitch / self.repeat.length
        self.rest = np.concatenate([np.zeros(3), pitch])[self.free]
        self._ways: list[Way] = []
        self._keep_fixed()

    def begin(self) -> Held:
        """The module at rest."""
        unknowns = np.zeros(self.model.unknowns.local)
        nothing = np.zeros(len(self.free), dtype=bool)
        return self._held(unknowns, None, nothing, self.rest * 0.0, np.zeros(len(self.groups)))

    def to(self, start: Held, strain: Array, pressures: Array) -> Held:
        """The module at strains (k,) and pressures (m,), from another state. Raises
        NoEquilibriumError."""
        everything = np.ones(len(self.free), dtype=bool)
        return self._go(start, everything, np.asarray(strain, float), np.asarray(pressures, float))

    def released(self, start: Held, pressures: Array) -> Held:
        """The module under pressures (m,) that nothing holds. Raises NoEquilibriumError."""
        nothing = np.zeros(len(self.free), dtype=bool)
        return self._go(start, nothing, np.zeros(len(self.free)), np.asarray(pressures, float))

    def bent(self, start: Held, goal: Array, pressures: Array) -> Held:
        """The module at curvatures, forces (k,) and pressures (m,). Raises NoEquilibriumError."""
        return self._go(start, self.turns, np.asarray(goal, float), np.asarray(pressures, float))

    @property
    def turns(self) -> NDArray[np.bool_]:
        """Which of the free strains are curvatures (k,)."""
        return np.asarray(self.free < 3)

    def _go(
        self,
        start: Held,
        given: NDArray[np.bool_],
        goal: Array,
        pressures: Array,
    ) -> Held:
        """To strains where they are given, and else to loads."""
        try:
            return self._stepped(start, given, goal, pressures, False, FEW)
        except NoEquilibriumError:
            self._columns = None
            return self._stepped(start, given, goal, pressures, True, HALVINGS)

    def _stepped(
        self,
        start: Held,
        given: NDArray[np.bool_],
        goal: Array,
        pressures: Array,
        carried: bool,
        halvings: int,
    ) -> Held:
        """The same, in smaller steps where it does not go in one. carried: see ``settle``."""
        k, change = len(self.free), pressures - start.pressures
        moved = np.where(given, goal - start.strain, 0.0)
        left = np.flatnonzero(~given)
        pull = goal - start.load - start.second[:k, k:] @ change - start.second[:k, :k] @ moved
        moved[left] = np.linalg.solve(start.second[np.ix_(left, left)], pull[left])
        change = np.concatenate([moved, change])
        straight = start.unknowns + start.rates @ change
        guess = straight + self._missed(start, given, change)
        try:
            found = self._held(guess, start, given, goal, pressures, carried)
            self._ways.append(Way(given, change, found.unknowns - straight))
            return found
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            if not halvings:
                raise NoEquilibriumError(f"the module finds no equilibrium: {error}") from None
        middle = (np.where(given, start.strain, start.load) + goal) / 2
        between = (start.pressures + pressures) / 2
        half = self._stepped(start, given, middle, between, carried, halvings - 1)
        return self._stepped(half, given, goal, pressures, carried, halvings - 1)

    def _missed(self, start: Held, given: NDArray[np.bool_], change: Array) -> Array:
        """By how much the rates of a state will miss the next one (local,): as on the way most
        alike, to or fro, by the square of its length; nothing where none is alike."""
        size = np.abs(start.rates).max(axis=0)
        alike, longer, missed = ALIKE, 0.0, start.unknowns * 0.0
        for way in self._ways:
            if not np.array_equal(way.given, given):
                continue
            mine, other = size * change, size * way.change
            along = abs(float(mine @ other))
            cosine = along / max(float(np.linalg.norm(mine) * np.linalg.norm(other)), TINY)
            if cosine > alike:
                alike, longer, missed = cosine, along / float(other @ other), way.missed
        return min(longer, LONGER) ** 2 * missed

    def _turned(self, strain: Array) -> tuple[Array, Array]:
        """Turn ω (3,) and the mean of the rotations V (3, 3) at strains (k,)."""
        turn = np.zeros(6)
        turn[self.free] = self.repeat.length * strain
        return turn[:3], RotationVector(turn[:3], integral=True).matrix

    def _held(
        self,
        guess: Array,
        start: Held | None,
        given: NDArray[np.bool_],
        goal: Array,
        pressures: Array,
        carried: bool = False,
    ) -> Held:
        """The equilibrium at a guess, and what it answers. carried: see ``settle``."""
        repeat, free = self.repeat, self.free
        six, held = np.zeros((2, 6))
        six[free], held[free] = np.where(given, goal, 0.0), given
        turn, mean = self._turned(np.where(given, goal, 0.0))
        moved = np.concatenate([turn, repeat.length * mean @ six[3:] - repeat.pitch])
        unknowns = np.where(held > 0, moved / repeat.scale, np.nan)[free]
        # A force on ν is one on t: where the turn is given, by V alone.
        loads = np.zeros(6)
        loads[free] = np.where(given, 0.0, goal)
        loads[3:] = np.linalg.solve(mean.T, loads[3:])
        pull = (loads * repeat.scale)[free] / self.model.mesh.layout.copies
        before = None if start is None else start.unknowns
        state, columns = self.settle(guess, before, pressures, unknowns, pull, carried)
        return self._found(state, pressures, columns)

    def _found(self, state: State, pressures: Array, columns: Array) -> Held:
        model, length = self.model, self.repeat.length
        copies, k = model.mesh.layout.copies, len(self.free)
        model.assembler.fixed[self._dofs] = 1  # what holds the faces is asked for
        section = CrossSection(model, state)
        model.assembler.fixed[self._dofs] = 0
        corner = columns[:k][:, self._dofs]
        corner = np.linalg.inv((corner + corner.T) / 2)
        by_air = columns[k:][:, self._dofs]  # moves of the faces' unknowns by pressures (m, k)
        gradients = np.array([self.gradient(state.x, group) for group in self.groups])
        of_motion = copies * corner / np.outer(self._scale, self._scale)
        slopes = section.slopes[np.ix_(self.free, self.free)]
        # At strains that are held: what unit pressures ask of the faces, and the air that they add.
        asked = -by_air @ corner
        second = np.zeros((k + len(self.groups),) * 2)
        second[:k, :k] = section.stiffness(of_motion)
        second[:k, k:] = (copies * asked / self._scale @ slopes).T
        second[k:, :k] = second[:k, k:].T
        grown = gradients @ columns[k:].T + by_air @ asked.T
        second[k:, k:] = -copies / length * (grown + grown.T) / 2
        by_faces = corner @ columns[:k]
        rates = np.concatenate(
            [length * slopes.T / self._scale @ by_faces, columns[k:] + asked @ columns[:k]]
        )
        strain, load = section.strain[self.free], section.load[self.free]
        return Held(state.x, strain, load, pressures, self.air(state) / length, second, rates.T)
