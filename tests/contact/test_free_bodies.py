"""Free rigid bodies: grasped, let go of, lifted, dropped, rolled; tangents with their unknowns."""

import numpy as np
import pytest

from softact.contact.dropped import rubbing
from softact.contact.obstacles.block import Block
from softact.contact.obstacles.cylinder import Cylinder
from softact.contact.obstacles.sphere import Sphere
from softact.contact.rigid import Obstacle
from softact.loads.load_step import LoadStep
from softact.measures import MEASURES
from softact.measures.snapshot import Snapshot
from tests.analytic.differences import assert_contact_tangent
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve
from tests.contact.grasping import GRAM, GRAVITY, backs, between_pads, grasp
from tests.contact.test_rigid_contact import SHAPES, SOFT

FACES = ("left_face", "right_face")
MIDDLE = (9.0, 4.0, 4.0)
BALL = Sphere(MIDDLE, 5.0)
MASS = 20 * GRAM
WEIGHT = MASS * GRAVITY
THINGS = {
    "block": Block(MIDDLE, (10.0, 5.0, 5.0)),
    "bar": Cylinder(MIDDLE, (0.0, 1.0, 0.0), 5.0, 6.0),
}


class Both:
    """Contact with a free body, and what acts on this beside."""

    def __init__(self, model):
        self._terms = [*model.contacts, *model.free_bodies.values()]

    def add_force(self, state, out):
        for term in self._terms:
            term.add_force(state, out)

    def add_tangent(self, state, origin):
        for term in self._terms:
            term.add_tangent(state, origin)

    def energy(self, state):
        return sum(term.energy(state) for term in self._terms)


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("shape", ["sphere", "cylinder", "block"])
def test_tangent(shape, friction):
    """Force against energy, tangent against force, with the body's unknowns, turned by a radian
    and more; and the force on the body is that on the rubber."""
    obstacle = Obstacle("thing", SHAPES[shape], friction, mass=1e-5)
    model = build(block((2, 2, 2)), SOFT, obstacles=[obstacle])
    rng = np.random.default_rng(5)
    state, body = model.initial_state(), model.free_bodies["thing"]
    for turn in ((0.0, 1.0, -0.5), (0.8, 0.0, 0.9)):
        state.x[body.dofs[3:]] += body.arm * np.array(turn)
        model.remember(state)
    state.x += 0.02 * rng.standard_normal(model.unknowns.local)
    model.remember(state)
    state.x = state.x + 0.003 * rng.standard_normal(model.unknowns.local)
    assert_contact_tangent(model, Both(model), state, friction, least=0.01, off=1e-4, step=1e-6)
    (term,) = model.contacts
    out = np.zeros(model.unknowns.local)
    term.add_force(state, out)
    np.testing.assert_allclose(out[body.dofs[:3]], term.force(state), atol=1e-12)
    # Moments about the origin are in balance, too: turned as one, nothing resists.
    places = model.nodes.places + state.x[model.displacement_dofs]
    moment = np.cross(places, out[model.displacement_dofs]).sum(axis=0)
    moved = np.array(obstacle.shape.center) + body.motion(state).shift
    moment += np.cross(moved, out[body.dofs[:3]])
    # Unknowns of a turn: R' R^T at each, whose axial vector the moment works on.
    motion = body.motion(state)
    axes = np.array([_axial(first @ motion.turn.T) for first in motion.first])
    np.testing.assert_allclose(axes @ -moment, out[body.dofs[3:]], atol=1e-12)


def _axial(cross):
    return np.array([cross[2, 1], cross[0, 2], cross[1, 0]])


@pytest.fixture(scope="module")
def lifted():
    """A ball of 20 g between two pads, with friction 0.5, lifted by 6 mm."""
    ball = Obstacle("ball", BALL, 0.5, surfaces=FACES, mass=MASS, held=True)
    lift = LoadStep("lift", supports=backs(0.5, (0.0, 0.0, 6.0)))
    return grasp(between_pads(SOFT, [ball]), lift)


def test_what_is_grasped_hangs_by_friction(lifted):
    """Let go of, half of its weight hangs at each pad, and the pads press alike (statics)."""
    model, state = lifted.model, lifted.ends[1]
    (term,) = model.contacts
    force = model.contacts.force(term, state)
    np.testing.assert_allclose(force, [0, 0, -WEIGHT], atol=1e-5 * WEIGHT)
    push = np.einsum("kq,kqc->kc", term.facets.areas, term.tractions(state))
    left = term.facets.points[:, 0, 0] < 5
    np.testing.assert_allclose(push[left].sum(axis=0)[2], -WEIGHT / 2, rtol=0.01)
    assert push[left].sum(axis=0)[0] == pytest.approx(-push[~left].sum(axis=0)[0], rel=1e-6)
    # Less friction than there may be: the ball does not slip.
    presses, _, most = rubbing(model, "ball", state)
    assert WEIGHT < most == pytest.approx(0.5 * presses)


def test_it_is_held_before(lifted):
    """Held in place it does not move, and hangs at what holds it but for what the pads do."""
    model, state = lifted.model, lifted.ends[0]
    body, (term,) = model.free_bodies["ball"], model.contacts
    assert np.abs(state.x[body.dofs]).max() < 1e-4
    holds = body.hold_force(state)[:3] + model.contacts.force(term, state)
    np.testing.assert_allclose(holds, [0, 0, -WEIGHT], atol=1e-5 * WEIGHT)
    assert body.hold_force(state)[2] == pytest.approx(-WEIGHT, rel=0.05)


