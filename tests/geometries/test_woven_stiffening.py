"""The woven stiffening actuator: its sheets, seams and pattern, and a run of the command."""

import re
from pathlib import Path

import numpy as np
import pytest

from softact.geometry import GEOMETRIES, export
from softact.results import read
from softact.run import run
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


def test_a_short_one_presses_on_its_cell(tmp_path):
    """Bent by 60°, it straightens until it leans on the load cell; its force is across the cell's
    face, and the moment of the fastened strip about the joint is the force times the arm of some
    point of the cell. With less pressure it presses less."""
    overrides = [
        *("geometry.l_i=100 mm", "geometry.w_a=40 mm", "geometry.free=15 mm"),
        *("geometry.strap=40 mm", "geometry.mesh_size=17 mm", "steps.0.pressure=100 kPa"),
        # joint + 35 mm along the half + (40/π + 10 mm) across it
        "obstacles.cell.center=[87.19 mm, 0 mm, -18.95 mm]",
    ]
    spec = load(str(CONFIGS / "woven_stiffening_60.yaml"), overrides)
    assert run(spec, tmp_path / "r", report=False).status == "complete"
    curve = read(tmp_path / "r").curve
    force, moment = curve["blocked_force_N"], curve["reaction_moment_y_Nmm"]
    back = curve["step"] == "deflate"
    assert force[0] == 0 and force[-1] > 0.1
    assert np.all(np.diff(force[back]) < 0)
    arms = moment[back] / -force[back]
    assert 25 < arms.min() and arms.max() < 45
    across = curve["contact_force_cell_x_N"][back]
    np.testing.assert_allclose(across, -np.sin(np.pi / 3) * force[back], rtol=1e-6)
    overlap = curve["contact_overlap_percent"][back]
    assert 0 < overlap.min() and overlap.max() < 2
