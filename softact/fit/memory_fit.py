"""Constants of materials with memory from whole records, beside those of the law.

Maxwell elements come from creep tests and from tests at several rates, Ogden and Roxburgh's r, m
and beta from loadings and unloadings.

All constants are found at once by least squares. Numbers of elements, and whether m, β or both
widen the softening, are compared by Schwarz's criterion (BIC).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from softact.errors import SpecError
from softact.fit.candidates import Candidate
from softact.fit.data import Test
from softact.fit.history import History
from softact.fit.optimise import solve
from softact.fit.problem import make_problem
from softact.fit.record import Record
from softact.fit.relaxation import APART, BETTER, LEAST_SHARE, MOST, TWO_SIDED, Series
from softact.materials.mullins import Mullins
from softact.materials.viscoelastic import Prony

LEAST_R, LARGEST_R = 1.001, 50.0
UNREACHED = 1e3  # residual where a law has no value
# Peaks that differ by less than this part of the largest energy are one: they do not part m from β.
ONE_PEAK = 0.05
FORMS = (("r", "m"), ("r", "beta"), ("r", "m", "beta"))


@dataclass(frozen=True)
class Question:
    """What is asked. softens: Ogden and Roxburgh's constants; creeps: Maxwell elements.
    by_stretch: residuals count as stretch, as where the stress is held. balance: every record
    counts alike."""

    candidate: Candidate
    softens: bool = False
    creeps: bool = False
    by_stretch: bool = False
    balance: bool = False


@dataclass(frozen=True)
class MemoryFit:
    """A fit. vector: constants of the law (long-time ones, MPa), ``law_error``: half of their 95 %
    intervals, NaN at a bound. softening: r, m (MPa) and beta with ``softening_error``; those that
    are held at zero are left out. series: the elements, its rms relative to the largest stress or
    stretch."""

    question: Question
    histories: tuple[History, ...]
    vector: np.ndarray
    law_error: np.ndarray
    softening: dict[str, float]
    softening_error: dict[str, float]
    series: Series

    @property
    def mullins(self) -> Mullins | None:
        """The softening as the formulas take it."""
        return _mullins(self.softening)

    @property
    def prony(self) -> Prony | None:
        """The elements, seen from the law's long-time stress."""
        rest = 1 - self.series.g.sum()
        return Prony(1.0, self.series.g / rest, self.series.tau) if len(self.series.g) else None

    @property
    def bic(self) -> float:
        """Schwarz's criterion: the lower, the better."""
        return self.series.bic

    @property
    def count(self) -> int:
        """Constants that are fitted."""
        return len(self.vector) + len(self.softening) + 2 * len(self.series.g)

    def stress(self, history: History) -> np.ndarray:
        """Nominal stress (n,) in MPa at the rows of a record."""
        candidate = self.question.candidate
        k = candidate.constants(self.vector)
        return history.stress(candidate.law, k, self.mullins, self.prony)

    def short(self, history: History) -> np.ndarray:
        """Stretch (n,) by which the fit lies below the record, to first order."""
        candidate = self.question.candidate
        k, memory = candidate.constants(self.vector), (self.mullins, self.prony)
        off = history.stress(candidate.law, k, *memory) - history.record.stress
        return off / history.stiffness(candidate.law, k, *memory)

    @property
    def peaks_alike(self) -> bool:
        """Whether the records reach one peak only."""
        return len(_levels(self.question, self.histories)) < 2


def _mullins(values: dict[str, float]) -> Mullins | None:
    if not values:
        return None
    return Mullins.model_construct(
        r=values["r"], m=values.get("m", 0.0), beta=values.get("beta", 0.0)
    )


def fit_memory(records: Sequence[Record], question: Question) -> list[MemoryFit]:
    """All fits that were compared. Raises SpecError where the records cannot tell what is asked."""
    for record in records:
        _check(record, question)
    problem = _Problem(tuple(map(History, records)), question)
    forms: Sequence[tuple[str, ...]] = [()]
    if question.softens:
        forms = FORMS if len(_levels(question, problem.histories)) > 1 else FORMS[:1]
    found = [problem.fitted(forms[-1], 0)]
    for count in range(1, MOST + 1 if question.creeps else 1):
        one = problem.fitted(forms[-1], count)
        if _degenerate(one.series):
            break
        found.append(one)
        if one.bic > found[-2].bic:
            break  # more would only follow the noise
    count = len(best(found).series.g)
    return [*found, *(problem.fitted(form, count) for form in forms[:-1])]


def best(fits: Sequence[MemoryFit]) -> MemoryFit:
    """The one with the fewest constants that none beats by more than ``BETTER``."""
    lowest = min(fit.bic for fit in fits)
    return min((f for f in fits if f.bic <= lowest + BETTER), key=lambda f: (f.count, f.bic))


