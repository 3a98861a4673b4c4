"""Finished meshes of the user's: read as data, of any order, joined where their solids touch."""

from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest

from softact.errors import MeshError
from softact.geometries.from_script import FromScript
from softact.geometry.base import look, make_mesh
from softact.mesh.components import components

BOXES = {"regions": ["left", "right"], "cavities": {}, "mesh_size": "4 mm"}
HEADER = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"


@pytest.fixture
def mesh(tmp_path):
    """Function that writes a .msh of what ``make(gmsh)`` does; returns its path as text."""

    def write(make, size=4.0, order=1, version=4.1, name="part.msh"):
        gmsh.initialize(readConfigFiles=False)
        try:
            for option, value in (
                ("General.Terminal", 0), ("Mesh.MeshSizeMax", size), ("Mesh.ElementOrder", order),
                ("Mesh.MeshSizeFromPoints", 0), ("Mesh.MshFileVersion", version),
            ):  # fmt: skip
                gmsh.option.setNumber(option, value)
            make()
            gmsh.write(str(tmp_path / name))
        finally:
            gmsh.finalize()
        return str(tmp_path / name)

    return write


def group(dimension: int, tags, name: str) -> None:
    gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, tags), name)


def ends(lower: float, upper: float) -> None:
    """Groups clamp and tip of the faces at two x."""
    for name, x in (("clamp", lower), ("tip", upper)):
        found = gmsh.model.getEntitiesInBoundingBox(x - 1e-3, -99, -99, x + 1e-3, 99, 99, 2)
        group(2, [tag for _, tag in found], name)


def two_boxes(gap: float = 0.0, right=(10, 10, 10), fine: bool = False):
    """Two boxes of 10 mm side by side along x, each meshed by itself."""

    def make():
        occ = gmsh.model.occ
        left = occ.addBox(0, 0, 0, 10, 10, 10)
        other = occ.addBox(10 + gap, 0, 0, *right)
        occ.synchronize()
        group(3, [left], "left")
        group(3, [other], "right")
        ends(0, 10 + gap + right[0])
        if fine:  # the right one's edges are cut into other pieces than the left one's
            for _, edge in gmsh.model.getBoundary([(3, other)], recursive=False, oriented=False):
                for _, line in gmsh.model.getBoundary([(2, edge)], oriented=False):
                    gmsh.model.mesh.setTransfiniteCurve(abs(line), 7)
        gmsh.model.mesh.generate(3)

    return make


def parts(solid) -> int:
    return int(components(solid.points, solid.cells).max()) + 1


def refused(geometry, tmp_path) -> str:
    with pytest.raises(MeshError) as caught:
        make_mesh(geometry, tmp_path / "x.msh", 60.0)
    (line,) = caught.value.lines
    return line


def matching(gap: float):
    """Two boxes of one cut each, whose triangles lie on each other up to the gap."""

    def make():
        occ, mesh = gmsh.model.occ, gmsh.model.mesh
        left = occ.addBox(0, 0, 0, 10, 10, 10)
        right = occ.copy([(3, left)])
        occ.mirror(right, 1, 0, 0, -10 - gap / 2)
        occ.synchronize()
        for _, line in gmsh.model.getEntities(1):
            mesh.setTransfiniteCurve(line, 4)
        for _, face in gmsh.model.getEntities(2):
            mesh.setTransfiniteSurface(face)
        group(3, [left], "left")
        group(3, [right[0][1]], "right")
        ends(0, 20 + gap)
        mesh.generate(3)

    return make


def test_matching_faces_of_two_solids_become_one(mesh, meshed, tmp_path):
    """Two parts in the file; one, of the same volume, after it is read: 16 nodes are common."""
    file = mesh(matching(0.0))
    apart = meshed(FromScript.model_validate({"file": file, "separate": True, **BOXES}))
    solid = meshed(FromScript.model_validate({"file": file, **BOXES}))
    assert (parts(apart), parts(solid)) == (2, 1)
    assert len(apart.points) - len(solid.points) == 16
    assert solid.volumes.sum() == pytest.approx(2000, rel=1e-12)
    said = make_mesh(FromScript.model_validate({"file": file, **BOXES}), tmp_path / "x.msh")
    assert said[0] == "solids of the mesh touch over 100 mm^2 and are joined there"


