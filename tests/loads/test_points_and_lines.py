"""Supports and forces on points and lines, and several loads of one kind in a step."""

import numpy as np
import pytest
from mpi4py import MPI

from softact import spec as specs
from softact.bodies.sheet import Ply, Sheet
from softact.errors import SpecError
from softact.loads import LOADS
from softact.loads.load_step import LoadStep
from softact.loads.payload import Payload
from softact.loads.support import Spring, Support
from softact.loads.torque import Torque
from softact.loads.traction import Traction
from softact.materials import LAWS
from softact.measures import MEASURES
from softact.measures.snapshot import Snapshot
from softact.mesh.layout import Layout
from softact.mesh.tetrahedra import distribute
from softact.model import Model
from softact.run.held import refuse_loose
from tests.analytic.meshes import block
from tests.analytic.sheet_meshes import build as sheet_model
from tests.analytic.sheet_meshes import rectangle
from tests.analytic.solving import solve

C10 = 0.14  # MPa
RUBBER = LAWS["neo_hookean"].of(c10=C10, bulk_modulus=1e4)
BEAM = (60.0, 4.0, 4.0)


def built(tets, points=None, lines=None, symmetry=None, **more):
    layout = Layout(
        regions=("body",), surfaces=tuple(tets.surfaces), cavities={}, symmetry=symmetry or {},
        clamp="", tip="x_max", points=points or {}, lines=lines or {},
    )  # fmt: skip
    mesh = distribute(MPI.COMM_SELF, lambda: tets, layout)
    return Model(mesh, {"body": RUBBER.material()}, **more)


def step(model, **values):
    """A load step of what a spec writes, as parts."""
    loads = {}
    for key, value in values.items():
        loads |= LOADS[key].ends(value, model)
    return LoadStep("load", **loads)


def reactions(model, state):
    columns = MEASURES["reaction"].evaluate(Snapshot(model, state))
    names = [s.surface for s in model.supports]
    return {n: np.array([columns[f"reaction_{n}_{c}_N"] for c in "xyz"]) for n in names}


def test_a_block_held_by_three_points_and_pulled_at_both_ends():
    """Two tractions in one step; nothing hinders it, so that it stretches as its law says, and the
    points take nothing."""
    stretch = 1.4
    pull = 2 * C10 * (stretch - stretch**-2)
    points = {"one": (0.0, 0.0, 0.0), "two": (4.0, 0.0, 0.0), "three": (0.0, 2.0, 0.0)}
    model = built(block((2, 1, 1), (4.0, 2.0, 2.0)), points)
    held = [
        Support("one", dict.fromkeys(range(3), 0.0)),
        Support("two", {1: 0.0, 2: 0.0}),
        Support("three", {2: 0.0}),
    ]
    both = (
        Traction.model_construct(surface="x_max", value=(pull, 0.0, 0.0)),
        Traction.model_construct(surface="x_min", value=(-pull, 0.0, 0.0)),
    )
    solution = solve(model, step(model, traction=both), held, 0.5)
    assert solution.displacement((4.0, 0.0, 0.0))[0] == pytest.approx(4 * (stretch - 1), rel=2e-4)
    for force in reactions(model, solution.state).values():
        assert force == pytest.approx(np.zeros(3), abs=1e-6)


def test_three_point_bending():
    """On lines at both ends, a force on a line in the middle: F L³/48 E I + F L/4 κ G A, and half
    of the force on each line."""
    length, width, height = BEAM
    force, young = 1e-3, 6 * C10
    lines = {
        "left": ("x_min", "z_min"),
        "right": ((length, 0.0, 0.0), (length, width, 0.0)),
        "middle": ((length / 2, 0.0, height), (length / 2, width, height)),
    }
    model = built(block((16, 1, 2), BEAM), {"corner": (0.0, 0.0, 0.0)}, lines)
    held = [Support("left", {0: 0.0, 2: 0.0}), Support("right", {2: 0.0}),
            Support("corner", {1: 0.0})]  # fmt: skip
    down = Payload.model_construct(surface="middle", force=(0.0, 0.0, -force))
    solution = solve(model, step(model, payload=down), [*held])
    sag = -solution.displacement((length / 2, 0.0, 0.0))[2]
    bent = force * length**3 / (48 * young * width * height**3 / 12)
    sheared = force * length / (4 * 5 / 6 * young / 3 * width * height)
    assert sag == pytest.approx(bent + sheared, rel=0.01)
    found = reactions(model, solution.state)
    for name in ("left", "right"):
        assert found[name][2] == pytest.approx(force / 2, rel=1e-4)


