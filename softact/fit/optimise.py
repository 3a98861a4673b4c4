"""Least squares of a law's stress on tests: starts by linear algebra, then a bounded optimiser."""

import warnings
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares, lsq_linear, minimize

from softact.errors import SpecError
from softact.fit.candidates import Candidate, Parameter
from softact.fit.data import Test
from softact.fit.modes import MODES, nominal_stress, path_stress, sheet_stress
from softact.fit.plausible import secant_modulus

METHODS = ("least-squares", "L-BFGS-B", "Nelder-Mead", "Powell", "CG", "COBYLA", "SLSQP")
ROUGH, FINE = 1e-8, 1e-14  # relative, of the descents from all starts and of the best one
UNREACHED = 1e3  # residual, in units of the largest stress, where a law has no value
RELATIVE_FLOOR = 0.02  # of the largest stress of a test: below it a relative residual is absolute


@dataclass(frozen=True)
class Problem:
    """Tests and how their residuals count.

    weights: per test, an array (n,) that multiplies the residual in MPa.
    """

    tests: tuple[Test, ...]
    weights: tuple[np.ndarray, ...]

    @cached_property
    def weight(self) -> np.ndarray:
        """The weights of all points."""
        return np.concatenate(self.weights)

    @cached_property
    def paths(self) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """Powers (3, n), pairs (n,) and stretches (n,) of all points; None for biaxial tests."""
        if any(test.mode not in MODES for test in self.tests):
            return None
        modes = [MODES[test.mode] for test in self.tests for _ in test.stretch]
        powers = np.array([mode.powers for mode in modes]).T
        pairs = np.array([mode.pairs for mode in modes], dtype=float)
        return powers, pairs, np.concatenate([test.stretch for test in self.tests])

    @cached_property
    def ceiling(self) -> np.ndarray:
        """Stress that stands for a value that the law has not."""
        return np.concatenate(
            [np.full(len(t.stress), UNREACHED * np.max(np.abs(t.stress))) for t in self.tests]
        )

    @property
    def size(self) -> int:
        """Number of data points."""
        return sum(len(test.stress) for test in self.tests)

    @cached_property
    def data(self) -> np.ndarray:
        """All weighted stresses."""
        return self.weight * np.concatenate([test.stress for test in self.tests])


def make_problem(tests: list[Test], relative: bool = False, balance: bool = False) -> Problem:
    """Return the problem of fitting ``tests``.

    relative: residuals in parts of the measured stress. balance: every test counts alike, however
    many points it has and however large its stress.
    """
    weights = []
    for test in tests:
        largest = float(np.max(np.abs(test.stress)))
        if largest == 0.0:
            raise SpecError(f"{test.label}: the stress is zero throughout")
        weight = np.ones(len(test.stress))
        if relative:
            weight = 1.0 / np.maximum(np.abs(test.stress), RELATIVE_FLOOR * largest)
        if balance:
            weight = weight / np.sqrt(np.sum((weight * test.stress) ** 2))
        weights.append(weight)
    return Problem(tuple(tests), tuple(weights))


def model_stress(candidate: Candidate, vector: np.ndarray, test: Test) -> np.ndarray:
    """Return the law's nominal stress (n,) in MPa at the stretches of ``test``."""
    k = candidate.constants(vector)
    if candidate.law.anisotropic:
        direction = test.direction or "course"
        return sheet_stress(candidate.law, k, test.mode, direction, test.stretch, test.other)
    if test.mode == "biaxial":
        return sheet_stress(candidate.law, k, test.mode, test.direction, test.stretch, test.other)
    return nominal_stress(candidate.law, k, test.mode, test.stretch)


def _all_stress(problem: Problem, candidate: Candidate, vector: np.ndarray) -> np.ndarray:
    """The law's stress at all points of a problem, in one evaluation where that is possible."""
    if problem.paths is None or candidate.law.anisotropic:
        return np.concatenate([model_stress(candidate, vector, test) for test in problem.tests])
    return path_stress(candidate.law, candidate.constants(vector), *problem.paths)


def residuals(problem: Problem, candidate: Candidate, vector: np.ndarray) -> np.ndarray:
    """Return the weighted residuals (n,), model less data; large where the law has no value."""
    stress = _all_stress(problem, candidate, vector)
    lost = ~np.isfinite(stress)
    if np.any(lost):
        stress = np.where(lost, problem.ceiling, stress)
    return problem.weight * stress - problem.data


