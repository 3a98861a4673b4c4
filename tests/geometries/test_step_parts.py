"""STEP files of several solids, in any unit, with and without names."""

import gmsh
import numpy as np
import pytest

from softact.errors import MeshError
from softact.geometries.from_step import FromStep
from softact.geometry.base import make_mesh
from softact.mesh.components import components
from tests import step_files
from tests.step_files import BLOCK_VOLUME, LIKE_THE_BLOCK, WIDE, in_unit

TWO = {"regions": ["rubber", "base"], "mesh_size": "5 mm"}


@pytest.fixture
def two(tmp_path):
    """Function that writes a named block on a plate; returns its path as text."""

    def write(plate=WIDE, solids=("rubber", "base"), change=lambda text: text):
        path = tmp_path / "two.step"
        make = step_files.on_a_plate(plate)
        step_files.write(path, make, step_files.ends_and_room, solids=solids)
        path.write_text(change(path.read_text()))
        return str(path)

    return write


@pytest.fixture
def one(tmp_path):
    """Function that writes the block alone, without names; returns its path as text."""

    def write(make=step_files.bladder, **names):
        return str(step_files.write(tmp_path / "one.step", make, **names))

    return write


def parts(solid) -> int:
    return int(components(solid.points, solid.cells).max()) + 1


def built(geometry) -> dict[str, list[tuple[float, tuple[float, ...]]]]:
    """Group of the geometry -> measure and bounding box of each of its entities, in mm."""
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        geometry.build(gmsh)
        return {
            gmsh.model.getPhysicalName(dimension, group): [
                (gmsh.model.occ.getMass(dimension, tag), gmsh.model.getBoundingBox(dimension, tag))
                for tag in gmsh.model.getEntitiesForPhysicalGroup(dimension, group)
            ]
            for dimension, group in gmsh.model.getPhysicalGroups()
        }
    finally:
        gmsh.finalize()


def refused(geometry, tmp_path) -> str:
    with pytest.raises(MeshError) as caught:
        make_mesh(geometry, tmp_path / "x.msh", 60.0)
    (line,) = caught.value.lines
    return line


@pytest.mark.parametrize("plate", [WIDE, LIKE_THE_BLOCK])
def test_solids_that_touch_are_joined_and_keep_their_names(plate, two, meshed):
    """One part; volumes and areas by hand. A plate that is wider than the block is cut along its
    rim, and one like it shares its whole face: the names stay on the pieces."""
    solid = meshed(FromStep.model_validate({"file": two(plate), **TWO}))
    assert parts(solid) == 1
    assert solid.volumes.sum() == pytest.approx(BLOCK_VOLUME + np.prod(plate[3:]), rel=1e-9)
    assert solid.area("clamp") == pytest.approx(14 * 12 + plate[4] * 2, rel=1e-9)
    assert solid.area("cavity") == pytest.approx(2 * (32 * 8 + 32 * 6 + 8 * 6), rel=1e-9)


def test_solids_stay_apart_where_that_is_wanted(two, meshed, tmp_path):
    geometry = FromStep.model_validate({"file": two(), "separate": True, **TWO})
    assert parts(meshed(geometry)) == 2
    said = make_mesh(geometry, tmp_path / "x.msh")
    assert "part 1 of 2, 'rubber'" in said[1] and "touches another near" in said[1]
    joined = make_mesh(geometry.model_copy(update={"separate": False}), tmp_path / "x.msh")
    assert joined[0].endswith("40 x 18 x 14 mm (the file says mm)")
    assert joined[1] == "solids that touch are joined, over 560 mm^2"
    assert joined[2].startswith("1 part of ")


def test_solids_that_overlap_are_refused(two, tmp_path):
    """A plate of 3 mm reaches 1 mm into the block over 40 x 14 mm."""
    geometry = FromStep.model_validate({"file": two((0, -9, 0, 40, 18, 3)), **TWO})
    line = refused(geometry, tmp_path)
    assert "'rubber' and 'base' overlap by 560 mm^3 near (20, 0, 2.5) mm" in line


