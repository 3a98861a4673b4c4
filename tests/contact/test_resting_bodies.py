"""Free bodies on obstacles that stay in place: balls and blocks on a table, and in motion."""

from dataclasses import replace

import numpy as np
import pytest

from softact.contact.obstacles.block import Block
from softact.contact.obstacles.cylinder import Cylinder
from softact.contact.obstacles.plane import Plane
from softact.contact.obstacles.sphere import Sphere
from softact.contact.rests import Rest
from softact.contact.rigid import Obstacle
from softact.errors import SpecError
from softact.loads.dynamics import Dynamics
from softact.loads.load_step import LoadStep
from softact.loads.timing import Sudden, Timing
from softact.measures import MEASURES
from softact.measures.snapshot import Snapshot
from tests.analytic.meshes import block
from tests.analytic.solving import CLAMP, build, solve
from tests.contact.grasping import GRAM, GRAVITY, backs, between_pads, grasp
from tests.contact.test_free_bodies import FACES, MASS, MIDDLE, WEIGHT
from tests.contact.test_rigid_contact import SOFT, TURNED

OTHERS = {
    "plane": Plane((0, 0, -0.7), (0.1, 0.2, 1.0)),
    "ball": Sphere((0.3, 0.1, -1.6), 1.0),
    "block": Block((0.0, 0.0, -1.1), (3.0, 3.0, 1.0), TURNED),
    "bar": Cylinder((0.0, 0.0, -1.1), (0.0, 1.0, 0.1), 0.5),
}
BODIES = {
    "ball": Sphere((0.0, 0.0, 0.0), 0.7),
    "bar": Cylinder((0.0, 0.0, 0.1), (0.1, 1.0, 0.0), 0.7, 1.0),
    "block": Block((0.0, 0.0, 0.1), (1.2, 1.2, 1.5)),
}
DOWN = (0.0, 0.0, -GRAVITY)


def far_block(points):
    """The soft body, where nothing touches it."""
    return np.add(points, [100.0, 0.0, 0.0])


def on_table(shape, other, friction=0.4, mass=MASS, **more):
    """A model of a body on an obstacle, beside a clamped block that nothing touches."""
    obstacles = [
        Obstacle("thing", shape, friction, mass=mass, **more),
        Obstacle("table", other, friction),
    ]
    return build(block((1, 1, 1), mapping=far_block), SOFT, obstacles=obstacles)


def touching(rest: Rest, state):
    """Move the body along the obstacle's normal until it is pressed in a little."""
    body, rng = rest._body, np.random.default_rng(5)
    state.x[body.dofs] = 0.02 * rng.standard_normal(6)
    for _ in range(8):
        motion = body.motion(state)
        places = rest._places(motion)
        g, n, _ = rest.other.shape.distance(places)
        deepest = np.argmin(g)
        depth = g[deepest] - rest._radius + 0.7e-4 * body.arm
        state.x[body.dofs[:3]] -= depth * n[deepest]


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("other", OTHERS)
@pytest.mark.parametrize("shape", BODIES)
def test_tangent(shape, other, friction):
    """Force against energy, tangent against force, by central differences."""
    model = on_table(BODIES[shape], OTHERS[other], friction)
    (rest,) = model.free_bodies["thing"].rests
    state, rng = model.initial_state(), np.random.default_rng(2)
    touching(rest, state)
    model.remember(state)
    dofs = model.free_bodies["thing"].dofs
    state.x[dofs] += 1e-5 * rng.standard_normal(6)
    direction, step = rng.standard_normal(6), 1e-8

    def along(part):
        there = replace(state, x=state.x.copy())
        there.x[dofs] += part * step * direction
        return there

    matrix = rest.tangent(state)
    assert np.abs(matrix).max() > 1e-3
    found = (rest.force(along(1)) - rest.force(along(-1))) / (2 * step)
    np.testing.assert_allclose(matrix @ direction, found, atol=2e-4 * np.abs(found).max())
    if friction:
        assert rest.rubs(state)[1] > 0.0
    else:
        work = (rest.energy(along(1)) - rest.energy(along(-1))) / (2 * step)
        assert rest.force(state) @ direction == pytest.approx(work, rel=1e-3)


@pytest.mark.parametrize("slope", [0.25, 0.35])
def test_a_block_on_a_slope(slope):
    """It stays where tan θ is below the friction of 0.3, and slides above: Coulomb's law."""
    model = on_table(Block((0, 0, 0.5), (2, 2, 1)), Plane((0, 0, 0), (0, 0, 1)), 0.3)
    steps = [
        LoadStep("settle", gravity=DOWN),
        LoadStep("tilt", gravity=(slope * GRAVITY, 0.0, -GRAVITY)),
    ]
    solution = solve(model, steps, [CLAMP], 0.5, stops=slope > 0.3)
    body = model.free_bodies["thing"]
    if slope < 0.3:
        assert np.abs(solution.state.x[body.dofs]).max() < 1e-2
        force = body.rests[0].force(solution.state)[:3]
        np.testing.assert_allclose(force, [WEIGHT * slope, 0, -WEIGHT], rtol=1e-6, atol=1e-9)
        found = MEASURES["contact"].evaluate(Snapshot(model, solution.state))
        size = WEIGHT * np.hypot(1, slope)
        assert found["rest_force_thing_N"] == pytest.approx(size, rel=1e-6)
    else:
        stopped = solution.stepper.progress.stopped
        assert "step 'tilt'" in stopped and "obstacles.thing: it slips" in stopped
        ratio = -solution.state["gravity"][""][0] / solution.state["gravity"][""][2]
        assert ratio == pytest.approx(0.3, rel=0.02)