def test_it_is_lifted(lifted):
    """It moves with the pads by 6 mm, from where it hung; the pads carry its weight."""
    model = lifted.model
    body = model.free_bodies["ball"]
    (term,) = model.contacts
    before, after = (state.x[body.dofs] for state in lifted.ends[1:])
    np.testing.assert_allclose(after - before, [0, 0, 6, 0, 0, 0], atol=1e-3)
    assert -0.2 < before[2] < 0  # it sags as the pads shear
    carried = model.contacts.force(term, lifted.state)
    np.testing.assert_allclose(carried, [0, 0, -WEIGHT], atol=1e-4 * WEIGHT)
    found = MEASURES["contact"].evaluate(Snapshot(model, lifted.state))
    assert found["obstacle_ball_z_mm"] == pytest.approx(after[2])
    assert found["contact_force_ball_z_N"] == pytest.approx(-WEIGHT, rel=1e-4)
    assert 50 < found["friction_used_ball_percent"] < 90
    assert found["hold_force_ball_N"] == 0.0


def test_it_slips():
    """With friction 0.1 no more of its weight is carried than the friction of what presses."""
    ball = Obstacle("ball", BALL, 0.1, surfaces=FACES, mass=MASS, held=True)
    model = between_pads(SOFT, [ball])
    solution = grasp(model, stops=True)
    assert "step 'let_go'" in solution.stepper.progress.stopped
    assert "obstacles.ball: it slips: " in solution.stepper.progress.stopped
    carried = WEIGHT * (1 - solution.state["hold"]["ball"])
    presses = rubbing(model, "ball", solution.state)[0]
    # Each pad's face leans a little where the ball has sunk in and is pulled down.
    assert carried == pytest.approx(0.1 * presses, rel=0.06)


def test_nothing_rubs():
    """Without friction it is squeezed out of the pads, and the line says so."""
    ball = Obstacle("ball", BALL, 0.0, surfaces=FACES, mass=MASS, held=True)
    model = between_pads(SOFT, [ball])
    solution = grasp(model, stops=True, dynamics=False, min_increment=0.02)
    stopped = solution.stepper.progress.stopped
    assert "obstacles.ball: what presses on it with " in stopped and "has no friction" in stopped


def test_it_is_dropped():
    """The pads open until friction carries its weight no more: that is where the step ends."""
    ball = Obstacle("ball", BALL, 0.5, surfaces=FACES, mass=MASS, held=True)
    model = between_pads(SOFT, [ball])
    solution = grasp(model, LoadStep("open", supports=backs(0.0)), stops=True)
    stopped = solution.stepper.progress.stopped
    assert "step 'open'" in stopped and "obstacles.ball: it slips: " in stopped
    assert 0.5 * rubbing(model, "ball", solution.state)[0] == pytest.approx(WEIGHT, rel=0.05)


@pytest.mark.parametrize("name", THINGS)
def test_other_bodies_are_lifted(name):
    """They hang by their friction as a ball does, and go up with the pads."""
    shape = THINGS[name]
    thing = Obstacle("ball", shape, 0.5, surfaces=FACES, mass=MASS, held=True)
    model = between_pads(SOFT, [thing])
    solution = grasp(model, LoadStep("lift", supports=backs(0.5, (0.0, 0.0, 6.0))))
    (term,) = model.contacts
    carried = model.contacts.force(term, solution.state)
    np.testing.assert_allclose(carried, [0, 0, -WEIGHT], atol=1e-4 * WEIGHT)
    before, after = (state.x[model.free_bodies["ball"].dofs] for state in solution.ends[1:])
    np.testing.assert_allclose(after - before, [0, 0, 6, 0, 0, 0], atol=2e-3)


def test_nothing_holds_it():
    """One line, of a ball that touches nothing: it is a fault of the step, not of the program."""
    ball = Obstacle("ball", BALL, 0.5, mass=MASS)
    model = between_pads(SOFT, [ball])
    step = LoadStep("fall", gravity=(0.0, 0.0, -GRAVITY))
    solution = solve(model, step, backs(0.0), 0.5, stops=True)
    assert solution.stepper.progress.stopped.splitlines() == [
        "no equilibrium found beyond 0.00% of step 'fall' (no load): obstacles.ball: nothing holds "
        f"it: it touches nothing, and weighs {solution_weight(solution):.3g} N; hold it in place "
        "(held: true), or let something hold it before"
    ]
    assert solution.stepper.progress.attempts[-1].iterations < 5


def solution_weight(solution):
    """What the ball weighed in the last attempt."""
    return WEIGHT * solution.stepper.progress.attempts[-1].fraction


def test_a_ball_rolls():
    """Between two parallel pads of which one moves by d it rolls: its centre moves by d/2 and it
    turns by d over its diameter (kinematics)."""
    ball = Obstacle("ball", BALL, 0.5, surfaces=FACES, mass=MASS, held=True)
    model = between_pads(SOFT, [ball])
    still, way = (0.0, 0.0, 0.0), (0.0, 0.0, 2.0)
    steps = [
        LoadStep("close", supports=backs(0.3)),
        LoadStep("let_go", hold={"ball": 0.0}),
        LoadStep("roll", supports=backs(0.3, still, way)),
    ]
    solution = solve(model, steps, backs(0.0), 0.1)
    body = model.free_bodies["ball"]
    moved = solution.state.x[body.dofs]
    np.testing.assert_allclose(moved[:3], [0, 0, 1.0], atol=0.01)
    turn = moved[3:] / body.arm
    assert turn[1] == pytest.approx(-2.0 / 10.0, rel=0.01)
    np.testing.assert_allclose(turn[[0, 2]], 0, atol=0.01)
