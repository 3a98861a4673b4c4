"""Previews: what they count, colour and write, against what is known of the mesh by hand."""

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
from PIL import Image

from softact.cli import main as cli
from softact.errors import SpecError
from softact.mesh.msh_file import Tetrahedra
from softact.mesh.quality import signed_volumes
from softact.preview import of_spec, of_step, write
from softact.preview.cost import FIT, cost
from softact.preview.page import packed
from softact.preview.roles import loads_of
from softact.preview.through import _Walk, thicknesses
from softact.preview.words import rows
from softact.spec import Step, load, loads
from tests import step_files

FINGER = """
name: finger
geometry: {type: pneunet, chambers: 2, chamber_length: 7 mm, mesh_size: 8 mm}
materials: {body: elastosil-m4601}
layers:
  - {surface: strain_limiting_layer, thickness: 0.1 mm, material: paper}
contact:
  - {self: outer}
obstacles:
  bar:
    {type: cylinder, center: [20 mm, 0 mm, -12 mm], axis: [0, 1, 0], radius: 8 mm,
     load_cell: true}
steps:
  - {name: weight, gravity: [0, 0, -1]}
  - {name: inflate, pressure: 20 kPa}
  - name: hold
    supports: [{surface: clamp, fix: [x, y, z]}, {surface: tip, fix: [z], move: {x: 1 mm}}]
    pressure: 25 kPa
"""


@pytest.fixture(scope="module")
def finger():
    return of_spec(loads(FINGER))


def areas(preview, view: str) -> dict[str, float]:
    """mm² of the triangles of each part in a view."""
    found: dict[str, float] = {}
    for patch in preview.drawing.seen(view):
        if patch.corners.shape[1] == 3:
            a, b, c = np.moveaxis(preview.drawing.points[patch.corners], 1, 0)
            area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
            found[patch.name] = found.get(patch.name, 0.0) + area
    return found


def test_each_part_says_what_happens_with_it(finger):
    said = {patch.name: patch.said for patch in finger.drawing.patches}
    assert said["clamp"] == "held in x, y, z from step 'hold' on"
    assert "moved by 1 mm along x from step 'hold' on" in said["tip"]
    assert "pressure 20 kPa in step 'inflate'" in said["cavity"]
    assert "pressure 25 kPa in step 'hold'" in said["cavity"]
    assert said["strain_limiting_layer"] == "layer of paper, 0.1 mm"
    assert "may touch" in said["outer"]
    assert said["bar"] == "obstacle, cylinder, a load cell"
    assert said["gravity"] == "direction of gravity in step 'weight'"
    assert said["section of body"] == "made of elastosil-m4601"


def test_the_parts_have_the_areas_of_the_geometry(finger):
    # Half a finger 12 mm wide inside, 21 mm high: by hand from geometries/pneunet.py.
    cut, whole = areas(finger, "open"), areas(finger, "whole")
    assert cut["clamp"] == pytest.approx(7 * 21)
    assert whole["clamp"] == pytest.approx(14 * 21)
    geometry = loads(FINGER).geometry
    assert cut["strain_limiting_layer"] == pytest.approx(7 * geometry.row.length)
    # The cut face: body volume per width is not one number; that of base and channel is not cut.
    side = geometry.row.length * 21 - (21 - 4 - 5) * 1.0  # less the gap, above base and bridge
    air = 2 * 7 * 16 + 2 * (1 + 1 + 1)  # two chambers, and the channel through two walls and bridge
    assert cut["section of body"] == pytest.approx(side - air)
    assert "section of body" not in whole and "cavity" not in whole


def test_the_unknowns_are_those_of_the_solver(finger):
    import dolfinx  # noqa: F401
    from mpi4py import MPI

    from softact.geometry.base import make_mesh
    from softact.run.from_spec import build_model

    spec = loads(FINGER)
    for element in ("P2/P1", "P2/P0", "P2"):
        changed = spec.with_({"solver.element": element, "contact": [], "obstacles": {}})
        path = Path("mesh.msh").absolute()
        make_mesh(changed.geometry, path)
        try:
            model = build_model(MPI.COMM_SELF, changed, path)
        finally:
            path.unlink()
        assert of_spec(changed).figures.unknowns == model.unknowns.owned


