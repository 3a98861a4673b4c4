"""``softact module``: its files, what they say, and that they agree with the runs beside them."""

import csv

import numpy as np
import pytest
from click.testing import CliRunner

from softact.cli.main import softact
from softact.results.folder import read

SPEC = """
name: small
geometry: {type: pneunet, chambers: 4, chamber_height: 6 mm, base: 3 mm, mesh_size: 4 mm}
materials: {body: elastosil-m4601}
steps: [{name: inflate, pressure: 6 kPa, max_increment: 0.5}]
solver: {initial_increment: 0.5, max_increment: 0.5}
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("module")
    (folder / "small.yaml").write_text(SPEC)
    out = folder / "out"
    called = CliRunner().invoke(softact, ["module", str(folder / "small.yaml"), "-o", str(out)])
    assert called.exit_code == 0, called.output
    return out, called.output


def test_the_table_is_that_of_the_runs(written):
    out, said = written
    rows = list(csv.DictReader((out / "module.csv").open()))
    last = {name: float(value) for name, value in rows[-1].items() if name != "step"}
    free, straight, clamped = (read(out / name).curve for name in ("free", "straight", "clamped"))
    assert len(rows) == len(free["step"])
    assert last["pressure_kPa"] == pytest.approx(6.0)
    assert last["module_angle_y_deg"] == free["module_angle_y_deg"][-1]
    assert last["actuator_angle_y_deg"] == pytest.approx(4 * last["module_angle_y_deg"])
    assert last["blocked_moment_y_Nmm"] == pytest.approx(-straight["module_moment_y_Nmm"][-1])
    assert last["blocked_force_x_N"] == pytest.approx(-clamped["module_force_x_N"][-1])
    assert "Actuator angle y" in said


def test_blocked_modules_are_blocked(written):
    """The straight one turns not and has no force; the clamped one has its undeformed length."""
    out, _ = written
    straight, clamped = (read(out / name).curve for name in ("straight", "clamped"))
    for curve in (straight, clamped):
        assert not np.any(curve["unstable_modes"])  # also counts the pivots of what follows
    moment = abs(straight["module_moment_y_Nmm"][-1])
    assert moment > 0.1
    assert np.abs(straight["module_angle_y_deg"]).max() < 1e-9
    assert np.abs(straight["module_force_x_N"]).max() < 1e-9
    assert straight["module_stretch_x"][-1] > 1.001
    assert np.abs(clamped["module_stretch_x"] - 1).max() < 1e-12
    assert abs(clamped["module_force_x_N"][-1]) > 0.01


def test_small_steps_follow_the_stiffness(written):
    """The angle at 3 kPa by the blocked moment and the stiffness, without force: within 5 %."""
    out, _ = written
    free, straight = (read(out / name).curve for name in ("free", "straight"))
    names = ("curvature_y", "stretch_x", "stretch_z")
    stiffness = np.zeros((3, 3))
    for i, one in enumerate(names):
        for j, other in enumerate(names[i:], start=i):
            unit = ("N", "Nmm", "Nmm2")[(i == 0) + (j == 0)]
            value = straight[f"module_stiffness_{one}_{other}_{unit}"][1]
            stiffness[i, j] = stiffness[j, i] = value
    bending = 1 / np.linalg.inv(stiffness)[0, 0]
    curvature = -straight["module_moment_y_Nmm"][1] / bending * 1e3
    assert free["module_curvature_y_per_m"][1] == pytest.approx(curvature, rel=0.05)


def test_the_page_stands_alone(written):
    out, _ = written
    page = (out / "module.html").read_text()
    assert (out / "chain.png").read_bytes().startswith(b"\x89PNG")
    assert "Moment of a blocked module" in page
    assert "data:image/png" in page
    assert "http://" not in page.split("<body")[1].split("<script")[0]


def test_another_folder_s_files_are_safe(written, tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    out, _ = written
    spec = str(out.parent / "small.yaml")
    called = CliRunner().invoke(softact, ["module", spec, "-o", str(tmp_path)])
    assert called.exit_code != 0
    assert "the folder holds other files" in str(called.exception)
