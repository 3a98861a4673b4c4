"""What the load steps of fabric actuators cost, with this tree and with another.

``python -m benchmarks.sheets OTHER [SPEC ...] [--rounds 3]``: OTHER is a Python in which another
tree's softact is installed, SPECs are names of ``configs/``, by default all free fabric actuators.
Both solve each of this tree's specs on one process in turn; told are the medians of the processor
time of the load steps, their ratio, and the iterations of Newton's method.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
SPECS = (
    "woven_contracting", "woven_elongating", "woven_bending", "woven_stiffening_60",
    "woven_stiffening_90", "knit_bending", "knit_elongating", "knit_twisting",
)  # fmt: skip
# The seconds of run.json are then those of the processor, in the run's own process.
CLOCK = "import time\ntime.perf_counter = time.process_time\n"


def solved(python: str, name: str, folder: Path) -> tuple[float, int]:
    """Processor seconds of the load steps, and iterations."""
    (folder / "sitecustomize.py").write_text(CLOCK, encoding="utf-8")
    threads = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [python, "-m", "softact.cli.main", "run", str(ROOT / f"configs/{name}.yaml")]
    subprocess.run(
        [*command, "-n", "1", "-o", "r"],
        cwd=folder,
        env={**os.environ, **threads, "PYTHONPATH": str(folder)},
        check=True,
        stdout=subprocess.DEVNULL,
    )
    run = json.loads((folder / "r" / "run.json").read_text(encoding="utf-8"))
    return run["times_s"]["solve"], run["counts"]["newton_iterations"]


def main() -> None:
    print("| spec | other s | this s | ratio | iterations, other and this |")
    print("| --- | --- | --- | --- | --- |")
    for name in options.specs or SPECS:
        found = {options.other: [], sys.executable: []}
        with tempfile.TemporaryDirectory() as folder:
            for _ in range(options.rounds):
                for python, runs in found.items():
                    runs.append(solved(python, name, Path(folder)))
        other, this = (statistics.median(s for s, _ in runs) for runs in found.values())
        counts = " and ".join(str(runs[0][1]) for runs in found.values())
        print(f"| {name} | {other:.1f} | {this:.1f} | {other / this:.2f} | {counts} |", flush=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("other")
    parser.add_argument("specs", nargs="*")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    main()
