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
from softact.loads.support import Support
from softact.measures.cross_section import CrossSection
from softact.model import Model
from softact.solve.acceptance import fault
from softact.solve.newton import Newton
from softact.system.rotation import RotationVector
from softact.system.term import Origin, State

Array = NDArray[np.float64]
STILL = 3e-6  # of the pitch: a step below it is the last one
NEAR = 3e-4  # of the pitch: factors of a state that is nearer do for its stiffness
SLOWER = 0.4  # of the last step: after a larger one there are new factors
FAR = 1.0  # pitch: no step is longer
MOST = 24  # iterations of one state
HALVINGS = 6  # of the way to a state that is not found in one go ...
FEW = 3  # ... and before the stress is carried on
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


class Presser:
    """Brings a model to equilibrium under pressures of groups of cavities, by few iterations.

    groups: of cavities whose pressures go together: name -> share of the group's. exact: whether
    what moves by unit loads is that of each state itself, not of one near by. iterations: with new
    factors, so far.
    """

    def __init__(
        self,
        model: Model,
        groups: Sequence[Mapping[str, float]],
        supports: Sequence[Support] = (),
        exact: bool = True,
    ):
        self.model, self.groups = model, list(groups)
        self.iterations, self._exact = 0, exact
        self._newton = Newton(model, STILL, MOST)
        self._newton.set_supports(supports, model.initial_state())
        self._dofs = np.empty(0, dtype=int)  # unknowns that a state may prescribe
        self._size = model.diagonal
        self._columns: Array | None = None  # by the last factors
        self._keep_fixed()

    def _keep_fixed(self) -> None:
        self.model.assembler.fixed[self._dofs] = 0
        self._fixed = self.model.assembler.fixed.copy()

    def state(self, x: Array, pressures: Array) -> State:
        """A state with unknowns (local,) under pressures (m,), MPa."""
        state = self.model.initial_state()
        state.x = x.copy()
        given = {
            name: share * float(pressure)
            for group, pressure in zip(self.groups, pressures, strict=True)
            for name, share in group.items()
        }
        state.put("pressure", dict(state["pressure"]) | given)
        return state

    def settle(
        self,
        guess: Array,
        before: Array | None,
        pressures: Array,
        goal: Array | None = None,
        pull: Array | None = None,
        carried: bool = False,
    ) -> tuple[State, Array]:
        """An equilibrium from a guess (local,) that was extrapolated from the unknowns ``before``,
        and what unit loads of the prescribed unknowns and unit pressures move there (k + m, local).

        goal: (k,) of the unknowns that may be prescribed, NaN where they are not; pull: (k,) loads
        on them, where they are not. None: nothing is, nothing does. carried: whether the stress at
        the guess is carried on from the state before, linearised; that takes more iterations from
        near by, but comes from farther away. Raises ArithmeticError where Newton's method finds
        nothing.
        """
        state, k = self.state(guess, pressures), len(self._dofs)
        goal = np.full(k, np.nan) if goal is None else goal
        pull = np.zeros(k) if pull is None else pull
        held = np.flatnonzero(~np.isnan(goal))
        state.x[self._dofs[held]] = goal[held]
        left = self.state(np.zeros_like(guess) if before is None else before, pressures)
        self.model.contacts.resume(left)  # what touched elsewhere does not count
        state.x = self._allowed(left, state.x)
        origin = Origin((left.x,), linearised=True) if carried else None
        found = self._iterated(state, goal, pull, origin)
        if len(self.model.contacts) and (why := fault(self.model, left, state)):
            raise ArithmeticError(why)
        return state, found

    def _iterated(self, state: State, goal: Array, pull: Array, origin: Origin | None) -> Array:
        """Newton's method for ``settle``, in place: first by the last factors, then by those of the
        guess with the stress of ``origin``. Returns what unit loads and pressures move."""
        k, held, begun = len(self._dofs), np.flatnonzero(~np.isnan(goal)), state.x.copy()
        last, gone, fresh, others = np.inf, np.inf, self._columns is None, True
        for _ in range(MOST):
            if fresh:
                change = self._factorised(state, origin)
                gone, others = self._moved(state.x, origin), False
            else:
                change = self._solved(-self._force(state)[None])[0]
            columns = self._columns
            assert columns is not None
            change = change + pull @ columns[:k]
            if len(held):
                at = self._dofs[held]
                lacking = goal[held] - state.x[at] - change[at]
                change = change + np.linalg.solve(columns[held][:, at].T, lacking) @ columns[held]
            moved = self._far(change)
            if not moved <= max(SLOWER * last, FAR * fresh):
                # Those of another state lead astray: anew from the guess.
                if fresh:
                    raise ArithmeticError("Newton's method went astray")
                if others:
                    state.x = begun.copy()
                last, fresh = np.inf, True
                continue
            origin = Origin((state.x.copy(),), linearised=True) if fresh else origin
            state.x = self._allowed(state, state.x + change)
            gone, last = gone + moved, moved
            if moved < STILL:
                if self._exact and (gone > NEAR or self.model.contacts.touch(state)):
                    self._factorised(state, None)
                assert self._columns is not None
                return self._columns
            fresh = False
        raise ArithmeticError(f"no equilibrium within {MOST} iterations")

    def _far(self, change: Array) -> float:
        """The longest way of a change (local,) of the unknowns, by the pitch."""
        return float(np.abs(change[self.model.displacement_dofs]).max() / self._size)

    def _moved(self, x: Array, origin: Origin | None) -> float:
        """How far unknowns (local,) are from those at which the stress of their tangent was
        linearised: as far as the tangent is from that of the state."""
        return 0.0 if origin is None else self._far(x - origin.states[0])

    def _allowed(self, state: State, to: Array) -> Array:
        """As far on the way from a state to other unknowns (local,) as contact lets it go."""
        model, change = self.model, to - state.x
        there = model.follow(to.copy())
        for halving in range(1, HALVINGS):
            if model.contacts.admissible(state, state.x, there):
                break
            there = model.follow(state.x + change * 0.5**halving)
        return there

    def inflated(self, state: State, columns: Array, pressures: Array) -> tuple[State, Array]:
        """The equilibrium under pressures (m,), from one and its columns, as ``settle`` gives them.
        Raises ArithmeticError."""
        try:
            return self._inflated(state, columns, pressures, False, FEW)
        except ArithmeticError:
            self._columns = None
            return self._inflated(state, columns, pressures, True, HALVINGS)

    def _inflated(
        self, state: State, columns: Array, pressures: Array, carried: bool, halvings: int
    ) -> tuple[State, Array]:
        """The same, in smaller steps where it does not go in one."""
        before = self.pressures_of(state)
        change = pressures - before
        try:
            guess = np.asarray(state.x + change @ columns[len(self._dofs) :], dtype=float)
            return self.settle(guess, state.x, pressures, carried=carried)
        except ArithmeticError:
            if not halvings:
                raise
        half = self._inflated(state, columns, before + change / 2, carried, halvings - 1)
        return self._inflated(*half, pressures, carried, halvings - 1)

    def pressures_of(self, state: State) -> Array:
        """Of the groups (m,), MPa."""
        found = []
        for group in self.groups:
            name, share = next((n, s) for n, s in group.items() if s)
            found.append(float(state["pressure"][name]) / share)
        return np.array(found)

    def moved_by(self, surface: str, force: Array) -> Array:
        """Unknowns (local,) that a small force (3,), N, spread over a surface of the whole moves,
        by the last factors."""
        model = self.model
        share = force / model.surfaces.area(surface) / model.mesh.layout.copies
        right = (share @ model.unit_forces(surface)) * (self._fixed == 0)
        return np.asarray(self._newton.factor.solve_all(right[None])[0], dtype=float)

    def _force(self, state: State) -> Array:
        """Out of balance (local,), zero at what is held. Raises ArithmeticError."""
        with np.errstate(all="ignore"):
            force, _ = self.model.force(state)
        if not np.isfinite(force).all():
            raise ArithmeticError("an element turned inside out")
        return np.asarray(force * (self._fixed == 0))

    def _factorised(self, state: State, origin: Origin | None) -> Array:
        """Newton's change (local,) by factors of the tangent at a state; they are kept, and what
        they say that unit loads of the prescribed unknowns and unit pressures move, too."""
        model = self.model
        model.assembler.fixed[:] = self._fixed
        rights = [-self._force(state), *np.zeros((len(self._dofs), len(state.x)))]
        for row, dof in enumerate(self._dofs, 1):
            rights[row][dof] = 1.0
        rights += [self.gradient(state.x, group) for group in self.groups]
        self.iterations += 1
        factor = self._newton.factor
        self._columns = None
        model.tangent(state, origin)
        factor.follow_layout()
        factor.again()
        change, *columns = self._solved(np.array(rights) * (self._fixed == 0))
        self._columns = np.array(columns)
        return np.asarray(change)

    def _solved(self, rights: Array) -> Array:
        return np.asarray(self._newton.factor.solve_all(rights), dtype=float)

    def gradient(self, x: Array, group: Mapping[str, float]) -> Array:
        """Of the meshed air of a group of cavities by the unknowns (local,), mm²."""
        out = np.zeros_like(x)
        for name, share in group.items():
            self.model.cavities[name].add_volume_gradient(x, share, out)
        return out

    def air(self, state: State) -> Array:
        """Of the groups (m,), mm³ of the whole."""
        copies = self.model.mesh.layout.copies
        return float(copies) * np.array(
            [
                sum(share * self.model.cavity_volume(state, name) for name, share in group.items())
                for group in self.groups
            ]
        )


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
