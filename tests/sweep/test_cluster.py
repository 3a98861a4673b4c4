"""A real Dask scheduler with two workers, one of which is killed in mid-run; SLURM's job script."""

import collections
import os
import signal
import subprocess
import sys
import time

import pytest

from softact.errors import SpecError
from softact.sweep.cluster import slurm_cluster

from .folders import CUBE

pytest.importorskip("distributed", reason="needs distributed (pip install softact[cluster])")
AXES = "axes: [{path: geometry.length, values: [4 mm, 5 mm, 6 mm, 7 mm]}]\n"


@pytest.fixture
def cluster(tmp_path):
    """Address of a scheduler, and its two workers with one thread each."""
    file = tmp_path / "scheduler.json"
    started = []

    def start(module, *options):
        command = [sys.executable, "-m", f"distributed.cli.{module}", *options]
        process = subprocess.Popen(
            command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        started.append(process)
        return process

    start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard",
          "--scheduler-file", str(file))  # fmt: skip
    wait_for(file.is_file)
    wait_for(lambda: '"address"' in file.read_text())
    workers = [
        start(
            "dask_worker",
            "--scheduler-file",
            str(file),
            "--nthreads",
            "1",
            "--no-nanny",
            "--no-dashboard",
        )
        for _ in range(2)
    ]
    import json

    yield json.loads(file.read_text())["address"], workers
    for process in started:
        process.kill()
        process.wait()


def wait_for(condition, seconds=90):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def test_a_killed_worker_loses_nothing(cluster, tmp_path):
    address, workers = cluster
    (tmp_path / "cube.yaml").write_text(CUBE + AXES)
    command = [sys.executable, "-m", "softact.cli.main", "sweep", "cube.yaml"]
    sweep = subprocess.Popen(
        [*command, "--scheduler", address], cwd=tmp_path, stdout=subprocess.PIPE, text=True
    )
    victim = workers[0]
    under_way = tmp_path / "results/.runs/tmp"
    wait_for(lambda: list(under_way.glob(f"*.{victim.pid}/softact-*/job.json")))
    os.kill(victim.pid, signal.SIGKILL)
    out, _ = sweep.communicate(timeout=300)
    assert sweep.returncode == 0, out
    assert "4 complete; 4 computed now" in out
    runs = (tmp_path / "results/.runs/journal.csv").read_text().splitlines()
    assert list(collections.Counter(line.split(",")[1] for line in runs).values()) == [1] * 4
    assert not [path for path in under_way.iterdir() if f".{victim.pid}" in path.name]


def test_slurm_jobs_have_one_thread_and_what_was_asked_for():
    pytest.importorskip("dask_jobqueue", reason="needs dask-jobqueue")
    script = slurm_cluster(["queue=short", "walltime=02:00:00", "memory=8GB"]).job_script()
    for line in ("#SBATCH -p short", "#SBATCH -t 02:00:00", "--cpus-per-task=1", "--nthreads 1"):
        assert line in script, script
    with pytest.raises(SpecError, match="--slurm-option"):
        slurm_cluster(["colour=blue"])
