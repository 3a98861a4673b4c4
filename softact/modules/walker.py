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
from softact.solve.newton import Newton
from softact.system.rotation import RotationVector
from softact.system.term import Origin, State

Array = NDArray[np.float64]
STILL = 1e-5  # of the pitch: a step below it is the last one
NEAR = 3e-3  # of the pitch: factors of a state that is nearer do for its stiffness
SLOWER = 0.4  # of the last step: after a larger one there are new factors
FAR = 1.0  # pitch: no step is longer
MOST = 24  # iterations of one state
HALVINGS = 6  # of the way to a state that is not found in one go


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

    @property
    def compliance(self) -> Array:
        """Derivatives (k, k) of the strains by the loads."""
        k = len(self.strain)
        return np.linalg.inv(self.second[:k, :k])


class Presser:
    """Brings a model to equilibrium under pressures of groups of cavities, by few iterations.

    groups: of cavities whose pressures go together: name -> share of the group's. iterations: with
    new factors, so far.
    """

    def __init__(
        self, model: Model, groups: Sequence[Mapping[str, float]], supports: Sequence[Support] = ()
    ):
        self.model, self.groups = model, list(groups)
        self.iterations = 0
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
        self, guess: Array, before: Array | None, goal: Array | None, pressures: Array
    ) -> tuple[State, Array]:
        """An equilibrium from a guess (local,) that was extrapolated from the unknowns ``before``,
        and what unit loads of the prescribed unknowns and unit pressures move there (k + m, local).

        goal: of the unknowns that may be prescribed; None: nothing is. Raises ArithmeticError where
        Newton's method finds nothing.
        """
        state, k = self.state(guess, pressures), len(self._dofs)
        if goal is not None:
            state.x[self._dofs] = goal
        self.model.follow(state.x)
        begun = state.x.copy()
        origin = None if before is None else Origin((before,), linearised=True)
        last, gone, fresh, others = np.inf, np.inf, self._columns is None, True
        for _ in range(MOST):
            if fresh:
                change = self._factorised(state, origin)
                gone, others = 0.0, False
            else:
                change = self._solved(-self._force(state)[None])[0]
            columns = self._columns
            assert columns is not None
            if goal is not None:
                corner = columns[:k][:, self._dofs]
                lacking = goal - state.x[self._dofs] - change[self._dofs]
                change = change + np.linalg.solve(corner.T, lacking) @ columns[:k]
            moved = np.abs(change[self.model.displacement_dofs]).max() / self._size
            if not moved <= max(SLOWER * last, FAR * fresh):
                # Those of another state lead astray: anew from the guess.
                if fresh:
                    raise ArithmeticError("Newton's method went astray")
                if others:
                    state.x = begun.copy()
                last, fresh = np.inf, True
                continue
            origin = Origin((state.x.copy(),), linearised=True) if fresh else origin
            state.x = self.model.follow(state.x + change)
            gone, last = gone + moved, moved
            if moved < STILL:
                if gone > NEAR:
                    self._factorised(state, origin)
                assert self._columns is not None
                return state, self._columns
            fresh = False
        raise ArithmeticError(f"no equilibrium within {MOST} iterations")

    def inflated(
        self, state: State, columns: Array, pressures: Array, halvings: int = HALVINGS
    ) -> tuple[State, Array]:
        """The equilibrium under pressures (m,), from one and its columns, as ``settle`` gives them.
        Raises ArithmeticError."""
        before = self.pressures_of(state)
        change = pressures - before
        try:
            guess = np.asarray(state.x + change @ columns[len(self._dofs) :], dtype=float)
            return self.settle(guess, state.x, None, pressures)
        except ArithmeticError:
            if not halvings:
                raise
        half = self.inflated(state, columns, before + change / 2, halvings - 1)
        return self.inflated(*half, pressures, halvings - 1)

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
        self._keep_fixed()

    def begin(self) -> Held:
        """The module at rest."""
        unknowns = np.zeros(self.model.unknowns.local)
        return self._held(unknowns, None, None, np.zeros(len(self.groups)))

    def to(self, start: Held, strain: Array, pressures: Array) -> Held:
        """The module at strains (k,) and pressures (m,), from another state. Raises
        NoEquilibriumError."""
        return self._go(start, np.asarray(strain, float), np.asarray(pressures, float), HALVINGS)

    def released(self, start: Held, pressures: Array) -> Held:
        """The module under pressures (m,) that nothing holds. Raises NoEquilibriumError."""
        return self._go(start, None, np.asarray(pressures, float), HALVINGS)

    def _go(self, start: Held, strain: Array | None, pressures: Array, halvings: int) -> Held:
        k, change = len(self.free), pressures - start.pressures
        if strain is None:
            # Along the state that nothing holds: no load is left.
            pull = start.load + start.second[:k, k:] @ change
            moved = -start.compliance @ pull
        else:
            moved = strain - start.strain
        guess = start.unknowns + start.rates @ np.concatenate([moved, change])
        try:
            return self._held(guess, start.unknowns, strain, pressures)
        except (ArithmeticError, np.linalg.LinAlgError) as error:
            if not halvings:
                raise NoEquilibriumError(f"the module finds no equilibrium: {error}") from None
        between = None if strain is None else (start.strain + strain) / 2
        middle = self._go(start, between, start.pressures + change / 2, halvings - 1)
        return self._go(middle, strain, pressures, halvings - 1)

    def _unknowns(self, strain: Array) -> Array:
        """Of the two faces (k,), from strains (k,)."""
        six = np.zeros(6)
        six[self.free] = strain
        turn = self.repeat.length * six[:3]
        ends = self.repeat.length * RotationVector(turn, integral=True).matrix @ six[3:]
        moved = np.concatenate([turn, ends - self.repeat.pitch])
        return np.asarray((moved / self.repeat.scale)[self.free])

    def _held(
        self, guess: Array, before: Array | None, strain: Array | None, pressures: Array
    ) -> Held:
        """The equilibrium at a guess, and what it answers."""
        goal = None if strain is None else self._unknowns(strain)
        state, columns = self.settle(guess, before, goal, pressures)
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
