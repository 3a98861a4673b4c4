"""What a held module answers, beside differences and the stepper's own path."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from mpi4py import MPI

from softact.geometry.base import make_mesh
from softact.modules.walker import Walker
from softact.run.from_spec import build_model
from softact.spec import Spec
from tests.modules.solving import solved

FINGER = {
    "type": "pneunet",
    "chambers": 4,
    "chamber_height": "8 mm",
    "chamber_width": "8 mm",
    "base": "3 mm",
    "mesh_size": "4 mm",
    "module_alone": True,
}
# Its walls press on the next ones.
CLOSING = {**FINGER, "gap": "0.2 mm", "inner_wall": "0.5 mm", "cavity_mesh_size": "2 mm"}
ARM = {
    "type": "omnidirectional",
    "modules": 3,
    "mesh_size": "6 mm",
    "symmetry": False,
    "module_alone": True,
}
CASES = {
    "half": (FINGER, ({"cavity": 1.0},), [0.02], "none"),
    "touching": (CLOSING, ({"cavity": 1.0},), [0.0025], "auto"),
    "whole": (ARM, ({"cavity_1": 1.0, "cavity_2": 0.5}, {"cavity_3": 1.0}), [0.01, 0.004], "none"),
}


def data_of(geometry, groups, pressures, contact):
    pairs = zip(groups, pressures, strict=True)
    given = {name: f"{share * p!r} MPa" for g, p in pairs for name, share in g.items()}
    return {
        "name": "module",
        "geometry": geometry,
        "materials": {"body": "ecoflex-00-30"},
        "module": {"left": "left", "right": "right"},
        "contact": contact,
        "steps": [{"name": "up", "pressure": given}],
    }


def model_of(data):
    spec = Spec.model_validate(data)
    with TemporaryDirectory() as folder:
        mesh = Path(folder) / "module.msh"
        make_mesh(spec.geometry, mesh, curved=spec.solver.curved)
        return build_model(MPI.COMM_SELF, spec, mesh)


@pytest.fixture(scope="module", params=CASES)
def case(request):
    _, groups, pressures, _ = CASES[request.param]
    walker = Walker(model_of(data_of(*CASES[request.param])), groups)
    return walker, np.array(pressures)


def test_second_derivatives_are_those_of_the_first(case):
    """At a state that is bent, sheared and twisted."""
    walker, pressures = case
    let_go = walker.released(walker.begin(), pressures)
    k = len(walker.free)
    turns = walker.free < 3
    strain = let_go.strain + np.where(turns, 4e-3, 0.02) * (-1.0) ** np.arange(k)
    held = walker.to(let_go, strain, pressures)
    assert held.strain == pytest.approx(strain, abs=1e-9)
    if contacts := walker.model.contacts:
        assert contacts.touch(walker.state(held.unknowns, pressures))
    assert_differences(walker, held)


def test_second_derivatives_of_a_state_that_one_iteration_found(case):
    """Bent alone, by 3°: the first factors did, and their stress was that of the state before."""
    walker, _ = case
    start = walker.begin()
    goal = np.where(walker.free == 1, -np.radians(3) / walker.repeat.length, 0.0)
    before = walker.iterations
    held = walker.bent(start, goal, start.pressures)
    if not walker.model.contacts:
        assert walker.iterations <= before + 2
    assert_differences(walker, held)


def assert_differences(walker, held):
    """The second derivatives of a state beside differences of the first ones near it."""
    strain, pressures, k = held.strain, held.pressures, len(walker.free)
    turns = walker.free < 3
    steps = np.concatenate([np.where(turns, 1e-5, 1e-4), np.full(len(pressures), 1e-5)])
    found = []
    for move in np.diag(steps):
        ends = [
            walker.to(held, strain + sign * move[:k], pressures + sign * move[k:]).first
            for sign in (1, -1)
        ]
        found.append((ends[0] - ends[1]) / (2 * move.sum()))
    size = np.sqrt(np.abs(np.outer(np.diag(held.second), np.diag(held.second))))
    assert np.abs(held.second - np.array(found)).max() / size.max() < 1e-3
    assert (np.abs(held.second - np.array(found)) / size).max() < 1e-2
    assert held.second == pytest.approx(held.second.T, abs=1e-9 * size.max())


@pytest.mark.parametrize(("name", "least"), [("half", (100, 10)), ("touching", (0.1, 0.1))])
def test_let_go_it_is_where_the_stepper_comes_to(name, least, tmp_path):
    _, groups, pressures, _ = CASES[name]
    data = data_of(*CASES[name])
    walker = Walker(model_of(data), groups)
    found = walker.released(walker.begin(), np.array(pressures))
    # A millionth of what holds it where the pressure would move it: moment (N mm), forces (N).
    k = len(walker.free)
    moment, pull = (np.abs(found.second[:k, k:]) @ pressures)[:2]
    assert moment > least[0]
    assert pull > least[1]
    assert np.abs(found.load / [moment, pull, pull]).max() < 1e-6
    model, (state,) = solved(data, tmp_path / "stepped")
    turn, shift = model.repeat.motion(state.x)
    mine, my_shift = walker.repeat.motion(found.unknowns)
    assert mine == pytest.approx(turn, abs=1e-6)
    assert my_shift == pytest.approx(shift, abs=1e-5)
