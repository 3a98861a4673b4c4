"""From a spec to a result folder: mesh, solve in processes of their own, report."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from softact.errors import (
    OUT_OF_MEMORY,
    CannotWriteError,
    NoEquilibriumError,
    SoftactError,
    SpecError,
)
from softact.files.lock import held
from softact.files.streams import UTF8
from softact.files.text import json_text, write_atomic
from softact.geometry.base import make_mesh
from softact.results.folder import COMPLETE, INCOMPLETE, is_pressure, read
from softact.results.run_log import RunLog
from softact.run import launch
from softact.run.ahead import Ahead
from softact.run.resuming import to_resume
from softact.run.staying import Staying, event_of
from softact.spec import plausible
from softact.verdict.judge import Verdict
from softact.verdict.judge import from_data as verdict_of

if TYPE_CHECKING:
    from softact.measured.curve import Measured
    from softact.sensitivities.choosing import Chosen
    from softact.spec import Spec
    from softact.tolerances.causes import Cause

# Events that ``progress`` receives: {"stage": "mesh"}; {"stage": "solve", "cells", "unknowns"};
# {"stage": "increment", "step", "fraction", "iterations", ... and the row of curve.csv};
# {"stage": "cutback", "step", "fraction", "reason"}; {"stage": "progress", "step", "fraction",
# "control", "iteration", "residual", "iterations"}: what is being tried, where nothing else has
# been told for some seconds; {"stage": "done", "status", "message", "verdict"}; {"stage":
# "report"}; {"stage": "note", "text"}: something the user should know.
Progress = Callable[[Mapping], None]


@dataclass(frozen=True)
class Outcome:
    """How a run ended. status: "complete" or "no_equilibrium"; message: why it stopped early;
    verdict: what is to be thought of it, see ``softact.verdict.judge``."""

    status: str
    directory: Path
    message: str | None
    verdict: Verdict | None = None

    @property
    def exit_code(self) -> int:
        """0 when all steps were solved, 4 when no further equilibrium was found."""
        return 0 if self.status == "complete" else NoEquilibriumError.exit_code


def run(
    spec: Spec,
    directory: Path,
    processes: int = 1,
    progress: Progress | None = None,
    report: bool = True,
    threads: int | None = None,
    scratch: Path | None = None,
    measured: Sequence[Measured] = (),
    resume: bool = False,
    sensitivities: Sequence[str] | None = None,
    near: Path | None = None,
    staying: Staying | None = None,
) -> Outcome:
    """Solve ``spec`` and write its result folder.

    processes: MPI processes of the solver. report: whether report.html and the pictures are made
    too; ``softact.report.write_report`` makes them later from the folder alone. threads: of a
    single process in BLAS, by default one for each core. measured: curves to set the run against;
    they stay in the folder.
    scratch: folder for mesh and job files, by default a new one in the system's temporary folder.
    The solver ends with this process, even where this one is killed. resume: go on with the run in
    ``directory`` from its last accepted increment; the spec may have further steps, and a finished
    last step other loads. sensitivities: paths of parameters by which all measures are
    differentiated at each increment; none of them: all usual ones. Those that have tolerances in
    the spec are in any case, and the folder gets tolerances.csv. near: result folder of an actuator
    like this one, from whose last state this one's is found without those before; where that cannot
    be, the run has all of them, and its notes say why. staying: a process that solves this run
    after others, with one thread.

    Raises SpecError where the spec asks for a library that is not there and MeshError, both before
    anything is written, FolderBusyError where another process writes into the folder,
    DamagedResultError where the run there cannot go on, CannotWriteError where the disk is full or
    the folder read-only, and SolverCrashError where the solver's process ends in a way that it
    could not tell of itself.
    """
    _check_factor(spec)
    directory = Path(directory)
    progress = _remembering(directory, measured, progress or (lambda event: None))
    notes = [*spec.geometry.notes(), *plausible.lines(spec)]
    slopes, some = _chosen(spec, sensitivities)
    if spec.sheets and processes > 1:
        processes = 1
        notes += ["sheets are computed by one process: the others are left out"]
    if spec.layout().repeats and processes > 1:
        processes = 1
        notes += ["a module is computed by one process: the others are left out"]
    with (
        held(directory, "run", {"run.json": json_text({"status": INCOMPLETE})}) as inherited,
        # Where other runs lie beside this one, it takes no more than one core.
        Ahead(directory, wanted=report and threads != 1) as ahead,
    ):
        old = to_resume(spec, directory) if resume else None
        if resume and old is None:
            notes.append(f"{directory}: there is nothing to go on from; solved from the beginning")
        finished = old if old is not None and old.finished_as(spec) else None
        if finished is not None:
            read(directory)  # what is damaged is told of before anything is written
            _remember(directory, measured)
            outcome = Outcome(COMPLETE, directory, None, finished.verdict)
        else:
            with _scratch(scratch) as folder:
                goes_on = old is not None
                log = RunLog(directory, goes_on)
                held_by = (log, inherited, ahead, goes_on, slopes, near, staying)
                solver = _Solver(spec, directory, folder, progress, *held_by)
                last = solver.run(notes, processes, threads)
            verdict = verdict_of(last.get("verdict"))
            outcome = Outcome(last["status"], directory, last.get("message"), verdict)
            if some:
                _write_scatter(directory, some)
        # A run that was killed while its report was made is finished, and has none.
        if report and (not finished or measured or not (directory / "report.html").exists()):
            progress({"stage": "report"})
            ahead.write(outcome.verdict)
        return outcome


def _remembering(directory: Path, measured: Sequence[Measured], progress: Progress) -> Progress:
    """The same, which copies measured curves into the folder as soon as that is there."""

    def both(event: Mapping) -> None:
        if event["stage"] == "solve":
            _remember(directory, measured)
        progress(event)

    return both


def _remember(directory: Path, measured: Sequence[Measured]) -> None:
    if measured:
        from softact.report.remembered import remember

        remember(directory, measured)


def _check_factor(spec: Spec) -> None:
    """Raises SpecError where what the spec wants its tangents factorised by is not there."""
    if spec.solver.factor == "pardiso":
        from softact.solve import pardiso  # few have it

        if pardiso.library() is None:
            raise SpecError(
                f"solver.factor: pardiso is part of MKL, which is not there: {pardiso.HOW}"
            )


def usual_processes(spec: Spec) -> int:
    """How many MPI processes a run takes where nobody says: the cores, up to two, beyond which
    little is gained; one where sheets or a module leave no choice."""
    alone = spec.sheets or spec.layout().repeats
    return 1 if alone else min(2, len(os.sched_getaffinity(0)))


@contextlib.contextmanager
def _scratch(parent: Path | None) -> Iterator[Path]:
    """A fresh folder, removed afterwards as far as that is allowed; tempfile.TemporaryDirectory of
    Python 3.11 never comes back from a folder that it may not empty."""
    try:
        folder = Path(tempfile.mkdtemp(prefix="softact-", dir=parent)).absolute()
    except OSError as error:
        why = error.strerror or str(error)
        raise CannotWriteError(
            f"no temporary files: {why}; export TMPDIR=DIR names a folder"
        ) from None
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _chosen(spec: Spec, paths: Sequence[str] | None) -> tuple[Chosen | None, list[Cause]]:
    """The parameters by which the measures are differentiated, and the causes of scatter."""
    if paths is None and not spec.tolerances:
        return None, []
    # Imported here: it loads scipy, and sweeps and their tables shall not wait for it.
    from softact.sensitivities.choosing import Chosen
    from softact.tolerances.causes import causes

    if spec.layout().repeats:
        raise SpecError("sensitivities: a module has none yet; differentiate the whole actuator")
    some = causes(spec)
    return Chosen(spec, paths, [p for cause in some for p in cause.parameters]), some


def _write_scatter(directory: Path, some: Sequence[Cause]) -> None:
    from softact.tolerances.first_order import write

    write(directory, some)


@dataclass(frozen=True)
class _Solver:
    """The processes that solve one spec.

    scratch: folder of the mesh and of the job. It is their current folder too: what lies in the
    caller's (PETSc's .petscrc, say) is no business of theirs. inherited: what holds ``directory``.
    ahead: hears when there is something to do for the report.
    """

    spec: Any
    directory: Path
    scratch: Path
    progress: Progress
    log: RunLog
    inherited: tuple[int, ...]
    ahead: Ahead
    resume: bool
    slopes: Chosen | None = None
    near: Path | None = None
    staying: Staying | None = None

    def run(self, notes: Sequence[str], processes: int, threads: int | None) -> Mapping:
        """Start the worker, pass its events on and log them; returns its last event.

        The worker loads its libraries while ``_prepare`` writes the job, but after it where the run
        has been given one thread: others run beside it, and it takes no more than one core.
        """
        self._note(notes)
        if self.staying is not None:
            return self._run_staying(self.staying)
        last: dict = {}
        errors = self.scratch / "stderr"
        beside = threads != 1
        if not beside:
            self._prepare()
        variables = launch.variables(processes, threads, self.scratch)
        worker: list[str | Path] = ["-m", "softact.run.worker", self._job_file]
        with errors.open("wb") as stderr:
            process = subprocess.Popen(
                launch.command(processes, worker, variables),
                stdout=subprocess.PIPE,
                stderr=stderr,
                **UTF8,
                cwd=self.scratch,
                env=variables,
                pass_fds=self.inherited,
                start_new_session=True,
            )
            assert process.stdout is not None  # it is a pipe
            try:
                if beside:
                    self._prepare()
                for line in process.stdout:
                    event = event_of(line)
                    if event:
                        last = event
                        self._tell(event)
                code = process.wait()
            except BaseException:
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(process.pid, signal.SIGTERM)
                process.wait()
                raise
        return self._ended(last, code, errors)

    def _run_staying(self, staying: Staying) -> Mapping:
        """The same by a process that is there already."""
        self._prepare()
        last, code = staying.solve(self._job_file, self._tell)
        return self._ended(last, code, staying.errors)

    def _ended(self, last: Mapping, code: int, errors: Path) -> Mapping:
        noise = errors.read_text(encoding="utf-8", errors="replace")
        self.log.add(*noise.splitlines())
        return _ended(last, code, errors)

    @property
    def _job_file(self) -> Path:
        return self.scratch / "job.json"

    def _prepare(self) -> None:
        """Mesh, what is to be said of it, and the job that the worker waits for."""
        started = time.perf_counter()
        mesh_file, spec_file = self.scratch / "mesh.msh", self.scratch / "spec.yaml"
        self.progress({"stage": "mesh"})
        notes = make_mesh(self.spec.geometry, mesh_file, curved=self.spec.solver.curved)
        self._note(notes)
        slopes = None
        if self.slopes:
            slopes, more = self.slopes.job(self.scratch)
            notes = [*notes, *more]
            self._note(more)
        spec_file.write_text(self.spec.to_yaml(), encoding="utf-8")
        job = {
            "spec": str(spec_file),
            "mesh": str(mesh_file),
            "directory": str(self.directory.absolute()),
            "times_s": {"mesh": time.perf_counter() - started},
            "resume": self.resume,
            "notes": notes,
            "sensitivities": slopes,
            "near": str(self.near.absolute()) if self.near else None,
        }
        write_atomic(self._job_file, json.dumps(job))

    def _tell(self, event: Mapping) -> None:
        if event["stage"] == "solved":
            self.ahead.solved(event["status"])
            return
        if event["stage"] == "solve":  # the results that were in the folder are gone
            self.log.begin()
            self.ahead.meshed()
        verdict = verdict_of(event.get("verdict"))
        if event["stage"] == "done" and self.slopes is None:  # or their table is written first
            self.ahead.judged(verdict)
        line = log_line(event)
        if event["stage"] == "solve":
            line += time.strftime(", on %Y-%m-%d at %H:%M:%S")
        self.log.add_now(line, *(verdict.lines if verdict else []))
        self.progress(event)

    def _note(self, texts: Sequence[str]) -> None:
        """Tell what the user should know, apart from what happens when."""
        self.log.add(*texts)
        for text in texts:
            self.progress({"stage": "note", "text": text})


def _ended(last: Mapping, code: int, errors: Path) -> Mapping:
    """The worker's last event, or what it means as an exception."""
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


