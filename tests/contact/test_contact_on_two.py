"""Contact between surfaces on two processes, of which each holds a part of both sides."""

import shutil

import numpy as np
import pytest

from softact import spec as specs
from softact.results.folder import read
from softact.run import start as runs
from tests.run.test_resume import interrupt

# Two chambers whose walls press on each other from 5 kPa on, at the latest.
SPEC = """
geometry: {type: pneunet, chambers: 2, chamber_length: 7 mm, mesh_size: 6 mm}
materials: {body: elastosil-m4601}
contact: [{self: outer, friction: %s}]
fields: [contact_pressure]
solver: {initial_increment: 0.0625, max_increment: 0.0625}
steps: [{pressure: 10 kPa}]
"""
FIGURES = (
    "bending_angle_deg", "tip_x_mm", "tip_z_mm", "cavity_volume_mm3",
    "contact_area_contact_1_mm2", "contact_pressure_contact_1_kPa", "contact_gap_contact_1_mm",
    "strain_energy_mJ",
)  # fmt: skip
ROUGH = 0.4


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """Function from friction and processes to a result folder; each is solved once."""
    known = {}

    def solve(friction, processes):
        if (friction, processes) not in known:
            folder = tmp_path_factory.mktemp("run") / "result"
            spec = specs.loads(SPEC % friction)
            outcome = runs.run(spec, folder, processes, report=False)
            assert outcome.status == "complete", outcome.message
            known[friction, processes] = folder
        return known[friction, processes]

    return solve


def curve(folder):
    """Figures (rows, columns) of a run."""
    return np.transpose([read(folder).curve[name] for name in FIGURES])


def assert_alike(one, other):
    scale = np.abs(curve(one)).max(axis=0)
    np.testing.assert_allclose(curve(one) / scale, curve(other) / scale, atol=1e-6)
    pressures = [read(folder).field(-1, "contact_pressure") for folder in (one, other)]
    assert pressures[0].max() > 1e-3
    sums = [np.sort(p[p > 0]) for p in pressures]  # nodes are numbered otherwise
    np.testing.assert_allclose(*sums, rtol=1e-6)


@pytest.mark.parametrize("friction", [0.0, ROUGH])
def test_two_processes_give_the_curve_of_one(solved, friction):
    one, two = (solved(friction, processes) for processes in (1, 2))
    assert_alike(one, two)
    assert read(one).curve["contact_area_contact_1_mm2"][-1] > 1.0
    assert read(two).run["processes"] == 2


def test_friction_counts(solved):
    """By far more than what is left between one process and two."""
    smooth, rough = (curve(solved(friction, 1)) for friction in (0.0, ROUGH))
    assert abs(smooth[-1] / rough[-1] - 1).max() > 1e-4


@pytest.mark.parametrize("then", [1, 2])
def test_an_interrupted_run_goes_on(solved, tmp_path, then):
    """What friction remembers is the same on any number of processes."""
    cut = tmp_path / "cut"
    spec = specs.loads(SPEC % ROUGH)
    interrupt(spec, cut, 7, processes=2)
    shutil.copytree(cut, tmp_path / "copy")
    outcome = runs.run(spec, tmp_path / "copy", then, report=False, resume=True)
    assert outcome.status == "complete", outcome.message
    assert_alike(solved(ROUGH, 2), tmp_path / "copy")