def test_forces_on_points_lines_and_surfaces_in_one_step_add_up():
    points, lines = {"corner": (4.0, 2.0, 2.0)}, {"edge": ("x_max", "z_min")}
    model = built(block((2, 1, 1), (4.0, 2.0, 2.0)), points, lines)
    parts = (
        Payload.model_construct(surface="corner", force=(1e-3, 0.0, 0.0)),
        Payload.model_construct(surface="edge", force=(0.0, 2e-3, 0.0)),
        Payload.model_construct(surface=None, force=(0.0, 0.0, 3e-3)),  # on the tip
        Payload.model_construct(surface=None, force=(0.0, 0.0, 4e-3)),
    )
    clamp = Support("x_min", dict.fromkeys(range(3), 0.0))
    solution = solve(model, step(model, payload=parts), [clamp])
    assert reactions(model, solution.state)["x_min"] == pytest.approx(
        [-1e-3, -2e-3, -7e-3], rel=1e-6
    )


def test_a_force_on_a_line_is_shared_by_simpsons_rule():
    """Quadratic edges: 1/6 at the ends, 2/3 in the middle, 1/3 where two meet."""
    model = built(block((2, 1, 1), (4.0, 2.0, 2.0)), lines={"edge": ("y_min", "z_min")})
    nodes, shares = model.surfaces.shares("edge")
    along = model.nodes.places[nodes, 0]
    assert shares[np.argsort(along)] == pytest.approx([1 / 12, 1 / 3, 1 / 6, 1 / 3, 1 / 12])
    assert model.surfaces.area("edge") == pytest.approx(4.0)


def test_a_point_beside_the_plane_of_a_half_is_on_both_sides_of_the_whole():
    """The force on the whole actuator is shared by the point and its mirror image."""
    tets = block((2, 1, 1), (4.0, 2.0, 2.0))
    points = {"right": (4.0, -2.0, 2.0), "middle": (4.0, 0.0, 2.0)}
    model = built(tets, points, symmetry={"y_min": 1})
    clamp = Support("x_min", dict.fromkeys(range(3), 0.0))
    for name in points:
        down = Payload.model_construct(surface=name, force=(0.0, 0.0, -1e-3))
        solution = solve(model, step(model, payload=down), [clamp])
        assert reactions(model, solution.state)["x_min"] == pytest.approx([0, 0, 1e-3], abs=1e-8)


def test_springs_at_a_point_and_a_torque_on_a_line():
    """The spring takes the weight, k u = F; two moments on a line are one."""
    tets = block((2, 1, 1), (4.0, 2.0, 2.0))
    lines = {"edge": ("x_max", "z_max")}
    more = {"springs": [Spring("foot", (0.0, 0.0, 0.5))]}
    model = built(tets, {"foot": (4.0, 2.0, 0.0)}, lines, more=more)
    held = [Support("x_min", {0: 0.0, 1: 0.0})]
    up = Payload.model_construct(surface="foot", force=(0.0, 0.0, 1e-3))
    solution = solve(model, step(model, payload=up), held)
    columns = MEASURES["reaction"].evaluate(Snapshot(model, solution.state))
    assert columns["spring_foot_z_N"] == pytest.approx(-1e-3, rel=1e-6)
    assert solution.displacement((4.0, 2.0, 0.0))[2] == pytest.approx(1e-3 / 0.5, rel=1e-6)
    parts = tuple(
        Torque.model_construct(surface="edge", moment=(0.0, 0.0, m)) for m in (1e-3, 2e-3)
    )
    ends = LOADS["torque"].ends(parts, model)
    assert ends["torque"]["edge"] == pytest.approx([0.0, 0.0, 3e-3])


def test_a_point_is_told_where_it_is_and_refused_outside():
    tets = block((2, 1, 1), (4.0, 2.0, 2.0))
    model = built(tets, {"near": (1.0, 0.02, 0.0), "on": (4.0, 2.0, 2.0)})
    assert model.surfaces.notes == ["points.near: is the node at (1, 0, 0) mm, 0.02 mm away"]
    with pytest.raises(SpecError, match=r"points.away: the body has no node near; .* 3 mm away"):
        built(tets, {"away": (7.0, 0.0, 0.0)})
    with pytest.raises(SpecError, match=r"lines.askew: no edge of the mesh lies on it"):
        built(tets, lines={"askew": ((0.0, 0.3, 0.0), (4.0, 1.7, 0.0))})


