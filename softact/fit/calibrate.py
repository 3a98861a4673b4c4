"""Constants of a spec adjusted so that its run meets a measured curve.

Bounded Gauss-Newton (scipy's trust region) on few runs: derivatives come from the run itself (see
``softact.fit.exact``) or, where it has none, are forward differences of whole runs, taken anew
after each accepted step. Covariance and intervals are linearised, the latter with Student's t.
"""

import shlex
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from softact.errors import NoEquilibriumError, SpecError
from softact.fit.calibration import Calibration, CalibrationRequest, Trial, differences, misfit
from softact.fit.calibration_files import files, tell, write
from softact.fit.exact import refusal, sensitivities
from softact.fit.knobs import Knob, read_knobs, turned
from softact.measured.curve import Measured, predicted, reached, read_measured, run_columns
from softact.results.folder import COMPLETE, read
from softact.results.own_folder import Output
from softact.spec import Spec, load
from softact.sweep.cache import Cache
from softact.sweep.compute import compute
from softact.sweep.version import run_key

STEP = 0.02  # relative change of a constant for its sensitivity: far above the solver's tolerance
MET = 2e-5  # of the largest measured value: nobody measures better
SETTLED = 1e-3  # relative change of all constants below which the search ends
ALIKE = 1e-3  # smallest over largest singular value at which constants are not told apart


class _EnoughError(Exception):
    """The search may end: the curve is met, or the runs are used up."""


