"""The gripper of ``configs/``, half of it, on a coarse mesh: it lifts its ball."""

from pathlib import Path

import pytest

from softact import spec as specs
from softact.results.folder import read
from softact.run import start as runs
from tests.contact.grasping import GRAM, GRAVITY

CONFIG = Path(__file__).parents[2] / "configs" / "gripper_lifts_ball.yaml"
COARSE = (
    "geometry.mesh_size=8 mm",
    "solver.initial_increment=0.5",
    "solver.max_increment=0.5",
    "steps.lift.supports=[{surface: clamp, fix: [y, z], move: {x: -5 mm}}]",
)


def test_it_lifts_the_ball(tmp_path):
    """By as much as the clamps go up, but for how far the fingers give; both bear its weight, and
    before it is lifted the table bears what the fingers, which slide down on it, press it with."""
    outcome = runs.run(specs.load(CONFIG, COARSE), tmp_path / "run", 1, report=False)
    assert outcome.status == "complete", outcome.message
    curve, weight = read(tmp_path / "run").curve, 3 * GRAM * GRAVITY
    assert curve["contact_force_ball_x_N"][-1] == pytest.approx(weight, rel=1e-3)
    assert -5.0 < curve["obstacle_ball_x_mm"][-1] < -4.5
    assert curve["rest_force_ball_N"][-1] == 0.0
    let_go = max(n for n, step in enumerate(curve["step"]) if step == "let_go")
    pressed = weight - curve["contact_force_ball_x_N"][let_go]
    assert curve["rest_force_ball_N"][let_go] == pytest.approx(pressed, rel=1e-3)
    assert curve["hold_force_ball_N"][let_go] == 0.0
