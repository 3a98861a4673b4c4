"""What sensitivities cost: processor time of a run with them beside the run without.

``python -m benchmarks.sensitivities [--times 3] [--set PATH=VALUE ...]``: the glove's finger by 15
parameters, both at the same time, each on one thread; time of the whole command, user and system,
with all of its processes. Exits with 1 where the two curves differ.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

SPEC = "configs/pneunet_glove.yaml"
PARAMETERS = (
    *(f"geometry.{name}" for name in (
        "chamber_height", "chamber_width", "gap", "length", "outer_wall", "inner_wall", "roof",
        "base", "layer_height", "channel_width", "channel_height", "channel_roof",
    )),
    "materials.body.c10",
    "materials.body.c20",
    "layers.0.thickness",
)  # fmt: skip


def begin(folder: Path, settings: list[str], paths: tuple[str, ...]) -> subprocess.Popen[bytes]:
    """Start a run into a folder."""
    command = [Path(sys.executable).with_name("softact"), "run", SPEC, "-n", "1", "-o", folder]
    command += [word for setting in settings for word in ("--set", setting)]
    command += [word for path in paths for word in ("-p", path)]
    threads = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    return subprocess.Popen(
        command, env=os.environ | threads, stdout=subprocess.DEVNULL, stderr=subprocess.STDOUT
    )


def processor_time(running: subprocess.Popen[bytes]) -> float:
    """Seconds, user and system, of a run until its end, with the processes that it began."""
    _, status, used = os.wait4(running.pid, 0)
    if os.waitstatus_to_exitcode(status) not in (0, 3):
        raise SystemExit("a run failed")
    return used.ru_utime + used.ru_stime


def pair(settings: list[str]) -> tuple[float, float]:
    """Seconds without and with sensitivities."""
    with tempfile.TemporaryDirectory() as place:
        folders = Path(place) / "without", Path(place) / "with"
        runs = begin(folders[0], settings, ()), begin(folders[1], settings, PARAMETERS)
        without, beside = map(processor_time, runs)
        curves = [(folder / "curve.csv").read_bytes() for folder in folders]
    if curves[0] != curves[1]:
        raise SystemExit("the curves differ")
    return without, beside


def main() -> None:
    """Print the times and their ratio, of each pair and the median."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--times", type=int, default=1)
    parser.add_argument("--set", action="append", default=[], dest="settings")
    asked = parser.parse_args()
    ratios = []
    for _ in range(asked.times):
        without, beside = pair(asked.settings)
        ratios.append(beside / without)
        print(f"without {without:.1f} s, with {beside:.1f} s: {ratios[-1]:.3f} times", flush=True)
    print(f"median {median(ratios):.3f}, {len(PARAMETERS)} parameters")


if __name__ == "__main__":
    main()
