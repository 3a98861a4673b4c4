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


def rows(directory):
    """Rows of the curve so far."""
    try:
        with (directory / "curve.csv").open() as file:
            return list(csv.DictReader(file))
    except FileNotFoundError:
        return []


def check(directory, all_rows):
    """The folder is absent, says that it is incomplete, or has everything. Returns its status."""
    if not directory.exists():
        return None
    status = json.loads((directory / "run.json").read_text())["status"]
    assert status in ("complete", "incomplete")
    if status == "complete":  # killed after the last file of the solver
        assert len(rows(directory)) == all_rows
    else:
        assert len(rows(directory)) <= all_rows
    return status


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Duration, with all code compiled, and number of rows of a run that nobody disturbs."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "cube.yaml").write_text(SPEC)
    for _ in range(2):
        started = time.monotonic()
        assert start(folder, "out").wait(timeout=300) == 0
    assert json.loads((folder / "out/run.json").read_text())["status"] == "complete"
    return time.monotonic() - started, len(rows(folder / "out"))


def test_killed_between_increments(tmp_path, whole):
    _, all_rows = whole
    (tmp_path / "cube.yaml").write_text(SPEC)
    draw = random.Random(20131103)
    for trial in range(3):
        process, directory = start(tmp_path, f"out{trial}"), tmp_path / f"out{trial}"
        wanted = draw.randrange(1, all_rows // 2)
        while process.poll() is None and len(rows(directory)) < wanted:
            time.sleep(0.002)
        kill_everything(process)
        assert check(directory, all_rows) == "incomplete"
        assert not (directory / "summary.csv").exists()


def test_killed_at_any_time(tmp_path, whole):
    duration, all_rows = whole
    (tmp_path / "cube.yaml").write_text(SPEC)
    draw = random.Random(2)
    for trial in range(5):
        process = start(tmp_path, f"out{trial}")
        time.sleep(duration * draw.random())
        kill_everything(process)
        check(tmp_path / f"out{trial}", all_rows)
