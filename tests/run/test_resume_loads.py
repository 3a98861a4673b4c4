"""A run goes on inside every kind of load, and to the same numbers wherever it was interrupted."""

import csv
import random

import numpy as np
import pytest
from mpi4py import MPI

from benchmarks import resume
from softact import spec as specs
from softact.catalogue import NO_LOADS
from softact.geometry.base import make_mesh
from softact.loads import BY_FIELD
from softact.run.worker import solve
from softact.solve.passed import Passed
from softact.spec import Step

BLOCK = """
geometry: {type: block, length: 6 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}
materials: {body: {law: neo_hookean, c10: 0.02 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
obstacles:
  table: {type: plane, point: [0 mm, 0 mm, -0.1 mm], normal: [0, 0, 1], friction: 0.3}
  cell: {type: sphere, center: [6 mm, 2 mm, 8.2 mm], radius: 4 mm, active: false}
solver: {initial_increment: 0.3, max_increment: 0.3}
"""
# Only where the tangent is symmetric do its factors tell whether the state is stable.
SYMMETRIC = BLOCK.replace(", friction: 0.3", "")
# A ball on the table, between the block and a wall.
BALL = BLOCK.replace(
    "[6 mm, 2 mm, 8.2 mm], radius: 4 mm, active: false}",
    "[8 mm, 2 mm, 1.9 mm], radius: 2 mm, mass: 2 g, friction: 0.5, held: true}\n"
    "  wall: {type: plane, point: [10 mm, 0 mm, 0 mm], normal: [-1, 0, 0], friction: 0.3}",
)
FREE = "\n".join(line for line in BLOCK.splitlines() if "type: plane" not in line) + "\n"
SPHERE = """
geometry: {type: thick_sphere, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
solver: {initial_increment: 0.3, max_increment: 0.3}
"""
MODULE = """
geometry:
  {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm, module_alone: true}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
solver: {initial_increment: 0.3, max_increment: 0.3}
"""
LATER = "{name: later, traction: {surface: x_max, value: [1 kPa, 0 kPa, 0.2 kPa]}}"
FURTHER = "{name: later, surface_pressure: {outer: 1 kPa}}"

# Field of the state, or key of a step: base of the spec, steps before and step in question.
CASES = {
    "gravity": (BLOCK, "gravity: [0, 1, -1]", LATER),
    "traction": (BLOCK, "traction: {surface: x_max, value: [2 kPa, 1 kPa, 0 kPa]}", LATER),
    "payload": (BLOCK, "payload: {surface: x_max, force: [20 mN, 0 N, 10 mN]}", LATER),
    "torque": (BLOCK, "torque: {surface: x_max, moment: [0.1 N*mm, 0.2 N*mm, 0 N*mm]}", LATER),
    "turn": (
        FREE,
        "supports: [{surface: x_min, fix: [x, y, z]}, "
        "{surface: x_max, turn: {axis: [1, 0, 0], angle: 20 deg}}]",
        "{name: later, surface_pressure: {y_max: 1 kPa}}",
    ),
    "wrench": (
        MODULE,
        "wrench: {moment: [0 N*mm, 2 N*mm, 0 N*mm]}",
        "{name: later, wrench: {force: [10 mN, 0 N, 0 N]}}",
    ),
    "surface_pressure": (BLOCK, "surface_pressure: {x_max: 2 kPa}", LATER),
    "shift": (BLOCK, "obstacles: {table: {move: [0 mm, 0 mm, 0.3 mm]}}", LATER),
    "presence": (BLOCK, "obstacles: {cell: {active: true, move: [0 mm, 0 mm, -1 mm]}}", LATER),
    "turned obstacle": (
        BLOCK,
        "obstacles: {table: {move: [0 mm, 0 mm, 0.2 mm], turn: {axis: [0, 1, 0], angle: -3 deg}}}",
        LATER,
    ),
    "hold": (
        BALL,
        "gravity: [0, 0, -1], traction: {surface: x_max, value: [6 kPa, 0 kPa, 0 kPa]}",
        "{name: later, obstacles: {cell: {held: false}}}",
    ),
    "supports": (
        BLOCK,
        "supports: [{surface: x_min, fix: [x, y, z]}, {surface: x_max, move: {x: 0.5 mm}}]",
        "{name: later, surface_pressure: {y_max: 1 kPa}}",
    ),
    "pressure": (SPHERE, "pressure: 4 kPa", FURTHER),
    "inject": (SPHERE, "inject: 20 mm^3", FURTHER),
    "supply": (
        SPHERE,
        "duration: 20 ms, supply: {pressure: 5 kPa, diameter: 0.5 mm}",
        "{name: later, duration: 20 ms, supply: {pressure: 8 kPa, diameter: 0.5 mm}}",
    ),
    "exhaust": (
        SPHERE,
        "duration: 20 ms, supply: {pressure: 5 kPa, diameter: 0.5 mm}",
        "{name: later, duration: 20 ms, exhaust: {diameter: 0.5 mm}}",
    ),
    "sealed": (SPHERE, "sealed: {heated: 1.01}", "{name: later, sealed: {heated: 1.01}}"),
    "ambient": (
        SPHERE,
        "sealed: true, ambient: 99 kPa",
        "{name: later, sealed: true, ambient: 98 kPa}",
    ),
}


