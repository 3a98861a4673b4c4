"""One law fitted to tests, with everything that is known about the fit; many laws ranked."""

from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from softact.fit.candidates import Candidate
from softact.fit.data import Test
from softact.fit.merit import Merit, merits
from softact.fit.modes import MODES, first_invariant, stretch_reaching
from softact.fit.optimise import Solution, solve
from softact.fit.problem import Problem, make_problem, model_stress, reweighted
from softact.fit.stability import Stability, drucker
from softact.fit.statistics import (
    Certainty,
    Information,
    Quality,
    Spread,
    certainty,
    explain,
    information,
    normalised_error,
    quality,
    reduced_chi_square,
    spreads,
)

POOR = 0.95  # R² below which a law does not follow the data
REWEIGHTINGS = 12  # at most; two or three do where the law suits the data
# Laws that are not functions of Ī1 alone: one mode does not fix what they do in the others.
TWO_INVARIANTS = ("mooney_rivlin", "ogden", "van_der_waals")


@dataclass(frozen=True)
class Options:
    """How to fit, see ``optimise``. sigma: standard deviation of the stress in MPa or None."""

    relative: bool = False
    balance: bool = False
    method: str = "least-squares"
    starts: int = 8
    seed: int = 0
    sigma: float | None = None


@dataclass(frozen=True)
class Specimen:
    """The constants of a fit to one specimen alone."""

    name: str
    vector: np.ndarray


@dataclass(frozen=True)
class Fit:
    """A fitted law: the constants ``vector`` (MPa) of ``candidate`` and how good they are.

    chi_square: reduced, None without a known scatter. error: ε of ``normalised_error``.
    stability: empty for fibre laws, whose range depends on the direction. merit: beside other laws,
    see ``ranked``.
    """

    candidate: Candidate
    vector: np.ndarray
    problem: Problem
    solution: Solution
    qualities: tuple[Quality, ...]
    certainty: Certainty
    information: Information
    chi_square: float | None
    error: float
    stability: tuple[Stability, ...]
    spreads: tuple[Spread, ...]
    specimens: tuple[Specimen, ...]
    merit: Merit | None = None

    @property
    def name(self) -> str:
        """Name of the candidate."""
        return self.candidate.name

    @property
    def worth(self) -> Merit:
        """The merit of a fit out of ``ranked``. Raises ValueError for one that was never ranked."""
        if self.merit is None:
            raise ValueError(f"the fit of {self.name} has not been ranked")
        return self.merit

    @property
    def r2(self) -> float:
        """The smallest R² of the tests."""
        return min(q.r2 for q in self.qualities)

    @property
    def stretch_range(self) -> tuple[float, float]:
        """Smallest and largest stretch of the tests, 1 included."""
        every = np.concatenate([t.stretch for t in self.problem.tests])
        return min(1.0, float(np.min(every))), max(1.0, float(np.max(every)))

    def range_of(self, mode: str) -> tuple[float, float]:
        """Smallest and largest stretch tested in a mode.

        For a mode that was not tested: where Ī1 is as large as the tests made it.
        """
        own = [t.stretch for t in self.problem.tests if t.mode == mode]
        if own:
            every = np.concatenate(own)
            return min(1.0, float(np.min(every))), max(1.0, float(np.max(every)))
        tests = [t for t in self.problem.tests if t.mode in MODES]
        if not tests:
            return self.stretch_range
        reached = max(float(np.max(first_invariant(t.mode, t.stretch))) for t in tests)
        low, high = self.stretch_range
        return (
            stretch_reaching(mode, reached, low) if low < 0.97 else 1.0,
            stretch_reaching(mode, reached, high) if high > 1.03 else 1.0,
        )

    @property
    def failures(self) -> list[tuple[str, float]]:
        """Modes in which the law is unstable within the tested range, with the stretch."""
        found = [(s.mode, s.fails_within(*self.range_of(s.mode))) for s in self.stability]
        return [(mode, stretch) for mode, stretch in found if stretch is not None]

    @property
    def sound(self) -> bool:
        """Whether the law is stable over the tested range and its constants are determined."""
        return not self.failures and self.certainty.identifiable

    @property
    def loose(self) -> list[str]:
        """Constants whose interval is wider than their value."""
        triples = zip(self.candidate.names, self.vector, self.certainty.interval, strict=True)
        return [name for name, v, half in triples if np.isfinite(half) and half > abs(v)]

    def stress(self, test: Test) -> np.ndarray:
        """Return the law's nominal stress in MPa at the stretches of ``test``."""
        return model_stress(self.candidate, self.vector, test)

    @property
    def _twins(self) -> str:
        """Terms of Ogden's law that became one."""
        exponents = {p.name: v for p, v in zip(self.candidate.parameters, self.vector, strict=True)
                     if p.name.startswith("alpha")}  # fmt: skip
        pairs = [
            f"{a} and {b}"
            for a, b in combinations(exponents, 2)
            if abs(exponents[a] - exponents[b]) < 1e-3
        ]
        return ", ".join(pairs)

    def remarks(self) -> list[str]:
        """Return what a user must know before using the constants."""
        lines = [
            f"R² {q.r2:.3f} on {q.name}: the law does not follow these data"
            for q in self.qualities
            if q.r2 < POOR
        ]
        for mode, stretch in self.failures:
            low, high = self.range_of(mode)
            where = "below" if stretch < 1 else "above"
            lines.append(
                f"unstable (Drucker) in {mode} deformation {where} a stretch of {stretch:.3g}; "
                f"the tests reach from {low:.3g} to {high:.3g}"
            )
        if self._twins:
            lines.append(
                f"{self._twins} have the same exponent: a lower order describes these data as well"
            )
        elif self.certainty.free:
            lines.append(explain(self.certainty.free, self.problem.tests))
        modes = {test.mode for test in self.problem.tests}
        if len(modes) == 1 and self.name.startswith(TWO_INVARIANTS) and self.vector.size > 1:
            lines.append(
                f"only {modes.pop()} tests: what the law predicts in other modes rests on no data"
            )
        if self.loose:
            said = ", ".join(self.loose)
            lines.append(f"poorly determined (interval wider than the value): {said}")
        bound = [
            p.name
            for p, half in zip(self.candidate.parameters, self.certainty.interval, strict=True)
            if np.isnan(half)
        ]
        if bound:
            lines.append(f"at the bound of what is allowed: {', '.join(bound)}")
        return lines


