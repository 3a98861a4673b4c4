"""What memory costs: processor time of a viscoelastic increment beside an elastic one.

``python -m benchmarks.viscoelastic [cells]``: a block of 14 × 6 × 6 hexahedra cut into tetrahedra,
or of another number along its length, pulled and bent in ten increments; each case in a process of
its own, twice.
"""

from __future__ import annotations

import resource
import subprocess
import sys

from softact.loads.load_step import LoadStep
from softact.loads.timing import Timing
from softact.materials import LAWS
from tests.analytic.meshes import block
from tests.analytic.solving import CLAMP, build, solve

CREEPS = {"g": [0.2, 0.1, 0.1], "tau": ["0.1 s", "1 s", "10 s"], "constants": "long_time"}
CASES = {
    "elastic": {},
    "viscoelastic": {"viscoelastic": CREEPS},
    "softening": {"mullins": {"r": 1.5, "m": "1 kPa"}},
}


def seconds(case: str, cells: int) -> float:
    """Processor time of an increment (user), s."""
    law = LAWS["yeoh"].of(c10=0.1, c20=0.02, bulk_modulus=50.0, **CASES[case])
    model = build(block((cells, 6, 6), (float(cells), 6.0, 6.0)), law)
    step = LoadStep("pull", timing=Timing(2.0), traction={"x_max": [0.02, 0.0, 0.01]})
    before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    solution = solve(model, step, [CLAMP], 0.1, time_tolerance=1e9)
    after = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    return (after - before) / (len(solution.path) - 1)


def main() -> None:
    """Print the times of all cases, each by the elastic one of its round."""
    if len(sys.argv) > 2:
        print(seconds(sys.argv[1], int(sys.argv[2])))
        return
    cells = sys.argv[1] if len(sys.argv) > 1 else "14"
    for _ in range(2):
        command = [sys.executable, "-m", "benchmarks.viscoelastic"]
        found = {c: float(subprocess.check_output([*command, c, cells])) for c in CASES}
        for case, time in found.items():
            print(f"{case:13s} {time:6.3f} s, {time / found['elastic']:.2f} of an elastic one")


if __name__ == "__main__":
    main()
