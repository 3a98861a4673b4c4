"""Derivatives of measures beside a run, and by differences of whole runs on meshes that follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mpi4py import MPI

from softact.geometry.base import make_mesh
from softact.geometry.motion import Moved
from softact.measures import MEASURES
from softact.measures.snapshot import Snapshot
from softact.model import Model
from softact.run.from_spec import build_model, load_steps, model_on, supports_of
from softact.run.twins import _move, make_twins
from softact.sensitivities.choosing import Chosen
from softact.sensitivities.following import Following
from softact.sensitivities.parameters import Parameter, changed
from softact.sensitivities.twin import Twin
from softact.solve.stepping import Stepper
from softact.spec import Spec

#: Of a parameter, by which it is changed between whole runs; the error is that of the fourth power.
WIDTH = 2e-4
TOLERANCE = 1e-11


@dataclass(frozen=True)
class Beside:
    """A spec's mesh and model, its parameters, and how the mesh moves with each of the geometry."""

    spec: Spec
    model: Model
    parameters: Sequence[Parameter]
    paths: Sequence[str]
    motion: Path | None


def prepare(spec: Spec, folder: Path, paths: Sequence[str] = ()) -> Beside:
    """The model of a spec, and its parameters."""
    mesh = folder / "mesh.msh"
    if spec.geometry.layout().regions:
        make_mesh(spec.geometry, mesh, curved=spec.solver.curved)
    job, _ = (slopes := Chosen(spec, paths)).job(folder)
    kept = [p for p in slopes.parameters if p.path in job["paths"]]
    motion = Path(job["motion"]) if job["motion"] else None
    return Beside(spec, build_model(MPI.COMM_SELF, spec, mesh), kept, job["paths"], motion)


def rows(spec: Spec, model: Model, beside: Beside | None = None) -> list[Any]:
    """The measures at each state of a run, and the derivatives beside them where these are wanted:
    [(row, {path: {measure: by the parameter in internal units}}), ...]."""
    found: list[Any] = []
    last: dict[str, Any] = {}
    seen: list[Snapshot] = []  # of the actuator

    def measured(snapshot: Snapshot) -> dict[str, Any]:
        row: dict[str, Any] = {}
        for measure in MEASURES.values():
            row |= measure.evaluate(snapshot)
        return row

    def of_twin(twin: Twin) -> dict[str, Any]:
        row, factor = dict(twin.row), spec.safety_factor
        return measured(Snapshot(twin.model, twin.state, row, factor, actuator=seen[-1]))

    def accept(state: Any, attempt: Any, number: int) -> None:
        seen.append(Snapshot(model, state, dict(last), spec.safety_factor))
        row = {"step_fraction": attempt.fraction, **measured(seen[-1])}
        slopes = following.accept(state, attempt, number, row) if following else None
        last.clear()
        last.update(row)
        found.append((row, slopes.of if slopes else None))

    stepper = Stepper(model, spec.solver.settings, accept)
    following = None
    if beside:
        twins = make_twins(spec, model, beside.paths, beside.motion)
        following = Following(stepper.walk, twins, of_twin)
    steps = load_steps(spec, model)
    assert not stepper.run(steps, supports_of(spec.supports or ())).stopped
    return found


def run_at(beside: Beside, parameter: Parameter, value: float) -> list[Any]:
    """The same of the spec with another value, on the mesh that follows."""
    spec = changed(beside.spec, parameter.place, value)
    mesh = beside.model.mesh
    if parameter.of_geometry:
        assert beside.motion
        moved = Moved.stored(beside.motion)
        index = [p.path for p in beside.parameters if p.of_geometry].index(parameter.path)
        velocity = moved.velocities[index]
        assert isinstance(velocity, np.ndarray)
        mesh = _move(mesh, moved, (value - parameter.value) * velocity)
    return rows(spec, model_on(mesh, spec))


def by_differences(
    beside: Beside, parameter: Parameter, at: int = -1, width: float = WIDTH
) -> dict[str, float]:
    """Derivatives of all measures at a state by Richardson's extrapolation of central differences
    of four whole runs."""
    step = width * (abs(parameter.value) or 1.0)
    if parameter.place[-1] == "poissons_ratio":
        step = width * (0.5 - parameter.value)
    ends = {k: run_at(beside, parameter, parameter.value + k * step)[at][0] for k in (-2, -1, 1, 2)}

    def slope(name: str, k: int) -> float:
        return (ends[k][name] - ends[-k][name]) / (2 * k * step)

    return {
        name: (4 * slope(name, 1) - slope(name, 2)) / 3
        for name, value in ends[1].items()
        if isinstance(value, float) and all(name in end for end in ends.values())
    }
