"""The woven elongating actuator: its sheets, seams and pattern, and a run of the command."""

import re
from pathlib import Path

import numpy as np
import pytest

from softact.errors import SoftactError
from softact.geometries import GEOMETRIES
from softact.geometry.base import export
from softact.results.folder import read
from softact.run.start import run
from softact.spec import load

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "woven_elongating.yaml"


def woven(**values):
    return GEOMETRIES["woven_elongating"].model_validate(values)


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"n_a": 2, "pitch": "5 mm", "passage": "4 mm", "mesh_size": "3 mm"},
        {"n_a": 1, "w_a": "30 mm", "h_a": "50 mm"},
    ],
)
def test_areas_volume_and_seams(values):
    """Areas and volume of the closed form; seams: n rims and n + 1 passages, a quarter of each."""
    geometry = woven(**values)
    mesh, known = geometry.checked_mesh(), geometry.volumes()
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    areas = np.cross(b - a, c - a) / 2
    for name, members in mesh.parts.items():
        assert np.linalg.norm(areas[members], axis=1).sum() == pytest.approx(known[name], rel=1e-12)
    # By the divergence theorem; the planes of symmetry go through the origin.
    assert ((a + b + c) / 3 * areas).sum() / 3 == pytest.approx(known["air"], rel=1e-12)
    seams = mesh.points[mesh.curves["seams"]]
    rims, passages = (geometry.w_a + geometry.h_a) / 2, geometry.passage
    total = geometry.n_a * rims + (geometry.n_a + 1) * passages
    assert np.linalg.norm(seams[:, 1] - seams[:, 0], axis=1).sum() == pytest.approx(total)
    assert np.abs(mesh.points[np.unique(mesh.curves["clamp"])][:, 0]).max() == 0
    tip = mesh.points[np.unique(mesh.curves["tip"])][:, 0]
    assert np.allclose(tip, geometry.n_a * geometry.pitch)


def test_the_pattern(tmp_path):
    """2 n sheets, all but the two at the ends with a passage."""
    export(woven(n_a=3), tmp_path / "cut.svg")
    lines = re.findall(
        r'class="cut" x1="(.*?)" y1="(.*?)" x2="(.*?)" y2="(.*?)"',
        (tmp_path / "cut.svg").read_text(),
    )
    x = np.array(lines, dtype=float)
    total = np.hypot(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]).sum()
    assert total == pytest.approx(6 * 2 * (62 + 31) + 4 * 4 * 10, rel=1e-4)


@pytest.mark.parametrize(
    ("values", "field"),
    [({"passage": "31 mm"}, "passage"), ({"pitch": "22 mm"}, "pitch"), ({"n_a": 0}, "n_a")],
)
def test_faults(values, field):
    with pytest.raises(ValueError, match=field):
        woven(**values)


def test_bending_is_refused(tmp_path):
    """Its sheets are no plane as they lie; the spec asks for a bending stiffness."""
    text = CONFIG.read_text().replace(
        "tension_field\n  ends", "tension_field\n    bending: 1\n  ends"
    )
    (tmp_path / "bad.yaml").write_text(text)
    with pytest.raises(SoftactError, match="curved"):
        run(load(str(tmp_path / "bad.yaml")), tmp_path / "r", report=False)


def test_two_square_pouches(tmp_path):
    """The paper bag problem: two inextensible squares of side a hold between 0.2055 a³, which a
    construction has, and 0.217 a³ (A. Kepert); the mesh is coarse: 3 %. Nothing pulls, and
    neighbours touch at their passage alone."""
    overrides = ["geometry.n_a=2", "geometry.h_a=62 mm", "geometry.passage=4 mm"]
    spec = load(str(CONFIG), [*overrides, "geometry.mesh_size=16 mm"])
    assert run(spec, tmp_path / "r", report=False).status == "complete"
    results = read(tmp_path / "r")
    curve, back = results.curve, results.curve["step"] == "deflate"
    p, v = curve["pressure_kPa"][back], curve["cavity_volume_mm3"][back]
    assert np.all(np.diff(v) < 0)  # a path of equilibria
    inextensible = v[-1] - p[-1] * (v[-2] - v[-1]) / (p[-2] - p[-1])  # towards no pressure
    assert 0.97 * 0.2055 < inextensible / 2 / 62**3 < 0.217
    assert abs(curve["reaction_x_N"][-1]) < 1e-6
    # By its corner nodes in the mesh: sheets 1 and 2 meet in the passage between the pouches.
    mesh = spec.geometry.sheet_mesh()
    places = mesh.points + results.field(len(back) - 1, "displacement")[: len(mesh.points)]
    between = np.abs(mesh.points[:, 0] - spec.geometry.pitch) < 1e-9
    sheets = mesh.points[:, 0] // (spec.geometry.pitch / 2)
    middle = places[between, 0]
    assert np.ptp(middle) < 0.5
    assert places[(sheets == 1) & ~between, 0].max() < middle.min()
    assert places[(sheets == 2) & ~between, 0].min() > middle.max()