def test_a_room_between_two_solids_is_closed_by_joining_them(one, meshed, tmp_path):
    """A block that is open below, on a plate: the walls are five faces of the one and the piece of
    the other that lies under the room. Left apart, the room is open, and that is said."""

    def make(occ):
        occ.cut([(3, occ.addBox(0, -7, 2, 40, 14, 12))], [(3, occ.addBox(4, -4, 2, 32, 8, 9))])
        occ.addBox(*WIDE)

    def names(x, y, z):
        inside = 3.9 < x < 36.1 and -4.1 < y < 4.1 and 2.1 < z < 11.1
        on_top = z == 2 and abs(y) < 1 and 15 < x < 25
        return {0: "clamp", 40: "tip"}.get(x, "cavity" if inside or on_top else "")

    file = one(make, faces=names, solids=("rubber", "base"))
    geometry = FromStep.model_validate({"file": file, **TWO})
    solid = meshed(geometry)
    # The rim on which the block stands has been named with the plate's face, but walls no room.
    assert solid.area("cavity") == pytest.approx(2 * (32 * 8 + 32 * 9 + 8 * 9), rel=1e-9)
    middles, vectors = solid.outward_areas("cavity")
    assert -(middles * vectors).sum() / 3 == pytest.approx(32 * 8 * 9, rel=1e-9)
    line = refused(geometry.model_copy(update={"separate": True}), tmp_path)
    assert "edges are open, one near" in line and line.endswith("leave separate: true out")


def test_the_face_that_is_missing_from_a_room_is_named(one, tmp_path):
    """The room's floor is a face of the plate that nobody named."""

    def make(occ):
        occ.cut([(3, occ.addBox(0, -7, 2, 40, 14, 12))], [(3, occ.addBox(4, -4, 2, 32, 8, 9))])
        occ.addBox(*WIDE)

    def names(x, y, z):
        inside = 3.9 < x < 36.1 and -4.1 < y < 4.1 and 2.1 < z < 11.1
        return {0: "clamp", 40: "tip"}.get(x, "cavity" if inside else "")

    file = one(make, faces=names, solids=("rubber", "base"))
    line = refused(FromStep.model_validate({"file": file, **TWO}), tmp_path)
    assert "the face of 'base' beside it" in line and line.endswith("is none of its walls")


@pytest.mark.parametrize(("unit", "size"), [("mm", 1), ("cm", 10), ("m", 1000), ("in", 25.4)])
def test_the_unit_of_the_file_counts(unit, size, two):
    """Volumes by hand in mm, whatever the header says, and with every other unit in its place."""
    file = two(change=lambda text: in_unit(text, unit))
    wanted = BLOCK_VOLUME + 40 * 18 * 2
    given = {**TWO, "file": file, "mesh_size": f"{5 * size} mm"}
    for scale, more in ((size, {}), (1, {"unit": "mm", "mesh_size": "5 mm"})):
        groups = built(FromStep.model_validate(given | more))
        volume = sum(volume for volume, _ in (*groups["rubber"], *groups["base"]))
        assert volume == pytest.approx(wanted * scale**3, rel=1e-9)


def test_a_part_drawn_in_mm_and_said_to_be_in_m_is_refused_before_it_is_meshed(two, tmp_path):
    geometry = FromStep.model_validate({**TWO, "file": two(change=lambda t: in_unit(t, "m"))})
    line = refused(geometry, tmp_path)
    assert "the part is 40000 x 18000 x 14000 mm" in line
    assert "the file says m: if it was drawn in mm (40 x 18 x 14 mm) write unit: mm" in line


def test_a_part_that_is_smaller_than_its_elements_is_refused(two, tmp_path):
    geometry = FromStep.model_validate({**TWO, "file": two(), "unit": "um"})
    line = refused(geometry, tmp_path)
    assert "0.04 x 0.018 x 0.014 mm, and mesh_size 5 mm is larger than that" in line
    assert "read in um: if it was drawn in mm (40 x 18 x 14 mm) write unit: mm" in line


def test_too_small_a_mesh_size_is_refused_with_one_that_will_do(two, tmp_path):
    """6 V / h^3 = 3e6 at h = 0.23 mm for the 6624 mm^3 of block and plate; surfaces need less."""
    geometry = FromStep.model_validate({**TWO, "file": two(), "mesh_size": "0.1 mm"})
    line = refused(geometry, tmp_path)
    assert "about 4e+07 tetrahedra, and 3e+06 are the most; write mesh_size: 0.24 mm" in line


PLACED = "#16 = CARTESIAN_POINT('',(0.,0.,0.));", "#16 = CARTESIAN_POINT('',(100.,0.,0.));"
TURNED = "#18 = DIRECTION('',(1.,0.,-0.));", "#18 = DIRECTION('',(0.,1.,0.));"
# What places the first part of an assembly and what the second, by the product that they name.
FIRST, SECOND = ("'',#5,#31,$)", "'',#36,#10)"), ("'',#5,#710,$)", "'',#715,#10)")


def replaced(text: str, *pairs: tuple[str, str]) -> str:
    """All old texts by new ones, at once."""
    for number, (old, _) in enumerate(pairs):
        assert old in text
        text = text.replace(old, f"<{number}>")
    for number, (_, new) in enumerate(pairs):
        text = text.replace(f"<{number}>", new)
    return text


