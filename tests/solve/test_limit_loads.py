"""A limit under dead load is named with its force; a snap that is passed is told at once."""

import re

import numpy as np
import pytest

from softact.loads.load_step import LoadStep
from softact.loads.support import Support
from softact.solve.settings import Settings
from softact.solve.stepping import Stepper
from tests.analytic.meshes import block
from tests.analytic.solving import solve
from tests.loads.test_points_and_lines import built

SPAN, RISE, THICK = 40.0, 3.0, 1.5


def arch():
    """A shallow arch of rubber, clamped at both ends; a line over its middle."""

    def mapping(points):
        lift = RISE * np.sin(np.pi * points[:, 0] / SPAN)
        return points + lift[:, None] * np.array([0.0, 0.0, 1.0])

    tets = block((16, 1, 1), (SPAN, 2.0, THICK), mapping)
    top = THICK + RISE
    return built(tets, lines={"crown": ((SPAN / 2, 0.0, top), (SPAN / 2, 2.0, top))})


CLAMPS = [Support(end, dict.fromkeys(range(3), 0.0)) for end in ("x_min", "x_max")]


@pytest.fixture(scope="module")
def limit():
    """The largest force on the crown, N, when it is pushed down."""
    model = arch()
    push = LoadStep("push", [*CLAMPS, Support("crown", {2: -2.5})])
    at_rest = [*CLAMPS, Support("crown", {2: 0.0})]
    solution = solve(model, push, at_rest, 0.04)
    forces = np.array([-solution.reaction("crown", state)[2] for state in solution.path])
    top = int(forces.argmax())
    assert 0 < top < len(forces) - 1
    s = np.arange(-1, 2)
    a, b, c = np.polyfit(s, forces[top - 1 : top + 2], 2)
    return c - b * b / (4 * a)


@pytest.mark.parametrize("dynamics", [False, True])
def test_a_limit_under_dead_load_is_named_with_its_force(limit, dynamics):
    """Within 0.5 % of that under displacement control, where the run ends and where the arch moves
    to the other side, which is told while the run goes on."""
    model, said = arch(), []
    force = 1.3 * limit
    area = model.surfaces.area("crown")
    step = LoadStep("load", payload={"crown": np.array([0.0, 0.0, -force / area])})
    settings = Settings(dynamics=dynamics)
    stepper = Stepper(model, settings, lambda *state: None, on_remark=said.append)
    progress = stepper.run([step], CLAMPS)
    assert bool(progress.stopped) != dynamics
    text = said[0] if dynamics else progress.stopped
    assert progress.remarks == said
    found = re.search(r"limit point at payload of ([\d.e-]+) N on 'crown' \(([\d.]+)%\)", text)
    assert found, text
    assert float(found[1]) == pytest.approx(limit, rel=5e-3)
    assert float(found[2]) == pytest.approx(100 / 1.3, rel=5e-3)
    if dynamics:
        assert "the actuator moved to that at" in text