@dataclass(frozen=True)
class Solution:
    """Where an optimiser arrived. cost: sum of the squared weighted residuals."""

    vector: np.ndarray
    cost: float
    evaluations: int
    starts: int


def solve(
    problem: Problem,
    candidate: Candidate,
    method: str = "least-squares",
    starts: int = 8,
    seed: int = 0,
    first: np.ndarray | None = None,
) -> Solution:
    """Return the best solution found from several starts.

    Starts are drawn for the constants in which the stress is not linear; the linear ones follow
    from them by bounded linear least squares. ``first`` is one more start. Raises SpecError for
    fewer points than constants and for an unknown method.
    """
    if method not in METHODS:
        raise SpecError(f"--method: '{method}' is none of {', '.join(METHODS)}")
    if problem.size <= len(candidate.parameters):
        raise SpecError(
            f"{candidate.name} has {len(candidate.parameters)} constants; "
            f"{problem.size} points do not determine them"
        )
    if not candidate.parameters:
        vector = np.zeros(0)
        return Solution(vector, float(np.sum(residuals(problem, candidate, vector) ** 2)), 1, 0)
    # A start may lie where a law overflows; its residual is then large, and that is all.
    with np.errstate(all="ignore"):
        return _from_many(problem, candidate, method, starts, seed, first)


def _from_many(problem, candidate, method, starts, seed, first) -> Solution:
    """Descend roughly from every start and finely from the best end."""
    points = _starts(problem, candidate, starts, seed)
    if first is not None:
        points.insert(0, np.clip(first, candidate.lower, candidate.upper))
    evaluations, best, best_cost = 0, None, np.inf
    for point in points:
        vector, count = _descend(problem, candidate, method, point, ROUGH)
        cost = float(np.sum(residuals(problem, candidate, vector) ** 2))
        evaluations += count
        if cost < best_cost:
            best, best_cost = vector, cost
    if best is None:
        raise SpecError(f"{candidate.name}: no start of the optimiser leads to finite stresses")
    vector, count = _descend(problem, candidate, method, best, FINE)
    cost = float(np.sum(residuals(problem, candidate, vector) ** 2))
    if cost < best_cost:
        best, best_cost = vector, cost
    return Solution(best, best_cost, evaluations + count, len(points))


def _starts(problem: Problem, candidate: Candidate, count: int, seed: int) -> list[np.ndarray]:
    """The best of many drawn starts; a single one for laws that are linear in their constants."""
    curved = [i for i, p in enumerate(candidate.parameters) if not p.linear]
    if not curved:
        return [_with_linear(problem, candidate, np.zeros(len(candidate.parameters)))]
    rng = np.random.default_rng(seed)
    coarse = _thinned(problem)
    drawn = []
    for _ in range(12 * count):
        vector = np.zeros(len(candidate.parameters))
        vector[curved] = [_draw(rng, candidate.parameters[i]) for i in curved]
        vector = _with_linear(coarse, candidate, vector)
        cost = float(np.sum(residuals(coarse, candidate, vector) ** 2))
        drawn.append((cost, tuple(vector)))
    drawn.sort()
    return [np.array(vector) for _, vector in drawn[:count]]


def _draw(rng: np.random.Generator, parameter: Parameter) -> float:
    low, high = parameter.seek
    if parameter.logarithmic:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))
    value = float(rng.uniform(low, high))
    return value if value else high


def _thinned(problem: Problem, most: int = 40) -> Problem:
    """A problem of few points, for sorting starts."""
    tests, weights = [], []
    for test, weight in zip(problem.tests, problem.weights, strict=True):
        keep = np.unique(np.linspace(0, len(test.stress) - 1, most).astype(int))
        other = None if test.other is None else test.other[keep]
        tests.append(
            Test(test.name, test.mode, test.stretch[keep], test.stress[keep], test.direction, other)
        )
        weights.append(weight[keep])
    return Problem(tuple(tests), tuple(weights))