def _degenerate(series: Series) -> bool:
    """Whether an element is none, or two are one."""
    merged = len(series.tau) > 1 and (series.tau[1:] / series.tau[:-1]).min() < APART
    return bool(series.g.min() < LEAST_SHARE or merged)


def _check(record: Record, question: Question) -> None:
    if question.softens and not any(peak < len(record.stretch) - 1 for peak in record.peaks):
        raise SpecError(
            f"{record.name}: the stretch never goes back; softening shows in the unloading after a "
            "loading"
        )
    far = np.abs(record.stretch - 1) > 0.01
    if not np.any(far):
        raise SpecError(f"{record.name}: the stretch stays at 1; there is no deformation")
    if np.mean((record.stress * np.log(record.stretch))[far] < 0) > 0.3:
        raise SpecError(
            f"{record.name}: the stress has the wrong sign in most rows; a positive one pulls "
            "(--zero subtracts the first value)"
        )


def _levels(question: Question, histories: Sequence[History]) -> list[float]:
    """Sizes of the peaks of all records that differ, as squares of the logarithmic stretch."""
    peaks = sorted(
        float(np.log(h.record.stretch[p]) ** 2) for h in histories for p in h.record.peaks
    )
    found: list[float] = []
    for peak in peaks:
        if not found or peak - found[-1] > ONE_PEAK * peaks[-1]:
            found.append(peak)
    return found


