"""Faces of a STEP file by number, place and direction, and the names of those that have none."""

from math import pi

import numpy as np
import pytest

from softact.errors import MeshError, SpecError
from softact.geometries.from_step import FromStep
from softact.geometry.base import look, make_mesh
from softact.spec import loads
from tests import step_files
from tests.geometries.looking import looked
from tests.step_files import BLOCK_VOLUME


@pytest.fixture
def step(tmp_path):
    """Function that writes a STEP file, the bladder by default; returns its path as text."""

    def write(make=step_files.bladder, **names):
        return str(step_files.write(tmp_path / "part.step", make, **names))

    return write


def test_ends_and_rooms_of_a_file_without_names(step, meshed):
    """The bladder's ends are 14 x 12 mm, its room 32 x 8 x 6 mm; what is left outside is outer."""
    given = {"file": step(), "surfaces": ["outer"], "mesh_size": "5 mm"}
    geometry = FromStep.model_validate(given)
    solid = meshed(geometry)
    assert solid.volumes.sum() == pytest.approx(BLOCK_VOLUME, rel=1e-9)
    areas = {name: solid.area(name) for name in solid.surfaces}
    room = 2 * (32 * 8 + 32 * 6 + 8 * 6)
    assert areas == pytest.approx(
        {"clamp": 14 * 12, "tip": 14 * 12, "cavity": room, "outer": 2 * 40 * (14 + 12)}
    )
    said = looked(geometry)
    assert "'cavity' is faces 7 to 12 (no face has a name: found by its place)" in said
    assert "face 1: flat, 168 mm^2, middle at (0, 0, 8) mm, looks along (-1, 0, 0)" in said


def two_rooms(occ):
    rooms = [(3, occ.addBox(*room)) for room in ((22, 3, 3, 14, 6, 4), (4, 3, 3, 14, 6, 4))]
    occ.cut([(3, occ.addBox(0, 0, 0, 40, 12, 10))], rooms)


def test_each_of_several_rooms_has_its_own_name_from_clamp_to_tip(step, meshed):
    cavities = {"near": ["cavity_1"], "far": ["cavity_2"]}
    solid = meshed(
        FromStep.model_validate(
            {"file": step(two_rooms), "cavities": cavities, "mesh_size": "6 mm"}
        )
    )
    for name, middle in (("cavity_1", 11), ("cavity_2", 29)):
        assert solid.points[solid.surfaces[name], 0].mean() == pytest.approx(middle, abs=1.5)
    both = FromStep.model_validate({"file": step(two_rooms), "mesh_size": "6 mm"})
    assert meshed(both).area("cavity") == pytest.approx(2 * 2 * (14 * 6 + 14 * 4 + 6 * 4))


def ball_in_a_rod(occ):
    """A rod of radius 6 mm along x with a room that is a ball: one face, of no corners."""
    occ.cut([(3, occ.addCylinder(0, 0, 0, 30, 0, 0, 6))], [(3, occ.addSphere(12, 0, 0, 4))])


def test_round_faces_have_names_too(step, meshed):
    """By themselves, and from the file: the ball's face has no corner that could be compared."""

    def named(x, y, z):
        return "cavity" if np.isnan(x) else {0: "clamp", 30: "tip"}.get(x, "")

    for names in ({}, {"faces": named}):
        solid = meshed(FromStep.model_validate({"file": step(ball_in_a_rod, **names)}))
        assert solid.area("cavity") == pytest.approx(4 * pi * 4**2, rel=0.05)
        for name, x in (("clamp", 0), ("tip", 30)):
            assert solid.points[solid.surfaces[name], 0] == pytest.approx(x, abs=1e-9)


