"""The process (or MPI processes) that solves one spec and fills its result folder.

``python -m softact.worker JOB`` is started by ``softact.run``; it tells what it does in lines of
JSON on standard output.
"""

from __future__ import annotations

import errno
import json
import mmap
import os
import resource
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import NoReturn

import numpy as np

from softact.errors import OUT_OF_MEMORY, SoftactError

Tell = Callable[[dict], None]
PETSC_OUT_OF_MEMORY = 55
_BLAS_BUFFER = 1 << 27  # bytes that OpenBLAS asks for on x86-64


def solve(
    comm,
    spec,
    mesh_file: Path,
    directory: Path,
    times: dict,
    tell: Tell,
    old_steps: list[dict] | None = None,
) -> str:
    """Solve ``spec`` on the mesh in ``mesh_file`` and write the result folder.

    Returns the status, "complete" or "no_equilibrium". times: seconds of the stages so far.
    tell: receives events, see ``softact.run``. old_steps: of the run that stands in the folder, to
    go on with it; None: start anew.
    """
    from softact import checkpoint

    started = time.perf_counter()
    model = build_model(comm, spec, mesh_file)
    mesh = model.mesh
    model.contacts.check_clear(model.initial_state())
    unknowns = comm.allreduce(model.unknowns.owned)
    start, begin = None, 0
    if old_steps is not None:
        start = checkpoint.read(model, directory)
        if start is not None:
            new_steps = spec.model_dump(mode="json", exclude_none=True)["steps"]
            begin = checkpoint.first_to_solve(start, old_steps, new_steps)
    known = {"mesh": {"cells": mesh.cell_count, "unknowns": unknowns}}
    writer = _writer(comm, spec, directory, known, start)
    # A new writer has no rows: then nothing is left to go on from.
    if start is not None and comm.bcast(writer is not None and not writer.last_row):
        start, begin = None, 0
    recorder = _Recorder(spec, model, writer, tell, start)
    times["set_up"] = time.perf_counter() - started
    kind = "tetrahedra" if model.solids else "triangles"
    tell({"stage": "solve", "cells": mesh.cell_count, "kind": kind, "unknowns": unknowns})
    return recorder.run(times, start, begin)


def build_model(comm, spec, mesh_file: Path):
    """The ``Model`` of a spec on a mesh. Collective."""
    from softact.mesh import distribute, of_sheets, read_msh
    from softact.model import Model

    layout = spec.geometry.layout()
    if layout.regions:
        mesh = distribute(comm, lambda: read_msh(mesh_file, layout), layout)
    else:
        mesh = of_sheets(comm, spec.geometry.checked_mesh(), layout)
    return Model(
        mesh,
        {name: law.material() for name, law in spec.materials.items()},
        [_layer(layer) for layer in spec.layers],
        spec.solver.element,
        spec.geometry.wall_normal,
        _obstacles(spec),
        _touching(spec),
        {name: _sheet(sheet) for name, sheet in spec.sheets.items()},
    )


def _layer(layer):
    from softact.bonded import BondedLayer

    relaxed = layer.wrinkling and layer.wrinkling == "tension_field"
    return BondedLayer(layer.surface, layer.material, layer.thickness, layer.bending, relaxed)


def _sheet(sheet):
    from softact.sheets.body import Ply, Sheet

    plies = [Ply(ply.material, ply.thickness, ply.angle, ply.incompressible) for ply in sheet.plies]
    relaxed = sheet.wrinkling == "tension_field"
    return Sheet(plies, relaxed, sheet.bending, tuple(sheet.axis))


def _writer(comm, spec, directory: Path, known: dict, start):
    """The writer of the result folder, on rank 0: a new one, or that of the run to go on with.

    Where the old fields cannot be read, all is written and solved anew.
    """
    if comm.rank:
        return None
    from softact.provenance import provenance
    from softact.results import ResultsWriter

    known = {"spec_hash": spec.hash, "processes": comm.size, **provenance(), **known}
    if start is not None:
        try:
            return ResultsWriter.reopen(directory, spec.to_yaml(), known, start.rows)
        except (OSError, KeyError, RuntimeError):
            pass  # killed in the middle of a write
    return ResultsWriter(directory, spec.to_yaml(), known)


