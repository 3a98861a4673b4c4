"""What a machine does to a sweep: a full disk, a folder that can no longer be written, damaged
runs, too little memory, and the kernel's killer. The real command with the real thing each time."""

import csv
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from softact.errors import OUT_OF_MEMORY
from tests.sweep.folders import CUBE

CUBES = CUBE + "axes: [{path: materials.body.c10, values: [0.1 MPa, 0.2 MPa]}]\n"
SIZES = "[geometry.length, geometry.width, geometry.height], values: [4 mm, 44 mm]"
BLOCKS = CUBE + "axes: [{name: size, path: " + SIZES + "}]\n"
MARGIN = 64 * 2**20  # bytes; the larger block's solver needs far more than that


def start(folder, text=CUBES, before=(), **more):
    (folder / "sweep.yaml").write_text(text)
    command = [*before, sys.executable, "-m", "softact.cli.main", "sweep", "sweep.yaml", "-j1"]
    command += ["--cache", str(folder / "runs"), "-o", str(folder / "out")]
    more |= {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(command, cwd=folder, **more)


def end(process):
    out, err = process.communicate(timeout=120)
    assert "Traceback" not in err
    return process.returncode, out, err.splitlines()


def completes(folder, computed, said=()):
    """Another call ends well, and computes so many of the two points."""
    code, out, lines = end(start(folder))
    assert (code, lines) == (0, [*said])
    assert f"2 points, {2 - computed} of them known" in out
    assert f"2 complete; {computed} computed now" in out


def finished(folder):
    """Keys of the runs that were computed, in their order."""
    text = "".join(path.read_text() for path in folder.glob("runs/journal.csv"))
    return [line.split(",")[1] for line in text.splitlines()]


def states(folder):
    with open(folder / "out/sweep.csv") as file:
        return {row["run"]: (row["status"], row["cause"]) for row in csv.DictReader(file)}


def until(found):
    """What ``found`` gives, as soon as it gives something."""
    latest = time.monotonic() + 60
    while not (answer := found()):
        assert time.monotonic() < latest
        time.sleep(0.01)
    return answer


def solver(folder):
    """The process that solves a run for the folder's cache, None where there is none."""
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_text().split("\0")
        except (OSError, ValueError):
            continue
        if "softact.run.worker" in words[:4] and words[4].startswith(f"{folder}/runs/"):
            return int(entry.name)
    return None


def address_space(process):
    """The most that a process has had so far, bytes; 0 where it has ended."""
    try:
        found = re.search(r"VmPeak:\s+(\d+)", Path(f"/proc/{process}/status").read_text())
    except OSError:
        return 0
    return 1024 * int(found[1]) if found else 0


@pytest.fixture(scope="module")
def revoked(tmp_path_factory):
    """A sweep of two points whose folder nobody may write any more from the middle of the second
    on, and its second call, when it may be written again."""
    folder = tmp_path_factory.mktemp("revoked")
    # Root may write everywhere, unless it gives up the right to.
    drop = ["setpriv", "--bounding-set=-dac_override,-dac_read_search"]
    sweep, peaks = start(folder, before=[] if os.geteuid() else drop), []
    worker = until(lambda: solver(folder))
    until(lambda: peaks.append(address_space(worker)) or finished(folder))
    until(lambda: list(folder.glob("runs/tmp/*/softact-*/mesh.msh")))
    subprocess.run(["chmod", "-R", "a-w", folder / "runs"])
    first = end(sweep)
    subprocess.run(["chmod", "-R", "u+w", folder / "runs"], check=True)
    kept, rows = finished(folder), states(folder)
    completes(folder, computed=1)
    return SimpleNamespace(folder=folder, first=first, kept=kept, rows=rows, peak=max(peaks))


def test_folder_that_is_no_longer_writable(revoked):
    code, _, lines = revoked.first
    cause = "cannot be written (Permission denied); what was finished is kept; name another"
    assert (code, len(lines)) == (2, 1)
    assert lines[0].startswith(f"{revoked.folder}/runs: {cause}")
    one, other = finished(revoked.folder)
    assert revoked.kept == [one]
    assert revoked.rows == {one: ("complete", ""), other: ("missing", "")}
    assert not list((revoked.folder / "runs/tmp").iterdir())


def test_damaged_run_is_told_and_computed_anew(revoked, tmp_path):
    shutil.copytree(revoked.folder / "runs", tmp_path / "runs")
    one, other = finished(tmp_path)
    path = tmp_path / "runs" / other[:2] / other / "record.json"
    raw = bytearray(path.read_bytes())
    raw[len(raw) // 2] ^= 0xFF
    path.write_bytes(raw)
    damage = "the kept run is damaged (record.json is not as it was written)"
    completes(tmp_path, computed=1, said=[f"{path.parent}: {damage}; it is computed anew"])
    assert finished(tmp_path) == [one, other, other]


@pytest.fixture
def disk(tmp_path):
    """A function that makes ``runs`` or ``out`` a disk of so many kB, or resizes it."""
    mounted = []

    def size(name, kilobytes):
        path, how = tmp_path / name, f"size={kilobytes}k"
        path.mkdir(exist_ok=True)
        options = ["-o", f"remount,{how}" if path in mounted else how]
        command = ["mount", "-t", "tmpfs", *options, "tmpfs", path]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            pytest.skip(f"may not mount a disk here: {done.stderr.strip()}")
        mounted.append(path)

    yield size
    for path in set(mounted):
        subprocess.run(["umount", path], check=True)


def test_full_disk_of_the_runs(disk, revoked, tmp_path):
    # Room for the first run, and for half of the second.
    taken = sum(4 * -(-path.stat().st_size // 4096) for path in revoked.folder.glob("runs/??/*/*"))
    disk("runs", 8 + taken * 3 // 4)
    code, _, lines = end(start(tmp_path))
    assert (code, lines) == (2, [f"{tmp_path}/runs: the disk is full; what was finished is kept"])
    (one,) = finished(tmp_path)
    assert sorted(states(tmp_path).values()) == [("complete", ""), ("missing", "")]
    assert not list((tmp_path / "runs/tmp").iterdir())
    disk("runs", 4 * taken)
    completes(tmp_path, computed=1)
    assert finished(tmp_path)[0] == one and len(finished(tmp_path)) == 2


def test_full_disk_of_the_table_and_page(disk, revoked, tmp_path):
    shutil.copytree(revoked.folder / "runs", tmp_path / "runs")
    disk("out", 200)  # enough for the table, not for the page
    code, _, lines = end(start(tmp_path))
    cause = "No space left on device; the runs are kept in the cache"
    assert (code, lines) == (2, [f"{tmp_path}/out: {cause}"])
    assert not list((tmp_path / "out").glob("*.tmp")) and len(states(tmp_path)) == 2
    disk("out", 20000)
    completes(tmp_path, computed=0)
    assert (tmp_path / "out/sweep.html").exists()


def test_solver_out_of_memory_or_killed(revoked, tmp_path):
    """Under a limit in which the small block's solver lives and the larger one's cannot; tried
    again without one, but killed as by the kernel."""
    limit = revoked.peak + MARGIN

    def less_memory():
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

    code, _, lines = end(start(tmp_path, text=BLOCKS, preexec_fn=less_memory))
    (one,) = finished(tmp_path)
    (other,) = states(tmp_path).keys() - {one}
    failed = {one: ("complete", ""), other: ("failed", OUT_OF_MEMORY)}
    assert (code, states(tmp_path)) == (1, failed)
    assert len(lines) == 1 and f"{OUT_OF_MEMORY}; the same command tries" in lines[0]
    sweep = start(tmp_path, text=BLOCKS)
    os.kill(until(lambda: solver(tmp_path)), signal.SIGKILL)
    code, out, lines = end(sweep)
    assert (code, len(lines), finished(tmp_path)) == (1, 1, [one])
    assert "2 points, 1 of them known" in out
    assert "was killed by signal 9 (out of memory?)" in states(tmp_path)[other][1]
