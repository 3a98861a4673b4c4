"""What a run costs beside its load steps, with this tree and with another.

``python -m benchmarks.beside_the_steps OTHER [--rounds 3] [-n 2]``: OTHER is the ``softact``
command of another tree. Both run ``benchmarks/pneunet8.yaml`` to 2 kPa in turn; told are the
medians of the seconds of the whole command less those of the load steps, of their parts, and of the
report alone.
"""

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SPEC = Path(__file__).with_name("pneunet8.yaml")
STAGES = ("mesh of", "all steps solved", "report")


def seconds(command: list[str], folder: Path) -> dict[str, float]:
    """Parts of one run and of one report of it, s."""
    started = time.perf_counter()
    run = [*command, "run", str(SPEC), "-n", str(options.processes), "-o", "r"]
    process = subprocess.Popen(
        [*run, "--set", "steps.0.pressure=2 kPa"], cwd=folder, stdout=subprocess.PIPE, text=True
    )
    marks = {}
    for line in process.stdout:
        marks |= {mark: time.perf_counter() - started for mark in STAGES if mark in line[:30]}
    if process.wait():
        raise SystemExit(f"{' '.join(run)}: exit code {process.returncode}")
    whole = time.perf_counter() - started
    times = json.loads((folder / "r" / "run.json").read_text())["times_s"]
    started, used = time.perf_counter(), processor()
    subprocess.run([*command, "report", "r"], cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return {
        "beside the load steps": whole - times["solve"],
        "start to first state": marks["mesh of"],
        "measures, fields, restart file": times["measure_and_write"],
        "report and end": whole - marks["all steps solved"],
        "softact report": time.perf_counter() - started,
        "softact report, processor": processor() - used,
        "load steps": times["solve"],
    }


def processor() -> float:
    """Processor seconds of all processes that were started and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    commands = {"other": [options.other], "this": [sys.executable, "-m", "softact.cli.main"]}
    found = {name: [] for name in commands}
    with tempfile.TemporaryDirectory() as name:
        for _ in range(options.rounds):
            for which, command in commands.items():
                found[which].append(seconds(command, Path(name)))
    print(f"load {os.getloadavg()[0]:.1f}; medians of {options.rounds}")
    for part in found["this"][0]:
        other, this = (statistics.median(r[part] for r in found[w]) for w in ("other", "this"))
        print(f"{part:32s} {other:6.2f} s  {this:6.2f} s  ratio {this / other:.2f}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("other")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("-n", "--processes", type=int, default=2)
    options = parser.parse_args()
    main()
