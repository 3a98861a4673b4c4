"""The process (or MPI processes) that solves one spec and fills its result folder.

``python -m softact.run.worker JOB`` is started by ``softact.run.start``; it tells what it does in
lines of JSON on standard output.
"""

from __future__ import annotations

import errno
import gc
import json
import mmap
import os
import sys
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from softact.errors import OUT_OF_MEMORY, SoftactError
from softact.files.text import digest
from softact.run.staying import ENDED, LATER

if TYPE_CHECKING:
    from mpi4py import MPI

    from softact.results.writer import ResultsWriter
    from softact.solve.checkpoint import Checkpoint
    from softact.spec import Spec

PETSC_OUT_OF_MEMORY = 55
_PAUSE = 0.005  # s
_BLAS_BUFFER = 1 << 27  # bytes that OpenBLAS asks for on x86-64


def solve(
    comm: MPI.Comm,
    spec: Spec,
    mesh_file: Path,
    directory: Path,
    times: dict,
    tell: Callable[[dict], None],
    resume: bool = False,
    notes: Sequence[str] = (),
    sensitivities: Mapping[str, Any] | None = None,
    near: str | None = None,
) -> str:
    """Solve ``spec`` on the mesh in ``mesh_file`` and write the result folder.

    Returns the status, "complete" or "no_equilibrium". times: seconds of the stages so far.
    tell: receives events, see ``softact.run.start``. resume: go on with the run in the folder.
    notes: on the mesh, for the user. sensitivities: what ``softact.run.twins.make_twins`` is to
    make: {"paths", "motion"}. near: folder of the run of an actuator like this one: the last state
    alone is sought, from that one's.
    """
    from softact.run.from_spec import build_model
    from softact.run.recorder import Recorder
    from softact.run.resuming import identity
    from softact.solve import checkpoint
    from softact.system import jit

    started = time.perf_counter()
    jit.cache_folder()  # on all processes alike, before they wait for each other
    model = build_model(comm, spec, mesh_file)
    mesh = model.mesh
    model.contacts.check_clear(model.initial_state())
    unknowns = comm.allreduce(model.unknowns.owned)
    start = None
    begin: int | None = 0
    if resume:
        start = checkpoint.read(model, directory)
    if start is not None:
        begin = checkpoint.first_to_solve(start, identity(spec)["steps"])
    notes = [*notes, *model.surfaces.notes]
    known: dict[str, Any] = {"mesh": {"cells": mesh.cell_count, "unknowns": unknowns}}
    if notes:
        known["mesh"]["remarks"] = list(notes)
    known["mesh_hash"] = digest(mesh_file)
    writer = _writer(comm, spec, directory, known, start)
    twins = []
    if sensitivities:
        from softact.run.twins import make_twins

        twins = make_twins(spec, model, sensitivities["paths"], sensitivities["motion"])
    recorder = Recorder(spec, model, writer, tell, start, notes, twins, begin)
    times["set_up"] = time.perf_counter() - started
    kind = "tetrahedra" if model.solids else "triangles"
    tell({"stage": "solve", "cells": mesh.cell_count, "kind": kind, "unknowns": unknowns})
    if near:
        recorder.guess_from(Path(near))
    return recorder.run(times, start, begin)


def _writer(
    comm: MPI.Comm, spec: Spec, directory: Path, known: dict, start: Checkpoint | None
) -> ResultsWriter | None:
    """The writer of the result folder, on rank 0: a new one, or that of the run to go on with.

    Raises DamagedResultError, on all processes, where that run's fields cannot be used.
    """
    writer = fault = None
    if comm.rank == 0:
        from softact.results.writer import ResultsWriter
        from softact.run.provenance import provenance

        known = {"spec_hash": spec.hash, "processes": comm.size, **provenance(), **known}
        try:
            if start is None:
                writer = ResultsWriter(directory, spec.to_yaml(), known)
            else:
                writer = ResultsWriter.reopen(directory, spec.to_yaml(), known, start.curve)
        except SoftactError as error:
            fault = error
    fault = comm.bcast(fault)
    if fault is not None:
        raise fault
    return writer


def print_event(event: dict) -> None:
    """Tell ``softact.run.start`` what happens."""
    print(json.dumps(event, default=float), flush=True)


def _start_blas() -> None:
    """Let OpenBLAS (numpy's own, and the one of scipy, basix and PETSc) take its buffer as long as
    there is room: where it gets none, it asks for it for ever.

    Raises MemoryError.
    """
    from scipy import linalg

    for solve_with in (np.linalg.solve, linalg.solve):
        try:
            private = mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS
            mmap.mmap(-1, _BLAS_BUFFER, flags=private).close()
        except OSError:
            raise MemoryError("no room for the buffer of OpenBLAS") from None
        solve_with(np.eye(2), np.ones(2))


def _await(job_file: Path) -> dict:
    """The job, as soon as it is there; ``softact.run.start`` ends this process where none will
    come."""
    while not job_file.exists():
        time.sleep(0.01)
    return json.loads(job_file.read_text(encoding="utf-8"))


