"""Newton's method for one load level: PETSc SNES with a sparse direct factorisation."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from petsc4py import PETSc

from softact import compat
from softact.bodies.last_few import LastFew
from softact.loads.support import Held, Support
from softact.model import Model
from softact.solve.border import Border, Control
from softact.solve.factor import Factor
from softact.solve.line_search import SEARCHES, part_of_step
from softact.solve.mumps_factor import MumpsFactor
from softact.solve.settings import FactorName
from softact.system.term import Origin, State


@dataclass(frozen=True)
class Tuning:
    """What was found best on the benchmark and the contact tests (docs/performance.md, contact.md).

    divergence: a residual that has grown by this factor does not come back. lost_from, lost_above,
    lost_rise: where forces are smooth, a solve is lost when from this iteration on the residual is
    above the second and so many times what it had been. stuck_from, stuck_above, stuck: where
    bodies may touch, it is lost when from this iteration on the residual is above the second and
    above this part of the largest of the three before. pressed, far: a first step of which no more
    than this part keeps bodies apart, of a guess with a residual above the second, see
    ``SolveOptions.shy``. halvings: after so many a step that is still inadmissible is a wrong
    direction. most_chords, chord_loss: steps with the factors of an earlier iteration, at the end
    of a solve, and how much worse than the last Newton step's is the reduction that is expected of
    them. near: where the residual is below this, whole steps get through the last kinks, and points
    look afresh once for what they face. hardly: steps are halved where the residual is still above
    this part of what it was two steps before. patience, steady: beyond the allowed iterations a
    solve goes on, to this multiple, while four of them reduce the residual to this part.
    """

    divergence: float = 1e6
    lost_from: int = 5
    lost_above: float = 1e-2
    lost_rise: float = 10.0
    stuck_from: int = 5
    stuck_above: float = 5e-3
    stuck: float = 0.5
    pressed: float = 0.25
    far: float = 0.3
    halvings: int = 8
    most_chords: int = 2
    chord_loss: float = 4.0
    near: float = 1e-3
    hardly: float = 0.5
    patience: int = 3
    steady: float = 0.3


TUNING = Tuning()


@dataclass(frozen=True)
class SolveOptions:
    """What is asked of one solve.

    tolerance: bounds two numbers, the ratio of the norm of the out-of-balance force to that of the
    internal force and the root mean square of the volumetric equation's error (a strain).
    force_floor: force (N) that, over the tolerance, internal forces count for at least; None: the
    model's. at_most: iterations, where fewer are allowed than otherwise. line_search: at each
    iteration. shy: end at once where the first step presses bodies into each other: a smaller
    increment costs less.
    """

    tolerance: float
    force_floor: float | None = None
    at_most: int | None = None
    line_search: bool = False
    shy: bool = False


@dataclass(frozen=True)
class NewtonOutcome:
    """What a Newton solve did.

    residuals: relative out-of-balance force per iteration. unstable_modes: directions in which
    the potential energy at constant pressure falls, at the last factorised tangent; none at a
    stable equilibrium. softening: those of them that prescribed volumes hold. apart: part of the
    first step up to which bodies stay apart, where a shy solve has ended by it.
    """

    converged: bool
    iterations: int
    residuals: list[float]
    reason: str
    unstable_modes: int
    softening: int = 0
    apart: float = 1.0


@dataclass
class Counts:
    """Work done so far."""

    newton_iterations: int = 0
    factorisations: int = 0
    residual_evaluations: int = 0


@dataclass(frozen=True)
class Loaded:
    """A state and the displacements that are prescribed along with its loads."""

    state: State
    held: np.ndarray


@dataclass
class _Solve:
    """One solve on its way.

    held: prescribed displacements. allowed: iterations. factored_at: iteration of the last
    factorisation. internal, out_of_balance: norms of forces (N), volume_error: of volumes (mm³), at
    the last evaluation. kinked: whether forces had kinks at any iterate. afresh: whether points
    have looked afresh for what they face. known: forces at the last few places, see ``_force``.
    """

    state: State
    origin: Origin | None
    held: np.ndarray
    border: Border | None
    options: SolveOptions
    force_floor: float
    allowed: int
    known: LastFew[tuple[np.ndarray, np.ndarray]] = field(default_factory=LastFew)
    factored_at: int | None = None
    residuals: list[float] = field(default_factory=list)
    reason: str = ""
    internal: float = 0.0
    out_of_balance: float = 0.0
    volume_error: float = 0.0
    handed_over: float = 0.0
    apart: float = 1.0
    kinked: bool = False
    afresh: bool = False


def _factor_of(name: FactorName) -> type[Factor]:
    if name == "pardiso":
        from softact.solve.pardiso_factor import PardisoFactor  # few have it

        return PardisoFactor
    return MumpsFactor


class Newton:
    """Equilibrium of a model at fixed loads.

    factor: what makes the factors of its tangents. options: of a solve that asks for nothing else.
    """

    def __init__(
        self,
        model: Model,
        tolerance: float,
        max_iterations: int,
        factor: FactorName = "mumps",
    ):
        self.model, self.options = model, SolveOptions(tolerance)
        self.counts = Counts()
        # Hears of each iteration: its number in the solve, and the relative residual.
        self.watch: Callable[[int, float], None] = lambda iteration, residual: None
        # Seconds of this process so far: values of the matrix, its factors and their solves.
        self.times = {"assembly": 0.0, "linear_solves": 0.0}
        u = model.unknowns
        displacement = np.zeros(u.local, dtype=bool)
        displacement[model.displacement_dofs] = True
        if model.repeat:
            displacement[model.repeat.dofs] = True
        for body in model.free_bodies.values():
            displacement[body.dofs] = True
        self._is_force = displacement[: u.owned]
        self._volume_scale = self._norm(model.pressure_weights[: u.owned])
        self._supported = Held(np.empty(0, dtype=int), np.empty(0), np.empty(0))
        self._x = u.create_vector()
        self._work = u.create_vector(), u.create_vector()
        self._max_iterations = max_iterations
        self._snes = self._create_snes(max_iterations)
        pressures = model.sum(int((~self._is_force).sum()))
        self.factor = _factor_of(factor)(model, self._snes, pressures)
        # The present solve, or the last one; before the first, one that has factorised nothing.
        rest, nowhere = model.initial_state(), np.empty(0)
        self._now = _Solve(rest, None, nowhere, None, self.options, model.force_floor, allowed=0)

    def _create_snes(self, max_iterations: int) -> PETSc.SNES:
        model = self.model
        snes = PETSc.SNES().create(model.comm)
        snes.setType(PETSc.SNES.Type.NEWTONLS)
        snes.setFunction(self._function, model.unknowns.create_vector())
        snes.setJacobian(self._jacobian, model.assembler.matrix)
        snes.setTolerances(max_it=TUNING.patience * max_iterations)
        snes.setConvergenceTest(self._test)
        snes.setLineSearchPreCheck(self._adapt)
        # PETSc has no call for the type of line search: an option, deleted at once so that
        # another run in this process does not see it.
        database, key = PETSc.Options(), "snes_linesearch_type"
        database[key] = "basic"
        snes.setFromOptions()
        database.delValue(key)
        snes.getKSP().setType(PETSc.KSP.Type.PREONLY)
        return snes

    @property
    def tolerance(self) -> float:
        """That of a solve that asks for nothing else."""
        return self.options.tolerance

    @property
    def has_factors(self) -> bool:
        """Whether the last solve left factors of a tangent on its way."""
        return self._now.factored_at is not None

    def resume(self, counts: Counts, unstable_modes: int) -> None:
        """Go on with what was counted, and with what the last factorised tangent said."""
        self.counts = counts
        self.factor.remember(unstable_modes)

    def set_supports(self, supports: Sequence[Support], state: State) -> None:
        """Change what is held from here on."""
        self._supported = self.model.set_supports(supports, state)

    def held(self, state: State) -> Held:
        """Displacements of the supported unknowns: from those of ``state`` to those that the
        supports prescribe."""
        return self._supported.seen_from(state.x)

    def arrive(self, state: State, part: float = 1.0) -> None:
        """Take what supports prescribe as reached, at the end of a step; part: of their way, where
        they went back."""
        if part == 1.0:
            self._supported = self._supported.arrived()
        else:
            self._supported = self._supported.halted(state.x, part)

    def solve(
        self,
        state: State,
        held: np.ndarray,
        control: Control | None = None,
        origin: Origin | None = None,
        options: SolveOptions | None = None,
    ) -> NewtonOutcome:
        """Bring ``state`` to equilibrium under its loads; ``state.x`` is the first guess.

        held: prescribed displacements. control: volumes to reach; the pressures of their cavities
        are then unknowns, with those of ``state`` as the first guess. origin: what the guess was
        extrapolated from. The state is changed in place, also where the solve fails.
        """
        options = options or self.options
        floor = self.model.force_floor if options.force_floor is None else options.force_floor
        allowed = min(options.at_most or self._max_iterations, self._max_iterations)
        state.x[self._supported.dofs] = held
        self.model.follow(state.x)
        guess, pressures = state.x[: self.model.unknowns.owned].copy(), dict(state["pressure"])

        def begin() -> None:
            border = Border(self.model, control, self._supported.dofs) if control else None
            # What touches is seen from where it was last: there is no way back to an earlier place.
            known: LastFew[tuple[np.ndarray, np.ndarray]] = LastFew(
                1 if len(self.model.contacts) else SEARCHES + 1
            )
            self._now = _Solve(state, origin, held, border, options, floor, allowed, known)
            self._x.setArray(guess)
            with np.errstate(all="ignore"):
                self._snes.solve(None, self._x)

        begin()
        while self.factor.more_space():
            state.put("pressure", pressures)
            begin()
        now = self._now
        state.x = self.model.follow(self.model.unknowns.to_local(self._x))
        converged = self._snes.getConvergedReason() > 0
        iterations = self._snes.getIterationNumber()
        self.counts.newton_iterations += iterations
        reason = "" if converged else now.reason or self._explain()
        unstable = self.factor.unstable_modes() if converged else 0
        softening = now.border.softening if now.border else 0
        found = (converged, iterations, now.residuals, reason, unstable, softening, now.apart)
        return NewtonOutcome(*found)

    def rate(self, here: Loaded, later: Loaded, step: float) -> np.ndarray | None:
        """Change of the unknowns (local,) per ``step`` of the loads from an equilibrium on, by the
        last factors; None where the last solve needed none."""
        if self._now.factored_at is None:
            return None
        change = self._forces(later)[0] - self._forces(here)[0]
        rate = self._response(-change[: self.model.unknowns.owned]) / step
        rate[self._supported.dofs] = (later.held - here.held) / step
        return rate

    def _forces(self, loaded: Loaded) -> tuple[np.ndarray, np.ndarray]:
        """Out-of-balance force, zero at supports, and internal force (local,)."""
        state = replace(loaded.state, x=loaded.state.x.copy())
        state.x[self._supported.dofs] = loaded.held
        self.model.follow(state.x)
        with np.errstate(all="ignore"):
            force, internal = self.model.force(state)
        force[self._supported.dofs] = 0.0
        return force, internal

    def _response(self, right: np.ndarray) -> np.ndarray:
        """Unknowns (local,) that the last factors give for another right-hand side (owned,)."""
        vector, answer = self._work
        vector.setArray(right)
        self.factor.solve(vector, answer)
        return self.model.unknowns.to_local(answer)

    def imbalance(self, guess: Loaded) -> float:
        """Ratio of the out-of-balance force of a guess to the internal one; inf: inverted."""
        force, internal = self._forces(guess)
        owned = slice(self.model.unknowns.owned)
        out, inside = self._norm(force[owned][self._is_force]), self._size_of(internal, guess.state)
        ratio = out / max(inside, self.model.force_floor / self.tolerance)
        return ratio if np.isfinite(ratio) else np.inf

    def _size_of(self, internal: np.ndarray, state: State) -> float:
        """Norm (N) of an internal force (local,) and of the weights of free bodies, which nothing
        elastic may carry."""
        inside = self._norm(internal[: self.model.unknowns.owned][self._is_force])
        weights = [body.weight(state) for body in self.model.free_bodies.values()]
        return math.hypot(inside, *np.ravel(weights))

    # --- what SNES calls ------------------------------------------------------------------------

    def _function(self, _snes: PETSc.SNES, x: PETSc.Vec, f: PETSc.Vec) -> None:
        now, owned = self._now, self.model.unknowns.owned
        now.state.x = self.model.follow(self.model.unknowns.to_local(x))
        self.counts.residual_evaluations += 1
        if not now.afresh and now.residuals and now.residuals[-1] < TUNING.near:
            # Else one more solve would be needed when it has been found.
            now.afresh = True
            if self.model.contacts.look_afresh(now.state):
                now.known.clear()
        force, internal = self._force(now.state)
        force = force.copy()
        force[self._supported.dofs] = now.state.x[self._supported.dofs] - now.held
        f.setArray(force[:owned])
        now.internal = self._size_of(internal, now.state)
        now.out_of_balance = self._norm(force[:owned][self._is_force])
        now.volume_error = self._norm(force[:owned][~self._is_force])

    def _force(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Out-of-balance and internal force (local,) on the way of a solve: a line search has been
        at most places already."""

        def find() -> tuple[np.ndarray, np.ndarray]:
            with np.errstate(all="ignore"):
                return self.model.force(state)

        return find() if self._now.border else self._now.known(state.x, b"", find)

    def _jacobian(
        self, _snes: PETSc.SNES, _x: PETSc.Vec, _matrix: PETSc.Mat, _preconditioner: PETSc.Mat
    ) -> None:
        now = self._now
        if self._old_factors_do():
            now.handed_over = time.perf_counter()
            return  # PETSc factorises again only when the matrix has changed
        started = time.perf_counter()
        self.counts.factorisations += 1
        self.factor.fresh = False
        self.model.tangent(now.state, now.origin)
        now.handed_over = time.perf_counter()
        self.times["assembly"] += now.handed_over - started
        self.factor.follow_layout()
        now.origin = Origin((now.state.x.copy(),), linearised=True)
        now.factored_at = len(now.residuals) - 1

    def _old_factors_do(self) -> bool:
        """Whether steps with the last factors will reach the tolerance, at ``most_chords`` steps.

        Where Newton's step took the error from e to C e², one with the same tangent multiplies it
        by about 2 C e, seen: up to twice that; after the first, their own ratio is known.
        """
        now = self._now
        if now.factored_at is None:
            return False
        chords = len(now.residuals) - 2 - now.factored_at
        before, last = now.residuals[-2:]
        ratio = last / before * (1.0 if chords else TUNING.chord_loss)
        return last * ratio ** (TUNING.most_chords - chords) <= now.options.tolerance

    def _adapt(self, x: PETSc.Vec, step: PETSc.Vec) -> bool:
        """Complete Newton's step (x becomes x − step) by the prescribed volumes, and shorten it."""
        now = self._now
        self.times["linear_solves"] += time.perf_counter() - now.handed_over
        self.factor.fresh = True
        change = None
        if now.border:
            array = step.getArray().copy()
            change = now.border.correct(now.state, array, self._response)
            step.setArray(array)
        here, change_of_x = map(self.model.unknowns.to_local, (x, step))
        factor, apart = self._admissible_part(here, change_of_x)
        if apart and now.options.shy and len(now.residuals) == 1 and now.residuals[0] > TUNING.far:
            now.apart = factor
        if change is None and self._may_overshoot(here, here - factor * change_of_x):
            factor = self._searched_part(here, change_of_x, factor)
        elif self._to_and_fro():
            factor *= 0.5
        if now.border and change is not None:
            now.border.add(now.state, factor * change)
        if factor < 1.0:
            step.scale(factor)
        return factor < 1.0 or change is not None

    def _may_overshoot(self, here: np.ndarray, there: np.ndarray) -> bool:
        """Whether a line search is wanted on the way between two arrays of unknowns (local,)."""
        now = self._now
        return now.options.line_search or (
            now.residuals[-1] > TUNING.near and self.model.kinks_between(now.state, here, there)
        )

    def _to_and_fro(self) -> bool:
        """Whether the last two steps undid what the two before had done."""
        seen, hardly = self._now.residuals[1:], TUNING.hardly  # the guess may be nearer
        return len(seen) > 3 and seen[-1] > hardly * seen[-3] and seen[-2] > hardly * seen[-4]

    def _searched_part(self, here: np.ndarray, change: np.ndarray, part: float) -> float:
        """Part of a step (here − change), at most ``part``, see ``line_search``."""
        now, owned = self._now, slice(self.model.unknowns.owned)
        direction = np.where(self._is_force, change[owned], 0.0)

        def slope(t: float) -> float:
            x = here - t * change
            x[self._supported.dofs] = now.held
            force, _ = self._force(replace(now.state, x=self.model.follow(x)))
            return self.model.sum(float(direction @ force[owned]))

        return part_of_step(slope, part)

    def _admissible_part(self, here: np.ndarray, change: np.ndarray) -> tuple[float, bool]:
        """Part of a step (here − change) that turns no element inside out and, where there is such
        a part, does not press bodies into each other; and whether it is less for their sake."""
        sound = None
        for halvings in range(TUNING.halvings):
            part = 0.5**halvings
            there = self.model.follow(here - change * part)
            if self.model.smallest_jacobian(there) <= 0.0:
                continue
            if self.model.contacts.admissible(self._now.state, here, there):
                return part, sound is not None
            sound = part if sound is None else sound
        return sound or 1.0, False  # where no part is sound, the residual will say so

    def _test(
        self, _snes: PETSc.SNES, iteration: int, _norms: tuple[float, float, float]
    ) -> PETSc.SNES.ConvergedReason:
        reason, now = PETSc.SNES.ConvergedReason, self._now
        tolerance = now.options.tolerance
        force = now.out_of_balance / max(now.internal, now.force_floor / tolerance)
        volume = now.volume_error / self._volume_scale if self._volume_scale else 0.0
        error = max(force, volume, now.border.error(now.state) if now.border else 0.0)
        now.residuals.append(float(error))
        now.kinked = now.kinked or self.model.contacts.kinks(now.state)
        self.watch(iteration, float(error))
        if not np.isfinite(error):
            now.reason = "an element turned inside out"
            return reason.DIVERGED_FNORM_NAN
        if error <= tolerance:
            return reason.CONVERGED_FNORM_ABS
        if error > TUNING.divergence * max(1.0, now.residuals[0]):
            now.reason = "the residual grew without bound"
            return reason.DIVERGED_DTOL
        if iteration >= TUNING.lost_from and self._rose():
            now.reason = "the residual grew again"
            return reason.DIVERGED_DTOL
        if now.apart <= TUNING.pressed:
            now.reason = "bodies would be pressed into each other"
            return reason.DIVERGED_DTOL
        if iteration >= TUNING.stuck_from and self._is_stuck():
            now.reason = "what touches changed from iteration to iteration"
            return reason.DIVERGED_DTOL
        if iteration >= now.allowed and not self._falls():
            return reason.DIVERGED_MAX_IT
        return reason.ITERATING

    def _rose(self) -> bool:
        """Whether the residual has grown by so much that it hardly comes back."""
        last, least = self._now.residuals[-1], min(self._now.residuals)
        smooth = self.model.smooth and not self._now.kinked
        return smooth and last > max(TUNING.lost_above, TUNING.lost_rise * least)

    def _is_stuck(self) -> bool:
        """Whether points come into contact and leave it again, and no equilibrium comes nearer."""
        last, before = self._now.residuals[-1], self._now.residuals[-4:-1]
        stuck = last > max(TUNING.stuck_above, TUNING.stuck * max(before))
        return stuck and self._now.kinked and self.model.is_solid

    def _falls(self) -> bool:
        """Whether the residual falls steadily, as it does where the tangent is not exact."""
        seen = self._now.residuals
        return len(seen) > 4 and seen[-1] < TUNING.steady * seen[-5]

    def _explain(self) -> str:
        reason = self._snes.getConvergedReason()
        linear = reason == PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE
        if linear and self.factor.did_not_fit:
            raise MemoryError("the factors of the tangent do not fit")
        names = {
            PETSc.SNES.ConvergedReason.DIVERGED_MAX_IT: "too many Newton iterations",
            PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE: "the factorisation failed",
            compat.diverged_to_nan(): "an element turned inside out",
        }
        return names.get(reason, f"SNES reason {reason}")

    def _norm(self, values: np.ndarray) -> float:
        return float(np.sqrt(self.model.sum(float(values @ values))))
