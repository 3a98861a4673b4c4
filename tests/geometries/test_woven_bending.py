"""The woven bending actuator: its sheets, seams and pattern, and a run of the command."""

import re
from pathlib import Path

import numpy as np
import pytest

from softact.geometry import GEOMETRIES, export
from softact.results import read
from softact.run import run
from softact.spec import load

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "woven_bending.yaml"


def woven(**values):
    return GEOMETRIES["woven_bending"].model_validate(values)


@pytest.mark.parametrize("values", [{"n": 3}, {"n": 4, "pitch": "20 mm", "seam": "2 mm"}])
def test_areas_volume_and_seams(values):
    """Areas and volume of the closed forms, to the second order of the mesh; seams: the top, the
    side and both edges of the floor of each pouch."""
    geometry = woven(**values, mesh_size="3 mm")
    mesh, known = geometry.checked_mesh(), geometry.volumes()
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    areas = np.cross(b - a, c - a) / 2
    for name, members in mesh.parts.items():
        assert np.linalg.norm(areas[members], axis=1).sum() == pytest.approx(known[name], rel=1e-3)
    walls = np.concatenate([mesh.parts[name] for name in geometry.layout().cavities["air"]])
    volume = ((a + b + c) / 3 * areas)[walls].sum() / 3
    assert volume == pytest.approx(known["air"], rel=2e-3)
    seams = mesh.points[mesh.curves["seams"]]
    half, s = geometry.w_a / 2, geometry.seam / 2
    total = geometry.n * (half + geometry.h_a + 2 * np.hypot(half, s))
    assert np.linalg.norm(seams[:, 1] - seams[:, 0], axis=1).sum() == pytest.approx(total)


def test_the_pattern(tmp_path):
    """2 n rectangles and a strip."""
    export(woven(n=3), tmp_path / "cut.svg")
    lines = re.findall(
        r'class="cut" x1="(.*?)" y1="(.*?)" x2="(.*?)" y2="(.*?)"',
        (tmp_path / "cut.svg").read_text(),
    )
    x = np.array(lines, dtype=float)
    total = np.hypot(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]).sum()
    assert total == pytest.approx(6 * 2 * (41 + 30) + 2 * (38 + 41), rel=1e-4)


@pytest.mark.parametrize(("values", "field"), [({"seam": "16 mm"}, "seam"), ({"n": 2}, "n")])
def test_faults(values, field):
    with pytest.raises(ValueError, match=field):
        woven(**values)


def test_three_pouches_between_held_floors(tmp_path):
    """With both ends held, neighbours press on each other and do not pass through each other; what
    holds the two ends are mirror images about the middle pouch, and the tip would bend on."""
    held = "supports=[{surface: clamp, fix: [x, y, z]}, {surface: tip, fix: [x, y, z]}]"
    overrides = ["geometry.n=3", "geometry.mesh_size=21 mm", "steps.0.pressure=50 kPa", held]
    spec = load(str(CONFIG), [*overrides, "geometry.pitch=12 mm"])
    assert run(spec, tmp_path / "r", report=False).status == "complete"
    results = read(tmp_path / "r")
    last = {name: values[-1] for name, values in results.curve.items() if name != "step"}
    print(last)
    assert abs(last["tip_force_x_N"]) > 1
    assert last["tip_force_x_N"] == pytest.approx(last["reaction_x_N"], rel=1e-3)
    assert last["blocked_torque_Nmm"] > 10
    assert 0 < last["contact_overlap_percent"] < 2
    mesh = spec.geometry.sheet_mesh()
    increments = len(results.curve["step"])
    places = mesh.points + results.field(increments - 1, "displacement")[: len(mesh.points)]
    walls = {name: np.unique(mesh.triangles[mesh.parts[name]]) for name in ("fore", "aft")}
    pouch = np.rint(mesh.points[:, 0] / spec.geometry.pitch)
    for k in (0, 1):
        fore, aft = walls["fore"], walls["aft"]
        left, right = places[fore[pouch[fore] == k]], places[aft[pouch[aft] == k + 1]]
        assert left[:, 0].mean() < right[:, 0].mean()
        assert left[:, 0].max() < right[:, 0].max()
