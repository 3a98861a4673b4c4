"""What the floor of relative residuals does to fitted constants, by tests that are drawn.

``python -m benchmarks.relative_floor``: uniaxial tests of known constants to a stretch of 2, of
100 points, with a scatter of 3 % of the stress and a load cell whose zero is off by so much of the
largest stress (standard deviation); fitted with ``--relative``, for each floor. Prints a table of
how far the mean of each constant is off, and how far one test scatters.
"""

from __future__ import annotations

import numpy as np

from softact.fit import problem as problems
from softact.fit.candidates import CANDIDATES
from softact.fit.data import Test
from softact.fit.fit import _with_own_weights
from softact.fit.modes import nominal_stress
from softact.fit.optimise import solve

FLOORS = (0.0, 0.02, 0.05)
ZEROS = (0.0, 0.005)
DRAWS, POINTS, SCATTER = 60, 100, 0.03
CONSTANTS = {"neo_hookean": {"c10": 0.14}, "reduced_polynomial_2": {"c10": 0.11, "c20": 0.02}}


def fitted(law: str, zero: float, floor: float) -> np.ndarray:
    """Constants (draws, constants) by their true values."""
    true = CANDIDATES[law].law.of(**CONSTANTS[law])
    stretch = np.linspace(1.0, 2.0, POINTS + 1)[1:]
    stress, draw = nominal_stress(true, true, "uniaxial", stretch), np.random.default_rng(0)
    problems.RELATIVE_FLOOR, found = max(floor, 1e-9), []
    for _ in range(DRAWS):
        offset = zero * stress.max() * draw.standard_normal()
        seen = stress * (1 + SCATTER * draw.standard_normal(POINTS)) + offset
        problem = problems.make_problem([Test("test", "uniaxial", stretch, seen)], relative=True)
        solution = solve(problem, CANDIDATES[law], starts=1)
        _, solution = _with_own_weights(problem, CANDIDATES[law], solution, "least-squares")
        found.append(solution.vector)
    return np.array(found) / list(CONSTANTS[law].values())


def main() -> None:
    """Print the table."""
    print("| law | zero off by | floor | c10 | c20 |")
    print("| --- | --- | --- | --- | --- |")
    for law in CONSTANTS:
        for zero in ZEROS:
            for floor in FLOORS:
                found = fitted(law, zero, floor)
                off, spread = 100 * (found.mean(axis=0) - 1), 100 * found.std(axis=0)
                off = np.round(off, 2) + 0.0
                cells = [f"{o:+.2f} ± {s:.1f} %" for o, s in zip(off, spread, strict=True)]
                cells += [""] * (2 - len(cells))
                row = (law, f"{100 * zero:g} %", f"{100 * floor:g} %", *cells)
                print(f"| {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main()
