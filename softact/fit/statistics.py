"""How good a fit is and what it determines: R², confidence, identifiability, AIC and BIC."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from softact.fit.candidates import Candidate
from softact.fit.data import Test
from softact.fit.problem import Problem, model_stress, parameter_scale, residuals

# A direction of constants along which the stresses change by less than this part of what the
# best determined direction changes them is not determined by the data.
DETERMINED = 1e-7
ON_BOUND = 1e-6
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Quality:
    """Agreement of a law with one test, in nominal stress (MPa)."""

    name: str
    mode: str
    points: int
    r2: float
    rmse: float
    largest_error: float


def quality(candidate: Candidate, vector: np.ndarray, test: Test) -> Quality:
    """Return R², root mean square error and largest error on one test."""
    error = model_stress(candidate, vector, test) - test.stress
    total = float(np.sum((test.stress - np.mean(test.stress)) ** 2))
    return Quality(
        name=test.label,
        mode=test.mode,
        points=len(error),
        r2=1.0 - float(np.sum(error**2)) / total if total > 0 else float("nan"),
        rmse=float(np.sqrt(np.mean(error**2))),
        largest_error=float(np.max(np.abs(error))),
    )


@dataclass(frozen=True)
class Certainty:
    """What the data say about the constants.

    interval: half width of the 95 % confidence interval per constant, infinite where the data do
    not determine it. free: directions of constants (scaled to their sizes) that change no stress.
    """

    interval: np.ndarray
    free: tuple[dict[str, float], ...]

    @property
    def identifiable(self) -> bool:
        """Whether the data determine every constant."""
        return not self.free


def certainty(problem: Problem, candidate: Candidate, vector: np.ndarray) -> Certainty:
    """Return confidence intervals from the Jacobian at the solution (linearised, Student's t).

    A constant that lies on a bound is left out of the covariance and has no interval.
    """
    count = len(vector)
    if count == 0:
        return Certainty(np.zeros(0), ())
    jacobian = _jacobian(problem, candidate, vector)
    effect = np.linalg.norm(jacobian, axis=0)
    # On a bound: going there would change the stresses by nothing that matters.
    distance = np.minimum(np.abs(vector - candidate.lower), np.abs(candidate.upper - vector))
    with np.errstate(invalid="ignore"):
        near = distance * effect < ON_BOUND * np.linalg.norm(problem.data)
    inside = np.flatnonzero(~near)
    interval = np.full(count, np.nan)
    if len(inside) == 0:
        return Certainty(interval, ())
    # Every column in units of its own effect, so that MPa and exponents compare.
    size = np.where(effect > 0, effect, 1.0)[inside]
    _, singular, directions = np.linalg.svd(jacobian[:, inside] / size, full_matrices=False)
    weak = singular < DETERMINED * singular[0]
    free = tuple(_direction(candidate, inside, direction / size) for direction in directions[weak])
    freedom = max(problem.size - len(inside), 1)
    variance = float(np.sum(residuals(problem, candidate, vector) ** 2)) / freedom
    strong = directions[~weak].T / singular[~weak]
    deviation = np.sqrt(variance * np.sum(strong**2, axis=1)) / size
    half = student.ppf(0.5 + 0.5 * CONFIDENCE, freedom) * deviation
    half[np.any(np.abs(directions[weak]) > 1e-3, axis=0)] = np.inf
    interval[inside] = half
    return Certainty(interval, free)


def _jacobian(problem: Problem, candidate: Candidate, vector: np.ndarray) -> np.ndarray:
    """Derivatives of the residuals with respect to the constants, central differences."""
    columns = []
    # In parts of the constant's size: one that is nearly 0 would give a step of no effect, or of 0.
    for i, size in enumerate(parameter_scale(problem, candidate, vector)):
        step = np.zeros(len(vector))
        step[i] = 1e-5 * size
        up = residuals(problem, candidate, vector + step)
        down = residuals(problem, candidate, vector - step)
        columns.append((up - down) / (2.0 * step[i]))
    return np.stack(columns, axis=1)


def _direction(candidate: Candidate, inside: np.ndarray, direction: np.ndarray) -> dict[str, float]:
    largest = np.argmax(np.abs(direction))
    share = direction / direction[largest]
    return {
        candidate.parameters[i].name: float(value)
        for i, value in zip(inside, share, strict=True)
        if abs(value) > 1e-3
    }


def explain(free: tuple[dict[str, float], ...], tests: tuple[Test, ...]) -> str:
    """Return a sentence about constants that the tests do not tell apart."""
    modes = sorted({test.mode for test in tests})
    said = " and ".join(modes)
    names = list(dict.fromkeys(name for direction in free for name in direction))
    beside = {"planar": "uniaxial or equibiaxial", "uniaxial": "equibiaxial",
              "equibiaxial": "uniaxial"}  # fmt: skip
    wanted = beside.get(modes[0], "another") if len(modes) == 1 else "another"
    advice = f"add a test in {wanted} tension"
    if len(names) == len(free):
        return f"{' and '.join(names)} change no stress in these tests ({said}): not determined"
    if len(names) == 2:
        first, second = names
        factor = -free[0][first] / free[0][second]
        size = "" if abs(abs(factor) - 1) < 1e-3 else f"{abs(factor):.3g} "
        combination = f"{first} {'+' if factor > 0 else '-'} {size}{second}"
        return (
            f"{first} and {second} are not told apart: {said} data determine only {combination}; "
            f"{advice}"
        )
    return (
        f"{', '.join(names[:-1])} and {names[-1]} are not told apart: {said} data determine only "
        f"{len(names) - len(free)} of their {len(names)} combinations; {advice}"
    )


@dataclass(frozen=True)
class Information:
    """Akaike's (corrected for few points) and Bayes' criterion; smaller is better."""

    aicc: float
    bic: float


def information(problem: Problem, parameters: int, cost: float) -> Information:
    """Return AICc and BIC of a fit with Gaussian residuals of unknown variance.

    The variance counts as a constant too. Burnham and Anderson 2002, eqs. 2.4 and 6.2.
    """
    n, k = problem.size, parameters + 1
    floor = 1e-30 * float(np.sum(problem.data**2))
    likelihood = n * np.log(max(cost, floor) / n)
    correction = 2.0 * k * (k + 1) / (n - k - 1) if n > k + 1 else float("inf")
    return Information(float(likelihood + 2 * k + correction), float(likelihood + k * np.log(n)))


@dataclass(frozen=True)
class Spread:
    """Scatter between specimens of one mode.

    stress: mean coefficient of variation of the stress over the common stretch range.
    strength: that of the largest stress; largest_stretch: that of the largest stretch.
    """

    mode: str
    specimens: int
    stress: float
    strength: float
    largest_stretch: float


def _common(tests: list[Test]) -> tuple[np.ndarray, np.ndarray] | None:
    """Common stretches (m,) and the stress of each test there (tests, m)."""
    low = max(float(np.min(t.stretch)) for t in tests)
    high = min(float(np.max(t.stretch)) for t in tests)
    if not high > low:
        return None
    grid = np.linspace(low, high, 50)
    values = []
    for test in tests:
        order = np.argsort(test.stretch)
        values.append(np.interp(grid, test.stretch[order], test.stress[order]))
    return grid, np.array(values)


def spreads(tests: tuple[Test, ...]) -> list[Spread]:
    """Return the scatter of every mode that was tested on several specimens."""
    result = []
    for group in _groups(tests):
        common = _common(group)
        if common is None:
            continue
        _, values = common
        mean, deviation = np.mean(values, axis=0), np.std(values, axis=0, ddof=1)
        count = np.abs(mean) > 0.1 * np.max(np.abs(mean))
        peaks = np.array([np.max(np.abs(t.stress)) for t in group])
        ends = np.array([np.max(np.abs(t.stretch - 1.0)) for t in group])
        result.append(
            Spread(
                mode=group[0].mode,
                specimens=len(group),
                stress=float(np.mean(deviation[count] / np.abs(mean[count]))),
                strength=float(np.std(peaks, ddof=1) / np.mean(peaks)),
                largest_stretch=float(np.std(ends, ddof=1) / np.mean(ends)),
            )
        )
    return result


def _groups(tests: tuple[Test, ...]) -> list[list[Test]]:
    kinds: dict[tuple[str, str | None, bool], list[Test]] = {}
    for test in tests:
        if test.mode != "biaxial":
            sense = bool(np.mean(test.stretch) > 1.0)
            kinds.setdefault((test.mode, test.direction, sense), []).append(test)
    return [group for group in kinds.values() if len(group) > 1]


def reduced_chi_square(
    problem: Problem, candidate: Candidate, vector: np.ndarray, sigma: float | None
) -> float | None:
    """Return Σ ((model − data)/σ)² / (points − constants).

    sigma: standard deviation of the stress in MPa; None takes the scatter between specimens, and
    the result is None where there is only one specimen of a mode.
    """
    total, points = 0.0, 0
    groups = {id(t): group for group in _groups(problem.tests) for t in group}
    for test in problem.tests:
        deviation: np.ndarray | float | None = sigma
        if deviation is None:
            common = _common(groups[id(test)]) if id(test) in groups else None
            if common is None:
                return None
            grid, values = common
            at_points = np.std(values, axis=0, ddof=1)
            if np.max(at_points) <= 1e-9 * np.max(np.abs(values)):
                return None  # one specimen, given twice
            # Near zero load all specimens agree by definition; do not let that dominate.
            at_points = np.maximum(at_points, 0.1 * np.max(at_points))
            deviation = np.interp(test.stretch, grid, at_points)
        error = model_stress(candidate, vector, test) - test.stress
        total += float(np.sum((error / deviation) ** 2))
        points += len(error)
    return total / max(points - len(vector), 1)


def normalised_error(problem: Problem, candidate: Candidate, vector: np.ndarray) -> float:
    """Return ε = √(Σ error² / (points − constants)) / mean stress, as in the HGO literature.

    Holzapfel, Sommer, Gasser and Regitnig 2005, Am. J. Physiol. 289:H2048.
    """
    errors = [model_stress(candidate, vector, t) - t.stress for t in problem.tests]
    error = np.concatenate(errors)
    mean = float(np.mean(np.abs(np.concatenate([t.stress for t in problem.tests]))))
    return float(np.sqrt(np.sum(error**2) / max(len(error) - len(vector), 1)) / mean)