class Killed(BaseException):
    """Stands for a kill."""


@pytest.fixture
def run(tmp_path):
    """A function that solves a spec in this process, and is killed after so many increments."""
    meshes = {}

    def solved(text, name, after=None, again=False):
        spec, count = specs.loads(text), 0
        if spec.geometry not in meshes:
            meshes[spec.geometry] = tmp_path / f"{len(meshes)}.msh"
            make_mesh(spec.geometry, meshes[spec.geometry], curved=spec.solver.curved)

        def tell(event):
            nonlocal count
            count += event["stage"] == "increment"
            if after is not None and count > after:
                raise Killed

        mesh, folder = meshes[spec.geometry], tmp_path / name
        try:
            solve(MPI.COMM_SELF, spec, mesh, folder, {}, tell, again)
        except Killed:
            pass
        with (folder / "curve.csv").open() as file:
            return list(csv.DictReader(file))

    return solved


@pytest.mark.parametrize("load", CASES)
def test_interrupted_inside_a_load(run, load):
    """In the middle of the step with the load, and of the one after it, which keeps it."""
    base, change, later = CASES[load]
    text = f"{base}steps: [{{name: first, {change}}}, {later}]\n"
    whole = run(text, "whole")
    assert float(whole[3]["strain_energy_mJ"]) > 1e-6  # the load does something
    for name in ("first", "later"):
        after = next(n for n, row in enumerate(whole) if row["step"] == name) + 2
        run(text, name, after=after)
        resumed = run(text, name, again=True)
        assert resume.difference(whole, resumed) < 1e-8


def test_every_load_is_interrupted():
    keys = set(Step.model_fields) - set(NO_LOADS)
    assert set(BY_FIELD) <= set(CASES)
    assert keys <= set(CASES) | {"obstacles"}


def test_next_step_changes_nothing(run):
    """It is at equilibrium before anything was factorised: what the tangent said is remembered."""
    pull = "traction: {surface: x_max, value: [2 kPa, 0 kPa, 0 kPa]}"
    text = f"{SYMMETRIC}steps: [{{name: pull, {pull}}}, {{name: hold, {pull}}}, {LATER}]\n"
    whole = run(text, "whole")
    hold = [n for n, row in enumerate(whole) if row["step"] == "hold"]
    assert {whole[n]["newton_iterations"] for n in hold} == {"0"}
    for after in (hold[0], hold[1]):
        run(text, "cut", after=after)
        assert resume.difference(whole, run(text, "cut", again=True)) < 1e-8


CHANGES = (
    "gravity: [0, 0, -1]",
    "gravity: [0, 1, 0]",
    "traction: {surface: x_max, value: [2 kPa, 0 kPa, 0 kPa]}",
    "traction: {surface: x_max, value: [-1 kPa, 1 kPa, 0 kPa]}",
    "surface_pressure: {y_max: 1 kPa}",
    "supports: [{surface: x_min, fix: [x, y, z]}, {surface: x_max, fix: [y]}]",
    "supports: [{surface: x_min, fix: [x, y, z]}, {surface: x_max, move: {z: 0.3 mm}}]",
)


@pytest.mark.parametrize("seed", range(3))
def test_random_specs_interrupted_anywhere(run, seed):
    """Three steps out of a few, so that some change nothing; killed twice on the way."""
    draw = random.Random(seed)
    steps = ", ".join(f"{{name: s{n}, {draw.choice(CHANGES)}}}" for n in range(3))
    text = f"{SYMMETRIC}steps: [{steps}]\n".replace(": 0.3}", f": {draw.choice((0.3, 0.5))}}}")
    whole = run(text, "whole")
    run(text, "cut", after=draw.randrange(2, len(whole)))
    run(text, "cut", after=2, again=True)
    assert resume.difference(whole, run(text, "cut", again=True)) < 1e-8


def test_equilibria_that_were_passed_are_remembered(run, monkeypatch):
    """Of all increments of the step, not of the last ones alone; branches that were left too."""
    text = f"{SYMMETRIC}steps: [{LATER}]\n"
    passed, kept, take, restored = [], Passed.kept, Passed.take, []

    def left_once(self):
        if not passed:
            self.leave()
            self.add(0.3, self._left[0][-1][1].repeat(1))
        passed.append(kept(self))
        return passed[-1]

    monkeypatch.setattr(Passed, "kept", left_once)
    monkeypatch.setattr(Passed, "take", lambda self, given: restored.append((self, given)))
    run(text, "cut", after=3)
    wanted = passed[-1]
    run(text, "cut", again=True)
    ((ladders, found),) = restored
    assert found["left"] == 1 and list(found["branch"]) == [0, 0, 1, 1]
    take(ladders, found)
    for name, values in kept(ladders).items():
        np.testing.assert_array_equal(values, wanted[name])
