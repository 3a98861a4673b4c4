"""What the floor of relative residuals does to fitted constants, by tests that are drawn.

``python -m benchmarks.relative_floor``: uniaxial tests of known constants to a stretch of 2, of
100 points, with a scatter of 3 % of the stress and a zero of the load cell that is off by so much
of the largest stress; fitted with ``--relative``, for each floor. Prints a table of how far the mean
of each constant is off, and how far one test scatters.
"""

from __future__ import annotations

import numpy as np

from softact.fit import problem as problems
from softact.fit.candidates import CANDIDATES
from softact.fit.data import Test
from softact.fit.fit import _with_own_weights
from softact.fit.modes import nominal_stress
from softact.fit.optimise import solve
from softact.materials import LAWS

FLOORS = (0.0, 0.005, 0.02, 0.05)
ZEROS = (0.0, 0.002, 0.01)
DRAWS, POINTS, SCATTER = 200, 100, 0.03
CONSTANTS = {"neo_hookean": {"c10": 0.14}, "yeoh": {"c10": 0.11, "c20": 0.02, "c30": 0.002}}


def fitted(law: str, zero: float, floor: float) -> np.ndarray:
    """Constants (draws, constants) by their true values."""
    true = LAWS[law].of(**CONSTANTS[law])
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
    print("| law | zero off by | floor | " + " | ".join(("c10", "c20", "c30")) + " |")
    print("| --- " * 6 + "|")
    for law in CONSTANTS:
        for zero in ZEROS:
            for floor in FLOORS:
                found = fitted(law, zero, floor)
                pairs = zip(
                    100 * (np.mean(found, axis=0) - 1), 100 * np.std(found, axis=0), strict=True
                )
                cells = [f"{mean:+.2f} ± {spread:.1f} %" for mean, spread in pairs]
                cells += [""] * (3 - len(cells))
                print(
                    f"| {law} | {100 * zero:g} % | {100 * floor:g} % | {' | '.join(cells)} |",
                    flush=True,
                )


if __name__ == "__main__":
    main()
