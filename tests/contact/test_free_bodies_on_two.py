"""A free body on two processes: one owns its unknowns, and both touch it."""

import numpy as np
import pytest

from softact import spec as specs
from softact.results.folder import read
from softact.run import start as runs
from tests.run.test_resume import interrupt
from tests.run.test_resume_loads import CASES

BASE, CHANGE, LATER = CASES["hold"]
# Fine enough that it can be interrupted.
SPEC = f"{BASE}steps: [{{name: first, {CHANGE}}}, {LATER}]\n".replace("size: 2 mm", "size: 1 mm")
FIGURES = [
    "contact_force_cell_x_N", "contact_force_cell_z_N", "obstacle_cell_x_mm", "obstacle_cell_z_mm",
    "obstacle_cell_turn_y_deg", "rest_force_cell_N", "hold_force_cell_N",
]  # fmt: skip


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Figures (rows, columns) on one process."""
    return solved(tmp_path_factory.mktemp("run") / "alone", 1)


def solved(folder, processes, resume=False):
    outcome = runs.run(specs.loads(SPEC), folder, processes, report=False, resume=resume)
    assert outcome.status == "complete", outcome.message
    assert read(folder).run["processes"] == processes
    return np.transpose([read(folder).curve[name] for name in FIGURES])


def test_two_processes_give_the_curve_of_one(alone, tmp_path):
    found = solved(tmp_path / "two", 2)
    assert np.abs(alone[-1, 4]) > 1e-3  # it turns
    np.testing.assert_allclose(found, alone, atol=1e-7 * np.abs(alone).max())


def test_an_interrupted_run_goes_on(alone, tmp_path):
    """Where it is and how it is turned is remembered once, by all."""
    folder = tmp_path / "cut"
    interrupt(specs.loads(SPEC), folder, 2, processes=2)
    found = solved(folder, 2, resume=True)
    np.testing.assert_allclose(found, alone, atol=1e-7 * np.abs(alone).max())
