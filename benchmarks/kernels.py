"""What the kernels of OpenBLAS cost where it does not know the processor.

    python -m benchmarks.kernels [SPEC] [PROCESSES]

Medians of three runs with the kernels that softact has OpenBLAS take (its own choice where it
knows the processor), each followed by one with those that it takes for an unknown one.
"""

import json
import os
import statistics
import sys
import tempfile
from pathlib import Path

from softact.run import start as runs
from softact.spec import Spec, load
from softact.system import blas

SPEC = Path(__file__).with_name("pneunet8.yaml")
TIMES = "solve", "linear_solves"


def timed(spec: Spec, processes: int, environment: dict[str, str]) -> tuple[str, list[float]]:
    """Kernels of a run, and its times in s."""
    os.environ.pop(blas.VARIABLE, None)
    os.environ.update(environment)
    with tempfile.TemporaryDirectory() as folder:
        runs.run(spec, Path(folder) / "result", processes=processes, report=False)
        record = json.loads((Path(folder) / "result" / "run.json").read_text())
    return record["factorisation"]["kernels"], [record["times_s"][name] for name in TIMES]


def main(spec_file: str = str(SPEC), processes: str = "1") -> None:
    spec, better = load(spec_file), blas.variables()
    found: dict[str, list[list[float]]] = {}
    for _ in range(3):
        for environment in better, {blas.VARIABLE: blas.UNKNOWN}:
            kernels, times = timed(spec, int(processes), environment)
            found.setdefault(kernels, []).append(times)
    for kernels, runs_of in found.items():
        medians = [statistics.median(times) for times in zip(*runs_of, strict=True)]
        print(kernels, *(f"{name} {t:.2f} s" for name, t in zip(TIMES, medians, strict=True)))


if __name__ == "__main__":
    main(*sys.argv[1:])