class _Problem:
    """Records and what is asked of them."""

    def __init__(self, histories: tuple[History, ...], question: Question):
        self.histories, self.question = histories, question
        self.candidate = question.candidate
        self.data = np.concatenate([h.record.stress for h in histories])

    @cached_property
    def weight(self) -> np.ndarray:
        """Of each residual (n,): by the largest stress (1/MPa), or by the largest stretch."""
        quantity = [
            np.abs(h.record.stretch - 1) if self.question.by_stretch else np.abs(h.record.stress)
            for h in self.histories
        ]
        sizes = [float(q.max()) for q in quantity]
        largest = max(sizes)
        each = sizes if self.question.balance else [largest] * len(sizes)
        return np.concatenate([np.full(len(q), 1 / s) for q, s in zip(quantity, each, strict=True)])

    @cached_property
    def elastic(self) -> np.ndarray:
        """The law alone: of first loadings where it softens, else of all rows."""
        tests = []
        for history in self.histories:
            record = history.record
            rows = _envelope(record) if self.question.softens else slice(None)
            tests.append(Test(record.name, record.mode, record.stretch[rows], record.stress[rows]))
        return solve(make_problem(tests), self.candidate).vector

    @cached_property
    def largest_energy(self) -> float:
        k = self.candidate.constants(self.elastic)
        every = [h.deviators(self.candidate.law, k)[1].max() for h in self.histories]
        return max(float(max(every)), 1e-12)

    def fitted(self, form: tuple[str, ...], count: int) -> MemoryFit:
        """The best of a few starts."""
        lower, upper = self._bounds(form, count)
        starts = [np.clip(s, lower, upper) for s in self._starts(form, count)]
        results = [
            least_squares(
                lambda x: self._residuals(x, form, count),
                start,
                bounds=(lower, upper),
                x_scale=self._scale(form, count),
                xtol=1e-12,
                ftol=1e-12,
                gtol=1e-12,
                max_nfev=200,
            )
            for start in starts
        ]
        found = min(results, key=lambda r: r.cost)
        return self._as_fit(found, form, count, (lower, upper))

    def _split(
        self, x: np.ndarray, form: tuple[str, ...]
    ) -> tuple[np.ndarray, dict[str, float], np.ndarray]:
        """Constants of the law, of the softening (m in MPa), and log b and log τ (2, k)."""
        law, rest = np.split(x, [len(self.candidate.parameters)])
        softening = dict(zip(form, map(float, rest[: len(form)]), strict=True))
        if "m" in softening:
            softening["m"] *= self.largest_energy
        return law, softening, rest[len(form) :].reshape(2, -1)

    def _bounds(self, form: tuple[str, ...], count: int) -> tuple[np.ndarray, np.ndarray]:
        low = {"r": LEAST_R, "m": 0.0, "beta": 0.0}
        high = {"r": LARGEST_R, "m": 100.0, "beta": 100.0}
        shortest, longest = self._span if count else (1.0, 1.0)
        ends = [np.log(shortest / 3), np.log(10 * longest)]
        lower = [*self.candidate.lower, *(low[n] for n in form), *[-20.0] * count]
        upper = [*self.candidate.upper, *(high[n] for n in form), *[5.0] * count]
        return np.array([*lower, *[ends[0]] * count]), np.array([*upper, *[ends[1]] * count])

    @cached_property
    def _span(self) -> tuple[float, float]:
        """Shortest time between two rows and longest record, s."""
        clocks = [h.record.times for h in self.histories if h.record.times is not None]
        return min(float(np.diff(c).min()) for c in clocks), max(float(np.ptp(c)) for c in clocks)

    def _scale(self, form: tuple[str, ...], count: int) -> np.ndarray:
        size = np.abs(self.elastic)
        law = np.maximum(size, 1e-3 * size.max(initial=1e-3))
        return np.array([*law, *[0.3] * len(form), *[1.0] * (2 * count)])

    def _starts(self, form: tuple[str, ...], count: int) -> list[np.ndarray]:
        softer = [(2.0, 0.3), (1.3, 0.1)][: 1 if count else 2] if form else [(0.0, 0.0)]
        spreads = (0.5, 0.8) if count else (0.0,)
        starts = []
        for r, width in softer:
            first = [r, *[width] * (len(form) - 1)] if form else []
            for spread in spreads:
                share = 0.3 / max(count, 1)
                times: list[float] = []
                if count:
                    low, high = np.log(self._span)
                    middle, half = (low + high) / 2, spread * (high - low) / 2
                    times = list(middle + half * np.linspace(-1, 1, count + 2)[1:-1])
                law = self.elastic * (1 / (1 + share * count / 2))
                linear = np.array([p.linear for p in self.candidate.parameters], dtype=bool)
                law = np.where(linear, law, self.elastic)
                starts.append(np.array([*law, *first, *[np.log(share)] * count, *times]))
        return starts

    def _residuals(self, x: np.ndarray, form: tuple[str, ...], count: int) -> np.ndarray:
        law, softening, logs = self._split(x, form)
        k, mullins = self.candidate.constants(law), _mullins(softening)
        prony = Prony(1.0, *np.exp(logs)) if count else None
        parts = []
        for history in self.histories:
            off = history.stress(self.candidate.law, k, mullins, prony) - history.record.stress
            if self.question.by_stretch:
                off = off / history.stiffness(self.candidate.law, k, mullins, prony)
            parts.append(off)
        every = self.weight * np.concatenate(parts)
        return np.where(np.isfinite(every), np.clip(every, -UNREACHED, UNREACHED), UNREACHED)

    def _as_fit(
        self,
        found: OptimizeResult,
        form: tuple[str, ...],
        count: int,
        bounds: tuple[np.ndarray, np.ndarray],
    ) -> MemoryFit:
        points, squares = len(found.fun), float(found.fun @ found.fun)
        variance = squares / max(points - len(found.x), 1)
        covariance = np.linalg.pinv(found.jac.T @ found.jac, hermitian=True) * variance
        half = TWO_SIDED * np.sqrt(np.maximum(np.diag(covariance), 0.0))
        reach = np.maximum(np.abs(found.x), 1.0) * 1e-6
        half = np.where((found.x - bounds[0] < reach) | (bounds[1] - found.x < reach), np.nan, half)
        law, softening, logs = self._split(found.x, form)
        first = len(law)
        scale = {"m": self.largest_energy}
        errors = {n: float(half[first + i]) * scale.get(n, 1.0) for i, n in enumerate(form)}
        begin = first + len(form)
        among = covariance[begin : begin + count, begin : begin + count]
        series = _series(logs, among, half[begin + count :], squares, points, len(found.x))
        return MemoryFit(
            self.question, self.histories, law, half[:first], softening, errors, series
        )


def _envelope(record: Record) -> np.ndarray:
    """Rows that are as far from 1 as any before: those of first loadings."""
    far = np.abs(np.log(record.stretch))
    return np.flatnonzero(far >= np.maximum.accumulate(far) * (1 - 1e-9))


def _series(
    logs: np.ndarray,
    among: np.ndarray,
    times_error: np.ndarray,
    squares: float,
    points: int,
    constants: int,
) -> Series:
    """g = b/(1 + Σ b) and τ with their intervals; ∂g/∂(log b) = g (δ − g)."""
    shares, times = np.exp(logs)
    g = shares / (1 + shares.sum())
    slope = np.diag(g) - np.outer(g, g)
    error = TWO_SIDED * np.sqrt(np.maximum(np.diag(slope @ among @ slope.T), 0.0))
    factor = np.exp(np.minimum(times_error, 50.0))
    order = np.argsort(times)
    bic = points * np.log(max(squares / points, 1e-300)) + constants * np.log(points)
    rms = float(np.sqrt(squares / points))
    return Series(g[order], times[order], error[order], factor[order], rms, float(bic))