def _with_linear(problem: Problem, candidate: Candidate, vector: np.ndarray) -> np.ndarray:
    """Return ``vector`` with its linear constants by least squares, the others held."""
    linear = [i for i, p in enumerate(candidate.parameters) if p.linear]
    if not linear:
        return vector
    scale = _modulus(problem)
    base = vector.copy()
    base[linear] = 0.0
    offset = _model(problem, candidate, base)
    columns = []
    for i in linear:
        probe = base.copy()
        probe[i] = scale
        columns.append(_model(problem, candidate, probe) - offset)
    matrix, data = np.stack(columns, axis=1), problem.data - offset
    good = np.all(np.abs(matrix) < 1e50, axis=1)  # exponentials of a wild start
    size = np.sqrt(np.sum(matrix[good] ** 2, axis=0))
    size[~(size > 0)] = 1.0
    bounds = candidate.lower[linear] * size, candidate.upper[linear] * size
    if not np.any(good):
        return np.where([p.linear for p in candidate.parameters], scale, vector)
    found = lsq_linear(matrix[good] / size, data[good], bounds=bounds, lsmr_tol="auto")
    result = vector.copy()
    result[linear] = scale * found.x / size
    return result


def _model(problem: Problem, candidate: Candidate, vector: np.ndarray) -> np.ndarray:
    return problem.weight * _all_stress(problem, candidate, vector)


def _modulus(problem: Problem) -> float:
    return max(abs(float(np.mean([secant_modulus(t) for t in problem.tests]))), 1e-12)


def parameter_scale(problem: Problem, candidate: Candidate, vector: np.ndarray) -> np.ndarray:
    """Return the size by which each constant is measured: its value, or a modulus, or its range."""
    modulus = _modulus(problem)
    scale = []
    for parameter, value in zip(candidate.parameters, vector, strict=True):
        usual = modulus if parameter.linear else 0.1 * (parameter.seek[1] - parameter.seek[0])
        scale.append(max(abs(value), 1e-3 * usual))
    return np.array(scale)


def _descend(problem, candidate, method, start, tolerance) -> tuple[np.ndarray, int]:
    scale = parameter_scale(problem, candidate, start)
    if method == "least-squares":
        low, high = candidate.lower, candidate.upper
        # An interior-point method: a start on a bound would be stuck there.
        room = 1e-8 * np.maximum(scale, 1e-12)
        inside = np.clip(start, np.where(np.isfinite(low), low + room, low),
                         np.where(np.isfinite(high), high - room, high))  # fmt: skip
        found = least_squares(
            lambda v: residuals(problem, candidate, v),
            inside,
            jac="3-point" if tolerance == FINE else "2-point",
            bounds=(low, high),
            x_scale="jac",
            ftol=tolerance,
            xtol=tolerance,
            gtol=tolerance,
            max_nfev=300 if tolerance == FINE else 60,
        )
        return found.x, int(found.nfev)
    return _descend_scalar(problem, candidate, method, start, scale)


def _descend_scalar(problem, candidate, method, start, scale) -> tuple[np.ndarray, int]:
    """One of scipy's general minimisers on the sum of squares, in scaled constants."""
    total = float(np.sum(problem.data**2))
    low, high = candidate.lower / scale, candidate.upper / scale

    def cost(z: np.ndarray) -> float:
        inside = np.clip(z, low, high)
        outside = float(np.sum((z - inside) ** 2))
        return float(np.sum(residuals(problem, candidate, inside * scale) ** 2)) / total + outside

    options = {"maxiter": 20000 if method in ("Nelder-Mead", "Powell", "COBYLA") else 2000}
    extra = {}
    if method in ("L-BFGS-B", "SLSQP", "Nelder-Mead", "Powell"):
        bounds = [(a if np.isfinite(a) else None, b if np.isfinite(b) else None)
                  for a, b in zip(low, high, strict=True)]  # fmt: skip
        extra["bounds"] = bounds
    if method in ("Nelder-Mead",):
        options |= {"adaptive": True, "xatol": 1e-9, "fatol": 1e-14}
    if method in ("L-BFGS-B", "SLSQP"):
        options |= {"ftol": 1e-15}
    tolerance = 1e-9 if method in ("COBYLA", "CG", "Powell") else None
    with warnings.catch_warnings():
        # Powell warns of starts on a bound and CG of lost precision; the cost decides anyway.
        warnings.simplefilter("ignore")
        found = minimize(
            cost, start / scale, method=method, tol=tolerance, options=options, **extra
        )
    return np.clip(found.x, low, high) * scale, int(found.nfev)