def fit(tests: list[Test], candidate: Candidate, options: Options | None = None) -> Fit:
    """Fit a law to tests. Raises SpecError where the data cannot determine it at all."""
    options = options or Options()
    problem = make_problem(tests, options.relative, options.balance)
    solution = solve(problem, candidate, options.method, options.starts, options.seed)
    if options.relative:
        problem, solution = _with_own_weights(problem, candidate, solution, options.method)
    vector = solution.vector
    isotropic = not candidate.law.anisotropic
    return Fit(
        candidate=candidate,
        vector=vector,
        problem=problem,
        solution=solution,
        qualities=tuple(quality(candidate, vector, test) for test in tests),
        certainty=certainty(problem, candidate, vector),
        information=information(problem, len(vector), solution.cost),
        chi_square=reduced_chi_square(problem, candidate, vector, options.sigma),
        error=normalised_error(problem, candidate, vector),
        stability=tuple(drucker(candidate.law, candidate.constants(vector))) if isotropic else (),
        spreads=tuple(spreads(problem.tests)),
        specimens=_each_specimen(tests, candidate, vector, options),
    )


def _with_own_weights(
    problem: Problem, candidate: Candidate, solution: Solution, method: str
) -> tuple[Problem, Solution]:
    """Weigh by the law's stress and solve again until the constants stay."""
    for _ in range(REWEIGHTINGS):
        before = solution.vector
        problem = reweighted(problem, candidate, before)
        solution = solve(problem, candidate, method, starts=1, first=before)
        if np.allclose(solution.vector, before, rtol=1e-8, atol=0.0):
            break
    return problem, solution


def _each_specimen(
    tests: list[Test], candidate: Candidate, vector: np.ndarray, options: Options
) -> tuple[Specimen, ...]:
    """Fit every specimen alone, from the joint solution, where several were tested in one mode."""
    modes = [(t.mode, t.direction) for t in tests]
    if len(set(modes)) > 1 or len(tests) < 2:
        return ()
    result = []
    for test in tests:
        problem = make_problem([test], options.relative, options.balance)
        if problem.size <= len(vector):
            continue
        alone = solve(problem, candidate, options.method, starts=2, first=vector)
        result.append(Specimen(test.name, alone.vector))
    return tuple(result)


def ranked(fits: list[Fit]) -> list[Fit]:
    """Return the fits with their merits, the best first, those that are not sound at the end.

    The order is that of ``Merit.error``.
    """
    laws = [(f.candidate, f.vector, len(f.loose)) for f in fits]
    found = merits(fits[0].problem, laws)
    return sorted(
        (replace(f, merit=m) for f, m in zip(fits, found, strict=True)),
        key=lambda f: (not f.sound, f.worth.error),
    )