class _Search:
    """Runs trials, remembers them, and gives residuals and sensitivities to the optimiser.

    Knobs are counted in their sizes, residuals in the largest measured value of their column. Runs
    are kept in the cache: the same search, begun anew after a kill, comes to where it was at once.
    """

    def __init__(
        self,
        request: CalibrationRequest,
        spec: Spec,
        knobs: list[Knob],
        measured: Measured,
        cache: Cache,
        say: Callable[[str], None],
    ) -> None:
        self.request, self.spec, self.knobs, self.measured = request, spec, knobs, measured
        self.cache, self.say = cache, say
        self.sizes = np.array([knob.size for knob in knobs])
        self.low = np.array([knob.low for knob in knobs]) / self.sizes
        self.high = np.array([knob.high for knob in knobs]) / self.sizes
        self.trials: dict[tuple[float, ...], Trial] = {}
        self.jacobian: np.ndarray | None = None
        why = refusal(spec, knobs)
        self.exact = not why
        if why:
            say(f"derivatives by differences of runs: {why}")

    def trial(self, position: np.ndarray) -> Trial:
        """The run at a position, from memory where it was done already."""
        values = tuple(float(f"{v:.10g}") for v in position * self.sizes)
        if values not in self.trials:
            if len(self.trials) == self.request.max_runs:
                raise _EnoughError
            self.trials[values] = self._run(values)
        return self.trials[values]

    def _run(self, values: tuple[float, ...]) -> Trial:
        started, number = time.perf_counter(), len(self.trials) + 1
        spec = turned(self.spec, self.knobs, values)
        processes = self.request.processes
        slopes = [knob.path for knob in self.knobs] if self.exact else []
        key = run_key(spec, processes=processes, threads=None, slopes=slopes)
        answer = compute(spec, key, self.cache, processes=processes, threads=None, slopes=slopes)
        if answer.record is None:
            raise answer.error()
        folder = self.cache.folder(key)
        curve = read(folder).curve
        columns = predicted(curve, self.measured)
        trial = Trial(values, columns, folder)
        words = ", ".join(
            f"{knob.path} {knob.text(float(f'{value:.5g}'))}"
            for knob, value in zip(self.knobs, values, strict=True)
        )
        taken = "(known)" if answer.cached else f"({time.perf_counter() - started:.1f} s)"
        if columns is None:
            self.say(f"run {number}: {words}: ended before the data do {taken}")
            if number == 1:
                kind = SpecError if answer.status == COMPLETE else NoEquilibriumError
                raise kind(*filter(None, (answer.cause, reached(curve, self.measured))))
        else:
            self.say(f"run {number}: {words}: RMSE {self._error(trial):.3%} of the largest {taken}")
        return trial

    def _scaled(self, trial: Trial) -> np.ndarray:
        return differences(self.measured, trial)

    def _error(self, trial: Trial) -> float:
        return misfit(self.measured, trial)

    @property
    def best(self) -> Trial:
        """The trial that is nearest to the data."""
        return min(self.trials.values(), key=self._error)

    def residuals(self, position: np.ndarray) -> np.ndarray:
        """Prediction less data; infinite where the run ended early, so that the step is cut."""
        trial = self.trial(position)
        if self._error(trial) < MET and self.jacobian is not None:
            raise _EnoughError
        return self._scaled(trial)

    def sensitivities(self, position: np.ndarray) -> np.ndarray:
        """Derivatives of the residuals with respect to the knobs: the run's own, or one run for
        each."""
        own = self._own(self.trial(position)) if self.exact else None
        if own is not None:
            self.jacobian = own
            return own
        if self.exact:
            self.exact = False
            self.say("derivatives by differences of runs: this one has not all of its own")
        here, columns = self._scaled(self.trial(position)), []
        for i, value in enumerate(position):
            change = STEP * max(abs(value), 0.1)
            columns.append(self._sensitivity(position, here, i, change))
        self.jacobian = np.stack(columns, axis=1)
        return self.jacobian

    def _own(self, trial: Trial) -> np.ndarray | None:
        """Derivatives of the residuals that a run carries; None where it has not all."""
        curve = read(trial.folder).curve
        found = sensitivities(trial.folder, curve, self.measured, self.knobs)
        if found is None:
            return None
        scales = [np.max(np.abs(self.measured.values[name])) for name in self.measured.names]
        parts = zip(self.measured.names, scales, strict=True)
        return np.concatenate([found[name] / scale for name, scale in parts])

    def _sensitivity(
        self, position: np.ndarray, here: np.ndarray, i: int, change: float
    ) -> np.ndarray:
        """Forward difference, backward at a bound or where the forward run ends early."""
        for signed in (change, -change):
            if not self.low[i] <= position[i] + signed <= self.high[i]:
                continue
            there = position.copy()
            there[i] += signed
            moved = self._scaled(self.trial(there))
            if np.isfinite(moved).all():
                return (moved - here) / signed
        raise SpecError(
            f"--vary {self.knobs[i].path}: the run ends early or a bound is met on both sides of "
            f"{self.knobs[i].text(position[i] * self.sizes[i])}, so its effect cannot be found"
        )


def given(request: CalibrationRequest, spec: Spec) -> tuple[Measured, list[Knob]]:
    """The measured curve, and the values to adjust. Raises SpecError where they do not go with the
    spec or with each other."""
    measured = _measured(request, spec)
    fractions = measured.values.get("step_fraction", np.zeros(1))
    if fractions.min() < 0 or fractions.max() > 1:  # before a run, not after
        raise SpecError(
            f"{measured.source}: step_fraction goes from {fractions.min():g} to "
            f"{fractions.max():g}; in a step of a run it goes from 0 to 1"
        )
    knobs = read_knobs(request.vary, spec)
    if not knobs:
        raise SpecError("nothing to adjust; name a value with --vary, such as materials.body.c10")
    if measured.count < len(knobs):
        raise SpecError(
            f"{measured.source}: {measured.count} values do not determine {len(knobs)} constants"
        )
    return measured, knobs


