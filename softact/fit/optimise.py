"""Least squares of a law's stress on tests: starts by linear algebra, then a bounded optimiser."""

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares, lsq_linear, minimize

from softact.errors import SpecError
from softact.fit.candidates import Candidate, Parameter
from softact.fit.problem import Problem, all_stress, modulus, parameter_scale, residuals, thinned

METHODS = ("least-squares", "L-BFGS-B", "Nelder-Mead", "Powell", "CG", "COBYLA", "SLSQP")
APART = 0.1  # of the range in which starts are drawn: nearer ones are in one valley
ROUGH, FINE = 1e-8, 1e-14  # relative, of the descents from all starts and of the best one


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


def _from_many(
    problem: Problem,
    candidate: Candidate,
    method: str,
    starts: int,
    seed: int,
    first: np.ndarray | None,
) -> Solution:
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
    return Solution(candidate.settled(best), best_cost, evaluations + count, len(points))


def _starts(problem: Problem, candidate: Candidate, count: int, seed: int) -> list[np.ndarray]:
    """The best of many drawn starts; a single one for laws that are linear in their constants."""
    curved = [i for i, p in enumerate(candidate.parameters) if not p.linear]
    if not curved:
        return [_with_linear(problem, candidate, np.zeros(len(candidate.parameters)))]
    rng = np.random.default_rng(seed)
    coarse = thinned(problem)
    reached = problem.largest_invariant
    ranges = [candidate.parameters[i].range_at(reached) for i in curved]
    drawn = []
    for _ in range(12 * count):
        vector = np.zeros(len(candidate.parameters))
        pairs = zip(curved, ranges, strict=True)
        vector[curved] = [_draw(rng, candidate.parameters[i], ends) for i, ends in pairs]
        vector = _with_linear(coarse, candidate, vector)
        cost = float(np.sum(residuals(coarse, candidate, vector) ** 2))
        drawn.append((cost, tuple(vector)))
    drawn.sort()
    span = np.array([high - low for low, high in ranges])
    return _apart([np.array(vector) for _, vector in drawn], curved, span, count)


def _apart(
    points: list[np.ndarray], curved: list[int], span: np.ndarray, count: int
) -> list[np.ndarray]:
    """The first ``count`` of the points, best first, that are not all in one valley."""
    chosen: list[np.ndarray] = []
    left: list[np.ndarray] = []
    for point in points:
        near = any(np.max(np.abs((point - other)[curved] / span)) < APART for other in chosen)
        (left if near else chosen).append(point)
        if len(chosen) == count:
            return chosen
    return chosen + left[: count - len(chosen)]


def _draw(rng: np.random.Generator, parameter: Parameter, ends: tuple[float, float]) -> float:
    low, high = ends
    if parameter.logarithmic and low < high:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))
    value = float(rng.uniform(low, high)) if low < high else high
    return value if value else high


def _with_linear(problem: Problem, candidate: Candidate, vector: np.ndarray) -> np.ndarray:
    """Return ``vector`` with its linear constants by least squares, the others held."""
    linear = [i for i, p in enumerate(candidate.parameters) if p.linear]
    if not linear:
        return vector
    scale = modulus(problem)
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
    return problem.weight * all_stress(problem, candidate, vector)


def _descend(
    problem: Problem, candidate: Candidate, method: str, start: np.ndarray, tolerance: float
) -> tuple[np.ndarray, int]:
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


def _descend_scalar(
    problem: Problem, candidate: Candidate, method: str, start: np.ndarray, scale: np.ndarray
) -> tuple[np.ndarray, int]:
    """One of scipy's general minimisers on the sum of squares, in scaled constants."""
    total = float(np.sum(problem.data**2))
    low, high = candidate.lower / scale, candidate.upper / scale

    def cost(z: np.ndarray) -> float:
        inside = np.clip(z, low, high)
        outside = float(np.sum((z - inside) ** 2))
        return float(np.sum(residuals(problem, candidate, inside * scale) ** 2)) / total + outside

    options: dict[str, float] = {
        "maxiter": 20000 if method in ("Nelder-Mead", "Powell", "COBYLA") else 2000
    }
    bounds = None
    if method in ("L-BFGS-B", "SLSQP", "Nelder-Mead", "Powell"):
        bounds = [(a if np.isfinite(a) else None, b if np.isfinite(b) else None)
                  for a, b in zip(low, high, strict=True)]  # fmt: skip
    if method in ("Nelder-Mead",):
        options |= {"adaptive": True, "xatol": 1e-9, "fatol": 1e-14}
    if method in ("L-BFGS-B", "SLSQP"):
        options |= {"ftol": 1e-15}
    tolerance = 1e-9 if method in ("COBYLA", "CG", "Powell") else None
    with warnings.catch_warnings():
        # Powell warns of starts on a bound and CG of lost precision; the cost decides anyway.
        warnings.simplefilter("ignore")
        found = minimize(
            cost, start / scale, method=method, bounds=bounds, tol=tolerance, options=options
        )
    return np.clip(found.x, low, high) * scale, int(found.nfev)
