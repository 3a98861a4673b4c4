"""Which of several fitted laws to take: how well it fits, predicts, and is determined."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from softact.errors import SpecError
from softact.fit.candidates import Candidate
from softact.fit.data import Test
from softact.fit.optimise import solve
from softact.fit.problem import Problem, model_stress, thinned
from softact.fit.statistics import certainty

PARTS = 4  # of the stretch, held out one after the other where there is only one mode
FOLDED = 60  # points of a test that are enough for seeing how a law predicts
FINEST = 1e-4  # relative error below which laws are alike: nobody measures better
WORST = 10.0  # relative error of a law that has no stress, or any, where it should predict
LEAST = 5  # independent pieces of information at least in a test


@dataclass(frozen=True)
class Merit:
    """What a law is worth on tests. Errors: root mean square, in parts of that of the stress.

    fitted: over what it was fitted to. predicted: over what was held out of the fit, each mode in
    turn (of one mode: each quarter of the stretch); None where nothing can be held out. modes:
    whether modes were held out. constants, loose: how many there are, and how many are poorly
    determined. error: of fit and prediction together, raised by what the constants cost.
    """

    fitted: float
    predicted: float | None
    modes: bool
    constants: int
    loose: int
    error: float


def merits(problem: Problem, laws: Sequence[tuple[Candidate, np.ndarray, int]]) -> list[Merit]:
    """Return the merit of each law.

    laws: candidate, constants and how many of these are poorly determined. The error is the
    geometric mean of those of fit and prediction, times n^(c/2n) for c constants, those that are
    poorly determined counted twice: Bayes' criterion as an error, since n ln e² + c ln n is n times
    the logarithm of its square. n is the number of independent residuals, not that of points.
    """
    fitted = [_error(problem, problem.tests, candidate, vector) for candidate, vector, _ in laws]
    closest = int(np.argmin(fitted))
    count = independent(problem, *laws[closest][:2])
    modes = len({test.mode for test in problem.tests}) > 1
    result = []
    for (candidate, vector, loose), own in zip(laws, fitted, strict=True):
        ahead = prediction(problem, candidate, vector)
        both = np.hypot(own, FINEST) * np.hypot(own if ahead is None else ahead, FINEST)
        cost = count ** ((len(vector) + loose) / (2.0 * count))
        error = float(np.sqrt(both) * cost)
        result.append(Merit(own, ahead, modes, len(vector), loose, error))
    return result


def prediction(problem: Problem, candidate: Candidate, vector: np.ndarray) -> float | None:
    """Return the error over held-out data, None where there is no law to fit.

    vector: constants of the fit to all data, from which the others start. Where what is left does
    not determine the constants, nothing is predicted and that part does not count.
    """
    if not len(vector):
        return None
    errors = []
    for kept, held in _folds(problem):
        try:
            found = solve(kept, candidate, starts=0, first=vector).vector
        except SpecError:  # fewer points than constants
            return WORST
        if certainty(kept, candidate, found).identifiable:
            errors.append(_error(held, held.tests, candidate, found))
    return float(np.sqrt(np.mean(np.square(errors)))) if errors else WORST


def _folds(problem: Problem) -> Iterator[tuple[Problem, Problem]]:
    """Yield what is fitted and what is predicted: mode by mode, or quarter by quarter."""
    problem = thinned(problem, FOLDED)
    modes = list(dict.fromkeys(test.mode for test in problem.tests))
    for mode in modes if len(modes) > 1 else []:
        held = [i for i, test in enumerate(problem.tests) if test.mode == mode]
        others = [i for i in range(len(problem.tests)) if i not in held]
        yield _only(problem, others), _only(problem, held)
    for part in range(PARTS) if len(modes) == 1 else []:
        inside = [_quarter(test) == part for test in problem.tests]
        yield _points(problem, [~rows for rows in inside]), _points(problem, inside)


def _quarter(test: Test) -> np.ndarray:
    """The quarter (0 to 3) in which each point is, counted from the undeformed state."""
    order = np.argsort(np.abs(np.log(test.stretch)), kind="stable")
    place = np.empty(len(order), dtype=int)
    place[order] = np.arange(len(order))
    return place * PARTS // len(order)


def _only(problem: Problem, places: Sequence[int]) -> Problem:
    return replace(
        problem,
        tests=tuple(problem.tests[i] for i in places),
        weights=tuple(problem.weights[i] for i in places),
    )


def _points(problem: Problem, rows: Sequence[np.ndarray]) -> Problem:
    """The problem with some points of each test."""
    tests = [
        replace(t, stretch=t.stretch[r], stress=t.stress[r],
                other=None if t.other is None else t.other[r])
        for t, r in zip(problem.tests, rows, strict=True)
    ]  # fmt: skip
    weights = [w[r] for w, r in zip(problem.weights, rows, strict=True)]
    return replace(problem, tests=tuple(tests), weights=tuple(weights))


def _error(
    problem: Problem, tests: Sequence[Test], candidate: Candidate, vector: np.ndarray
) -> float:
    """Root mean square error in parts of the root mean square stress; every test counts alike."""
    parts = []
    for test, weight in zip(tests, problem.weights, strict=True):
        size = float(np.sum((weight * test.stress) ** 2))
        with np.errstate(all="ignore"):
            off = weight * (model_stress(candidate, vector, test) - test.stress)
            part = float(np.sum(off**2)) / size if size else 0.0
        parts.append(min(part, WORST**2) if np.isfinite(part) else WORST**2)
    return float(np.sqrt(np.mean(parts)))


def independent(problem: Problem, candidate: Candidate, vector: np.ndarray) -> float:
    """Return the number of independent residuals of a fit: neighbours on a curve err alike.

    n (1 − ρ)/(1 + ρ) per test, with ρ the correlation of neighbouring residuals (Bartlett 1935,
    J. R. Stat. Soc. 98:536).
    """
    total = 0.0
    for test in problem.tests:
        count = len(test.stress)
        off = model_stress(candidate, vector, test) - test.stress
        off = off - np.mean(off)
        size = float(np.sum(off**2))
        alike = float(np.sum(off[1:] * off[:-1])) / size if size > 0 else 0.0
        own = count * (1.0 - alike) / (1.0 + alike) if abs(alike) < 1 else count
        total += min(max(own, min(LEAST, count)), count)
    return total
