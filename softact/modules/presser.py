"""Brings a model to equilibrium under pressures, by few factorisations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from softact.loads.support import Support
from softact.model import Model
from softact.solve.acceptance import fault
from softact.solve.newton import Newton
from softact.system.term import Origin, State

Array = NDArray[np.float64]
STILL = 3e-6  # of the pitch: a step below it is the last one
NEAR = 3e-4  # of the pitch: factors of a state that is nearer do for its stiffness
SLOWER = 0.4  # of the last step: after a larger one there are new factors
FAR = 1.0  # pitch: no step is longer
MOST = 24  # iterations of one state
HALVINGS = 6  # of the way to a state that is not found in one go ...
FEW = 3  # ... and before the stress is carried on


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