def test_it_is_lifted_off_the_table():
    """Between two pads on a table: the table carries all of it, and none once it is lifted."""
    obstacles = [
        Obstacle("ball", Sphere(MIDDLE, 5.0), 0.5, surfaces=FACES, mass=MASS, held=True),
        Obstacle("table", Plane((0.0, 0.0, -1.0), (0.0, 0.0, 1.0)), 0.3, surfaces=FACES),
    ]
    model = between_pads(SOFT, obstacles)
    lift = LoadStep("lift", supports=backs(0.5, (0.0, 0.0, 2.0)))
    solution = grasp(model, lift)
    (rest,) = model.free_bodies["ball"].rests
    on, off = (np.abs(rest.force(state)[2]) for state in solution.ends[1:])
    assert on == pytest.approx(WEIGHT, rel=0.05) and off == 0.0
    contact = model.contacts.force(next(iter(model.contacts)), solution.state)
    np.testing.assert_allclose(contact, [0, 0, -WEIGHT], atol=1e-4 * WEIGHT)


def test_the_table_is_taken_away():
    """What it bore goes over to the pads as it fades; turned back on, it would bear nothing."""
    obstacles = [
        Obstacle("ball", Sphere(MIDDLE, 5.0), 0.5, surfaces=FACES, mass=MASS, held=True),
        Obstacle("table", Plane((0.0, 0.0, -1.0), (0.0, 0.0, 1.0)), 0.3, surfaces=FACES),
    ]
    model = between_pads(SOFT, obstacles)
    solution = grasp(model, LoadStep("take", presence={"table": 0.0}), increment=0.25)
    (rest,) = model.free_bodies["ball"].rests
    bore = rest.force(solution.ends[1])
    going = [state for state in solution.path if 0.0 < state["presence"]["table"] < 1.0]
    assert going and abs(bore[2]) > 0.9 * WEIGHT
    for state in going:
        np.testing.assert_allclose(rest.force(state), state["presence"]["table"] * bore)
    contact = model.contacts.force(next(iter(model.contacts)), solution.state)
    np.testing.assert_allclose(contact, [0, 0, -WEIGHT], atol=1e-4 * WEIGHT)


def test_it_overlaps_the_table():
    """One line, before anything is solved."""
    model = on_table(Sphere((0, 0, 0.5), 1.0), Plane((0, 0, 0), (0, 0, 1)))
    with pytest.raises(SpecError, match=r"obstacles.thing: overlaps obstacles.table by 0.5 mm"):
        solve(model, LoadStep("settle", gravity=DOWN), [CLAMP])


def moved_in_time(model, gravity, held=()):
    """Displacement and turn (6,) of the body after 0.1 s of sudden gravity, from rest."""
    timing = Timing(0.1, Sudden(), Dynamics())
    steps = [*held, LoadStep("go", gravity=gravity, timing=timing)]
    solution = solve(model, steps, [CLAMP], 0.1)
    return solution.state.x[model.free_bodies["thing"].dofs], model.free_bodies["thing"].arm


def test_free_fall():
    """It falls by g t²/2."""
    model = on_table(Sphere((0, 0, 1.0), 1.0), Plane((0, 0, -100), (0, 0, 1)))
    moved, _ = moved_in_time(model, DOWN)
    np.testing.assert_allclose(moved, [0, 0, -GRAVITY * 0.1**2 / 2, 0, 0, 0], rtol=1e-3, atol=1e-6)


def test_a_ball_rolls_down():
    """A ball that rolls down a slope without slipping is two sevenths slower than one that slides:
    5/7 g sin θ, as its inertia is 2/5 m r² (any textbook)."""
    model = on_table(Sphere((0, 0, 2.0), 2.0), Plane((0, 0, 0), (0, 0, 1)), mass=20 * GRAM)
    gravity = (0.2 * GRAVITY, 0.0, -GRAVITY)
    settle = LoadStep("settle", gravity=DOWN)
    moved, arm = moved_in_time(model, gravity, [settle])
    way = 5 / 7 * 0.2 * GRAVITY * 0.1**2 / 2
    assert moved[0] == pytest.approx(way, rel=0.01)
    assert moved[4] / arm == pytest.approx(way / 2.0, rel=0.01)
