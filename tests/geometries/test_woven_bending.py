"""The woven bending actuator: its sheets, seams and pattern, and its spec."""

import re
from pathlib import Path

import numpy as np
import pytest

from softact.geometry import GEOMETRIES, export
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


def test_the_spec_fits_the_geometry():
    """Each sheet has its plies; floors have the strip and one of nylon; neighbours may touch."""
    spec = load(str(CONFIG))
    assert set(spec.sheets) == set(spec.geometry.layout().sheets)
    assert [ply.thickness for ply in spec.sheets["floors"].plies] == [0.2, 0.5]
    assert [contact.groups for contact in spec.contact] == [(("fore", "aft"),)]
