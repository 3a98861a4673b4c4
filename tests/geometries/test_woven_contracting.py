"""The woven contracting actuator: its sheets, seams and pattern, and a run of the command."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest

from softact.errors import MeshError
from softact.geometries import GEOMETRIES
from softact.geometry.base import export
from softact.run.start import run
from softact.spec import load

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "woven_contracting.yaml"


def woven(**values):
    return GEOMETRIES["woven_contracting"].model_validate(values)


def lengths(points, edges):
    return np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)


@pytest.mark.parametrize(
    "values", [{}, {"n_a": 2, "l_i": "80 mm", "mesh_size": "3 mm"}, {"seam": "3 mm"}]
)
def test_areas_and_seams(values):
    """Areas of the closed form; seams: the rim of all pouches and n − 1 lines with a gap, or the
    three sides of welds that have a width."""
    geometry = woven(**values)
    mesh = geometry.checked_mesh()
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    areas = np.cross(b - a, c - a)[:, 2] / 2
    for name, members in mesh.parts.items():
        assert areas[members].sum() == pytest.approx(geometry.volumes()[name], rel=1e-12)
    assert areas.min() > 0
    n, h, half = geometry.n_a, geometry.h_a, geometry.w_a / 2
    wide, line = geometry.seam, half - geometry.passage / 2
    between = (n - 1) * (2 * line + wide if wide else line)
    rim = n * (h - wide)
    assert lengths(mesh.points, mesh.hinges).sum() == pytest.approx(rim + 2 * half + between)
    # Both tabs and the welds; the pouches hang together.
    assert len(np.unique(mesh.patches())) == 3 + (n - 1 if wide else 0)


def test_a_seam_wider_than_a_pouch_is_refused():
    assert [*woven(n_a=3).faults()] == []
    [(field, text)] = woven(n_a=3).model_copy(update={"seam": 23.0}).faults()
    assert field == "seam" and "23 mm" in text and "22.86 mm" in text


def test_the_pattern(tmp_path):
    """Cut: the outline of a piece; seams: rim and lines with gaps; the same in both formats."""
    geometry = woven()
    cut = 2 * (200 + 60)
    seam = 2 * 160.02 + 2 * 60 + 6 * (60 - 5)
    for suffix, patterns in (
        ("svg", (r'class="cut" (.*) stroke', r'class="seam" (.*) stroke')),
        ("dxf", (r"8\nCUT\n((?:.*\n){14})", r"8\nSEAM\n((?:.*\n){14})")),
    ):
        path = tmp_path / f"pattern.{suffix}"
        export(geometry, path)
        text = path.read_text()
        for pattern, wanted in zip(patterns, (cut, seam), strict=True):
            total = 0.0
            for entry in re.findall(pattern, text):
                values = re.findall(
                    r"[-\d.]+", re.sub(r'x1|y1|x2|y2|stroke-width="[^"]*"', "", entry)
                )
                x = [float(v) for v in values]
                if suffix == "dxf":  # colour, then pairs of a code and a value
                    pairs = dict(zip(map(int, x[2::2]), x[3::2], strict=True))
                    x = [pairs[10], pairs[20], pairs[11], pairs[21]]
                total += np.hypot(x[2] - x[0], x[3] - x[1])
            assert total == pytest.approx(wanted, rel=1e-4)


@pytest.mark.parametrize(
    ("values", "field"),
    [({"n_a": 9}, "l_i"), ({"passage": "60 mm"}, "passage")],
)
def test_faults(values, field):
    with pytest.raises(ValueError, match=field):
        woven(**values)


def test_a_run_of_two_pouches(tmp_path):
    """Free contraction between the pouch motor's limit 1 − 2/π, which seams at the sides keep it
    from, and half of it; no force on the free actuator; quasi-static where it says so."""
    overrides = ["geometry.n_a=2", "geometry.l_i=60 mm", "geometry.mesh_size=8 mm"]
    spec = load(str(CONFIG), overrides)
    outcome = run(spec, tmp_path / "r", processes=2, report=False)
    assert outcome.status == "complete"
    with (tmp_path / "r" / "curve.csv").open() as file:
        rows = list(csv.DictReader(file))
    texts = "step", "control"
    last = {name: float(value) for name, value in rows[-1].items() if name not in texts}
    contraction = -last["elongation_mm"] / (2 * 22.86)
    assert 0.5 * (1 - 2 / np.pi) < contraction < 1 - 2 / np.pi
    assert abs(last["reaction_x_N"]) < 1e-2
    volumes = [float(row["cavity_volume_mm3"]) for row in rows]
    assert volumes[0] == pytest.approx(0.0, abs=1e-6)
    assert np.all(np.diff(volumes) > -1e-5 * volumes[-1])  # it also settles under the full load
    known = json.loads((tmp_path / "r" / "run.json").read_text())
    assert known["processes"] == 1
    told = " ".join(known["notes"])
    assert "inflated by implicit dynamics" in told and "more than quasi-static" not in told
    # After the first inflation the kinetic energy stays below 5 % of the internal energy.
    ratios = [a["kinetic_ratio"] for a in known["history"] if a["control"] == "motion"]
    below = next(i for i, ratio in enumerate(ratios) if i > 2 and ratio < 0.05)
    assert max(ratios[below:]) < 0.05


def test_faults_of_a_spec(tmp_path):
    """An unknown or missing sheet is told by name."""
    text = CONFIG.read_text().replace("  tabs:\n", "  taps:\n")
    (tmp_path / "bad.yaml").write_text(text)
    with pytest.raises(Exception) as caught:
        load(str(tmp_path / "bad.yaml"))
    lines = "\n".join(caught.value.lines)
    assert "no sheet 'taps'" in lines and "did you mean 'tabs'" in lines
    assert "sheets.tabs: missing" in lines


def test_plies_of_any_law():
    """A knit as a ply: a card of a law of solids."""
    spec = load(str(CONFIG), ["sheets.tabs.plies.0.material=knit-fabric-coated-biaxial"])
    assert spec.sheets["tabs"].plies[0].material.c10 == 1.098


def test_an_open_seam_is_told():
    geometry = woven(n_a=1, l_i="60 mm")
    mesh = geometry.sheet_mesh()
    layout = geometry.layout()
    with pytest.raises(MeshError, match="edges of its sheets are open"):
        mesh.check(layout.cavities, [1], layout.flux)  # no plane closes the rim