class _Recorder:
    """Runs the steps of a spec and writes down each accepted state."""

    def __init__(self, spec, model, writer, tell: Tell, start):
        from softact.measures import MEASURES
        from softact.settings import Settings
        from softact.stepping import Stepper

        self.spec, self.model, self.writer, self.tell = spec, model, writer, tell
        wanted = MEASURES if spec.measures == "all" else dict.fromkeys(spec.measures)
        self.measures = [MEASURES[name] for name in wanted]
        settings = spec.solver.model_dump()
        settings.pop("element")
        self.stepper = Stepper(
            model, Settings(**settings), self._accept, self._reject, self._checkpoint
        )
        self.row: dict = model.comm.bcast(writer.last_row if writer is not None else None)
        self.write_time = 0.0
        if start is None:
            self._write_mesh()

    def _write_mesh(self) -> None:
        from softact.snapshot import gather_mesh

        gathered = gather_mesh(self.model)
        if gathered is not None:
            points, cells, region, surfaces = gathered
            layout = self.model.mesh.layout
            names = layout.regions or layout.sheets
            self.writer.mesh(points, cells, region, names, surfaces, layout)

    def run(self, times: dict, start, begin: int | None) -> str:
        started = time.perf_counter()
        steps, supports = _load_steps(self.spec, self.model), supports_of(self.spec.supports)
        progress = self.stepper.run(steps, supports, start, begin)
        times["solve"] = time.perf_counter() - started - self.write_time
        times |= {"measure_and_write": self.write_time, **self.stepper.newton.times}
        memory = self.model.comm.allreduce(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
        status = "no_equilibrium" if progress.stopped else "complete"
        messages = [progress.stopped, *progress.remarks, self._unstable(), *self._beyond_test()]
        messages = [message for message in messages if message]
        if self.writer is not None:
            summary = _parameters(self.spec) | self.row
            counts = {
                "increments": len(progress.attempts) - progress.cutbacks - 1,
                "cutbacks": progress.cutbacks,
                **asdict(self.stepper.newton.counts),
            }
            self.writer.finish(
                status,
                summary,
                {
                    "times_s": {name: round(t, 4) for name, t in times.items()},
                    "counts": counts,
                    "memory_MB": round(memory / 1024),
                    "messages": messages,
                    "history": [asdict(a) for a in progress.attempts],
                },
            )
        self.tell({"stage": "done", "status": status, "message": progress.stopped})
        return status

    def _unstable(self) -> str | None:
        """What to say of the first unstable equilibrium."""
        for attempt in self.stepper.progress.attempts:
            if attempt.converged and attempt.unstable_modes > 0:
                return (
                    f"unstable from {attempt.fraction:.2%} of step '{attempt.step}' on: the "
                    "potential energy falls in some direction, so the actuator would snap or buckle"
                )
        return None

    def _beyond_test(self) -> list[str]:
        """What to say of material that is stretched further at the end than its card was tested."""
        said = []
        for name, solid in self.model.solids.items():
            card = solid.material.card
            if card is None or card.stretch_range is None:
                continue
            f = solid.deformation_gradient(self.stepper.state.x)
            stretch = np.linalg.svd(f, compute_uv=False)
            low, high = card.stretch_range
            beyond = stretch[..., 0] > high
            if low < 1:  # a tension test says nothing of its transverse stretches below 1
                beyond |= stretch[..., -1] < low
            part = self.model.sum(float(solid.volumes[beyond].sum()))
            whole = self.model.sum(float(solid.volumes.sum()))
            if part > 0:
                said.append(
                    f"region '{name}': {part / whole:.2%} of the volume leaves the stretches "
                    f"{low:g} to {high:g} to which {card.name or 'its material'} was tested"
                )
        return said

    def _accept(self, state, attempt, number) -> None:
        from softact.snapshot import Snapshot, gather_nodes

        started = time.perf_counter()
        snapshot = Snapshot(self.model, state, self.row, self.spec.safety_factor)
        row = {"step": attempt.step, "increment": number, "step_fraction": attempt.fraction}
        for measure in self.measures:
            row |= measure.evaluate(snapshot)
        row["unstable_modes"] = attempt.unstable_modes
        row["newton_iterations"] = attempt.iterations
        row["residual"] = attempt.residuals[-1] if attempt.residuals else 0.0
        self.row = row
        fields = {
            name: gather_nodes(self.model, values)
            for name, values in snapshot.nodal_fields().items()
        }
        if self.writer is not None:
            self.writer.increment(row, fields)
        self.write_time += time.perf_counter() - started
        self.tell({"stage": "increment", "steps": len(self.spec.steps), **asdict(attempt), **row})

    def _checkpoint(self, checkpoint) -> None:
        from softact.checkpoint import pack

        started = time.perf_counter()
        data = pack(self.model, checkpoint)
        if self.writer is not None:
            self.writer.checkpoint(data)
        self.write_time += time.perf_counter() - started

    def _reject(self, attempt) -> None:
        self.tell({"stage": "cutback", **asdict(attempt)})


def supports_of(supports):
    from softact.model import Support

    return [Support(s.surface, s.values) for s in supports]


def _obstacles(spec):
    from softact.contact.rigid import Obstacle

    return [
        Obstacle(name, o.shape(), o.friction, o.active, o.load_cell, o.surfaces)
        for name, o in spec.obstacles.items()
    ]


def _touching(spec):
    from softact.contact.surfaces import Touching

    return [Touching(c.name, c.groups, c.friction, c.distance) for c in spec.contact]


def _dead_loads(spec, model) -> list[dict | None]:
    """For each step {surface: force per undeformed area in MPa}, None where nothing changes."""
    tractions, payloads, loads = {}, {}, []
    for step in spec.steps:
        changed = set()
        if step.traction:
            tractions[step.traction.surface] = np.asarray(step.traction.value)
            changed.add(step.traction.surface)
        if step.payload:
            surface = step.payload.surface or model.mesh.layout.tip
            area = model.mesh.layout.copies * model.surfaces.area(surface)
            payloads[surface] = np.asarray(step.payload.force) / area
            changed.add(surface)
        now = {name: tractions.get(name, 0.0) + payloads.get(name, 0.0) for name in changed}
        loads.append(now or None)
    return loads


def _load_steps(spec, model):
    from softact.ramp import LoadStep

    copies = spec.geometry.layout().copies
    return [
        LoadStep(
            name=step.name,
            pressure=step.pressure,
            gravity=step.gravity,
            traction=dead_loads,
            surface_pressure=step.surface_pressure,
            inject={name: v / copies for name, v in step.inject.items()} if step.inject else None,
            supports=supports_of(step.supports) if step.supports is not None else None,
            shift={n: o.move for n, o in (step.obstacles or {}).items() if o.move is not None},
            presence={
                n: float(o.active)
                for n, o in (step.obstacles or {}).items()
                if o.active is not None
            },
            max_increment=step.largest_increment,
        )
        for step, dead_loads in zip(spec.steps, _dead_loads(spec, model), strict=True)
    ]


def _parameters(spec) -> dict[str, str]:
    """The spec's values as columns: 'geometry.wall' -> '1 mm'."""
    dumped = spec.model_dump(mode="json", exclude_none=True)
    columns = {"name": spec.name}

    def walk(prefix, value):
        if isinstance(value, dict):
            for key, entry in value.items():
                walk(f"{prefix}.{key}", entry)
        else:
            columns[prefix] = value

    for part in ("geometry", "materials", "sheets", "solver"):
        walk(part, dumped[part])
    for number, layer in enumerate(dumped["layers"]):
        walk(f"layers.{number}", layer)
    return columns


def print_event(event: dict) -> None:
    """Tell ``softact.run`` what happens."""
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
    """The job, as soon as it is there; ``softact.run`` ends this process where none will come."""
    while not job_file.exists():
        time.sleep(0.01)
    return json.loads(job_file.read_text())


def main(job_file: str, parent: str | None = None) -> int:
    """Run the job, once its file is there; returns an exit code of the command line.

    parent: process with which this one ends. Where mpirun started this process, it is mpirun.
    """
    from softact.orphans import end_with

    end_with(int(parent) if parent else os.getppid())
    try:
        _start_blas()
    except MemoryError:
        print_event({"stage": "error", "exit_code": 70, "lines": [OUT_OF_MEMORY]})
        os._exit(70)

    from mpi4py import MPI

    # While the mesh is made: these take as long.
    from softact import measures, model, results  # noqa: F401
    from softact import spec as specs

    comm = MPI.COMM_WORLD
    job = _await(Path(job_file))

    def tell(event: dict) -> None:
        if comm.rank == 0:
            print_event(event)

    try:
        spec = specs.load(job["spec"])
        directory = Path(job["directory"])
        times, old_steps = job["times_s"], job.get("old_steps")
        status = solve(comm, spec, Path(job["mesh"]), directory, times, tell, old_steps)
    except OSError as error:  # a full disk, a folder that has gone
        if error.errno == errno.ENOMEM:
            _abort_without_memory(comm)
        lines = [f"cannot write: {error}"]
        print_event({"stage": "error", "exit_code": 2, "lines": lines, "cannot_write": True})
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


def _abort_without_memory(comm) -> NoReturn:
    print_event({"stage": "error", "exit_code": 70, "lines": [OUT_OF_MEMORY]})
    comm.Abort(70)


def _leave(code: int) -> None:
    """End this process without taking Python and the matrices apart, which takes a second."""
    from mpi4py import MPI
    from petsc4py import PETSc

    sys.stdout.flush()
    sys.stderr.flush()
    PETSc._finalize()  # writes what PETSC_OPTIONS asks for, such as -log_view
    MPI.Finalize()
    os._exit(code)


if __name__ == "__main__":
    _leave(main(*sys.argv[1:]))