def test_parts_of_an_assembly_keep_their_names_where_they_are_placed(two):
    """The block is moved by 100 mm along x and turned by 90 degrees about z."""
    file = two(change=lambda text: replaced(text, PLACED, TURNED))
    groups = built(FromStep.model_validate({"file": file, **TWO}))
    assert groups["rubber"][0][1] == pytest.approx([93, 0, 2, 107, 40, 14], abs=1e-5)
    assert sorted(box[1] for _, box in groups["clamp"]) == pytest.approx([-9, 0], abs=1e-5)


def test_the_order_of_an_assembly_need_not_be_that_of_the_file(two):
    """Plate and block of one shape; the assembly has the second first, and apart from the other."""
    pairs = [*zip(FIRST, SECOND, strict=True), *zip(SECOND, FIRST, strict=True), PLACED]
    file = two((0, -7, 20, 40, 14, 12), change=lambda text: replaced(text, *pairs))
    groups = built(FromStep.model_validate({"file": file, **TWO}))
    assert groups["base"][0][1] == pytest.approx([100, -7, 20, 140, 7, 32], abs=1e-5)
    assert groups["rubber"][0][1] == pytest.approx([0, -7, 2, 40, 7, 14], abs=1e-5)


def test_a_part_that_an_assembly_repeats_is_there_each_time(two):
    """The plate's place is taken by the block once more, 100 mm away."""
    again = "#20 = CARTESIAN_POINT('',(0.,0.,0.));", "#20 = CARTESIAN_POINT('',(100.,0.,0.));"
    pairs = [*zip(SECOND, FIRST, strict=True), again]

    file = two(change=lambda text: replaced(text, *pairs))
    groups = built(FromStep.model_validate({"file": file, **TWO}))
    assert len(groups["rubber"]) == 2
    assert sum(volume for volume, _ in groups["rubber"]) == pytest.approx(2 * BLOCK_VOLUME)


SOLID_NAMES = [
    (["rubber", "plate"], "no solid has the name 'plate'; there are rubber, base"),
    (["rubber"], "the solid 'base' (or solid_2) is in no region; name all solids"),
    (["rubber", "base", "solid_2"], "'base' and 'solid_2' are one solid; name it once"),
]


@pytest.mark.parametrize(("regions", "words"), SOLID_NAMES)
def test_every_solid_is_in_one_region(regions, words, two, tmp_path):
    geometry = FromStep.model_validate({"file": two(), "regions": regions})
    with pytest.raises(MeshError) as caught:
        make_mesh(geometry, tmp_path / "x.msh", 60.0)
    assert any(words in line for line in caught.value.lines)


def test_solids_without_names_go_by_their_number(two):
    """OCC gives products names of its own; a solid has its number beside that."""
    file = two(solids=())
    groups = built(FromStep.model_validate({"file": file, "regions": ["solid_1", "solid_2"]}))
    assert [len(groups[name]) for name in ("solid_1", "solid_2")] == [1, 1]


def test_a_face_whose_name_is_spelt_otherwise_is_meant(two, tmp_path):
    file = two(change=lambda text: text.replace("ADVANCED_FACE('tip'", "ADVANCED_FACE('Tip'"))
    line = refused(FromStep.model_validate({"file": file, **TWO}), tmp_path)
    assert "no face has the name 'tip'; there are Tip, cavity, clamp; did you mean 'Tip'?" in line


def test_names_of_a_file_stay_on_one_line(two, tmp_path):
    r"""A name with a line break (\X\0A), a quote and a slash neither ends a line nor gets into
    the mesh, where nobody asks for it."""
    file = two(change=lambda text: text.replace("ADVANCED_FACE(''", r"ADVANCED_FACE('a/\X\0A" "b'"))
    geometry = FromStep.model_validate({"file": file, **TWO})
    make_mesh(geometry, tmp_path / "x.msh")
    assert b"a/" not in (tmp_path / "x.msh").read_bytes()
    line = refused(geometry.model_copy(update={"surfaces": ("ab",)}), tmp_path)
    assert "there are a/ b, cavity, clamp, tip" in line


def test_a_step_file_that_refers_to_other_files_is_refused(two, tmp_path):
    other = "DATA;\n#99999 = DOCUMENT_FILE('arm.stp','','',#8,'','');"
    file = two(change=lambda text: text.replace("DATA;", other))
    line = refused(FromStep.model_validate({"file": file, **TWO}), tmp_path)
    assert "refers to other files (arm.stp)" in line
