"""Runs on a Dask cluster, whose workers share the cache's folder with this machine."""

from __future__ import annotations

import shlex
import shutil
import socket
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from softact.child_processes import python
from softact.errors import SpecError
from softact.sweep.cache import Cache
from softact.sweep.compute import FAILED, Answer, compute
from softact.sweep.local import Jobs
from softact.sweep.study import Runner
from softact.sweep.version import version

_SECONDS = 30.0  # within which the scheduler has to answer
# What a job asks for where --slurm-option does not say otherwise: a run has one thread.
_SLURM = {"cores": 1, "processes": 1, "memory": "4GB", "python": shlex.join(python())}
# What no option may change: whom a scheduler obeys runs code as its user.
_OURS = ("host", "protocol", "scheduler_options", "security", "shared_temp_directory")
_HERE = "127.0.0.1:0"  # where scheduler and workers serve pages that nobody asks for


@contextmanager
def on_scheduler(address: str) -> Iterator[Runner]:
    """A runner on the cluster of a scheduler. Raises SpecError where none answers."""
    with closing(_client(address)) as client:
        yield partial(_run_all, client)


@contextmanager
def on_slurm(
    count: int, interface: str | None, options: Sequence[str], cache: Cache
) -> Iterator[Runner]:
    """A runner on ``count`` workers that are SLURM jobs; interface, options: see
    ``slurm_cluster``. Raises SpecError where they are wrong or there is no SLURM."""
    given = slurm_options(options, interface)
    if shutil.which("sbatch") is None:
        raise SpecError("--slurm: there is no command sbatch here, so no job can be started")
    cache.make()
    with slurm_cluster(given, cache.directory / "tmp") as cluster:
        from distributed import Client

        cluster.scale(jobs=count)
        with closing(Client(cluster)) as client:
            yield partial(_run_all, client)


def slurm_options(options: Sequence[str], interface: str | None = None) -> dict[str, Any]:
    """What ``name=value`` options say to SLURMCluster, and where its scheduler listens: on one
    interface, by default that of the route out of this machine. Raises SpecError where one is
    wrong."""
    try:
        from dask.config import get
        from dask_jobqueue.slurm import SLURMJob
        from distributed.utils import get_ip
    except ImportError:
        raise SpecError(_missing("dask-jobqueue")) from None
    given: dict[str, Any] = dict(_SLURM)
    for option in options:
        name, equals, value = (part.strip() for part in option.partition("="))
        if not equals:
            raise SpecError(f"--slurm-option {option}: write name=value, such as queue=short")
        if name in _OURS:
            raise SpecError(f"--slurm-option {name}: softact sets this; see --interface")
        given[name] = int(value) if value.isdecimal() else value
    interface = interface or given.pop("interface", None) or get("jobqueue.slurm.interface", None)
    try:
        SLURMJob("tls://scheduler", name="softact", **given)
        address = _address(interface) if interface else get_ip()
    except (TypeError, ValueError) as error:
        raise SpecError(f"--slurm-option: {error}") from None
    if interface:
        given["interface"] = interface
    return given | {"scheduler_options": {"host": address, "dashboard_address": _HERE}}


def _address(interface: str) -> str:
    from distributed.utils import get_ip_interface

    try:
        return get_ip_interface(interface)
    except ValueError as error:
        raise SpecError(f"--interface {interface}: {error}") from None


@contextmanager
def slurm_cluster(given: dict[str, Any], folder: Path) -> Iterator[Any]:
    """A SLURMCluster of options as ``slurm_options`` gives them, without workers yet.

    Scheduler and workers talk by TLS, and prove by a key that is made here and now that they belong
    to each other. folder: where the workers find that key, readable by their user only.
    """
    from dask import config
    from dask_jobqueue import SLURMCluster

    with tempfile.TemporaryDirectory(prefix="slurm-", dir=folder.absolute()) as keys:
        # Pages of the scheduler would tell everybody on this machine what it does.
        with config.set({"distributed.scheduler.http.routes": []}):
            cluster = SLURMCluster(
                **given,
                security=_security(Path(keys)),
                worker_extra_args=["--no-dashboard", "--dashboard-address", _HERE],
            )
        with closing(cluster):
            yield cluster


def _security(folder: Path) -> Any:
    """A key and certificate of this sweep's own, in files of a folder that is its user's only."""
    from distributed.security import Security

    try:
        made = Security.temporary()
    except ImportError:
        raise SpecError(_missing("cryptography")) from None
    key, certificate = folder / "key.pem", folder / "certificate.pem"
    for path, text in ((key, made.tls_client_key), (certificate, made.tls_client_cert)):
        path.touch(0o600)
        path.write_text(text, encoding="utf-8")
    roles = ("client", "scheduler", "worker")
    files = {f"tls_{role}_key": str(key) for role in roles}
    files |= {f"tls_{role}_cert": str(certificate) for role in roles}
    return Security(require_encryption=True, tls_ca_file=str(certificate), **files)


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


def _run_all(
    client: Any, jobs: Jobs, cache: Cache, blocked: Sequence[str] | None
) -> Iterator[Answer]:
    from distributed import as_completed
    from distributed.scheduler import KilledWorker

    cache.make()
    folder = str(cache.directory.absolute())
    futures = {}
    for key, spec in jobs.items():
        # Where a worker dies, Dask gives its runs to another one.
        future = client.submit(
            _task,
            spec().to_yaml(),
            key,
            folder,
            version(),
            blocked,
            key=f"softact-{key}",
            pure=False,
        )
        futures[future] = key
    for future in as_completed(list(futures)):
        try:
            yield future.result()
        except KilledWorker as error:
            cause = f"its worker died again and again: {error.last_worker}"
            yield Answer(futures[future], None, FAILED, cause, transient=True)


def _task(text: str, key: str, folder: str, wanted: str, blocked: Sequence[str] | None) -> Answer:
    """One run, on a worker."""
    from softact.spec import loads

    here = version()
    if here != wanted:
        cause = f"worker on {socket.gethostname()} has another version: {here}; wanted: {wanted}"
        return Answer(key, None, FAILED, cause, transient=True)
    if not (Path(folder) / "locks").is_dir():
        cause = f"worker on {socket.gethostname()} does not see the folder {folder}"
        return Answer(key, None, FAILED, cause, transient=True)
    return compute(loads(text), key, Cache(Path(folder)), blocked=blocked)
