"""Kills at random moments of a 24-point sweep: nothing finished is lost, no point done twice.

``python -m benchmarks.sweep_kills [-k 50] [-j 2]`` starts the sweep again and again; each time it
kills (SIGKILL) the command or one of its solvers after a random time, and in the end lets it
finish. Where a sweep is complete before all kills are done, another one is begun.
"""

import argparse
import collections
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

SWEEP = """
base:
  geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
  materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
  steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
  solver: {initial_increment: 1, max_increment: 1}
axes:
  - {path: materials.body.c10, from: 0.1 MPa, to: 0.4 MPa, count: 4}
  - {path: geometry.length, from: 4 mm, to: 9 mm, count: 6}
"""
POINTS = 24


def start(folder: Path, jobs: int) -> subprocess.Popen:
    command = [sys.executable, "-m", "softact.cli.main", "sweep", "cube.yaml", "-j", str(jobs)]
    log = (folder / "log.txt").open("a")
    return subprocess.Popen(command, cwd=folder, stdout=log, stderr=log)


def processes_in(folder: Path) -> list[int]:
    """Processes other than the command whose arguments name the folder, or that stand in it."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and os.readlink(entry / "cwd") == str(folder):
                found.append(int(entry.name))
        except OSError:
            continue
    return found


def finished(folder: Path) -> list[str]:
    journal = folder / "results/.runs/journal.csv"
    return (
        [line.split(",")[1] for line in journal.read_text().splitlines()]
        if (journal.exists())
        else []
    )


def kill_once(folder: Path, jobs: int, seconds: float, whom: str) -> str:
    """Start the sweep and kill it or a solver of its; returns what was killed."""
    process = start(folder, jobs)
    try:
        process.wait(seconds)
        return "nothing"  # it had ended
    except subprocess.TimeoutExpired:
        pass
    children = [pid for pid in processes_in(folder) if pid != process.pid]
    if whom == "solver" and children:
        os.kill(random.choice(children), signal.SIGKILL)
        time.sleep(0.5)
        process.kill()
        process.wait()
        return "a solver, then the sweep"
    process.kill()
    process.wait()
    return "the sweep"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-k", "--kills", type=int, default=50)
    parser.add_argument("-j", "--jobs", type=int, default=2)
    parser.add_argument("--longest", type=float, default=24.0, help="seconds before a kill")
    options = parser.parse_args()
    random.seed(1)
    killed, sweeps, orphans, twice = collections.Counter(), 0, 0, 0
    while sum(killed.values()) < options.kills:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name).resolve()
            (folder / "cube.yaml").write_text(SWEEP)
            while sum(killed.values()) < options.kills and len(set(finished(folder))) < POINTS:
                whom = random.choice(["sweep", "solver"])
                what = kill_once(folder, options.jobs, random.uniform(2, options.longest), whom)
                time.sleep(0.3)
                orphans += len(processes_in(folder))
                if what != "nothing":
                    killed[what] += 1
                print(f"{sum(killed.values())}: {what}; {len(finished(folder))} runs", flush=True)
            code = start(folder, options.jobs).wait()
            runs = collections.Counter(finished(folder))
            twice += sum(count - 1 for count in runs.values())
            rows = (folder / "results/cube/sweep.csv").read_text().splitlines()[1:]
            complete = sum(",complete," in row for row in rows)
            left = list((folder / "results/.runs/tmp").iterdir())
            sweeps += 1
            print(f"sweep {sweeps}: exit {code}, {complete} of {len(rows)} complete, "
                  f"{len(runs)} runs computed, {len(left)} folders left over")  # fmt: skip
            if code or complete != POINTS or len(runs) != POINTS or left:
                return 1
    print(f"{dict(killed)}; {twice} runs computed twice; {orphans} processes outlived a kill")
    return 1 if twice or orphans else 0


if __name__ == "__main__":
    sys.exit(main())