BLOCK = """
geometry: {type: block, mesh_size: 10 mm}
materials: {body: ecoflex-00-30}
points: {pin: [0 mm, 0 mm, 0 mm], end: [10 mm, 0 mm, 0 mm], side: [0 mm, 10 mm, 0 mm]}
lines: {rim: {between: [x_max, z_max]}}
"""
THREE = "[{surface: pin, fix: [x, y, z]}, {surface: end, fix: [y, z]}, {surface: side, fix: [z]}]"


def test_what_points_hold_is_known_before_the_first_load():
    """Three points hold a block; two of them let it turn about the line between them."""
    tets = block((1, 1, 1), (10.0, 10.0, 10.0))
    spec = specs.loads(f"{BLOCK}supports: {THREE}\nsteps: [{{gravity: [0, 0, -1]}}]")
    refuse_loose(tets, spec.layout(), spec)
    two = THREE.replace(", {surface: side, fix: [z]}", "")
    spec = specs.loads(f"{BLOCK}supports: {two}\nsteps: [{{gravity: [0, 0, -1]}}]")
    with pytest.raises(SpecError, match="turn about x"):
        refuse_loose(tets, spec.layout(), spec)


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("lines: {a: {}}", "lines.a", "write one of ends: "),
        ("lines: {a: {between: [x_max, z_mx]}}", "lines.a.between.1", "did you mean 'z_max'"),
        ("points: {x_max: [0 mm, 0 mm, 0 mm]}", "points.x_max", "name of a surface"),
        ("steps: [{payload: []}]", "steps.0.payload", "1 or more are wanted"),
        ("steps: [{payload: [{surface: rimm, force: [0 N, 0 N, 1 N]}]}]",
         "steps.0.payload.0.surface", "did you mean 'rim'"),
        ("steps: [{payload: [{force: [0 N, 0 N]}]}]", "steps.0.payload.0.force", "list of three"),
        ("steps: [{torque: {surface: pin, moment: [1 N*mm, 0 N*mm, 0 N*mm]}}]",
         "steps.0.torque.surface", "is a point; write one of"),
        ("steps: [{traction: {surface: rim, value: [1 kPa, 0 kPa, 0 kPa]}}]",
         "steps.0.traction.surface", "is a line"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_told_in_a_line(text, place, words):
    key = text.partition(":")[0]
    kept = "\n".join(line for line in BLOCK.splitlines() if not line.startswith(f"{key}:"))
    steps = "" if key == "steps" else "steps: [{gravity: [0, 0, -1]}]"
    if key in ("points", "lines"):
        kept = "\n".join(line for line in kept.splitlines() if not line.startswith("lines:"))
    with pytest.raises(SpecError) as caught:
        specs.loads(f"{kept}\n{text}\n{steps}")
    assert any(place in line and words in line for line in caught.value.lines), caught.value.lines


def test_one_load_and_several_are_written_as_they_were():
    """Paths of ``--set`` go to either, and the resolved spec loads to an equal one."""
    pull = "{surface: x_max, force: [1 N, 0 N, 0 N]}"
    one = specs.loads(f"{BLOCK}steps: [{{name: pull, payload: {pull}}}]")
    several = specs.loads(f"{BLOCK}steps: [{{name: pull, payload: [{pull}, {pull}]}}]")
    for spec in (one, several):
        assert specs.loads(spec.to_yaml()) == spec
    changed = one.with_({"steps.pull.payload.force.0": "2 N"})
    assert changed.steps[0].payload.force[0] == 2.0
    changed = several.with_({"steps.pull.payload.1.force.0": "2 N"})
    assert [load.force[0] for load in changed.steps[0].payload] == [1.0, 2.0]


def test_a_point_and_a_line_on_a_sheet():
    """Of a square sheet a force on its edge is shared by the quadratic edges there."""
    law = LAWS["linear"].of(youngs_modulus=10.0, poissons_ratio=0.3)
    points, lines = {"corner": (0.0, 0.0, 0.0)}, {"rim": ((4.0, 0.0, 0.0), (4.0, 4.0, 0.0))}
    mesh = rectangle((2, 2), (4.0, 4.0))
    model = sheet_model(mesh, Sheet([Ply(law, 0.1)]), points=points, lines=lines)
    assert model.surfaces.area("rim") == pytest.approx(4.0)
    nodes, shares = model.surfaces.shares("rim")
    along = model.nodes.places[nodes, 1]
    assert shares[np.argsort(along)] == pytest.approx([1 / 12, 1 / 3, 1 / 6, 1 / 3, 1 / 12])
    (corner,) = model.surfaces.nodes("corner")
    assert model.nodes.places[corner] == pytest.approx([0.0, 0.0, 0.0])
