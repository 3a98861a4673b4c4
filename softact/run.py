"""From a spec to a result folder: mesh, solve in processes of their own, report."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from softact.errors import OUT_OF_MEMORY, NoEquilibriumError, SoftactError, SpecError
from softact.files import write_atomic
from softact.geometry import make_mesh
from softact.orphans import bound
from softact.results import RESTART

# Events that ``progress`` receives: {"stage": "mesh"}; {"stage": "solve", "cells", "unknowns"};
# {"stage": "increment", "step", "fraction", "iterations", ... and the row of curve.csv};
# {"stage": "cutback", "step", "fraction", "reason"}; {"stage": "done", "status", "message"};
# {"stage": "report"}; {"stage": "note", "text"}: something the user should know.
Progress = Callable[[Mapping], None]


@dataclass(frozen=True)
class Outcome:
    """How a run ended. status: "complete" or "no_equilibrium"; message: why it stopped early."""

    status: str
    directory: Path
    message: str | None

    @property
    def exit_code(self) -> int:
        """0 when all steps were solved, 4 when no further equilibrium was found."""
        return 0 if self.status == "complete" else NoEquilibriumError.exit_code


def run(
    spec,
    directory: Path,
    processes: int = 1,
    progress: Progress | None = None,
    report: bool = True,
    threads: int | None = None,
    scratch: Path | None = None,
    extra: Sequence = (),
    resume: bool = False,
) -> Outcome:
    """Solve ``spec`` and write its result folder.

    processes: MPI processes of the solver. report: whether report.html and the pictures are made
    too; ``softact.report.write_report`` makes them later from the folder alone. threads: of a
    single process in BLAS, by default one for each core. extra: further sections of the report.
    scratch: folder for mesh and job files, by default a new one in the system's temporary folder.
    The solver ends with this process, even where this one is killed. resume: go on with the run in
    ``directory`` from its last accepted increment; the spec may have further steps, and a finished
    last step other loads.

    Raises MeshError before anything is written, CannotWriteError where the disk is full or the
    folder read-only, and SolverCrashError where the solver's process ends in a way that it could
    not tell of itself.
    """
    progress = progress or (lambda event: None)
    directory = Path(directory)
    notes = []
    if spec.contact and processes > 1:
        processes = 1
        notes = ["contact between surfaces is computed by one process: the others are left out"]
    if spec.sheets and processes > 1:
        processes = 1
        notes = ["sheets are computed by one process: the others are left out"]
    started = time.perf_counter()
    old = _to_resume(spec, directory) if resume else None
    if old and old.finished_as(spec):
        return Outcome(old.status, directory, None)
    with _scratch(scratch) as folder:
        mesh_file, spec_file = folder / "mesh.msh", folder / "spec.yaml"
        job_file = folder / "job.json"

        def prepare() -> list[str]:
            """Mesh, and the job that the solver waits for; returns remarks on the mesh."""
            progress({"stage": "mesh"})
            remarks = make_mesh(spec.geometry, mesh_file)
            spec_file.write_text(spec.to_yaml())
            job = {
                "spec": str(spec_file),
                "mesh": str(mesh_file),
                "directory": str(directory.absolute()),
                "times_s": {"mesh": time.perf_counter() - started},
                "old_steps": old.steps if old else None,
                "remarks": remarks,
            }
            write_atomic(job_file, json.dumps(job))
            return remarks

        last = _solve(job_file, prepare, directory, processes, threads, progress, notes)
    if report:
        progress({"stage": "report"})
        from softact.report import write_report

        write_report(directory, extra)
    return Outcome(last["status"], directory, last.get("message"))


@contextlib.contextmanager
def _scratch(parent: Path | None) -> Iterator[Path]:
    """A fresh folder, removed afterwards as far as that is allowed; tempfile.TemporaryDirectory of
    Python 3.11 never comes back from a folder that it may not empty."""
    folder = Path(tempfile.mkdtemp(prefix="softact-", dir=parent))
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@dataclass(frozen=True)
class _Old:
    """A run that can be resumed."""

    status: str
    steps: list[dict]

    def finished_as(self, spec) -> bool:
        """Whether nothing is left to solve."""
        return self.status == "complete" and self.steps == _dump(spec)["steps"]


def _dump(spec) -> dict:
    return spec.model_dump(mode="json", exclude_none=True)


def _to_resume(spec, directory: Path) -> _Old | None:
    """The run in a folder; None where there is nothing to go on from.

    Raises SpecError where it is the run of another spec.
    """
    from softact.spec import load

    stored, known = directory / "spec.yaml", directory / "run.json"
    if not all(file.is_file() for file in (stored, known, directory / RESTART)):
        return None
    old, new = _dump(load(str(stored))), _dump(spec)
    texts = {"name", "description", "source", "assumptions", "steps"}
    differing = [key for key in (old | new) if old.get(key) != new.get(key) and key not in texts]
    if differing:
        raise SpecError(
            f"{directory}: holds the run of another spec ({', '.join(differing)} differ); a run is "
            "resumed with its own spec, in which only later steps may change"
        )
    return _Old(json.loads(known.read_text())["status"], old["steps"])


def _solve(
    job_file: Path,
    prepare: Callable[[], list[str]],
    directory: Path,
    processes: int,
    threads: int | None,
    progress: Progress,
    notes: list[str],
) -> Mapping:
    """Start the worker, pass its events on and write its log; returns its last event.

    The worker loads its libraries while ``prepare`` writes the job, but after it where the run has
    been given one thread: others run beside it, and it takes no more than one core.
    """
    last: dict = {}
    lines: list[str] = []

    def note(texts: Sequence[str]) -> None:
        lines.extend(texts)
        for text in texts:
            progress({"stage": "note", "text": text})

    note(notes)
    errors = job_file.with_name("stderr")
    beside = threads != 1
    if not beside:
        note(prepare())
    with errors.open("w") as stderr:
        process = subprocess.Popen(
            _command(job_file, processes),
            stdout=subprocess.PIPE,
            stderr=stderr,
            text=True,
            env=_environment(processes, threads),
            start_new_session=True,
        )
        try:
            if beside:
                note(prepare())
            for line in process.stdout:
                try:
                    last = json.loads(line)
                except ValueError:
                    continue
                lines.append(log_line(last))
                progress(last)
            code = process.wait()
        except BaseException:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
            process.wait()
            raise
    if directory.is_dir():
        noise = errors.read_text(errors="replace")
        write_atomic(directory / "log.txt", "\n".join(lines) + "\n" + noise)
    if last.get("stage") == "error":
        if last.get("cannot_write"):
            raise CannotWriteError(*last["lines"])
        error = SoftactError(*last["lines"])
        error.exit_code = last["exit_code"]
        raise error
    if last.get("stage") != "done":
        raise SolverCrashError(_crash(code, errors))
    return last


# What Python, C++, the loader of libraries and PETSc's trace say of it. PETSc 3.18's error code is
# of no use where the matrix is laid out: it is a line number.
_NO_MEMORY = re.compile(
    r"MemoryError|bad_alloc|Cannot allocate memory|failed to map segment|\bPetscMalloc"
)


class CannotWriteError(SoftactError):
    """The results could not be written: a full disk, a read-only folder."""


class SolverCrashError(SoftactError):
    """The solver's process ended without a word: killed, out of memory, or a fault of ours."""

    exit_code = 70


