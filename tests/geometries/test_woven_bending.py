"""The woven bending actuator: its sheets, seams and pattern, and its spec."""

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
    # The strip goes on beneath the pouches; each wall is a piece of its own.
    patches = mesh.patches()
    flat = np.concatenate([mesh.parts[name] for name in mesh.continuous])
    assert len(np.unique(patches[flat])) == 1
    assert len(np.unique(patches)) == 2 * geometry.n + 1


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


@pytest.mark.parametrize(
    ("name", "strip"),
    [("woven_bending", 0.5), ("finger_woven", 0.2), ("finger_woven_blocked", 0.2)],
)
def test_the_spec_fits_the_geometry(name, strip):
    """Each sheet has its plies; floors have the strip and one of nylon; neighbours may touch."""
    spec = load(str(CONFIGS / f"{name}.yaml"))
    assert set(spec.sheets) == set(spec.geometry.layout().sheets)
    assert [ply.thickness for ply in spec.sheets["floors"].plies] == [0.2, strip]
    assert [contact.groups for contact in spec.contact] == [(("fore", "aft"),)]


@pytest.mark.parametrize(
    ("name", "mesh", "again"),
    [
        ("woven_bending", "21 mm", []),
        ("finger_woven", "10 mm", ["steps.inflate_again.pressure=30 kPa"]),
    ],
)
def test_a_run_of_three_pouches(name, mesh, again, tmp_path):
    """Neighbours press on each other and the strip bends, by less than endless pouches, circles of
    the girth 2 h + s that touch: with the radius r and their middles c above the strip, turned by
    2 β, where the strip between the floors is straight, (pitch − s) cos 0 + s cos β + 2 c sin β =
    2 r cos β at most. A free limb presses on nothing at its clamp. Up and down are one curve, to
    the rest of motion that is left where the first inflation, by damped dynamics, ends: 1e-4."""
    overrides = ["geometry.n=3", f"geometry.mesh_size={mesh}", "steps.inflate.pressure=30 kPa"]
    spec = load(
        str(CONFIGS / f"{name}.yaml"), [*overrides, "steps.deflate.pressure=25 kPa", *again]
    )
    assert run(spec, tmp_path / "r", report=False).status == "complete"
    curve = read(tmp_path / "r").curve
    (message,) = json.loads((tmp_path / "r" / "run.json").read_text())["messages"]
    assert float(re.search(r"([\d.]+)% are unexplained", message)[1]) < 1.0
    geometry, back, up = spec.geometry, curve["step"] != "inflate", curve["step"] == "inflate_again"
    girth = 2 * geometry.h_a + geometry.seam
    r = girth / (2 * np.pi)
    c = r * np.cos(np.pi * geometry.seam / girth)
    beta = np.linspace(0, 0.5, 5001)
    apart = geometry.pitch - geometry.seam + geometry.seam * np.cos(beta) + 2 * c * np.sin(beta)
    touching = beta[np.argmax(apart > 2 * r * np.cos(beta))]
    angle = curve["bending_angle_deg"]
    assert 0.0 < angle[back & ~up][-1] < angle[~back][-1] < 2 * np.degrees(2 * touching)
    assert angle[up][-1:] == pytest.approx(angle[~back][-1:] if again else [], rel=1e-3)
    assert 0.0 < curve["contact_overlap_percent"].max() < 2.0
    pressed = 0.025 * geometry.w_a * geometry.h_a
    for c in "xz":
        assert abs(curve[f"reaction_{c}_N"][back]).max() < 1e-6 * pressed
    assert abs(curve["reaction_moment_y_Nmm"][back]).max() < 1e-6 * pressed * geometry.h_a


def test_what_three_pouches_press_with(tmp_path):
    """The strip's end leans on the cell, the first pouch on the mount: without friction one pushes
    up, the other forward; with the clamp they are in balance, and with the cell's force within its
    face the mount's is within the height of a pouch."""
    path, edge = CONFIGS / "finger_woven_blocked.yaml", 13.0
    overrides = ["geometry.n=3", "geometry.mesh_size=10 mm", "steps.inflate.pressure=60 kPa"]
    cell = f"obstacles.cell.center=[{edge + 50} mm, 0 mm, -10 mm]"
    again = "steps.inflate_again.pressure=60 kPa"
    spec = load(str(path), [*overrides, cell, "steps.deflate.pressure=55 kPa", again])
    assert run(spec, tmp_path / "r", report=False).status == "complete"
    last = {name: values[-1] for name, values in read(tmp_path / "r").curve.items()}
    pressed = 0.060 * spec.geometry.w_a * spec.geometry.h_a
    up, forward = last["contact_force_cell_z_N"], last["contact_force_mount_x_N"]
    assert up == pytest.approx(last["blocked_force_N"]) and up > 0.01 * pressed
    assert last["reaction_z_N"] == pytest.approx(-up, abs=1e-6 * pressed)
    assert last["reaction_x_N"] == pytest.approx(-forward, abs=1e-6 * pressed)
    for x in (edge, last["tip_x_mm"] + spec.geometry.seam / 2):
        height = (x * up - last["reaction_moment_y_Nmm"]) / forward
        assert 0 < height < spec.geometry.h_a