@pytest.mark.parametrize(
    ("chosen", "wanted"),
    [
        (3, 40 * 14),
        ([2, 4], 2 * 40 * 12),
        ({"plane": {"z": "14 mm"}}, 40 * 14),
        ({"normal": [0, 0, 2]}, 40 * 14 + 32 * 8),  # the roof, and the floor of the room
        ({"normal": [0, 0, 1], "plane": {"z": "14 mm"}}, 40 * 14),
        ({"box": [["3 mm", "-5 mm", "4 mm"], ["37 mm", "5 mm", "6 mm"]]}, 32 * 8),
    ],
)
def test_faces_are_chosen_by_number_and_by_place(chosen, wanted, step, meshed):
    given = {"file": step(), "surfaces": ["felt"], "select": {"felt": chosen}, "mesh_size": "5 mm"}
    assert meshed(FromStep.model_validate(given)).area("felt") == pytest.approx(wanted)


def test_chosen_faces_take_the_place_of_named_ones(step, meshed):
    file = step(faces=step_files.ends_and_room)
    solid = meshed(
        FromStep.model_validate({"file": file, "select": {"tip": 3}, "mesh_size": "5 mm"})
    )
    assert solid.area("tip") == pytest.approx(40 * 14)


SPEC = """
geometry: {{type: from_step, file: {file}, select: {select}}}
materials: {{body: ecoflex-00-30}}
steps: [{{pressure: 1 kPa}}]
"""


@pytest.mark.parametrize(
    ("select", "words"),
    [
        ("{roof: 3}", "select: 'roof' is no surface of this geometry; add it to surfaces"),
        ("{tip: {}}", "selects no face; write numbers, plane, normal, box or beside"),
        ("{tip: {plane: {x: 40}}}", "'40' has no unit"),
        ("{tip: {plane: {w: 40 mm}}}", "'w' is not one of: x, y, z"),
        ("{tip: {normal: [0, 0, 0]}}", "three zeros are no direction"),
        ("{tip: 0}", "select.tip: '0' must be at least 1"),
        ("{tip: {number: 3}}", "select.tip.number: unknown key"),
    ],
)
def test_a_selection_that_makes_no_sense_is_told_with_its_line(select, words, step):
    with pytest.raises(SpecError) as caught:
        loads(SPEC.format(file=step(), select=select))
    assert any(line.startswith("spec:2: geometry") and words in line for line in caught.value.lines)


def test_a_spec_with_selections_reads_back_as_it_is(step):
    select = "{tip: {box: [[1 mm, 2 mm, 3 mm], [4 mm, 5 mm, 6 mm]]}, clamp: 1}"
    loaded = loads(SPEC.format(file=step(), select=select))
    assert loads(loaded.to_yaml()) == loaded


def test_a_selection_without_a_face_says_how_to_find_one(step, tmp_path):
    geometry = FromStep.model_validate({"file": step(), "select": {"tip": 99}})
    with pytest.raises(MeshError, match="tip chooses no face; 'softact validate' lists"):
        make_mesh(geometry, tmp_path / "x.msh")
    said: list[str] = []
    with pytest.raises(MeshError):
        look(geometry, said)
    assert sum(line.startswith("face ") for line in said) == 12


def test_a_surface_that_is_not_found_by_itself_says_what_is(step, tmp_path):
    geometry = FromStep.model_validate({"file": step(), "surfaces": ["felt"]})
    with pytest.raises(MeshError) as caught:
        make_mesh(geometry, tmp_path / "x.msh")
    (line,) = caught.value.lines
    assert "no face has a name, and 'felt' is not among those that are found without" in line
    assert "(cavity, cavity_1, clamp, outer, tip)" in line and "select: {felt: [1, 2]}" in line


def test_a_part_that_lies_across_is_doubted(step, tmp_path):
    """Along y, the ends at the lowest and highest x are its long sides."""

    def across(occ):
        occ.cut([(3, occ.addBox(0, 0, 0, 14, 40, 12))], [(3, occ.addBox(3, 3, 3, 8, 34, 6))])

    said = make_mesh(FromStep.model_validate({"file": step(across)}), tmp_path / "x.msh")
    assert any("longest along y; axis, here x, has to run" in line for line in said)
