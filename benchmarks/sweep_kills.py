"""Kills at random moments of a command that computes many runs: nothing finished is lost, no run
done twice, and the outcome is that of a call that nobody disturbed.

``python -m benchmarks.sweep_kills [sweep|optimize|calibrate|converge] [-k 50] [-j 2] [--seed 1]``
starts the command again and again; each time it kills (SIGKILL) the command or one of its solvers
after a random time, and in the end lets it finish. Where one is complete before all kills are done,
another is begun.
"""

import argparse
import collections
import csv
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

CUBE = """
  geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
  materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
  steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
  solver: {initial_increment: 1, max_increment: 1}
"""
SWEEP = f"""
base:{CUBE}
axes:
  - {{path: materials.body.c10, from: 0.1 MPa, to: 0.4 MPa, count: 2}}
  - {{path: geometry.length, from: 4 mm, to: 9 mm, count: COUNT}}
"""
OPTIMISE = f"""
base:{CUBE}
parameters:
  - {{path: materials.body.c10, from: 0.1 MPa, to: 0.4 MPa}}
  - {{path: geometry.length, from: 4 mm, to: 9 mm}}
objectives: [{{measure: elongation_mm, goal: maximise}}]
constraints: [{{measure: max_principal_stretch, take: largest, below: 1.05}}]
reference: {{materials.body.c10: 0.2 MPa, geometry.length: 5 mm}}
trials: COUNT
"""
SPEC = CUBE.replace("\n  ", "\n")
DATA = "step_fraction,elongation_mm\n0.5,0.1\n1,0.21\n"


@dataclass(frozen=True)
class Study:
    """A command that computes many runs. outcome: what is in its folder, but for times."""

    files: dict[str, str]
    arguments: tuple[str, ...]
    folder: str
    outcome: Callable[[Path], Any]


def table(path: Path, without: set[str]) -> list[tuple]:
    """Rows of a CSV in an order of their own."""
    with path.open() as file:
        rows = [{k: v for k, v in row.items() if k not in without} for row in csv.DictReader(file)]
    return sorted(tuple(row.items()) for row in rows)


def studies(jobs: int, count: int) -> dict[str, Study]:
    """Sweep of twice ``count`` points, optimisation of so many trials, calibration of so many
    runs, convergence of three meshes."""
    each = ("-j", str(jobs))
    return {
        "sweep": Study(
            {"cube.yaml": SWEEP.replace("COUNT", str(count))},
            ("sweep", "cube.yaml", *each),
            "results/cube",
            lambda folder: table(folder / "sweep.csv", {"seconds"}),
        ),
        # So few that no trial depends on how the ones before it ended.
        "optimize": Study(
            {"cube.yaml": OPTIMISE.replace("COUNT", str(min(2 * count, 10)))},
            ("optimize", "cube.yaml", *each),
            "results/cube",
            lambda folder: table(folder / "trials.csv", {"trial"}),
        ),
        "calibrate": Study(
            {"cube.yaml": SPEC, "data.csv": DATA},
            (
                "calibrate",
                "cube.yaml",
                "--data",
                "data.csv",
                "--vary",
                "materials.body.c10",
                "--max-runs",
                str(2 * count),
            ),
            "results/cube-calibrated",
            lambda folder: json.loads((folder / "calibration.json").read_text()),
        ),
        "converge": Study(
            {"cube.yaml": SPEC},
            ("converge", "cube.yaml", "-m", "elongation_mm", "--tolerance", "20 %", *each),
            "results/cube-converge",
            lambda folder: table(folder / "converge.csv", {"seconds"}),
        ),
    }


def start(study: Study, folder: Path) -> subprocess.Popen:
    """The command, in a folder that has its input."""
    for name, text in study.files.items():
        (folder / name).write_text(text)
    command = [sys.executable, "-m", "softact.cli.main", *study.arguments]
    log = (folder / "log.txt").open("a")
    return subprocess.Popen(command, cwd=folder, stdout=log, stderr=log)