def test_figures_are_those_of_the_whole(finger):
    figures, geometry = finger.figures, loads(FINGER).geometry
    assert figures.cells == len(finger.mesh.cells)
    assert figures.volumes["body"] == pytest.approx(2 * geometry.volumes()["body"])
    assert figures.size == pytest.approx([geometry.row.length, 14, 21])
    said = dict(rows(finger))
    assert (
        said["thinnest wall"]
        == "outer_wall, 1 mm, 1 element (two are wanted where it bends) through it"
    )
    assert said["quality"].startswith("median 0.")


def block(divisions: int) -> Tetrahedra:
    """A hollow block 6 x 6 x 6 mm with a room 2 x 2 x 2 mm at (1, 2, 3) mm: walls of 1 to 3 mm."""
    count = 6 * divisions
    grid = np.stack(np.meshgrid(*[np.arange(count)] * 3, indexing="ij"), -1).reshape(-1, 3)
    middle = (grid + 0.5) / divisions
    room = ((middle > (1, 2, 3)) & (middle < (3, 4, 5))).all(axis=1)
    corner = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    size = count + 1

    def number(at):
        return (at[..., 0] * size + at[..., 1]) * size + at[..., 2]

    cube = number(grid[~room][:, None] + corner)
    ways = np.array(
        [[0, 1, 3, 7], [0, 1, 5, 7], [0, 2, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 4, 6, 7]]
    )
    cells = cube[:, ways].reshape(-1, 4)
    points = np.stack(np.meshgrid(*[np.arange(size)] * 3, indexing="ij"), -1).reshape(-1, 3)
    points = points / divisions
    from softact.mesh.boundary import exterior
    from softact.mesh.cells import upright

    cells = upright(points, cells)
    skin = exterior(cells)
    inner = ((points[skin].mean(axis=1) > 0.9) & (points[skin].mean(axis=1) < 5.1)).all(axis=1)
    return Tetrahedra(points, cells, np.zeros(len(cells), int), {"cavity": skin[inner]})


@pytest.mark.parametrize("divisions", [1, 2])
def test_how_thick_the_walls_of_a_room_are(divisions):
    layout = SimpleNamespace(cavities={"cavity": ("cavity",)}, symmetry={})
    (found,) = thicknesses(block(divisions), layout)
    # Walls along x: 1 and 3 mm, y: 2 and 2, z: 3 and 1.
    assert found.thinnest == pytest.approx(1.0)
    assert found.median == pytest.approx(2.0)
    ways = _Walk(block(divisions), layout).through(block(divisions).surfaces["cavity"])[1]
    for thick, sides in ((1.0, 2), (2.0, 2), (3.0, 2)):  # of six
        assert np.isclose(ways, thick).mean() == pytest.approx(sides / 6)
    # Six tetrahedra of a cube have edges of 1, sqrt(2) and sqrt(3): 3, 2 and 1 of six each.
    edge = (3 + 2 * np.sqrt(2) + np.sqrt(3)) / 6 / divisions
    assert found.elements == pytest.approx(1 / edge)


def test_a_whole_actuator_is_cut_through_its_middle():
    spec = loads(FINGER).with_({"geometry.symmetry": False, "obstacles": {}, "contact": []})
    found = of_spec(spec)
    cut, whole = areas(found, "open"), areas(found, "whole")
    assert found.drawing.cut.startswith("cut through its middle, y = 0 mm")
    assert whole["clamp"] == pytest.approx(14 * 21)
    assert cut["clamp"] < whole["clamp"]
    assert whole["cavity"] > cut["cavity"] > 0.3 * whole["cavity"]
    assert "section of body" in cut


