"""Surfaces that are turned, loaded by a torque or held by springs, against exact solutions."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.optimize
from mpi4py import MPI

from softact.errors import SpecError
from softact.loads.load_step import LoadStep
from softact.loads.support import Spring, Support, Turn, Turned
from softact.materials import LAWS
from softact.measures import MEASURES
from softact.measures.points import locate
from softact.measures.snapshot import Snapshot
from softact.mesh.layout import Layout
from softact.mesh.tetrahedra import distribute
from softact.model import Model
from softact.system.rotation import rotation_about
from tests.analytic.differences import force, slope, tangent
from tests.analytic.meshes import block, disc
from tests.analytic.solving import ROLLERS, build, solve

RADIUS, LENGTH, C10 = 12.7, 25.4, 0.14  # mm, MPa
AXIS = (0.0, 0.0, 1.0)
SIDES = 32
CLAMP = Support("z_min", dict.fromkeys(range(3), 0.0))


def moment(angle: float) -> float:
    """N·mm that hold a bar of neo-Hookean rubber at an angle (rad) and at its length (Rivlin 1949),
    times the polar moment of the polygon that its rim is by that of the circle."""
    step = 2 * np.pi / SIDES
    polygon = np.sin(step) / step * (2 + np.cos(step)) / 3
    return np.pi * C10 * angle / LENGTH * RADIUS**4 * polygon


@pytest.fixture
def bar():
    tets = block((8, 8, 3), (1.0, 1.0, LENGTH), lambda points: disc(points, RADIUS))
    ends = {"clamp": "z_min", "tip": "z_max", "axis": AXIS}
    return build(tets, LAWS["neo_hookean"].of(c10=C10, bulk_modulus=1e3), **ends)


def test_torsion_by_a_support_that_turns(bar):
    """At 1 rad in one step, then on to 2 rad: the angle counts from the undeformed state."""
    steps = [
        LoadStep(f"to {angle}", [CLAMP, Support("z_max", turn=Turn(AXIS, np.degrees(angle)))])
        for angle in (1.0, 2.0)
    ]
    solution = solve(bar, steps, [CLAMP], 0.5)
    for angle, state in zip((1.0, 2.0), solution.ends, strict=True):
        forces, _ = bar.force(state)
        nodes = bar.surfaces.nodes("z_max")
        dofs = bar.displacement_dofs[nodes]
        places = bar.nodes.places[nodes] + state.x[dofs]
        found = np.cross(places, forces[dofs]).sum(axis=0)[2]
        assert found == pytest.approx(moment(angle), rel=0.01)
    # The face would turn back, as it is turned on against the bar.
    row = MEASURES["held_tip"].evaluate(Snapshot(bar, solution.ends[0]))
    assert row["blocked_axial_torque_Nmm"] == pytest.approx(-moment(1.0), rel=0.01)
    # On the way of the second step the face is a plate too, at an angle between.
    fraction = [a.fraction for a in solution.stepper.progress.attempts if a.converged][-2]
    assert 0 < fraction < 1
    turned = bar.nodes.places[nodes] @ rotation_about(AXIS, np.degrees(1 + fraction)).T
    way = bar.nodes.places[nodes] + solution.path[-2].x[dofs]
    np.testing.assert_allclose(way, turned, atol=1e-9)


def test_a_whole_turn_is_one():
    """A block that nothing but its turning face holds goes round once, as a rigid body; and once
    more, half a turn, in the step after."""
    model = build(block((1, 1, 2), (1.0, 1.0, 2.0)), LAWS["neo_hookean"].of(c10=C10))
    steps = [
        LoadStep(f"to {angle}", [Support("z_min", turn=Turn((1.0, 2.0, 0.0), angle))])
        for angle in (360.0, 540.0)
    ]
    solution = solve(model, steps, [], 0.05)
    attempts = [a for a in solution.stepper.progress.attempts if a.converged]
    assert len(attempts) > 15
    centre = np.array([0.5, 0.5, 0.0])
    for state, attempt in zip(solution.path, attempts, strict=True):
        angle = (
            360 * attempt.fraction if attempt.step == "to 360.0" else 360 + 180 * attempt.fraction
        )
        turned = (model.nodes.places - centre) @ rotation_about((1.0, 2.0, 0.0), angle).T + centre
        found = model.nodes.places + state.x[model.displacement_dofs]
        np.testing.assert_allclose(found, turned, atol=1e-6)


def test_what_was_turned_stays_so(bar):
    """A step without supports of its own leaves the face where it is."""
    turn = [CLAMP, Support("z_max", turn=Turn(AXIS, 40.0))]
    steps = [LoadStep("turn", turn), LoadStep("hold", gravity=(0.0, 0.0, 1.0))]
    solution = solve(bar, steps, [CLAMP], 0.5)
    dofs = bar.displacement_dofs[bar.surfaces.nodes("z_max")]
    for state in solution.path[-2:]:
        np.testing.assert_allclose(state.x[dofs], solution.ends[0].x[dofs], atol=1e-12)


def test_a_face_that_is_no_plate_yet_becomes_one_as_it_turns():
    places = np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [-1.0, -1.0, 0.0]])
    before = np.array([[0.1, 0.0, 0.3], [0.0, -0.1, 0.0], [0.0, 0.0, 0.0]])
    turned = Turned("face", np.empty(0), places, np.zeros(3), np.array(AXIS), 0.0, 500.0)
    np.testing.assert_allclose(turned.displacements(before, 0.0), before, atol=1e-14)
    end = places @ rotation_about(AXIS, 500.0).T - places
    np.testing.assert_allclose(turned.displacements(before, 1.0), end, atol=1e-14)
    half = (places + before / 2) @ rotation_about(AXIS, 250.0).T - places
    np.testing.assert_allclose(turned.displacements(before, 0.5), half, atol=1e-14)


def test_torque(bar):
    """The torque that holds the bar at 1.5 rad turns its end by 1.5 rad: forces that are tangential
    and grow with the arm are those of the exact solution."""
    step = LoadStep("twist", torque={"z_max": (0.0, 0.0, moment(1.5))})
    solution = solve(bar, step, [CLAMP, Support("z_max", {2: 0.0})], 0.5)
    term = bar.load_terms["torque", "z_max"]
    assert term.angle(solution.state) == pytest.approx(1.5, rel=0.005)


@pytest.mark.parametrize("size", [0.05, 3.0])
def test_tangent_of_a_torque(bar, size):
    """Force by energy and tangent by force, near the undeformed state and past a half turn."""
    bar.make_room({"torque": {"z_max": 0.0}})
    draw = np.random.default_rng(3)
    state = bar.initial_state()
    state.put("torque", {"z_max": np.array([20.0, -30.0, 70.0])})
    state.x = size * draw.standard_normal(bar.unknowns.local)
    change = draw.standard_normal(bar.unknowns.local)
    term = bar.load_terms["torque", "z_max"]
    numeric = slope(lambda s: bar.energy(s, [term]), state, change)
    assert force(bar, term, state) @ change == pytest.approx(numeric, rel=1e-6)
    numeric = slope(lambda s: force(bar, term, s), state, change)
    found = tangent(bar, [term], state) @ change
    np.testing.assert_allclose(found, numeric, atol=1e-6 * np.abs(numeric).max())


def sprung(symmetry):
    """A block of 2 × 1 × 1 mm whose end is held by springs of 0.05 N/mm along x."""
    tets = block((2, 1, 1), (2.0, 1.0, 1.0))
    names = {"regions": ("body",), "surfaces": tuple(tets.surfaces), "cavities": {}}
    layout = Layout(**names, symmetry=symmetry, clamp="x_min", tip="x_max")
    mesh = distribute(MPI.COMM_SELF, lambda: tets, layout)
    law = LAWS["neo_hookean"].of(c10=C10, bulk_modulus=1e4).material()
    return Model(mesh, {"body": law}, more={"springs": [Spring("x_max", (0.05, 0.0, 0.0))]})


@pytest.mark.parametrize("symmetry", [{}, {"y_min": 1}])
def test_spring(symmetry):
    """Traction t = 2 c10 (λ − λ⁻²) + k L (λ − 1)/A, of the whole actuator also of its half."""
    model, traction = sprung(symmetry), 0.3
    area = 2.0 if symmetry else 1.0
    exact = scipy.optimize.brentq(
        lambda s: 2 * C10 * (s - s**-2) + 0.05 * 2.0 * (s - 1) / area - traction, 1.0, 3.0
    )
    step = LoadStep("pull", traction={"x_max": (traction, 0.0, 0.0)})
    solution = solve(model, step, ROLLERS, 0.5)
    moved = solution.displacement((2.0, 1.0, 1.0))[0]
    assert moved / 2 + 1 == pytest.approx(exact, rel=1e-4)
    snapshot = Snapshot(model, solution.state)
    found = MEASURES["reaction"].evaluate(snapshot)["spring_x_max_x_N"]
    assert found == pytest.approx(-0.05 * moved, rel=1e-9)
    # The springs' energy is none of the rubber's: c10 (λ² + 2/λ − 3) V.
    stored = MEASURES["energy"].evaluate(snapshot)["strain_energy_mJ"]
    assert stored == pytest.approx(C10 * (exact**2 + 2 / exact - 3) * 2 * area, rel=1e-3)


def test_lateral_contraction_and_a_point():
    """In uniaxial tension 1 − λ^(−1/2), and each point goes to F X, also in the mirror image."""
    model = sprung({"y_min": 1})
    step = LoadStep("pull", traction={"x_max": (0.3, 0.0, 0.0)})
    solution = solve(model, step, ROLLERS, 0.5)
    stretch = 1 + solution.displacement((2.0, 1.0, 1.0))[0] / 2
    points = {"here": (0.3, 0.4, 0.9), "there": (1.7, -0.2, 0.1)}
    snapshot = replace(Snapshot(model, solution.state), probes=locate(model, points))
    found = MEASURES["lateral_contraction"].evaluate(snapshot)
    assert set(found) == {"lateral_contraction_y_percent", "lateral_contraction_z_percent"}
    for value in found.values():
        assert value == pytest.approx(100 * (1 - stretch**-0.5), rel=1e-3)
    (radius,) = MEASURES["radial_growth"].evaluate(snapshot).values()
    assert radius == pytest.approx(100 * (stretch**-0.5 - 1), rel=1e-3)
    columns = MEASURES["probes"].evaluate(snapshot)
    gradient = np.array([stretch, stretch**-0.5, stretch**-0.5])
    for name, point in points.items():
        place = [columns[f"probe_{name}_{c}_mm"] for c in "xyz"]
        np.testing.assert_allclose(place, gradient * point, atol=2e-4)


def test_a_point_outside_of_the_body():
    with pytest.raises(SpecError, match=r"probes.far: the point is 1 mm outside .*\(2, 1, 1\) mm"):
        locate(sprung({}), {"far": (3.0, 1.0, 1.0)})
