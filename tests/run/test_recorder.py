"""What is written down and told of a run, whatever happens to its parts."""

import json

import pytest
from mpi4py import MPI

from softact import spec as specs
from softact.geometry.base import make_mesh
from softact.run import recorder
from softact.run.worker import solve
from softact.verdict.judge import from_data

PULLED = """
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{name: pull, traction: {surface: x_max, value: [100 kPa, 0 kPa, 60 kPa]}}]
"""
TRIED = "solver: {initial_increment: 1, max_increment: 1, max_iterations: 3}\n"
GIVEN_UP = TRIED.replace("3}", "3, min_increment: 0.9, dynamics: false}")


@pytest.fixture
def told(tmp_path):
    """Function that solves a spec in this process: what it told, and what run.json holds."""

    def solved(text):
        spec, events = specs.loads(text), []
        make_mesh(spec.geometry, tmp_path / "mesh.msh")
        solve(MPI.COMM_SELF, spec, tmp_path / "mesh.msh", tmp_path / "out", {}, events.append)
        return events, json.loads((tmp_path / "out" / "run.json").read_text())

    return solved


def test_increments_that_fail_are_told_and_kept(told):
    """As many, in the same order, as the history of run.json has."""
    events, known = told(PULLED + TRIED)
    stages = [e["stage"] for e in events if e["stage"] in ("increment", "cutback")]
    assert "cutback" in stages
    assert [s == "increment" for s in stages] == [a["converged"] for a in known["history"]]
    assert known["counts"]["cutbacks"] == stages.count("cutback")
    assert events[-1]["stage"] == "done"
    assert from_data(events[-1]["verdict"]).data() == known["verdict"]


@pytest.mark.parametrize(
    ("solver", "status", "colour"),
    [(TRIED, "complete", "amber"), (GIVEN_UP, "no_equilibrium", "red")],
)
def test_a_run_of_which_nothing_can_be_thought_is_kept(told, monkeypatch, solver, status, colour):
    def fail(results):
        raise ArithmeticError("no thought")

    monkeypatch.setattr(recorder, "judge", fail)
    _, known = told(PULLED + solver)
    assert (known["status"], known["verdict"]["colour"]) == (status, colour)
    assert "no verdict could be reached: ArithmeticError('no thought')" in str(known["verdict"])