def test_solids_with_a_gap_are_two_parts_and_it_is_said_how_wide_it_is(mesh, tmp_path):
    geometry = FromScript.model_validate({"file": mesh(matching(0.5)), **BOXES})
    first, second = make_mesh(geometry, tmp_path / "x.msh")
    assert first.startswith("part 1 of 2, 'left', ")
    assert "is joined to no other, the next is 0.5 mm away at (10" in first
    assert second.startswith("part 2 of 2, 'right', ")


def test_solids_whose_triangles_differ_where_they_touch_are_refused(mesh, tmp_path):
    geometry = FromScript.model_validate({"file": mesh(two_boxes(fine=True)), **BOXES})
    line = refused(geometry, tmp_path)
    assert "'left' and 'right' touch near (10, " in line
    assert "their triangles there differ" in line and "separate: true" in line
    apart = geometry.model_copy(update={"separate": True})
    assert "touches another near" in make_mesh(apart, tmp_path / "x.msh")[0]


def test_what_is_wrong_with_a_mesh_is_seen_before_a_run(mesh):
    """Its ends are no room: four edges times two."""
    given = {**BOXES, "cavities": {"air": ["clamp", "tip"]}, "file": mesh(matching(0.0))}
    said: list[str] = []
    with pytest.raises(
        MeshError, match="walls of the cavity 'air' do not close: 24 edges are open"
    ):
        look(FromScript.model_validate(given), said)
    assert said == [
        "solids of the mesh touch over 100 mm^2 and are joined there",
        f"1 part of {said[1].split()[3]} tetrahedra",
    ]


def sphere():
    occ = gmsh.model.occ
    occ.addSphere(0, 0, 0, 10)
    occ.addBox(0, -20, -20, 20, 40, 40)
    occ.cut([(3, 1)], [(3, 2)])
    occ.synchronize()
    group(3, [1], "body")
    for _, tag in gmsh.model.getEntities(2):
        group(2, [tag], "clamp" if gmsh.model.getType(2, tag) == "Plane" else "tip")
    gmsh.model.mesh.generate(3)


@pytest.mark.parametrize("version", [2.2, 4.0, 4.1])
def test_a_mesh_of_second_order_is_read_by_its_corners(version, mesh, meshed, tmp_path):
    """The corners of a mesh of first and of second order are the same; nodes on the sphere's edges
    of 4 mm lie h^2/8R = 0.2 mm off them, which is said. A box has nothing to say."""
    given = {"cavities": {}, "mesh_size": "4 mm", "axis": "-x"}
    first = FromScript.model_validate({"file": mesh(sphere, name="first.msh"), **given})
    second = FromScript.model_validate(
        {"file": mesh(sphere, order=2, version=version, name="second.msh"), **given}
    )
    one, other = meshed(first), meshed(second)
    assert len(one.cells) == len(other.cells)
    assert other.volumes.sum() == pytest.approx(one.volumes.sum(), rel=1e-9)
    said = make_mesh(second, tmp_path / "x.msh")[0]
    off = float(said.split("up to ")[1].split()[0])
    assert "tetrahedra have curved edges" in said and 0.1 < off < 0.4
    flat = {**BOXES, "file": mesh(two_boxes(2.0), order=2, version=version)}
    assert not any("curved" in line for line in make_mesh(FromScript.model_validate(flat),
                                                          tmp_path / "x.msh"))  # fmt: skip


def test_a_mesh_of_hexahedra_is_refused_by_what_it_is(mesh, tmp_path):
    def bricks():
        matching(0.0)()
        gmsh.model.mesh.clear()
        for _, face in gmsh.model.getEntities(2):
            gmsh.model.mesh.setRecombine(2, face)
        for _, solid in gmsh.model.getEntities(3):
            gmsh.model.mesh.setTransfiniteVolume(solid)
        gmsh.model.mesh.generate(3)

    line = refused(FromScript.model_validate({"file": mesh(bricks), **BOXES}), tmp_path)
    assert "has elements of another kind (" in line and "write a mesh of " in line


def test_the_unit_of_a_mesh_is_that_of_the_spec(mesh, meshed, tmp_path):
    """gmsh's format has no unit: 20 x 10 x 10 are mm, or 25.4 times that."""
    file = mesh(matching(0.0))
    inches = meshed(FromScript.model_validate({"file": file, "unit": "in", **BOXES}))
    assert inches.volumes.sum() == pytest.approx(2000 * 25.4**3, rel=1e-12)
    said = make_mesh(FromScript.model_validate({"file": file, "unit": "m", **BOXES}),
                     tmp_path / "x.msh")  # fmt: skip
    assert "20000 x 10000 x 10000 mm, an unlikely size" in said[0]
    assert "if it was drawn in mm (20 x 10 x 10 mm) write unit: mm" in said[0]


