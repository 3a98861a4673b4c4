"""Walls with one element through them: found in a mesh, told beforehand, named with thickness."""

import numpy as np
import pytest

from softact.cli import main as cli
from softact.geometries import GEOMETRIES
from softact.geometries.pneunet import Pneunet
from softact.geometry.base import make_mesh
from softact.geometry.boxes import Box, Boxes
from softact.geometry.walls import Thin, Wall, expected, one_element_thick, remark
from softact.mesh.cells import upright

# A room with a lid of 1 mm, a floor of 3 mm and sides of 2 mm.
ROOM = Boxes(
    (Box("body", (0, 0, 0), (20, 20, 14)), Box("room", (2, 2, 3), (18, 18, 13))),
    ("body",),
    ("room",),
)


def thin_walls(size, least=1, left_out=()):
    """Thickness -> area in mm² of the walls of the room that are one element thick."""
    mesh = ROOM.mesh(size, size, least)
    named = {name: part for names, part in mesh.triangles() for name in names}
    cells = upright(mesh.points(), mesh.tetrahedra(0))
    found = one_element_thick(
        mesh.points(), cells, {"room": named["room"]}, [named[n] for n in left_out]
    )
    if not found:
        return {}
    (thin,) = found
    assert thin.whole == pytest.approx(2 * 16 * 16 + 4 * 16 * 10)
    thick = np.round(thin.thickness, 6)
    return {float(t): thin.area[thick == t].sum() for t in np.unique(thick)}


def test_thin_walls_of_a_room():
    """By hand: the areas of the lid, the four sides and the floor, as seen from the room."""
    assert thin_walls(5.0) == pytest.approx({1.0: 256, 2.0: 640, 3.0: 256})
    assert thin_walls(1.9) == pytest.approx({1.0: 256})
    assert thin_walls(0.9) == {}
    assert thin_walls(5.0, least=2) == {}


def test_what_is_left_out_is_no_side_of_a_wall():
    """As symmetry planes are: the outside, and so every wall."""
    assert thin_walls(5.0, left_out=("outer",)) == {}


def test_a_solid_corner_is_no_wall():
    """A step inside a room, one element wide: its faces look along different axes."""
    steps = Boxes((*ROOM.boxes, Box("body", (2, 2, 3), (5, 18, 6))), ROOM.regions, ROOM.cavities)
    mesh = steps.mesh(20, 20, 1)
    named = {name: part for names, part in mesh.triangles() for name in names}
    cells = upright(mesh.points(), mesh.tetrahedra(0))
    (thin,) = one_element_thick(mesh.points(), cells, {"room": named["room"]}, [])
    assert set(np.round(thin.thickness, 6)) <= {1.0, 2.0, 3.0}


def test_remark_names_walls_by_their_thickness():
    walls = (Wall("lid", 1.0, 1), Wall("side", 1.0, 1), Wall("floor", 3.0, 2))
    thin = [Thin("room", np.array([0.9, 1.1, 8.0]), np.array([30.0, 30.0, 40.0]), 400.0)]
    assert remark(walls, thin).startswith("one element through lid (1 mm) and side (1 mm): ")
    assert expected(walls) == remark(walls, thin)
    assert remark(walls, [Thin("room", np.array([8.0]), np.array([40.0]), 400.0)]) == ""
    assert remark(None, thin).startswith(
        "one element through 25% of the walls of 'room' (0.92 to 7.31 mm thick): "
    )
    assert expected(None) == expected(()) == remark((), thin) == remark(None, []) == ""


def of_walls(said: list[str]) -> list[str]:
    """Remarks on walls, without those on the volume."""
    return [line for line in said if not line.startswith("the mesh gives")]


def test_a_volume_far_off_the_closed_form_is_told(tmp_path):
    """An eighth of a ball of air, faceted with edges of 6 mm on 10 mm: 14.6 % less; the wall of
    1 mm around it as much. Curved edges have nothing to say."""
    ball = GEOMETRIES["thick_sphere"].model_validate({"mesh_size": "6 mm"})
    (said,) = make_mesh(ball, tmp_path / "flat.msh", 60.0)
    assert said.startswith("the mesh gives 'cavity' ") or said.startswith("the mesh gives 'body' ")
    assert "mm^3, -14.6% of the closed form" in said and said.count("-14.6%") == 2
    assert "solver: {curved: true}" in said
    assert make_mesh(ball, tmp_path / "curved.msh", 60.0, curved=True) == []


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("pneunet", {"chambers": 2, "roof": "3 mm"}),
        ("pneunet", {"chambers": 2, "inner_wall": "1.9 mm", "mesh_size": "1 mm"}),
        ("slow_pneunet", {"chambers": 2}),
        ("slow_pneunet", {"chambers": 2, "kind": "linear"}),
        ("omnidirectional", {"modules": 2}),
        ("antagonistic", {"chambers": 1, "symmetry": True}),
        ("shell_reinforced", {"cuts": 2, "mesh_size": "6 mm"}),
        ("shell_reinforced", {"cuts": 2, "mesh_size": "2 mm"}),
        ("fiber_reinforced", {"length": "40 mm"}),
        ("bellows", {"convolutions": 2}),
        ("bellows", {"convolutions": 1, "wall": "2 mm", "pitch": "12 mm", "mesh_size": "1.5 mm"}),
        ("braided_muscle", {"length": "30 mm"}),
        ("thick_sphere", {}),
    ],
)
@pytest.mark.parametrize("through", [1, 2])
def test_a_mesh_is_as_expected(name, given, through, tmp_path):
    """What is told before the mesh is made is what is found in it."""
    geometry = GEOMETRIES[name].model_validate({**given, "through_wall": through})
    said = expected(geometry.walls())
    assert of_walls(make_mesh(geometry, tmp_path / "solid.msh", 60.0)) == [said] * bool(said)
    if through == 2:
        assert not said


def test_a_round_wall_may_turn_out_to_have_one_element(tmp_path):
    """3 mm in a mesh of 4 mm: nobody knows before gmsh has meshed the section."""
    shell = GEOMETRIES["shell_reinforced"].model_validate({"cuts": 2})
    assert expected(shell.walls()) == ""
    (said,) = of_walls(make_mesh(shell, tmp_path / "solid.msh", 60.0))
    assert said.startswith("one element through radius less chamber_radius (3 mm): ")


def test_walls_of_a_pneunet_by_name():
    finger = Pneunet.model_validate({"chambers": 2, "roof": "3 mm", "inner_wall": "1.5 mm"})
    assert {wall.name: (wall.thickness, wall.elements) for wall in finger.walls()} == {
        "outer_wall": (1.0, 1), "roof": (3.0, 2), "base": (4.0, 3), "inner_wall": (1.5, 1),
    }  # fmt: skip


SPEC = """\
geometry: {type: pneunet, chambers: 1, roof: 3 mm}
materials: {body: ecoflex-00-30}
steps: [{name: up, pressure: 1 kPa}]
"""


def test_validate_and_mesh_tell_of_thin_walls(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "thin.yaml").write_text(SPEC)
    note = "one element through outer_wall (1 mm): walls that bend need two or more, as "
    for command in (["validate", "thin.yaml"], ["mesh", "thin.yaml"]):
        with pytest.raises(SystemExit) as left:
            cli.main(command)
        assert left.value.code == 0 and f"note: {note}" in capsys.readouterr().out
        with pytest.raises(SystemExit):
            cli.main([*command, "--set", "geometry.through_wall=2"])
        assert "note" not in capsys.readouterr().out
