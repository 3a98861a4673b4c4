"""What is fitted: tests with their weights, and the residuals of a law on them."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from softact.errors import SpecError
from softact.fit.candidates import Candidate
from softact.fit.data import Test
from softact.fit.modes import MODES, nominal_stress, path_stress, sheet_stress
from softact.fit.plausible import secant_modulus

UNREACHED = 1e3  # residual, in units of the largest stress, where a law has no value
RELATIVE_FLOOR = 0.02  # of the largest stress of a test: below it a relative residual is absolute


@dataclass(frozen=True)
class Problem:
    """Tests and how their residuals count.

    weights: per test, an array (n,) that multiplies the residual in MPa. relative, balance: how
    they were made, see ``make_problem``.
    """

    tests: tuple[Test, ...]
    weights: tuple[np.ndarray, ...]
    relative: bool = False
    balance: bool = False

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

    @cached_property
    def largest_invariant(self) -> float:
        """The larger of Ī1 and Ī2 that the tests reach; of biaxial ones at their stretches."""
        largest = 3.0
        for test in self.tests:
            if test.mode in MODES:
                powers = np.array(MODES[test.mode].powers)[:, None]
                stretches = test.stretch**powers
            else:
                stretches = np.stack([test.stretch, test.across, 1 / (test.stretch * test.across)])
            for sign in (2, -2):
                largest = max(largest, float(np.max(np.sum(stretches**sign, axis=0))))
        return largest

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

    relative: residuals in parts of the stress, where that is above ``RELATIVE_FLOOR`` of the
    largest. balance: every test counts alike, however many points it has and however large its
    stress.
    """
    for test in tests:
        if not np.any(test.stress):
            raise SpecError(f"{test.label}: the stress is zero throughout")
    weights = [_weights(test, test.stress, relative, balance) for test in tests]
    return Problem(tuple(tests), tuple(weights), relative, balance)


def _weights(test: Test, stress: np.ndarray, relative: bool, balance: bool) -> np.ndarray:
    """Weights (n,) of a test's residuals; stress: (n,) that relative ones are parts of."""
    weight = np.ones(len(test.stress))
    if relative:
        floor = RELATIVE_FLOOR * float(np.max(np.abs(test.stress)))
        weight = 1.0 / np.maximum(np.abs(stress), floor)
    if balance:
        weight = weight / np.sqrt(np.sum((weight * test.stress) ** 2))
    return weight


def reweighted(problem: Problem, candidate: Candidate, vector: np.ndarray) -> Problem:
    """Return the problem with relative residuals in parts of the law's stress, not the measured.

    Parts of the measured stress count points that noise makes small more than those that it makes
    large: a scatter of 3 % makes a modulus 0.2 % too small (twice the variance). Weights by the
    law's own stress, taken anew until they stay, have no such bias (Carroll and Ruppert 1988,
    Transformation and Weighting in Regression, section 2.1).
    """
    weights = []
    for test in problem.tests:
        stress = model_stress(candidate, vector, test)
        stress = np.where(np.isfinite(stress), stress, test.stress)
        weights.append(_weights(test, stress, problem.relative, problem.balance))
    return replace(problem, weights=tuple(weights))


def model_stress(candidate: Candidate, vector: np.ndarray, test: Test) -> np.ndarray:
    """Return the law's nominal stress (n,) in MPa at the stretches of ``test``."""
    k = candidate.constants(vector)
    if candidate.law.anisotropic or test.mode == "biaxial":
        direction = test.direction or "course"  # one is named for every biaxial test
        return sheet_stress(candidate.law, k, test.mode, direction, test.stretch, test.other)
    return nominal_stress(candidate.law, k, test.mode, test.stretch)


def all_stress(problem: Problem, candidate: Candidate, vector: np.ndarray) -> np.ndarray:
    """Return the law's stress (n,) in MPa at all points, in one evaluation where that can be."""
    if problem.paths is None or candidate.law.anisotropic:
        return np.concatenate([model_stress(candidate, vector, test) for test in problem.tests])
    return path_stress(candidate.law, candidate.constants(vector), *problem.paths)


def residuals(problem: Problem, candidate: Candidate, vector: np.ndarray) -> np.ndarray:
    """Return the weighted residuals (n,), model less data; large where the law has no value."""
    stress = all_stress(problem, candidate, vector)
    lost = ~np.isfinite(stress)
    if np.any(lost):
        stress = np.where(lost, problem.ceiling, stress)
    return problem.weight * stress - problem.data


def thinned(problem: Problem, most: int = 40) -> Problem:
    """Return a problem of few points, for sorting starts."""
    tests, weights = [], []
    for test, weight in zip(problem.tests, problem.weights, strict=True):
        keep = np.unique(np.linspace(0, len(test.stress) - 1, most).astype(int))
        other = None if test.other is None else test.other[keep]
        tests.append(
            Test(test.name, test.mode, test.stretch[keep], test.stress[keep], test.direction, other)
        )
        weights.append(weight[keep])
    return replace(problem, tests=tuple(tests), weights=tuple(weights))


def modulus(problem: Problem) -> float:
    """Return a stiffness in MPa that the tests show."""
    return max(abs(float(np.mean([secant_modulus(t) for t in problem.tests]))), 1e-12)


def parameter_scale(problem: Problem, candidate: Candidate, vector: np.ndarray) -> np.ndarray:
    """Return the size by which each constant is measured: its value, or a modulus, or its range."""
    stiffness = modulus(problem)
    scale = []
    for parameter, value in zip(candidate.parameters, vector, strict=True):
        low, high = parameter.range_at(problem.largest_invariant)
        usual = stiffness if parameter.linear else 0.1 * (high - low)
        scale.append(max(abs(value), 1e-3 * usual))
    return np.array(scale)
