"""Obstacles that are turned, and pressed on by what they turn."""

import numpy as np
import pytest

from softact.contact.obstacles.block import Block
from softact.contact.obstacles.plane import Plane
from softact.contact.pose import Pose, between, pose_of, rotation_vector
from softact.contact.rigid import Obstacle
from softact.loads.load_step import LoadStep
from softact.measures import MEASURES
from softact.measures.snapshot import Snapshot
from softact.model import Support
from softact.system.rotation import rotation_about
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve
from tests.contact.test_rigid_contact import SOFT

FLOOR = Support("z_min", dict.fromkeys(range(3), 0.0))


def test_pose_by_hand():
    """A quarter of a turn about z through (1, 0, 0), then 5 mm up: (2, 0, 0) comes to (1, 1, 5)."""
    pose = pose_of(np.array([0.0, 0.0, 5.0]), np.array([0.0, 0.0, 90.0, 1.0, 0.0, 0.0]))
    np.testing.assert_allclose(pose.placed(np.array([[2.0, 0, 0]])), [[1, 1, 5]], atol=1e-12)
    points = np.random.default_rng(1).standard_normal((5, 3))
    np.testing.assert_allclose(pose.seen(pose.placed(points)), points, atol=1e-12)
    np.testing.assert_allclose(pose.outward(np.array([1.0, 0, 0])), [0, 1, 0], atol=1e-12)
    moved = Pose(np.array([1.0, 2, 3]))
    np.testing.assert_allclose(moved.seen(moved.placed(points)), points)


@pytest.mark.parametrize("angle", [0.0, 1e-7, 40.0, 179.9, 180.0])
def test_rotation_vector(angle):
    """Axis times angle, up to half a turn."""
    axis = np.array([1.0, -2.0, 2.0]) / 3
    found = rotation_vector(rotation_about(axis, angle))
    assert np.linalg.norm(found) == pytest.approx(angle, abs=1e-6)
    if angle:
        np.testing.assert_allclose(np.cross(found, axis), 0, atol=1e-5)


def test_between_two_states():
    """Half-way on the shortest way: from 170° to −170° it is half a turn."""
    states = [np.array([0.0, 0.0, 170.0]), np.array([0.0, 0.0, -170.0])]
    np.testing.assert_allclose(between(states, 0.5), rotation_about(np.eye(3)[2], 180.0), atol=1e-9)


def test_turned_as_placed():
    """A stamp that is turned about an edge, then pressed down, presses as one that was placed so:
    another way to the same body."""
    turned = Block((2.0, 2.0, 3.0), (3.0, 6.0, 2.0))
    rotation = rotation_about(np.eye(3)[1], 12.0)
    corner = np.array([3.5, 2.0, 2.0])
    centre = corner + rotation @ (np.array(turned.center) - corner)
    axes = [tuple(float(c) for c in row) for row in rotation.T]
    placed = Block(tuple(float(c) for c in centre), turned.size, tuple(axes))
    down = {"stamp": (0.0, 0.0, -0.2)}
    turn = {"stamp": np.array([0.0, 12.0, 0.0, *corner])}
    forces = []
    for shape, loads in ((turned, {"shift": down, "turn": turn}), (placed, {"shift": down})):
        stamp = Obstacle("stamp", shape, surfaces=("z_max",), turns="turn" in loads)
        model = build(block((4, 4, 2), (4.0, 4.0, 2.0)), SOFT, obstacles=[stamp])
        solution = solve(model, LoadStep("press", **loads), [FLOOR], 0.25)
        (term,) = model.contacts
        forces.append(model.contacts.force(term, solution.state))
        found = MEASURES["contact"].evaluate(Snapshot(model, solution.state))
        if loads.get("turn"):
            assert found["obstacle_stamp_turn_y_deg"] == pytest.approx(12.0)
            moved = centre - turned.center + [0, 0, -0.2]
            assert found["obstacle_stamp_x_mm"] == pytest.approx(moved[0])
            assert found["obstacle_stamp_z_mm"] == pytest.approx(moved[2])
        else:
            assert "obstacle_stamp_turn_y_deg" not in found
    assert forces[0][2] < -0.05
    np.testing.assert_allclose(forces[0], forces[1], atol=1e-6)


def test_torque_of_friction():
    """A plate that turns on a block drags it around: each point with μ p, across its arm."""
    plate = Obstacle("plate", Plane((0.0, 0.0, 1.0), (0.0, 0.0, -1.0)), 0.2, surfaces=("z_max",))
    model = build(block((6, 6, 1), (6.0, 6.0, 1.0)), SOFT, obstacles=[plate])
    steps = [
        LoadStep("press", shift={"plate": (0.0, 0.0, -0.02)}),
        LoadStep("turn", turn={"plate": np.array([0.0, 0.0, 60.0, 3.0, 3.0, 1.0])}),
    ]
    rollers = Support("z_min", dict.fromkeys(range(3), 0.0))
    solution = solve(model, steps, [rollers], 0.1)
    (term,) = model.contacts
    tractions = term.tractions(solution.state) * term.facets.areas[..., None]
    arms = term.facets.places(solution.state.x) - [3.0, 3.0, 1.0]
    torque = np.cross(arms, tractions).sum(axis=(0, 1))[2]
    presses = -tractions[..., 2]
    distance = np.linalg.norm(arms[..., :2], axis=-1)
    assert torque == pytest.approx(0.2 * np.sum(presses * distance), rel=0.01)
    assert presses.sum() > 0.1
