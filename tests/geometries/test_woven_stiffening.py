"""The woven stiffening actuator: its sheets, seams and pattern, and its spec."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from softact.geometries import GEOMETRIES
from softact.geometry.base import export
from softact.results.folder import read
from softact.run.start import run
from softact.spec import load

CONFIGS = Path(__file__).resolve().parents[2] / "configs"


def woven(**values):
    return GEOMETRIES["woven_stiffening"].model_validate(values)


@pytest.mark.parametrize(
    "values",
    [{}, {"angle": "90 deg", "l_i": "100 mm", "mesh_size": "7 mm"}, {"strap": "20 mm"}],
)
def test_areas_seams_and_fold(values):
    """Areas of the closed form, nothing enclosed; seams: both ends and one side; the half beyond
    the joint lies in a plane that is turned down by the angle."""
    geometry = woven(**values)
    mesh, known = geometry.checked_mesh(), geometry.volumes()
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    areas = np.cross(b - a, c - a) / 2
    for name, members in mesh.parts.items():
        assert np.linalg.norm(areas[members], axis=1).sum() == pytest.approx(known[name], rel=1e-12)
    assert ((a + b + c) / 3 * areas).sum() == pytest.approx(0.0, abs=1e-8)
    seams = mesh.points[mesh.curves["seams"]]
    total = np.linalg.norm(seams[:, 1] - seams[:, 0], axis=1).sum()
    assert total == pytest.approx(geometry.l_i + geometry.w_a)
    joint, turn = np.array([geometry.l_i / 2, 0, 0]), np.radians(geometry.angle)
    tip = mesh.points[np.unique(mesh.curves["tip"])] - joint
    along, across = [np.cos(turn), 0, -np.sin(turn)], [np.sin(turn), 0, np.cos(turn)]
    np.testing.assert_allclose(tip @ along, geometry.l_i / 2)
    np.testing.assert_allclose(tip @ across, 0, atol=1e-12)


def test_the_pattern(tmp_path):
    """Two rectangles, sealed along their rim."""
    export(woven(), tmp_path / "cut.svg")
    text = (tmp_path / "cut.svg").read_text()
    for kind in ("cut", "seam"):
        found = re.findall(rf'class="{kind}" x1="(.*?)" y1="(.*?)" x2="(.*?)" y2="(.*?)"', text)
        x = np.array(found, dtype=float)
        total = np.hypot(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]).sum()
        assert total == pytest.approx(2 * (240 + 65))
    assert "2 of each piece" in text


def test_faults():
    with pytest.raises(ValueError, match="120 mm leave nothing of the half"):
        woven(free="120 mm")
    with pytest.raises(ValueError, match="at most the width of 65 mm"):
        woven(strap="66 mm")


@pytest.mark.parametrize("angle", [60, 90])
def test_the_cell_stands_where_the_spec_says(angle):
    """Its face is parallel to the half that leans on it, w_a/π from it, its middle 90 mm from the
    joint."""
    spec = load(str(CONFIGS / f"woven_stiffening_{angle}.yaml"))
    geometry, cell = spec.geometry, spec.obstacles["cell"]
    assert geometry.angle == angle
    turn, joint = np.radians(angle), np.array([geometry.l_i / 2, 0.0, 0.0])
    along = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    across = np.array([np.sin(turn), 0.0, np.cos(turn)])
    face = joint + 90 * along + geometry.w_a / np.pi * across
    found = cell.shape().distance(np.array([face, face - across, face + 9 * along - across]))[0]
    np.testing.assert_allclose(found, [0.0, 1.0, 1.0], atol=0.01)


def test_a_run_against_the_cell(tmp_path):
    """What the pouch presses with on the cell is what holds it, normal to the cell's face (there is
    no friction), and turns it about the joint with an arm within the cell's 80 to 100 mm."""
    overrides = ["geometry.mesh_size=22 mm", "steps.inflate.pressure=25 kPa"]
    spec = load(
        str(CONFIGS / "woven_stiffening_60.yaml"), [*overrides, "steps.deflate.pressure=20 kPa"]
    )
    assert run(spec, tmp_path / "r", report=False).status == "complete"
    curve = read(tmp_path / "r").curve
    (message,) = json.loads((tmp_path / "r" / "run.json").read_text())["messages"]
    assert float(re.search(r"([\d.]+)% are unexplained", message)[1]) < 1.0
    back = curve["step"] == "deflate"
    force = curve["blocked_force_N"][back]
    assert np.all(force > 0.1) and np.all(np.diff(force) < 0)
    turn = np.radians(spec.geometry.angle)
    for component, part in (("x", np.sin(turn)), ("z", np.cos(turn))):
        held = curve[f"reaction_{component}_N"][back]
        np.testing.assert_allclose(np.abs(held), part * force, rtol=1e-4)
    arm = np.abs(curve["reaction_moment_y_Nmm"][back]) / force
    assert np.all((arm > 80) & (arm < 100))
    assert 0.0 < curve["contact_overlap_percent"].max() < 2.0