def test_a_tetrahedron_that_is_there_twice_is_refused(mesh, tmp_path):
    path = Path(mesh(matching(0.0), version=2.2))
    lines = path.read_text().splitlines()
    at = lines.index("$Elements") + 1
    last = lines.index("$EndElements")
    tag, rest = lines[last - 1].split(" ", 1)
    lines.insert(last, f"{int(tag) + 1} {rest}")
    lines[at] = str(int(lines[at]) + 1)
    path.write_text("\n".join(lines) + "\n")
    line = refused(FromScript.model_validate({"file": str(path), **BOXES}), tmp_path)
    assert "1 tetrahedra are there more than once, one near (" in line


def test_names_that_nobody_asks_for_stay_out_of_the_mesh(mesh, tmp_path):
    def make():
        matching(0.0)()
        group(2, [3], "a/b c")

    geometry = FromScript.model_validate({"file": mesh(make), **BOXES})
    make_mesh(geometry, tmp_path / "x.msh")
    assert set(meshio.read(tmp_path / "x.msh").field_data) == {"left", "right", "clamp", "tip"}


@pytest.mark.parametrize("name", ['bo"dy', "two\nlines"])
def test_a_name_with_a_quote_or_a_line_break_is_told_with_its_line(name, mesh, tmp_path):
    def make():
        matching(0.0)()
        group(2, [3], name)

    line = refused(FromScript.model_validate({"file": mesh(make), **BOXES}), tmp_path)
    assert "part.msh:" in line and "a name has neither quotes nor line breaks" in line


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("part.msh", 'SystemCall "touch {mark}";\n'),
        ("part.MSH", 'SystemCall "touch {mark}";\n'),
        ("part.msh", HEADER + 'SystemCall "touch {mark}";\n'),
        ("part.msh", "$Comments\n$EndComments\n" + 'SystemCall "touch {mark}";\n'),
        ("part.msh.opt", 'SystemCall "touch {mark}";\n'),
        ("part.step", 'SystemCall "touch {mark}";\n'),
        ("part.stp", "ISO-10303-21;\nDATA;\n" + 'SystemCall "touch {mark}";\n'),
        ("part.step.opt", 'SystemCall "touch {mark}";\n'),
    ],
)
def test_what_looks_like_data_is_never_run(name, content, mesh, tmp_path):
    """gmsh runs a .msh without a header as a script, and whatever lies beside it as .opt."""
    from softact.geometries.from_step import FromStep

    mark = tmp_path / "mark"
    file = mesh(matching(0.0)) if name == "part.msh.opt" else str(tmp_path / name)
    (tmp_path / name).write_text(content.format(mark=mark))
    if name == "part.step.opt":
        from tests import step_files

        file = str(step_files.write(tmp_path / "part.step", step_files.bladder))
    file = file.removesuffix(".opt")
    if ".st" in name:
        geometry = FromStep.model_validate({"file": file})
    else:
        geometry = FromScript.model_validate({"file": file, **BOXES})
    if name.endswith(".opt"):
        make_mesh(geometry, tmp_path / "x.msh")
    else:
        refused(geometry, tmp_path)
    assert not mark.exists()


def test_a_mesh_that_is_a_script_is_named_as_such(tmp_path):
    file = tmp_path / "part.msh"
    file.write_text("Point(1) = {0, 0, 0, 1};\n")
    line = refused(FromScript.model_validate({"file": str(file), **BOXES}), tmp_path)
    assert "part.msh is no mesh: it does not begin with $MeshFormat" in line
    assert "named .geo" in line


def test_damaged_meshes_end_in_one_line(mesh, tmp_path):
    """Cut anywhere, or with other bytes: refused, or read."""
    whole = Path(mesh(matching(0.0))).read_bytes()
    random = np.random.default_rng(0)
    for number in range(6):
        data = bytearray(whole[: len(whole) * (number + 3) // 10])
        for at in random.integers(0, len(data), 20):
            data[at] = random.integers(32, 127)
        (tmp_path / "part.msh").write_bytes(data)
        geometry = FromScript.model_validate({"file": str(tmp_path / "part.msh"), **BOXES})
        with pytest.raises(MeshError) as caught:
            make_mesh(geometry, tmp_path / "x.msh", 60.0)
        assert all(len(line.splitlines()) == 1 for line in caught.value.lines)
