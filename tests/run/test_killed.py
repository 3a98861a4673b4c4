"""A run that is killed at any moment leaves no folder, or one that says that it is incomplete, from
which it goes on; a report that is killed leaves the results as they were."""

import csv
import json
import os
import random
import shutil
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


def start(tmp_path, name, *options, command=("run", "cube.yaml", "-o")):
    """The command line in a session of its own, so that all its processes can be killed."""
    return subprocess.Popen(
        [sys.executable, "-m", "softact.cli.main", *command, name, *options],
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
    """Duration, with all code compiled, number of rows, and place of a run that nobody disturbs."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "cube.yaml").write_text(SPEC)
    for _ in range(2):
        started = time.monotonic()
        assert start(folder, "out").wait(timeout=300) == 0
    assert json.loads((folder / "out/run.json").read_text())["status"] == "complete"
    return time.monotonic() - started, len(rows(folder / "out")), folder


def test_killed_between_increments(tmp_path, whole):
    _, all_rows, _ = whole
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
    """The next call finds what the kill left, and comes to the same end."""
    duration, all_rows, _ = whole
    (tmp_path / "cube.yaml").write_text(SPEC)
    draw, found = random.Random(2), []
    for trial in range(3):
        process, folder = start(tmp_path, f"out{trial}"), tmp_path / f"out{trial}"
        time.sleep(duration * draw.uniform(0.3, 0.9))
        kill_everything(process)
        found.append((check(folder, all_rows), len(rows(folder))))
    assert any(status and 0 < count for status, count in found), found  # or nothing was tried
    for trial, (_, count) in enumerate(found):
        if 0 < count < all_rows:
            kept = rows(tmp_path / f"out{trial}")
            assert start(tmp_path, f"out{trial}", "--resume").wait(timeout=300) == 0
            assert check(tmp_path / f"out{trial}", all_rows) == "complete"
            assert rows(tmp_path / f"out{trial}")[: count - 1] == kept[: count - 1]
            break


def test_stopped_run_leaves_nothing_in_the_temporary_folder(tmp_path, monkeypatch):
    (tmp_path / "cube.yaml").write_text(SPEC)
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    process = start(tmp_path, "out")
    while process.poll() is None and len(rows(tmp_path / "out")) < 2:
        time.sleep(0.002)
    assert list((tmp_path / "tmp").iterdir())
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=60) == 128 + signal.SIGTERM
    assert not list((tmp_path / "tmp").iterdir())


def test_report_killed_at_any_time(tmp_path, whole):
    """What it had not yet written is missing, or as before; nothing else has changed."""
    folder = tmp_path / "out"
    shutil.copytree(whole[2] / "out", folder)
    made = ("report.html", "curve.png", "states.png", "shape.png")
    kept = {path.name: path.read_bytes() for path in folder.iterdir() if path.name not in made}
    command = {"command": ("report",)}
    began = time.monotonic()
    assert start(tmp_path, "out", **command).wait(timeout=300) == 0
    duration, draw = time.monotonic() - began, random.Random(3)
    for _ in range(2):
        process = start(tmp_path, "out", **command)
        time.sleep(duration * draw.random())
        kill_everything(process)
        there = {path.name: path.read_bytes() for path in folder.iterdir() if path.name[0] != "."}
        assert {name: there.pop(name) for name in kept} == kept
        assert there.keys() <= set(made)
        assert there["report.html"].endswith(b"</html>")
        assert all(b"IEND" in data[-12:] for name, data in there.items() if name.endswith("png"))
    assert start(tmp_path, "out", **command).wait(timeout=300) == 0
    assert {path.name for path in folder.iterdir()} == {*kept, *made}