def test_sheets_show_their_parts_and_curves():
    root = Path(__file__).parents[2]
    found = of_spec(load(root / "configs/woven_contracting.yaml"))
    said = {patch.name: patch.said for patch in found.drawing.patches}
    assert said["clamp"] == "held in x, y, z"
    assert "pressure 206 kPa" in said["pouches"]
    assert said["tabs"].startswith("0.2 mm of law linear")
    assert areas(found, "whole")["pouches"] == pytest.approx(2 * 7 * 22.86 * 60)
    assert found.figures.volumes["pouches"] == pytest.approx(2 * 7 * 22.86 * 60)


def test_the_page_holds_the_drawing_and_is_one_file(finger, tmp_path):
    path = tmp_path / "finger.html"
    write(finger, path)
    text = path.read_text()
    data = json.loads(text.split('id="data">')[1].split("</script>")[0])["view"]
    assert data == json.loads(json.dumps(packed(finger.drawing)))
    assert [patch["name"] for patch in data["patches"]] == [p.name for p in finger.drawing.patches]
    assert f"{finger.figures.unknowns} unknowns" in text


def test_the_picture_shows_the_colours_of_the_parts(finger, tmp_path):
    path = tmp_path / "finger.png"
    write(finger, path)
    pixels = np.asarray(Image.open(path).convert("RGB")).reshape(-1, 3).astype(float)
    assert len(pixels) > 300_000
    for patch in finger.drawing.seen("open"):
        if patch.name in ("clamp", "cavity", "outer"):
            colour = np.array([int(patch.colour[n : n + 2], 16) for n in (1, 3, 5)], float)
            # Shading makes it darker, and leaves its hue.
            hue = pixels / np.maximum(np.linalg.norm(pixels, axis=1, keepdims=True), 1)
            near = np.linalg.norm(hue - colour / np.linalg.norm(colour), axis=1) < 0.05
            assert near.sum() > 2000, patch.name


def test_the_mesh_goes_to_abaqus_with_its_names(finger, tmp_path):
    path = tmp_path / "finger.inp"
    write(finger, path)
    mesh = meshio.read(path)
    (cells,) = [block.data for block in mesh.cells if block.type == "tetra"]
    volume = np.abs(signed_volumes(mesh.points, cells)).sum()
    assert 2 * volume == pytest.approx(finger.figures.volumes["body"], rel=1e-6)
    assert set(mesh.point_sets) >= {"clamp", "tip", "cavity"}
    assert np.allclose(mesh.points[mesh.point_sets["clamp"]][:, 0], 0)
    # Faces of elements, by Abaqus' numbers of their corners.
    lines = path.read_text().split("*SURFACE, NAME=cavity_SURFACE, TYPE=ELEMENT\n")[1]
    faces = [line.split(", S") for line in lines.split("*")[0].splitlines()]
    corners = {1: (0, 1, 2), 2: (0, 1, 3), 3: (1, 2, 3), 4: (0, 2, 3)}
    a, b, c = np.moveaxis(
        mesh.points[[cells[int(e) - 1][list(corners[int(f)])] for e, f in faces]], 1, 0
    )
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    assert area == pytest.approx(areas(finger, "open")["cavity"])
    with pytest.raises(SpecError, match=r"\.html, \.png, \.inp"):
        write(finger, tmp_path / "finger.obj")
    with pytest.raises(SpecError, match="only the mesh of a solid"):
        write(replace(finger, mesh=None), tmp_path / "finger.inp")


# Runs of first specs, 'softact new' and 'softact run -n 1' with one thread, on a machine that five
# other sessions shared: kind of figures, what the cost hangs on, user seconds, MB.
MEASURED = [
    ("pneunet", "contact: []", 17598, 17.3, 292),
    ("bellows", "", 10401, 10.6, 233),
    ("omnidirectional", "", 30786, 24.2, 440),
    ("antagonistic", "", 64933, 39.9, 823),
    ("shell_reinforced", "", 9251, 33.5, 240),
    ("braided_muscle", "", 6285, 12.5, 200),
    ("thick_sphere", "", 1152, 7.4, 160),
    ("woven_contracting", "", 1089, 16.6, 153),
    ("woven_elongating", "", 2103, 37.8, 161),
]


