"""Newton's method for one load level: PETSc SNES with a sparse direct factorisation."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from petsc4py import PETSc

from softact.model import Model, Support
from softact.solve.border import Border, VolumeControl
from softact.system.term import Origin, State

# A residual that has grown by this factor does not come back.
DIVERGENCE = 1e6

# Where forces are smooth, a solve is lost when from this iteration on the residual is above the one
# and so many times what it had been.
LOST_FROM, LOST_ABOVE, LOST_RISE = 5, 1e-2, 10.0

# A step that is still inadmissible after so many halvings is a wrong direction.
MAX_HALVINGS = 8

# Steps with the factors of an earlier iteration, at the end of a solve, and how much worse than
# the last Newton step's is the reduction that is expected of them.
MOST_CHORDS, CHORD_LOSS = 2, 4.0

# A line search ends when the slope has fallen to this part, or after so many evaluations; where the
# residual is below this, whole steps get through the last kinks (docs/contact.md).
SLACKENED, MAX_SEARCHES = 0.8, 5
NEAR = 1e-3

# Steps are halved where the residual is still above this part of what it was two steps before.
HARDLY = 0.5

# Beyond the allowed iterations a solve goes on, to this multiple, while four of them reduce the
# residual to this part.
PATIENCE, STEADY = 3, 0.3

# MUMPS's INFOG(1) where it could not allocate its factors (users' guide, section 8).
OUT_OF_MEMORY = (-13, -19)

# ... and where its working space was too small for them; percent of that above its estimate (sheets
# without stiffness delay many pivots), how much more is then tried, and how much at most.
OUT_OF_SPACE = (-8, -9)
SLACK_SPACE, SLACK_SPACE_OF_SHEETS = 60, 400
MORE_SPACE, MOST_SPACE = 4, 10_000
MUMPS_CONTROLS = {
    13: 1,  # no ScaLAPACK on the root: it would hide its inertia
    24: 1,  # find null pivots; PETSc asks for it before it tells the inertia
}


@dataclass(frozen=True)
class NewtonOutcome:
    """What a Newton solve did.

    residuals: relative out-of-balance force per iteration. unstable_modes: directions in which
    the potential energy at constant pressure falls, at the last factorised tangent; none at a
    stable equilibrium. softening: those of them that prescribed volumes hold.
    """

    converged: bool
    iterations: int
    residuals: list[float]
    reason: str
    unstable_modes: int
    softening: int = 0


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


class Newton:
    """Equilibrium of a model at fixed loads.

    tolerance bounds two numbers: the norm of the out-of-balance force by that of the internal
    force, and the root mean square of the volumetric equation's error (a strain).
    """

    def __init__(self, model: Model, tolerance: float, max_iterations: int):
        self.model, self.tolerance = model, tolerance
        self.counts = Counts()
        self.line_search = False
        # Hears of each iteration: its number in the solve, and the relative residual.
        self.watch: Callable[[int, float], None] = lambda iteration, residual: None
        # Seconds of this process so far: values of the matrix, its factors and their solves.
        self.times = {"assembly": 0.0, "linear_solves": 0.0}
        u = model.unknowns
        displacement = np.zeros(u.local, dtype=bool)
        displacement[model.displacement_dofs] = True
        self._is_force = displacement[: u.owned]
        self._volume_scale = self._norm(model.pressure_weights[: u.owned])
        self._fixed_dofs = np.empty(0, dtype=int)
        self._fixed_values = np.empty(0)
        self._x = u.create_vector()
        self._work = u.create_vector(), u.create_vector()
        self._factor: PETSc.Mat | None = None
        # Whether it holds factors, and what the last ones said.
        self._factored = False
        self._modes = 0
        self._space = SLACK_SPACE_OF_SHEETS if model.sheets else SLACK_SPACE
        self._snes = self._create_snes(max_iterations)

    def _create_snes(self, max_iterations: int) -> PETSc.SNES:
        model = self.model
        snes = PETSc.SNES().create(model.comm)
        snes.setType(PETSc.SNES.Type.NEWTONLS)
        snes.setFunction(self._function, model.unknowns.create_vector())
        snes.setJacobian(self._jacobian, model.assembler.matrix)
        self._max_iterations = max_iterations
        snes.setTolerances(max_it=PATIENCE * max_iterations)
        snes.setConvergenceTest(self._test)
        snes.setLineSearchPreCheck(self._adapt)
        # PETSc has no call for the type of line search: an option, deleted at once so that
        # another run in this process does not see it.
        database, key = PETSc.Options(), "snes_linesearch_type"
        database[key] = "basic"
        snes.setFromOptions()
        database.delValue(key)
        ksp = snes.getKSP()
        ksp.setType(PETSc.KSP.Type.PREONLY)
        self._snes = snes
        self._set_up_factor()
        return snes

    def _set_up_factor(self) -> None:
        """A direct factorisation for the matrix as it is laid out now."""
        model = self.model
        self._layouts = model.assembler.layouts
        ksp = self._snes.getKSP()
        pc = ksp.getPC()
        if self._factor is not None:
            self._factor.destroy()  # petsc4py keeps what Python lets go until it is told otherwise
        pc.reset()
        ksp.setOperators(model.assembler.matrix)
        # LDLT where the tangent is symmetric (and indefinite); friction makes it unsymmetric.
        symmetric = model.contacts.symmetric
        pc.setType(PETSc.PC.Type.CHOLESKY if symmetric else PETSc.PC.Type.LU)
        pc.setFactorSolverType("mumps")
        pc.setFactorSetUpSolverType()
        self._factor = pc.getFactorMatrix()
        self._factored = False
        for control, value in {**MUMPS_CONTROLS, 14: self._space}.items():
            self._factor.setMumpsIcntl(control, value)

    def _unstable_modes(self) -> int:
        """Negative eigenvalues of the last factorised tangent beyond one per pressure unknown.

        The factors' inertia is the matrix's (Sylvester). The pressure block −1/K is negative, and
        eliminating it leaves the stiffness of the displacements: the inertias add up (Haynsworth).
        """
        if not self.model.contacts.symmetric:
            return 0  # LU factors have no inertia
        if self._factored:
            pressures = self.model.sum(int((~self._is_force).sum()))
            self._modes = self._factor.getInertia()[0] - pressures
        return self._modes

    def resume(self, counts: Counts, unstable_modes: int) -> None:
        """Go on with what was counted, and with what the last factorised tangent said."""
        self.counts, self._modes = counts, unstable_modes

    def set_supports(self, supports: Sequence[Support], state: State) -> None:
        """Change what is held from here on."""
        self._fixed_dofs, self._fixed_values = self.model.set_supports(supports, state)

    def held(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Displacements of the supported unknowns: now, and as the supports prescribe."""
        return state.x[self._fixed_dofs], self._fixed_values

    def solve(
        self,
        state: State,
        fixed_values: np.ndarray,
        control: VolumeControl | None = None,
        origin: Origin | None = None,
        at_most: int | None = None,
    ) -> NewtonOutcome:
        """Bring ``state`` to equilibrium under its loads; ``state.x`` is the first guess.

        control: volumes to reach; the pressures of their cavities are then unknowns, with those of
        ``state`` as the first guess. origin: what the guess was extrapolated from. at_most:
        iterations, where fewer are allowed than otherwise. The state is changed in place, also
        where the solve fails.
        """
        self._state, self._origin = state, origin
        self._allowed = min(at_most or self._max_iterations, self._max_iterations)
        self._border = Border(self.model, control, self._fixed_dofs) if control else None
        self._held = fixed_values
        state.x[self._fixed_dofs] = fixed_values
        guess, pressures = state.x[: self.model.unknowns.owned].copy(), dict(state.pressure)
        self._iterate(guess)
        while self._more_space():
            state.pressure = dict(pressures)
            self._origin = origin
            self._iterate(guess)
        state.x = self.model.unknowns.to_local(self._x)
        converged = self._snes.getConvergedReason() > 0
        iterations = self._snes.getIterationNumber()
        self.counts.newton_iterations += iterations
        reason = "" if converged else self._reason or self._explain()
        unstable = self._unstable_modes() if converged else 0
        softening = self._border.softening if self._border else 0
        return NewtonOutcome(converged, iterations, self._residuals, reason, unstable, softening)

    def _iterate(self, guess: np.ndarray) -> None:
        """Newton's method from a guess (owned,), which it leaves as it is."""
        self._factored_at: int | None = None  # iteration of the last factorisation in this solve
        self._residuals: list[float] = []
        self._reason = ""
        self._x.setArray(guess)
        with np.errstate(all="ignore"):
            self._snes.solve(None, self._x)

    def _more_space(self) -> bool:
        """Whether the factors did not fit into their working space and may have more now."""
        failed = PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE
        short = self._snes.getConvergedReason() == failed
        short = short and self._factor.getMumpsInfog(1) in OUT_OF_SPACE
        if not short or self._space > MOST_SPACE:
            return False
        self._space = max(MORE_SPACE * self._space, SLACK_SPACE)
        self._set_up_factor()  # its analysis sets the space aside
        return True

    def rate(self, here: Loaded, later: Loaded, step: float) -> np.ndarray | None:
        """Change of the unknowns (local,) per ``step`` of the loads from an equilibrium on, by the
        last factors; None where the last solve needed none."""
        if self._factored_at is None:
            return None
        change = self._forces(later)[0] - self._forces(here)[0]
        rate = self._response(-change[: self.model.unknowns.owned]) / step
        rate[self._fixed_dofs] = (later.held - here.held) / step
        return rate

    def _forces(self, loaded: Loaded) -> tuple[np.ndarray, np.ndarray]:
        """Out-of-balance force, zero at supports, and internal force (local,)."""
        state = replace(loaded.state, x=loaded.state.x.copy())
        state.x[self._fixed_dofs] = loaded.held
        with np.errstate(all="ignore"):
            force, internal = self.model.force(state)
        force[self._fixed_dofs] = 0.0
        return force, internal

    def _response(self, right: np.ndarray) -> np.ndarray:
        """Unknowns (local,) that the last factors give for another right-hand side (owned,)."""
        vector, answer = self._work
        vector.setArray(right)
        self._snes.getKSP().getPC().apply(vector, answer)
        return self.model.unknowns.to_local(answer)

    def imbalance(self, guess: Loaded) -> float:
        """Out-of-balance by internal force of a guess; inf: inverted."""
        force, internal = self._forces(guess)
        owned = slice(self.model.unknowns.owned)
        out, inside = (self._norm(f[owned][self._is_force]) for f in (force, internal))
        ratio = out / max(inside, self.model.force_floor / self.tolerance)
        return ratio if np.isfinite(ratio) else np.inf

    def _function(self, _snes, x, f) -> None:
        owned = self.model.unknowns.owned
        self._state.x = self.model.unknowns.to_local(x)
        self.counts.residual_evaluations += 1
        force, internal = self.model.force(self._state)
        force[self._fixed_dofs] = self._state.x[self._fixed_dofs] - self._held
        f.setArray(force[:owned])
        self._internal = self._norm(internal[:owned][self._is_force])
        self._out_of_balance = self._norm(force[:owned][self._is_force])
        self._volume_error = self._norm(force[:owned][~self._is_force])

    def _jacobian(self, _snes, x, _matrix, _preconditioner) -> None:
        if self._old_factors_do():
            self._handed_over = time.perf_counter()
            return  # PETSc factorises again only when the matrix has changed
        started = time.perf_counter()
        self.counts.factorisations += 1
        self._factored = False
        self.model.tangent(self._state, self._origin)
        self._handed_over = time.perf_counter()
        self.times["assembly"] += self._handed_over - started
        if self.model.assembler.layouts != self._layouts:
            self._set_up_factor()
        self._origin = Origin((self._state.x.copy(),), linearised=True)
        self._factored_at = len(self._residuals) - 1

    def _old_factors_do(self) -> bool:
        """Whether steps with the last factors will reach the tolerance, at MOST_CHORDS steps.

        Where Newton's step took the error from e to C e², one with the same tangent multiplies it
        by about 2 C e, seen: up to twice that; after the first, their own ratio is known.
        """
        if self._factored_at is None:
            return False
        chords = len(self._residuals) - 2 - self._factored_at
        before, now = self._residuals[-2:]
        ratio = now / before * (1.0 if chords else CHORD_LOSS)
        return now * ratio ** (MOST_CHORDS - chords) <= self.tolerance

    def _adapt(self, x, step) -> bool:
        """Complete Newton's step (x becomes x − step) by the prescribed volumes, and shorten it."""
        self.times["linear_solves"] += time.perf_counter() - self._handed_over
        self._factored = True
        change = None
        if self._border:
            array = step.getArray().copy()
            change = self._border.correct(self._state, array, self._response)
            step.setArray(array)
        here, change_of_x = map(self.model.unknowns.to_local, (x, step))
        factor = self._admissible_part(here, change_of_x)
        if change is None and self._may_overshoot(here, here - factor * change_of_x):
            factor = self._searched_part(here, change_of_x, factor)
        elif self._to_and_fro():
            factor *= 0.5
        if change is not None:
            self._border.add(self._state, factor * change)
        if factor < 1.0:
            step.scale(factor)
        return factor < 1.0 or change is not None

    def _may_overshoot(self, here: np.ndarray, there: np.ndarray) -> bool:
        """Whether a line search is wanted on the way between two arrays of unknowns (local,)."""
        return self.line_search or (
            self._residuals[-1] > NEAR and self.model.kinks_between(self._state, here, there)
        )

    def _to_and_fro(self) -> bool:
        """Whether the last two steps undid what the two before had done."""
        seen = self._residuals[1:]  # the guess may be nearer than what follows
        return len(seen) > 3 and seen[-1] > HARDLY * seen[-3] and seen[-2] > HARDLY * seen[-4]

    def _searched_part(self, here: np.ndarray, change: np.ndarray, part: float) -> float:
        """Part of a step (here − change), at most ``part``, at which the out-of-balance force along
        it has fallen to SLACKENED of what it is before (Crisfield 1991, section 9.2)."""
        owned = slice(self.model.unknowns.owned)
        direction = np.where(self._is_force, change[owned], 0.0)

        def slope(t: float) -> float:
            there = replace(self._state, x=here - t * change)
            force, _ = self._forces(Loaded(there, self._held))
            return self.model.sum(float(direction @ force[owned]))

        first = slope(0.0)
        slopes = {}
        while len(slopes) < MAX_SEARCHES:
            now = slopes[part] = slope(part)
            if abs(now) <= SLACKENED * abs(first) or first * now > 0:
                break
            part *= min(max(first / (first - now), 0.2), 0.6) if np.isfinite(now) else 0.5
        return min(slopes, key=lambda t: abs(slopes[t]) if np.isfinite(slopes[t]) else np.inf)

    def _admissible_part(self, here: np.ndarray, change: np.ndarray) -> float:
        """Part of a step (here − change) that turns no element inside out and, where there is such
        a part, does not press bodies into each other."""
        sound = None
        for halvings in range(MAX_HALVINGS):
            part = 0.5**halvings
            there = here - change * part
            if self.model.smallest_jacobian(there) <= 0.0:
                continue
            if self.model.contacts.admissible(self._state, here, there):
                return part
            sound = part if sound is None else sound
        return sound or 1.0  # where no part is sound, the residual will say so

    def _test(self, _snes, iteration, _norms):
        reason = PETSc.SNES.ConvergedReason
        floor = self.model.force_floor / self.tolerance
        force = self._out_of_balance / max(self._internal, floor)
        volume = self._volume_error / self._volume_scale if self._volume_scale else 0.0
        error = max(force, volume, self._border.error(self._state) if self._border else 0.0)
        self._residuals.append(float(error))
        self.watch(iteration, float(error))
        if not np.isfinite(error):
            self._reason = "an element turned inside out"
            return reason.DIVERGED_FNORM_NAN
        if error <= self.tolerance:
            return reason.CONVERGED_FNORM_ABS
        if error > DIVERGENCE * max(1.0, self._residuals[0]):
            self._reason = "the residual grew without bound"
            return reason.DIVERGED_DTOL
        if iteration >= LOST_FROM and self._rose():
            self._reason = "the residual grew again"
            return reason.DIVERGED_DTOL
        if iteration >= self._allowed and not self._falls():
            return reason.DIVERGED_MAX_IT
        return reason.ITERATING

    def _rose(self) -> bool:
        """Whether the residual has grown by so much that it hardly comes back."""
        now, least = self._residuals[-1], min(self._residuals)
        return self.model.smooth and now > max(LOST_ABOVE, LOST_RISE * least)

    def _falls(self) -> bool:
        """Whether the residual falls steadily, as it does where the tangent is not exact."""
        seen = self._residuals
        return len(seen) > 4 and seen[-1] < STEADY * seen[-5]

    def _explain(self) -> str:
        reason = self._snes.getConvergedReason()
        linear = reason == PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE
        if linear and self._factor.getMumpsInfog(1) in OUT_OF_MEMORY:
            raise MemoryError("the factors of the tangent do not fit")
        names = {
            PETSc.SNES.ConvergedReason.DIVERGED_MAX_IT: "too many Newton iterations",
            PETSc.SNES.ConvergedReason.DIVERGED_LINEAR_SOLVE: "the factorisation failed",
            PETSc.SNES.ConvergedReason.DIVERGED_FNORM_NAN: "an element turned inside out",
        }
        return names.get(reason, f"SNES reason {reason}")

    def _norm(self, values: np.ndarray) -> float:
        return float(np.sqrt(self.model.sum(float(values @ values))))
