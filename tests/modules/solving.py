"""A spec's equilibria at the ends of its steps, without a result folder."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from mpi4py import MPI

from softact.geometry.base import Geometry, make_mesh
from softact.model import Model
from softact.run.from_spec import build_model, load_steps, supports_of
from softact.solve.settings import Settings
from softact.solve.stepping import Stepper
from softact.spec import Spec
from softact.system.term import State


def solved(
    data: dict[str, Any], folder: Path, kind: type[Geometry] | None = None
) -> tuple[Model, list[State]]:
    """Carry out the steps of a spec's plain data; the model, and its states at their ends.

    kind: of geometry that makes the mesh, where it is not the spec's own.
    """
    model, ends, _ = stepped(data, folder, kind)
    return model, ends


def stepped(
    data: dict[str, Any], folder: Path, kind: type[Geometry] | None = None
) -> tuple[Model, list[State], int]:
    """The same, and how many modes of the last state are unstable."""
    spec = Spec.model_validate(data)
    folder.mkdir()
    mesh = folder / "mesh.msh"
    ends: dict[str, State] = {}
    geometry = kind.model_validate(data["geometry"]) if kind else spec.geometry
    make_mesh(geometry, mesh, curved=spec.solver.curved)
    model = build_model(MPI.COMM_SELF, spec, mesh)

    def keep(state: State, attempt: Any, number: int) -> None:
        if attempt.fraction == 1.0:
            ends[attempt.step] = State(state.x.copy(), dict(state.loads))

    size = 0.25 if spec.sheets else 1.0  # of slack folds a long way leaves others
    settings = Settings(initial_increment=size, max_increment=size, tolerance=1e-9)
    supports = supports_of(spec.supports or ())
    progress = Stepper(model, settings, keep).run(load_steps(spec, model), supports)
    assert not progress.stopped, progress.stopped
    return model, list(ends.values()), progress.attempts[-1].unstable_modes
