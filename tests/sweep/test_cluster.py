"""A real Dask scheduler with two workers, one of which is killed in mid-run; SLURM's job script."""

import collections
import os
import signal
import ssl
import subprocess
import sys
import time

import psutil
import pytest

from softact.errors import SpecError
from softact.sweep.cluster import slurm_cluster, slurm_options
from tests.sweep.folders import CUBE

pytest.importorskip("distributed", reason="needs distributed (pip install softact[cluster])")
pytest.importorskip("dask_jobqueue", reason="needs dask-jobqueue")
from distributed import Client
from distributed.security import Security

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


def test_slurm_jobs_have_one_thread_and_what_was_asked_for(tmp_path):
    given = slurm_options(["queue=short", "walltime=02:00:00", "memory=8GB"], "lo")
    with slurm_cluster(given, tmp_path) as cluster:
        script = cluster.job_script()
    for line in ("#SBATCH -p short", "#SBATCH -t 02:00:00", "--cpus-per-task=1", "--nthreads 1"):
        assert line in script, script
    assert not list(tmp_path.iterdir())  # the key has gone with the cluster


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ("colour=blue", "--slurm-option: .*colour"),
        ("queue", "write name=value, such as queue=short"),
        ("protocol=tcp", "--slurm-option protocol: softact sets this"),
        ("interface=none0", "--interface none0: .*not a valid network interface.*'lo'"),
    ],
)
def test_wrong_options_of_slurm(option, said):
    with pytest.raises(SpecError, match=said):
        slurm_options([option])


def listening():
    """Addresses at which this process listens."""
    here = psutil.Process()
    connections = getattr(here, "net_connections", here.connections)()
    return {c.laddr for c in connections if c.status == psutil.CONN_LISTEN}


@pytest.fixture(scope="module")
def listening_before():
    """Those of what other tests have started in this process, such as MPI."""
    return listening()


@pytest.fixture(scope="module")
def secured(tmp_path_factory, listening_before):
    """The scheduler that --slurm starts, on the loopback interface, without workers."""
    with slurm_cluster(slurm_options([], "lo"), tmp_path_factory.mktemp("keys")) as cluster:
        yield cluster


STRANGERS = {
    "without TLS": lambda address: {"address": address.replace("tls", "tcp")},
    "without a key": lambda address: {
        "security": Security(require_encryption=True, tls_ca_file=authority(address))
    },
    "with a key of their own": lambda address: {"security": Security.temporary()},
}


def authority(address):
    """The certificate that the scheduler shows to everybody, as a file."""
    host, port = address.removeprefix("tls://").split(":")
    return ssl.get_server_certificate((host, int(port)))


@pytest.mark.parametrize("who", STRANGERS)
def test_without_its_credentials_nobody_is_let_in(secured, listening_before, who):
    """Neither is anything listening elsewhere than on the interface that was named."""
    with pytest.raises((OSError, TypeError, ssl.SSLError)):
        address = secured.scheduler_address
        Client(**{"address": address, "timeout": 10, **STRANGERS[who](address)})
    with Client(secured) as ours:
        assert ours.scheduler_info()["address"].startswith("tls://127.0.0.1:")
    assert {address.ip for address in listening() - listening_before} == {"127.0.0.1"}


def test_only_its_user_may_read_the_key(secured):
    files = [word for word in secured.job_script().split() if word.endswith(".pem")]
    assert len(files) == 3
    assert {os.stat(file).st_mode & 0o777 for file in files} == {0o600}


COMMANDS = {
    "sbatch": """#!/bin/sh
cp "$1" "$HERE/job.sh"
setsid sh "$HERE/job.sh" > "$HERE/worker.log" 2>&1 &
echo $! > "$HERE/worker.pid"
echo Submitted batch job 1
""",
    "scancel": """#!/bin/sh
kill -- "-$(cat "$HERE/worker.pid")"
""",
}


def test_a_sweep_on_slurm(tmp_path):
    """With an sbatch that starts the job's script here: workers take the key and compute."""
    for name, text in COMMANDS.items():
        (tmp_path / name).write_text(text)
        (tmp_path / name).chmod(0o755)
    (tmp_path / "cube.yaml").write_text(CUBE + AXES.replace(", 6 mm, 7 mm", ""))
    command = [sys.executable, "-m", "softact.cli.main", "sweep", "cube.yaml", "--slurm", "-j1"]
    command += ["--interface", "lo"]
    here = {"PATH": f"{tmp_path}:{os.environ['PATH']}", "HERE": str(tmp_path)}
    sweep = subprocess.run(command, cwd=tmp_path, env=os.environ | here, capture_output=True,
                           text=True, timeout=300)  # fmt: skip
    assert sweep.returncode == 0, sweep.stderr
    assert "2 complete; 2 computed now" in sweep.stdout
    assert "tls://127.0.0.1" in (tmp_path / "worker.log").read_text()
    assert not list((tmp_path / "results/.runs/tmp").iterdir())


def test_without_slurm_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    (tmp_path / "cube.yaml").write_text(CUBE + AXES)
    command = [sys.executable, "-m", "softact.cli.main", "sweep", "cube.yaml", "--slurm"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (done.returncode, len(done.stderr.splitlines())) == (2, 1)
    assert "no command sbatch" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["cube.yaml"]