def processes_of(folder: Path) -> list[int]:
    """Processes that stand in the folder or below it."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and Path(os.readlink(entry / "cwd")).is_relative_to(folder):
                found.append(int(entry.name))
        except OSError:
            continue
    return found


def survivors(folder: Path, seconds: float = 5.0) -> list[int]:
    """Processes of the folder that are still there after so many seconds."""
    until = time.monotonic() + seconds
    while (found := processes_of(folder)) and time.monotonic() < until:
        time.sleep(0.05)
    return found


def finished(folder: Path) -> list[str]:
    """Keys of the runs that were computed, as often as they were."""
    journal = folder / "results/.runs/journal.csv"
    return [line.split(",")[1] for line in journal.read_text().splitlines()] if (
        journal.exists()) else []  # fmt: skip


def kill_once(study: Study, folder: Path, seconds: float, whom: str) -> str:
    """Start the command and kill it or a solver of its; returns what was killed."""
    process = start(study, folder)
    try:
        process.wait(seconds)
        return "nothing"  # it had ended
    except subprocess.TimeoutExpired:
        pass
    children = [pid for pid in processes_of(folder) if pid != process.pid]
    what = "the command"
    if whom == "solver" and children:
        os.kill(random.choice(children), signal.SIGKILL)
        time.sleep(0.5)
        what = "a solver, then the command"
    process.kill()
    process.wait()
    return what


def faults_of(study: Study, folder: Path, wanted: Any, keys: set[str], code: int) -> list[str]:
    """What is not as after a call that nobody disturbed."""
    runs, out = finished(folder), folder / study.folder
    left = [*(folder / "results/.runs/tmp").iterdir(), *out.glob(".*.tmp"), *out.glob(".lock")]
    faults = [f"exit code {code}"] if code else []
    faults += [f"{key} computed {n} times" for key, n in collections.Counter(runs).items() if n > 1]
    faults += ["other runs were computed"] if set(runs) != keys else []
    faults += [f"left over: {path.name}" for path in left]
    return faults or (["another outcome"] if study.outcome(out) != wanted else [])


def undisturbed(study: Study, folder: Path) -> tuple[Any, set[str], float]:
    """Outcome, keys of the runs and seconds."""
    started = time.monotonic()
    code = start(study, folder).wait()
    assert code == 0, (folder / "log.txt").read_text()
    took = time.monotonic() - started
    return study.outcome(folder / study.folder), set(finished(folder)), took


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("command", nargs="?", default="sweep", choices=studies(1, 6))
    parser.add_argument("-k", "--kills", type=int, default=50)
    parser.add_argument("-j", "--jobs", type=int, default=2)
    parser.add_argument("-n", "--count", type=int, default=12)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    random.seed(options.seed)
    study = studies(options.jobs, options.count)[options.command]
    with tempfile.TemporaryDirectory() as name:
        wanted, keys, took = undisturbed(study, Path(name).resolve())
    print(f"undisturbed: {len(keys)} runs in {took:.1f} s", flush=True)
    killed, calls, orphans = collections.Counter(), 0, 0
    while sum(killed.values()) < options.kills:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name).resolve()
            what = ""
            while sum(killed.values()) < options.kills and what != "nothing":
                whom = random.choice(["command", "solver"])
                what = kill_once(study, folder, random.uniform(0.3, took), whom)
                orphans += len(survivors(folder))
                killed[what] += what != "nothing"
                print(f"{sum(killed.values())}: {what}; {len(finished(folder))} runs", flush=True)
            code = start(study, folder).wait()
            calls += 1
            faults = faults_of(study, folder, wanted, keys, code)
            print(f"{options.command} {calls}: {'; '.join(faults) or 'as undisturbed'}", flush=True)
            if faults:
                print((folder / "log.txt").read_text()[-3000:])
                return 1
    print(f"{dict(+killed)}; {orphans} processes outlived a kill")
    return 1 if orphans else 0


if __name__ == "__main__":
    sys.exit(main())