def calibrate(
    request: CalibrationRequest,
    spec: Spec,
    measured: Measured,
    knobs: list[Knob],
    say: Callable[[str], None],
    cache: Cache,
) -> Calibration:
    """Search the constants. measured, knobs: as ``given`` finds them. say: one line at a time.

    Raises SpecError where a run of the spec as it is does not reach the data (NoEquilibriumError
    where it found no equilibrium).
    """
    search = _Search(request, spec, knobs, measured, cache, say)
    start = np.array([knob.value for knob in knobs]) / search.sizes
    remarks = []
    try:
        least_squares(
            search.residuals,
            start,
            search.sensitivities,
            bounds=(search.low, search.high),
            xtol=SETTLED,
            ftol=1e-6,
            gtol=1e-12,
        )
    except _EnoughError:
        if len(search.trials) == request.max_runs:
            remarks.append(f"stopped after {request.max_runs} runs (--max-runs): not settled")
    best, trials = search.best, list(search.trials.values())
    if search.exact and (own := search._own(best)) is not None:
        search.jacobian = own
    covariance, freedom = _covariance(search, remarks)
    with np.errstate(invalid="ignore"):
        interval = student.ppf(0.975, max(freedom, 1)) * np.sqrt(np.diag(covariance))
    found = turned(spec, knobs, best.values)
    return Calibration(
        found, knobs, measured, trials[0], best, interval, covariance, trials, remarks
    )


def _measured(request: CalibrationRequest, spec: Spec) -> Measured:
    given = ["softact", "calibrate", str(request.spec), "--data", str(request.data)]
    for option, values in (("--vary", request.vary), ("--set", request.overrides)):
        given += [word for value in values for word in (option, value)]
    given += ["--x", request.x] if request.x else []
    headings = [name.strip() for name in request.columns.split(",")] if request.columns else None
    return read_measured(
        request.data, run_columns(spec), request.x, headings, command=shlex.join(given)
    )


def _covariance(search: _Search, remarks: list[str]) -> tuple[np.ndarray, int]:
    """Covariance (k, k) of the constants in the knobs' units, and the degrees of freedom left.

    s² (JᵀJ)⁻¹ with s² of the residuals (Seber and Wild 2003, Nonlinear Regression, eq. 2.21); NaN
    at a bound, infinite where the data do not determine a constant.
    """
    best = search.best
    position = np.array(best.values) / search.sizes
    margin = 1e-3 * (search.high - search.low)
    at_bound = (position < search.low + margin) | (position > search.high - margin)
    for knob, stuck in zip(search.knobs, at_bound, strict=True):
        if stuck:
            remarks.append(f"{knob.path} is at a bound: the data pull it further")
    covariance = np.full((len(position), len(position)), np.nan)
    free = np.flatnonzero(~at_bound)
    freedom = search.measured.count - len(free)
    if search.jacobian is None or not len(free):
        return covariance, freedom
    inside = np.ix_(free, free)
    size = np.linalg.norm(search.jacobian, axis=0)[free]
    if freedom < 1 or np.any(size == 0.0):
        covariance[inside] = np.inf
        return covariance, freedom
    _, singular, directions = np.linalg.svd(search.jacobian[:, free] / size, full_matrices=False)
    if singular[-1] < ALIKE * singular[0]:
        names = ", ".join(search.knobs[i].path for i in free)
        remarks.append(f"the data hardly tell {names} apart: vary fewer, or measure more")
    root = (directions.T / singular) / size[:, None] * search.sizes[free][:, None]
    scatter = np.sum(search._scaled(best) ** 2) / freedom
    covariance[inside] = scatter * root @ root.T
    return covariance, freedom


def run_request(
    request: CalibrationRequest, directory: Path | None, cache: Cache, say: Callable[[str], None]
) -> Calibration:
    """Calibrate, tell, and write the folder (default results/<name>-calibrated)."""
    spec = load(request.spec, request.overrides)
    for line in spec.geometry.notes():
        say(line)
    directory = directory or Path("results") / f"{spec.name}-calibrated"
    reads, kept = (request.spec, request.data), "the runs are kept in the cache"
    output = Output(directory, "calibrate", request.force, reads, kept)
    measured, knobs = given(request, spec)
    for message in measured.messages:
        say(f"{request.data}: {message}")
    with output.opened(files(spec)):
        outcome = calibrate(request, spec, measured, knobs, say, cache)
        for line in tell(outcome):
            say(line)
        for line in write(request, outcome, output):
            say(line)
    return outcome
