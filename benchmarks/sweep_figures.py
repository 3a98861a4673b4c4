"""What a sweep costs beside its runs.

``python -m benchmarks.sweep_figures throughput [4 [3]]`` (needs two idle cores): six runs with -j 1
and with -j 2, each from an empty cache, on a mesh of so many mm; so many times, alternating, and
the medians. ``python -m benchmarks.sweep_figures many``: 10,000 points whose runs are in the cache
(copies of one run under other keys), listed and reported. ``python -m benchmarks.sweep_figures
fixed``: processor seconds of four runs of a cube, and of the same command once more, when all of
them are known; a busy machine changes them little. ``python -m benchmarks.sweep_figures forked
[12 [3]]``: so many runs of a cube with -j 2, each from an empty cache, with processes forked from
fork servers and with each started anew; so many times, in turn, and the medians.
"""

import csv
import hashlib
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

FINGER = """
base:
  geometry: {type: pneunet, chambers: 3, chamber_length: 7 mm, mesh_size: MESH mm}
  materials: {body: elastosil-m4601}
  layers: [{surface: strain_limiting_layer, thickness: 0.1 mm, material: paper}]
  steps: [{name: inflate, pressure: 20 kPa}]
axes: [{path: geometry.roof, from: 1 mm, to: 1.5 mm, count: 6}]
"""
MANY = """
base:
  geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
  materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
  steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
axes:
  - {path: materials.body.c10, from: 0.1 MPa, to: 0.4 MPa, count: 100}
  - {path: geometry.length, from: 4 mm, to: 9 mm, count: 100}
"""


FORKED = ("-m", "softact.cli.main")
STARTED = ("-c", "import runpy; from softact.forkserver import servers; servers.MOST = 0; "
           "runpy.run_module('softact.cli.main', run_name='__main__')")  # fmt: skip


def sweep(folder: Path, *options: str, way: tuple[str, str] = FORKED) -> float:
    """Seconds of ``softact sweep study.yaml``."""
    command = [sys.executable, *way, "sweep", "study.yaml", *options]
    started = time.perf_counter()
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - started


def throughput(mesh: str = "4", pairs: str = "3") -> None:
    walls, outside = {1: [], 2: []}, {1: [], 2: []}
    for jobs in (1, 2) * int(pairs):
        wall, run = six_runs(mesh, jobs)
        walls[jobs].append(wall)
        outside[jobs].append(1 - 6 * run / (jobs * wall))
        print(f"-j {jobs}: {wall:.1f} s for 6 runs of {run:.2f} s", flush=True)
    for jobs, parts in outside.items():
        print(f"ratio sweep_outside_runs_j{jobs} {statistics.median(parts):.4f}")
    print(f"ratio sweep_j2_vs_j1 {statistics.median(walls[1]) / statistics.median(walls[2]):.2f}")


def six_runs(mesh: str, jobs: int) -> tuple[float, float]:
    """Seconds of a sweep of six runs from an empty cache, and of one of its runs."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "study.yaml").write_text(FINGER.replace("MESH", mesh))
        wall = sweep(folder, "-j", str(jobs))
        with open(folder / "results/study/sweep.csv") as file:
            runs = [float(row["seconds"]) for row in csv.DictReader(file)]
    return wall, statistics.mean(runs)


def many() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        one = MANY.replace("count: 100", "count: 2")
        (folder / "study.yaml").write_text(one)
        sweep(folder, "-j", "2")
        sample = next((folder / "results/.runs").glob("??/*/record.json")).parent
        (folder / "study.yaml").write_text(MANY)
        print(f"first listing, keys made: {both(folder, '--list')}")
        for key in keys(folder):
            copy(sample, folder / "results/.runs" / key[:2] / key)
        print(f"table, curves and page, keys made: {both(folder)}")
        print(f"listing, keys remembered: {both(folder, '--list')}")
        print(f"table, curves and page: {both(folder)}")
        size = (folder / "results/study/sweep.html").stat().st_size
        rows = (folder / "results/study/sweep.csv").read_text().count(",complete,")
        print(f"{rows} rows; sweep.html has {size / 1e6:.1f} MB")


def keys(folder: Path) -> list[str]:
    """Of all points, as ``softact sweep --list`` tells them."""
    command = [sys.executable, "-m", "softact.cli.main", "sweep", "study.yaml", "--list"]
    done = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    return [line.split()[1] for line in done.stdout.splitlines()[1:]]


def fixed() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "study.yaml").write_text(MANY.replace("count: 100", "count: 2"))
        used = []
        for _ in range(3):  # the first compiles what is not compiled yet
            shutil.rmtree(folder / "results", ignore_errors=True)
            first, again = (cost(folder, "-j", "1") for _ in range(2))
            used.append((again, (first - again) / 4))
        beside, run = np.min(used, axis=0)
        print(f"beside the runs {beside:.2f} s of processor time, a run of a cube {run:.2f} s")


def forked(count: str = "12", pairs: str = "3") -> None:
    found: dict[tuple[str, str], list[tuple[float, float]]] = {FORKED: [], STARTED: []}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        study = MANY.replace("count: 100", "count: 2")
        (folder / "study.yaml").write_text(
            study.replace("count: 2", f"count: {int(count) // 2}", 1)
        )
        sweep(folder, "-j", "2")  # compiles what is not compiled yet
        for way in (FORKED, STARTED) * int(pairs):
            shutil.rmtree(folder / "results", ignore_errors=True)
            before = processor()
            wall = sweep(folder, "-j", "2", way=way)
            found[way].append((wall, processor() - before))
    for number, what in enumerate(("seconds", "processor seconds")):
        new, old = (statistics.median(pair[number] for pair in found[way]) for way in found)
        print(f"{count} runs: {new:.1f} {what} forked, {old:.1f} started, ratio {old / new:.2f}")


def cost(folder: Path, *options: str) -> float:
    """Processor seconds of ``softact sweep study.yaml`` with all its processes."""
    before = processor()
    sweep(folder, *options)
    return processor() - before


def both(folder: Path, *options: str) -> str:
    """Seconds of ``softact sweep study.yaml``, and those of a processor."""
    before = processor()
    wall = sweep(folder, *options)
    used, load = processor() - before, os.getloadavg()[0]
    return f"{wall:.1f} s, {used:.1f} s of processor time; load {load:.1f}"


def processor() -> float:
    """Processor seconds of all processes that were started and have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def copy(sample: Path, target: Path) -> None:
    """The run under another key; its other files are links to the same ones."""
    if target.exists():
        return
    target.mkdir(parents=True)
    for path in sample.iterdir():
        if path.name != "record.json":
            os.link(path, target / path.name)
    data = json.loads((sample / "record.json").read_text().splitlines()[1])
    data["key"] = target.name
    text = json.dumps(data, separators=(",", ":"))
    digest = hashlib.sha256(text.encode()).hexdigest()
    (target / "record.json").write_text(f"{digest}\n{text}\n")


if __name__ == "__main__":
    {"throughput": throughput, "many": many, "fixed": fixed, "forked": forked}[sys.argv[1]](
        *sys.argv[2:]
    )
