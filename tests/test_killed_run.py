"""A run that is killed at any moment leaves no folder, or one that says that it is incomplete."""

import csv
import json
import os
import random
import signal
import subprocess
import sys
import time

import pytest

SPEC = """
name: cube
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
solver: {initial_increment: 0.02, max_increment: 0.02}
"""


def start(tmp_path, name):
    """The command line in a session of its own, so that all its processes can be killed."""
    return subprocess.Popen(
        [sys.executable, "-m", "softact.cli.main", "run", "cube.yaml", "-o", name],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def kill_everything(process):
    """Kill -9 the command and the solver that it started (which has a session of its own)."""
    found = subprocess.run(
        ["pgrep", "-P", str(process.pid)], capture_output=True, text=True, check=False
    )
    for pid in (process.pid, *map(int, found.stdout.split())):
        for kill in (os.killpg, os.kill):
            try:
                kill(pid, signal.SIGKILL)
            except ProcessLookupError:
                continue
    process.wait()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Duration and number of rows of a run that nobody disturbs."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "cube.yaml").write_text(SPEC)
    started = time.monotonic()
    assert start(folder, "out").wait(timeout=300) == 0
    assert json.loads((folder / "out/run.json").read_text())["status"] == "complete"
    return time.monotonic() - started, len(rows(folder / "out"))


def rows(directory):
    with (directory / "curve.csv").open() as file:
        return list(csv.DictReader(file))


def test_killed_runs_never_look_complete(tmp_path, whole):
    duration, all_rows = whole
    (tmp_path / "cube.yaml").write_text(SPEC)
    draw = random.Random(20131103)
    seen_partial = 0
    for trial in range(8):
        process = start(tmp_path, f"out{trial}")
        time.sleep(duration * (0.3 + 0.6 * draw.random()))
        kill_everything(process)
        directory = tmp_path / f"out{trial}"
        if not directory.exists():
            continue
        status = json.loads((directory / "run.json").read_text())["status"]
        if status == "complete":
            # Killed after the last file of the solver: then nothing may be missing.
            assert len(rows(directory)) == all_rows
            continue
        assert status == "incomplete"
        if (directory / "curve.csv").exists():
            seen_partial += 1
            assert len(rows(directory)) <= all_rows
            assert not (directory / "summary.csv").exists()
    assert seen_partial >= 1, "no kill hit the solver at work; the moments need a new choice"