@pytest.mark.parametrize(("name", "change", "unknowns", "seconds", "megabytes"), MEASURED)
def test_the_cost_is_near_that_of_measured_runs(
    name, change, unknowns, seconds, megabytes, tmp_path
):
    from softact.starter import Wanted, family
    from softact.starter import write as first

    path = tmp_path / "first.yaml"
    path.write_text(first(family(name), Wanted(), path))
    spec = load(path, [change.replace(": ", "=")] if change else [])
    kind = "triangles" if spec.sheets else "tetrahedra"
    figures = SimpleNamespace(kind=kind, unknowns=unknowns, curved=("shell",))
    found = cost(spec, figures)
    assert 1 / FIT.off < seconds / found.seconds < FIT.off
    assert found.megabytes == pytest.approx(megabytes, rel=0.15)


@pytest.fixture(scope="module")
def part(tmp_path_factory):
    return step_files.write(tmp_path_factory.mktemp("step") / "part.step", step_files.bladder)


def test_a_step_file_shows_its_faces_by_number(part):
    found = of_step(part)
    numbers = {patch.name for patch in found.drawing.seen("whole")}
    assert numbers == {str(n) for n in range(1, 13)}  # a block and a room of six faces each
    said = {patch.name: patch.said for patch in found.drawing.patches}
    area = areas(found, "whole")
    block_, room = step_files.BLOCK[3:], step_files.ROOM[3:]
    ends = [n for n, text in said.items() if text.startswith(("clamp", "tip"))]
    assert sorted(area[n] for n in ends) == pytest.approx([block_[1] * block_[2]] * 2)
    walls = sum(a for n, a in area.items() if said[n].startswith("cavity"))
    x, y, z = room
    assert walls == pytest.approx(2 * (x * y + y * z + z * x))
    assert any("1 solid with 12 faces, 40 x 14 x 12 mm" in note for note in found.notes)


def test_a_step_file_without_what_a_spec_needs_is_shown_all_the_same(tmp_path):
    solid = step_files.write(tmp_path / "solid.step", lambda occ: occ.addBox(0, 0, 0, 40, 14, 12))
    found = of_step(solid)
    assert {patch.name for patch in found.drawing.seen("whole")} == {str(n) for n in range(1, 7)}
    assert any("'cavity' is not among those that are found" in note for note in found.notes)
    small = of_step(solid, unit="um")
    assert any("an unlikely size" in note for note in small.notes)
    with pytest.raises(SpecError, match="there is no file"):
        of_step(tmp_path / "none.step")


def leave(*arguments: str) -> int | str | None:
    with pytest.raises(SystemExit) as left:
        cli.main(arguments)
    return left.value.code


def test_the_command_writes_over_its_own_page_and_nothing_else(tmp_path, monkeypatch, capsys, part):
    monkeypatch.chdir(tmp_path)
    Path("finger.yaml").write_text(FINGER)
    for _ in range(2):
        assert leave("preview", "finger.yaml", "--set", "geometry.chambers=1") == 0
    said = capsys.readouterr().out
    assert "unknowns" in said and "wrote finger_preview.html" in said and "of one core" in said
    Path("other.html").write_text("mine")
    assert leave("preview", "finger.yaml", "-o", "other.html") == 2
    assert Path("other.html").read_text() == "mine"
    assert leave("preview", "finger.yaml", "-o", "finger.obj") == 2
    assert leave("preview", str(part), "--set", "a=b") == 2
    assert leave("preview", str(part)) == 0
    assert "wrote part_preview.html" in capsys.readouterr().out


def test_what_a_step_does_with_obstacles():
    """In words, of each obstacle, and not of the tip."""
    step = Step.model_validate(
        {
            "name": "go",
            "obstacles": {
                "ball": {"held": False},
                "cell": {
                    "move": ["1 mm", "0 mm", "0 mm"],
                    "turn": {"axis": [0, 0, 1], "angle": "20 deg"},
                },
                "post": {"active": False},
            },
        }
    )
    found = list(loads_of(step, loads(FINGER).layout()))
    assert found == [
        ("ball", "", "let go"),
        ("cell", "", "turned by 20 deg, moved by (1 mm, 0 mm, 0 mm)"),
        ("post", "", "removed"),
    ]