def _crash(code: int, errors: Path) -> str:
    noise = errors.read_text(errors="replace")
    if _NO_MEMORY.search(noise):
        return OUT_OF_MEMORY
    words = [line for line in noise.splitlines() if line.strip()]
    raised = [line for line in words if re.match(r"[\w.]*(Error|Exception)\b", line)]
    words = raised or words  # what mpirun says after it tells little
    cause = f"was killed by signal {-code}" if code < 0 else f"ended with exit code {code}"
    if code in (-signal.SIGKILL, 128 + signal.SIGKILL):
        cause += " (out of memory?)"
    return f"the solver {cause}; its last words: {words[-1] if words else 'none'}"


def _command(job_file: Path, processes: int) -> list[str]:
    worker = [sys.executable, "-m", "softact.worker", str(job_file)]
    if processes == 1:
        return bound([*worker, str(os.getpid())])
    # Unbound, or two runs side by side would share one core.
    mpirun = ["mpirun", "-n", str(processes), "--oversubscribe", "--bind-to", "none", *worker]
    return bound(mpirun)


def _environment(processes: int, threads: int | None = None) -> dict[str, str]:
    """Threads: all cores for one process, one for each of several (MUMPS uses them in BLAS)."""
    usual = str(len(os.sched_getaffinity(0)) if processes == 1 else 1)
    environment = {"OPENBLAS_NUM_THREADS": usual, **os.environ, "OMP_NUM_THREADS": "1"}
    if threads:
        environment["OPENBLAS_NUM_THREADS"] = str(threads)
    # All processes are on this machine and talk by shared memory: looking for networks takes each
    # of them 0.2 s, and leaving them at the end 1 s; without one, Open MPI 5 complains of TCP.
    environment |= {"OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self,vader"}
    if processes > 1:
        environment["OPENBLAS_NUM_THREADS"] = "1"
        # Waiting processes give their core away: another program may need it.
        environment["OMPI_MCA_mpi_yield_when_idle"] = "1"
    else:
        environment["OMPI_MCA_ess_singleton_isolated"] = "1"  # no daemon beside it
    if os.geteuid() == 0:
        environment |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return environment


def log_line(event: Mapping) -> str:
    """One plain line for an event."""
    match event["stage"]:
        case "solve":
            kind = event.get("kind", "tetrahedra")
            return f"mesh of {event['cells']} {kind}, {event['unknowns']} unknowns"
        case "increment":
            loads = ", ".join(
                f"{name} {value:.4g}"
                for name, value in event.items()
                if name.startswith("pressure_") and name.endswith("_kPa")
            )
            return (
                f"{event['step']} {event['fraction']:7.2%}  {event['iterations']:2d} iterations  "
                f"{loads}"
            )
        case "note":
            return event["text"]
        case "cutback":
            return (
                f"{event['step']} {event['fraction']:7.2%}  cut back after "
                f"{event['iterations']} iterations: {event['reason']}"
            )
        case "done":
            return event["message"] or "all steps solved"
        case "error":
            return "\n".join(event["lines"])
        case stage:
            return str(stage)
