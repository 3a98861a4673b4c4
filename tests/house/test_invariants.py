"""What must hold of every accepted state, looked at by other means than the solver's own."""

from dataclasses import replace

import pytest

from benchmarks.invariants import watched
from benchmarks.watch import Watch
from softact.solve.progress import Attempt
from softact.spec import loads

RUBBER = "materials: {body: {law: neo_hookean, c10: 0.1 MPa}}"
CASES = {
    "pulled": "geometry: {type: block, length: 20 mm, mesh_size: 5 mm}\n" + RUBBER + """
supports: [{surface: x_min, fix: [x, y, z]}]
steps:
  - {name: weight, gravity: [0, 0, -1]}
  - {name: pull, traction: {surface: x_max, value: [80 kPa, 0 kPa, 10 kPa]}}
""",
    "over the limit of a balloon": """\
geometry: {type: thick_sphere, mesh_size: 8 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
steps: [{name: inflate, pressure: 40 kPa}]
""",
    "injected": """\
geometry: {type: pneunet, chambers: 2, mesh_size: 8 mm}
materials: {body: elastosil-m4601}
steps: [{name: gravity, gravity: [0, 0, -1]}, {name: inject, inject: 500 mm^3}]
""",
    "on a rod": """\
geometry: {type: block, length: 60 mm, width: 6 mm, height: 4 mm, mesh_size: 8 mm}
materials: {body: ecoflex-00-30}
supports: [{surface: x_min, fix: [x, y, z]}]
obstacles: {rod: {type: cylinder, center: [40 mm, 0 mm, -3.1 mm], axis: [0, 1, 0], radius: 3 mm}}
steps: [{name: load, payload: {surface: x_max, force: [0 N, 0 N, -50 mN]}}]
""",
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_invariants_hold_of_every_state(case):
    watch = watched(loads(CASES[case]))
    assert watch.states > 5
    assert watch.faults == []


@pytest.fixture(scope="module")
def pulled():
    """A model and its states with what is known of them."""
    seen = []

    def keep(watch: Watch) -> None:
        seen.append(watch._last)

    return watched(loads(CASES["pulled"]), keep).model, seen


def told(model, *states) -> str:
    """What the watch says of states, whose fractions go up."""
    watch = Watch(model)
    for number, state in enumerate(states):
        part = (number + 1) / len(states)
        watch(state, Attempt("pull", part, 3, True, [], "", 0), number)
    return "\n".join(watch.end())


def test_a_state_out_of_balance_is_seen(pulled):
    model, states = pulled
    assert told(model, *states) == ""
    off = replace(states[-1], x=1.01 * states[-1].x)
    said = told(model, states[-2], off)
    assert "out of balance" in said


def test_work_that_is_not_in_the_energy_is_seen(pulled):
    model, states = pulled
    said = told(model, *states[:-1], replace(states[-1], x=1.3 * states[-1].x))
    assert "work of the loads" in said


def test_an_element_inside_out_is_seen(pulled):
    model, states = pulled
    assert "an element is inside out" in told(model, replace(states[-1], x=-30 * states[-1].x))


def test_a_return_to_a_passed_branch_is_seen(pulled):
    model, states = pulled
    watch = Watch(model)
    for number, state in enumerate(states[-5:]):
        watch(state, Attempt("pull", 0.2 * (number + 1), 3, True, [], "", 0), number)
    watch(states[-4], Attempt("pull", 0.4, 3, True, [], "", 1, "volume"), 5)
    assert any("returned to a branch that was passed" in fault for fault in watch.faults)