class SolverCrashError(SoftactError):
    """The solver's process ended without a word: killed, out of memory, or a fault of ours."""

    exit_code = 70


def _crash(code: int, errors: Path) -> str:
    noise = errors.read_text(encoding="utf-8", errors="replace")
    if _NO_MEMORY.search(noise):
        return OUT_OF_MEMORY
    words = [line for line in noise.splitlines() if line.strip()]
    raised = [line for line in words if re.match(r"[\w.]*(Error|Exception)\b", line)]
    words = raised or words  # what mpirun says after it tells little
    cause = f"was killed by signal {-code}" if code < 0 else f"ended with exit code {code}"
    if code in (-signal.SIGKILL, 128 + signal.SIGKILL):
        cause += " (out of memory?)"
    return f"the solver {cause}; its last words: {words[-1] if words else 'none'}"


#: What is being tried under each control of an attempt.
_TRIED = {
    "load": "seeks the next equilibrium",
    "search": "seeks the next equilibrium with a line search",
    "volume": "follows the path beyond a limit, by volume instead of pressure",
    "arc": "follows the path beyond a limit, by its length",
    "dynamics": "lets the actuator move to its next equilibrium",
    "motion": "lets the pressure blow up the flat sheets",
}


def log_line(event: Mapping) -> str:
    """One plain line for an event."""
    match event["stage"]:
        case "solve":
            kind = event.get("kind", "tetrahedra")
            return f"mesh of {event['cells']} {kind}, {event['unknowns']} unknowns"
        case "increment":
            loads = ", ".join(
                f"{name} {value:.4g}" for name, value in event.items() if is_pressure(name)
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
        case "progress":
            what = _TRIED.get(event["control"], event["control"])
            return (
                f"{event['step']} {event['fraction']:7.2%}  {what}: iteration "
                f"{event['iteration']}, residual {event['residual']:.1e}, {event['iterations']} "
                "iterations so far"
            )
        case "error":
            return "\n".join(event["lines"])
        case stage:
            return str(stage)
