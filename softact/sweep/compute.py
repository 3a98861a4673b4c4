"""One run by its key: taken from the cache, or computed and put there."""

from __future__ import annotations

import errno
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from softact.errors import CannotWriteError, GmshKilledError, SoftactError, SpecError
from softact.files.restart import RESTART
from softact.files.text import why_unwritable
from softact.results import chain
from softact.results.folder import Results, read
from softact.run.start import Progress, SolverCrashError, run
from softact.run.staying import Staying
from softact.spec import Spec
from softact.spec.one_module import blocked_modules
from softact.sweep import record, shape
from softact.sweep.cache import Cache
from softact.sweep.record import Record
from softact.sweep.version import run_key

FAILED, INVALID = "failed", "invalid_spec"

_CHANGED = (
    "a file that the spec names, or that its script reads, has changed since the run was planned, "
    "or its script makes another mesh each time"
)


class ChangedError(SpecError):
    """The run that was computed is not the one that was asked for."""


@dataclass(frozen=True)
class Answer:
    """How a point ended.

    key: of the run, "" where the spec is wrong. record: of its run, None where there is none.
    status: the record's, "failed" or "invalid_spec". cause: why it is not complete, "" where it
    is. cached: whether the run was there before. transient: whether another try could end better
    (a solver that was killed). exit_code: of a command that can do without this run no further.
    """

    key: str
    record: Record | None
    status: str
    cause: str
    cached: bool = False
    transient: bool = False
    exit_code: int = SpecError.exit_code

    def error(self) -> SoftactError:
        """What a command that needs this run ends with."""
        error = SoftactError(self.cause)
        error.exit_code = self.exit_code
        return error


def of_record(found: Record, cached: bool) -> Answer:
    """The answer that a finished run gives."""
    return Answer(found.key, found, found.status, found.cause, cached)


def compute(
    spec: Spec,
    key: str,
    cache: Cache,
    wait: bool = True,
    progress: Progress | None = None,
    processes: int = 1,
    threads: int | None = 1,
    slopes: Sequence[str] = (),
    end_only: bool = False,
    near: Path | None = None,
    blocked: Sequence[str] | None = None,
    staying: Staying | None = None,
) -> Answer:
    """Solve ``spec`` unless its run is in the cache; keep the run there.

    wait: for somebody else who computes it; else BusyError is raised. progress: hears of each
    increment of a run that is computed. processes, threads: see ``run``; one thread each, unless
    the key says otherwise. slopes: paths of parameters by which the measures are differentiated, as
    the key says; the spec's tolerances are let be. end_only: whether the key is of a run whose
    states before the last may be missing; such a one may start from another's folder, ``near``.
    blocked: None, or the spec is of a free module and the record that of so many as the actuator
    has, with what is exerted where these kinds of run block it (``one_module.blocked_modules``).
    staying: see ``run``.
    Raises CannotWriteError where the disk is full
    or read-only: there is no sense in going on. Whatever else goes wrong is told in the answer.
    """
    given: dict[str, Any] = {"processes": processes, "threads": threads, "slopes": slopes}
    given |= {"end_only": end_only, "blocked": blocked}
    with cache.lock(key, wait):
        found = cache.find(key)
        if found is not None:
            return of_record(found, cached=True)
        try:
            with cache.workspace(key) as folder:
                found = _solve(spec, key, folder, cache, progress, given, near, staying)
                return of_record(found, cached=False)
        except CannotWriteError:
            raise
        except SoftactError as error:
            again = GmshKilledError, ChangedError
            transient = isinstance(error, again) or error.exit_code == 70
            cause, code = "; ".join(error.lines), error.exit_code
            return Answer(key, None, FAILED, cause, transient=transient, exit_code=code)
        except OSError as error:
            return Answer(key, None, FAILED, str(error), transient=True)


def _solve(
    spec: Spec,
    key: str,
    folder: Path,
    cache: Cache,
    progress: Progress | None,
    given: dict[str, Any],
    near: Path | None,
    staying: Staying | None,
) -> Record:
    started = time.perf_counter()
    results = folder / "results"
    how = {key: given[key] for key in ("processes", "threads")} | {"staying": staying}
    slopes = given["slopes"] or None
    alone = spec.model_copy(update={"tolerances": {}})  # no derivatives but those asked for
    try:
        run(
            alone, results, progress=progress, report=False, scratch=folder,
            sensitivities=slopes, near=near, **how,
        )  # fmt: skip
        finished = read(results)
        shape.store(finished)
        if given["blocked"] is not None:
            finished = _of_chain(alone, finished, folder, given["blocked"], how)
    except CannotWriteError as error:
        raise cache.cannot_write(error) from None
    except SolverCrashError:
        # MPI dies without a reason where it may not write into the solver's folder.
        if os.access(folder, os.W_OK | os.X_OK):
            raise
        raise cache.cannot_write(PermissionError(errno.EACCES, os.strerror(errno.EACCES))) from None
    except OSError as error:
        if why_unwritable(error):
            raise cache.cannot_write(error) from None
        raise
    # What is kept under a key is what the key says, whatever was edited meanwhile.
    if run_key(spec, mesh=finished.run.get("mesh_hash", ""), **given) != key:
        raise ChangedError(_CHANGED)
    found = record.from_results(key, finished, time.perf_counter() - started)
    cache.keep(found, results)
    return found


def _of_chain(
    free: Spec, results: Results, folder: Path, kinds: Sequence[str], how: Mapping[str, Any]
) -> Results:
    """The results of a free module with the curve of so many as the actuator has, and with what
    modules exert that are blocked in these ways; their runs are carried out in ``folder``."""
    specs = blocked_modules(free) if kinds else {}
    curves = {}
    for kind in kinds:
        if kind in specs:
            run(specs[kind], folder / kind, report=False, scratch=folder, **how)
            curves[kind] = read(folder / kind).curve
    curve = chain.whole(results.curve, free.geometry.pitches)
    curve |= chain.exerted(results.curve, curves)
    # A run that goes on is none of a study's, and thousands of these files take room.
    (results.directory / RESTART).unlink(missing_ok=True)
    return replace(results, curve=curve)