def main(job_file: str, parent: str | None = None) -> int:
    """Run the job, once its file is there; returns an exit code of the command line.

    job_file: ``staying.LATER`` for the files that standard input names, a line each, as long as it
    lasts; after each of them an event tells its exit code.
    parent: process with which this one ends. Where mpirun started this process, it is mpirun.
    """
    from softact.child_processes import end_with

    end_with(int(parent) if parent else os.getppid())
    try:
        _start_blas()
    except MemoryError:
        print_event({"stage": "error", "exit_code": 70, "lines": [OUT_OF_MEMORY]})
        os._exit(70)

    import mpi4py
    import petsc4py

    mpi4py.rc.initialize = mpi4py.rc.finalize = False
    from mpi4py import MPI

    MPI.Init_thread()
    # Options in .petscrc, of the home or of the folder that softact is called in, would change
    # results without a word in the spec.
    petsc4py.init(["softact", "-skip_petscrc"])
    comm = MPI.COMM_WORLD

    def tell(event: dict) -> None:
        if comm.rank == 0:
            print_event(event)

    _import_the_rest()
    if job_file != LATER:
        return _carry_out(comm, Path(job_file), tell)
    for line in sys.stdin:
        code = _carry_out(comm, Path(line.rstrip("\n")), tell)
        _clear()
        print_event({"stage": ENDED, "code": code})
    return 0


def _carry_out(comm: MPI.Comm, job_file: Path, tell: Callable[[dict], None]) -> int:
    """Run a job, once its file is there; its exit code. Ends this process where it cannot go on."""
    from softact import spec as specs
    from softact.system import jit

    directory = job_file.parent
    try:
        job = _await(job_file)
        spec = specs.load(job["spec"])
        directory = Path(job["directory"])
        times = job["times_s"]
        more = [job[name] for name in ("resume", "notes", "sensitivities", "near")]
        status = solve(comm, spec, Path(job["mesh"]), directory, times, tell, *more)
    except OSError as error:  # a full disk, a folder that has gone
        if error.errno == errno.ENOMEM:
            _abort_without_memory(comm)
        lines = [f"{error.filename or directory}: cannot be written ({error.strerror or error})"]
        what = {"lines": lines, "cannot_write": True}
        if jit.concerns(error):
            what = {"lines": jit.no_room(error).lines}
        print_event({"stage": "error", "exit_code": 2, **what})
        comm.Abort(2)
    except MemoryError:
        _abort_without_memory(comm)
    except SoftactError as error:
        tell({"stage": "error", "exit_code": error.exit_code, "lines": error.lines})
        return error.exit_code
    except Exception as error:
        # On one process only, the others would wait for it for ever.
        if getattr(error, "ierr", None) == PETSC_OUT_OF_MEMORY:
            _abort_without_memory(comm)
        traceback.print_exc()
        sys.stderr.flush()
        comm.Abort(70)
    return 0 if status == "complete" else 4


def _clear() -> None:
    """Give back what a run held, before the next one begins."""
    from petsc4py import PETSc

    gc.collect()
    PETSc.garbage_cleanup()


def preload() -> None:
    """Load what can be loaded before MPI begins, in a fork server; dolfinx and PETSc cannot."""
    import mpi4py

    mpi4py.rc.initialize = mpi4py.rc.finalize = False
    import basix  # noqa: F401
    import ffcx.codegeneration.jit  # noqa: F401
    import h5py  # noqa: F401
    import meshio  # noqa: F401
    import ufl  # noqa: F401
    from mpi4py import MPI  # noqa: F401
    from scipy import linalg, sparse, spatial  # noqa: F401

    from softact import spec  # noqa: F401


def _import_the_rest() -> None:
    """What a solve needs, while the mesh is made: it takes as long."""
    import meshio  # noqa: F401

    from softact.run import from_spec, recorder  # noqa: F401


def _abort_without_memory(comm: MPI.Comm) -> NoReturn:
    print_event({"stage": "error", "exit_code": 70, "lines": [OUT_OF_MEMORY]})
    comm.Abort(70)
    raise AssertionError  # Abort does not return


def _leave(code: int) -> None:
    """End this process without taking Python and the matrices apart, which takes a second."""
    # What is collected once MPI has ended frees its communicators, which MPI answers by an abort.
    gc.disable()
    from mpi4py import MPI
    from petsc4py import PETSc

    sys.stdout.flush()
    sys.stderr.flush()
    # MPI waits with a whole core, which the first process judges with and the report is made with.
    met = MPI.COMM_WORLD.Ibarrier()
    while not met.Test():
        time.sleep(_PAUSE)
    # PETSc takes what Python no longer holds apart together, on the processes that know of some:
    # each must, or those that do would wait for the others for ever.
    PETSc.Vec().createMPI(MPI.COMM_WORLD.size, comm=MPI.COMM_WORLD)
    PETSc._finalize()  # writes what PETSC_OPTIONS asks for, such as -log_view
    MPI.Finalize()
    os._exit(code)


if __name__ == "__main__":
    _leave(main(*sys.argv[1:]))
