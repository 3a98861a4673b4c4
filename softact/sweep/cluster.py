"""Runs on a Dask cluster, whose workers share the cache's folder with this machine."""

from __future__ import annotations

import shlex
import socket
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from softact.errors import SpecError
from softact.orphans import python
from softact.sweep.cache import Cache
from softact.sweep.compute import FAILED, Answer, compute
from softact.sweep.local import Jobs
from softact.sweep.study import Runner
from softact.sweep.version import version

_SECONDS = 30.0  # within which the scheduler has to answer
# What a job asks for where --slurm-option does not say otherwise: a run has one thread.
_SLURM = {"cores": 1, "processes": 1, "memory": "4GB", "python": shlex.join(python())}


def on_scheduler(address: str) -> Runner:
    """A runner on the cluster of a scheduler. Raises SpecError where none answers."""
    return lambda jobs, cache: _run_all(lambda: _client(address), jobs, cache)


def on_slurm(count: int, options: Sequence[str]) -> Runner:
    """A runner on ``count`` workers that are SLURM jobs; ``options``: name=value."""
    cluster = slurm_cluster(options)

    def connect() -> Any:
        from distributed import Client

        try:
            cluster.scale(jobs=count)
        except OSError as error:
            raise SpecError(f"--slurm: cannot start jobs: {error.strerror}: sbatch") from None
        return Client(cluster)

    return lambda jobs, cache: _run_all(connect, jobs, cache)


def slurm_cluster(options: Sequence[str]) -> Any:
    """The SLURMCluster of ``name=value`` options. Raises SpecError where one is wrong."""
    try:
        from dask_jobqueue import SLURMCluster
    except ImportError:
        raise SpecError(_missing("dask-jobqueue")) from None
    given: dict[str, Any] = dict(_SLURM)
    for option in options:
        name, equals, value = option.partition("=")
        if not equals:
            raise SpecError(f"--slurm-option {option}: write name=value, such as queue=short")
        given[name.strip()] = int(value) if value.isdecimal() else value
    try:
        return SLURMCluster(**given)
    except (TypeError, ValueError) as error:
        raise SpecError(f"--slurm-option: {error}") from None


def _missing(package: str) -> str:
    return f"the package {package} is not installed; pip install 'softact[cluster]'"


def _client(address: str) -> Any:
    try:
        from distributed import Client
    except ImportError:
        raise SpecError(_missing("distributed")) from None
    try:
        return Client(address, timeout=_SECONDS)
    except (OSError, ValueError):
        raise SpecError(f"--scheduler {address}: no Dask scheduler answers there") from None


@contextmanager
def _open(connect) -> Iterator[Any]:
    client = connect()
    try:
        yield client
    finally:
        client.close()


def _run_all(connect, jobs: Jobs, cache: Cache) -> Iterator[Answer]:
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    folder = str(cache.directory.absolute())
    with _open(connect) as client:
        futures = {}
        for key, spec in jobs.items():
            # Where a worker dies, Dask gives its runs to another one.
            future = client.submit(
                _task, spec().to_yaml(), key, folder, version(), key=f"softact-{key}", pure=False
            )
            futures[future] = key
        for future in as_completed(list(futures)):
            try:
                yield future.result()
            except KilledWorker as error:
                cause = f"its worker died again and again: {error.last_worker}"
                yield Answer(futures[future], None, FAILED, cause, transient=True)


def _task(text: str, key: str, folder: str, wanted: str) -> Answer:
    """One run, on a worker."""
    from softact.spec import loads

    here = version()
    if here != wanted:
        cause = f"worker on {socket.gethostname()} has another version: {here}; wanted: {wanted}"
        return Answer(key, None, FAILED, cause, transient=True)
    if not (Path(folder) / "locks").is_dir():
        cause = f"worker on {socket.gethostname()} does not see the folder {folder}"
        return Answer(key, None, FAILED, cause, transient=True)
    return compute(loads(text), key, Cache(Path(folder)))
