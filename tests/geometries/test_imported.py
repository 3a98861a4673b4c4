"""Solids out of the user's own files: names, meshes, and one clear error for each fault."""

import re

import gmsh
import numpy as np
import pytest
from pydantic import ValidationError

from softact import spec as specs
from softact.errors import MeshError, SpecError
from softact.geometries.from_script import FromScript
from softact.geometries.from_step import FromStep
from softact.geometry.base import make_mesh
from softact.geometry.step_names import StepFile

# A block 30 x 12 x 10 mm with a room of 24 x 6 x 4 mm, its named parts found by where they are.
POUCH = """
def build(gmsh):
    occ = gmsh.model.occ
    outer, inner = occ.addBox(0, 0, 0, 30, 12, 10), occ.addBox(3, 3, 3, 24, 6, 4)
    occ.cut([(3, outer)], [(3, inner)])
    occ.synchronize()
    groups = {}
    for _, tag in gmsh.model.getEntities(2):
        groups.setdefault(name(*occ.getCenterOfMass(2, tag)), []).append(tag)
    for label, tags in groups.items():
        gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, tags), label)
    solids = [tag for _, tag in gmsh.model.getEntities(3)]
    gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, solids), "body")


def name(x, y, z):
    if x < 1e-6 or x > 30 - 1e-6:
        return "clamp" if x < 15 else "tip"
    inside = 2.9 < x < 27.1 and 2.9 < y < 9.1 and 2.9 < z < 7.1
    return "cavity" if inside else "outer"
"""
VOLUME, ROOM = 30 * 12 * 10 - 24 * 6 * 4, 24 * 6 * 4


def names(x, y, z):
    scope = {}
    exec(POUCH, scope)
    return scope["name"](x, y, z)


@pytest.fixture
def script(tmp_path):
    """Function that writes the script with pieces replaced; returns its path as text."""

    def write(*replace, suffix=".py"):
        text = POUCH
        for old, new in replace:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / f"pouch{suffix}"
        path.write_text(text)
        return str(path)

    return write


@pytest.fixture
def step(tmp_path):
    """Function that writes a STEP file as a CAD program would, faces named by where they are."""

    def write(named=True, shell_only=False):
        gmsh.initialize(readConfigFiles=False)
        gmsh.option.setNumber("General.Terminal", 0)
        occ = gmsh.model.occ
        occ.cut([(3, occ.addBox(0, 0, 0, 30, 12, 10))], [(3, occ.addBox(3, 3, 3, 24, 6, 4))])
        occ.synchronize()
        faces = [tag for _, tag in gmsh.model.getEntities(2)]
        if shell_only:
            occ.remove([(3, 1)])
            occ.remove([(2, faces[0])])
            occ.synchronize()
        path = tmp_path / "pouch.step"
        gmsh.write(str(path))
        gmsh.finalize()
        text = path.read_text()
        path.write_text(with_names(text) if named else text)
        return str(path)

    return write


def with_names(text):
    """The text with each face's name written into it, after the middle of its corners."""
    file = StepFile(text)
    for number in file.kinds("ADVANCED_FACE"):
        corners = [file._place(corner) for corner in file._corners(number)]
        label = names(*np.mean(corners, axis=0))
        text = re.sub(rf"(#{number}\s*=\s*ADVANCED_FACE\(')", rf"\g<1>{label}", text)
    return text


def areas(solid):
    return {
        name: np.linalg.norm(solid.outward_areas(name)[1], axis=1).sum() for name in solid.surfaces
    }


WANTED = {
    "clamp": 120,
    "tip": 120,
    "cavity": 2 * (24 * 6 + 24 * 4 + 6 * 4),
    "outer": 2 * 30 * (12 + 10),
}


@pytest.mark.parametrize("kind", [FromScript, FromStep])
def test_names_of_the_file_are_those_of_the_mesh(kind, script, step, meshed):
    """Areas of all named surfaces and the volumes by hand, from a script and from STEP names."""
    file = script() if kind is FromScript else step()
    solid = meshed(kind.model_validate({"file": file, "surfaces": ["outer"], "mesh_size": "4 mm"}))
    assert solid.volumes.sum() == pytest.approx(VOLUME, rel=1e-9)
    assert areas(solid) == pytest.approx(WANTED, rel=1e-9)
    middles, vectors = solid.outward_areas("cavity")
    assert -(middles * vectors).sum() / 3 == pytest.approx(ROOM, rel=1e-9)


def refused(geometry, meshed) -> str:
    with pytest.raises(MeshError) as caught:
        meshed(geometry)
    (line,) = caught.value.lines
    return line


@pytest.mark.parametrize(
    ("change", "given", "words"),
    [
        (("def build(", "def make("), {}, "pouch.py has no function build(gmsh)"),
        (('"clamp" if', '"root" if'), {}, "surface group 'clamp'; there are cavity, outer, root"),
        (('"body")', '"core")'), {}, "volume group 'body'; there are core"),
        (('"body")', '"core")'), {"regions": ["core", "skin"]}, "group 'skin'; there are core"),
        (("27.1 and", "27.1 and z < 6.9 and"), {}, "the walls of the cavity 'cavity' do not close"),
        (("    occ.synchronize()", "    1 / 0"), {}, "ZeroDivisionError"),
        (
            ("    occ.synchronize()", "    occ.remove(occ.getEntities(3))\n    occ.synchronize()"),
            {},
            "not watertight",
        ),
    ],
)
def test_faults_of_a_script(change, given, words, script, meshed):
    file = script(change)
    assert words in refused(FromScript.model_validate({"file": file, **given}), meshed)


def test_a_step_file_that_is_not_watertight(step, meshed):
    file = step(named=False, shell_only=True)
    assert "not watertight" in refused(FromStep.model_validate({"file": file}), meshed)


def test_a_script_is_run_whatever_the_case_of_its_suffix(script, meshed):
    geometry = {"file": script(suffix=".PY"), "surfaces": ["outer"], "mesh_size": "4 mm"}
    assert meshed(FromScript.model_validate(geometry)).volumes.sum() == pytest.approx(VOLUME)


def test_the_file_is_looked_for_beside_the_spec(script, tmp_path):
    script()
    spec = tmp_path / "pouch.yaml"
    spec.write_text(
        "geometry: {type: from_script, file: pouch.py}\n"
        "materials: {body: ecoflex-00-30}\nsteps: [{pressure: 1 kPa}]\n"
    )
    loaded = specs.load(spec)
    assert loaded.geometry.file == str(tmp_path / "pouch.py")
    before = loaded.hash
    script(("24, 6, 4", "24, 6, 3"))
    assert specs.load(spec).hash != before  # the file's content counts, not its name
    for name, words in (("other.py", "there is no file"), ("pouch.txt", "is none of .py, .geo")):
        spec.write_text(spec.read_text().replace("pouch.py", name))
        with pytest.raises(SpecError, match=words):
            specs.load(spec)
        spec.write_text(spec.read_text().replace(name, "pouch.py"))


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("a/b", "holds /"),
        ("a\\b", "holds \\"),
        ("a'b", "holds '"),
        ('a"b', 'holds "'),
        ("<region>", "holds < >"),
        ("a\nb", "holds a line break"),
        ("a\x1b[2J", "holds a line break or another character that cannot be printed"),
        (" a", "begins or ends with a blank"),
        ("..", "means a folder"),
        (" ", "is empty"),
        ("a" * 101, "is longer than 100 characters"),
    ],
)
def test_a_name_that_no_file_can_hold_is_refused_before_anything_is_meshed(tmp_path, name, why):
    """gmsh ends a name at a quote, HDF5 begins a group at a slash: after hours of solving."""
    (tmp_path / "pouch.py").write_text(POUCH)
    places = {
        "regions": [name], "surfaces": [name], "cavities": {name: [name]}, "clamp": name,
        "tip": name, "symmetry": {"y": name},
    }  # fmt: skip
    for key, value in places.items():
        with pytest.raises(ValidationError) as caught:
            FromScript(file=str(tmp_path / "pouch.py"), **{key: value})
        for fault in caught.value.errors():
            assert fault["loc"][0] == key
            assert why in fault["msg"]
            assert fault["msg"].isprintable()


@pytest.mark.parametrize("name", ["a.b", "Körper 1", "=1+1", "a,b", "a:b", "{x}", "%s", "Part[2]"])
def test_other_names_are_meshed(tmp_path, meshed, name):
    text = POUCH.replace('"outer"', repr(name))
    (tmp_path / "pouch.py").write_text(text, encoding="utf-8")
    given = {"file": str(tmp_path / "pouch.py"), "surfaces": [name], "mesh_size": "6 mm"}
    assert len(meshed(FromScript.model_validate(given)).surfaces[name])


# What a script may do beside naming its parts: leave gmsh to mesh, say sizes itself, mesh itself.
WAYS = {
    "sizes by mesh_size": [],
    "a callback for sizes": [
        ("solids = [", "gmsh.model.mesh.setSizeCallback(lambda *a: 5.0)\n    solids = [")
    ],
    "a mesh of its own": [
        ('solids), "body")\n', 'solids), "body")\n    gmsh.model.mesh.generate(3)\n')
    ],
}


@pytest.mark.parametrize("way", [*WAYS, "step"])
def test_an_imported_solid_is_refined_through_its_walls(way, script, step, meshed):
    """The walls of 3 mm have one element in a mesh of 5 mm; refined by two there are eight of
    each, whoever says how long its edges are, and the named parts are the same."""
    kind = FromStep if way == "step" else FromScript
    given = {"file": step() if way == "step" else script(*WAYS[way]), "surfaces": ["outer"]}
    counts = []
    for times in range(2):
        mesh = {"mesh_size": f"{5 / 2**times} mm", "through_wall": 2**times}
        solid = meshed(kind.model_validate(given | mesh))
        assert solid.volumes.min() > 0
        assert areas(solid) == pytest.approx(WANTED, rel=1e-9)
        assert solid.volumes.sum() == pytest.approx(VOLUME, rel=1e-9)
        counts.append(len(solid.cells))
    assert counts[1] == 8 * counts[0]


def test_a_mesh_of_the_users_is_refined_too(script, tmp_path, meshed):
    """A finished mesh has its elements cut; its mesh_size changes nothing."""
    file = script(*WAYS["a mesh of its own"])
    make_mesh(FromScript.model_validate({"file": file, "mesh_size": "5 mm"}), tmp_path / "own.msh")
    given = {"file": str(tmp_path / "own.msh")}
    counts = [
        len(meshed(FromScript.model_validate(given | mesh)).cells)
        for mesh in ({}, {"mesh_size": "1 mm"}, {"through_wall": 3})
    ]
    assert counts == [counts[0], counts[0], 27 * counts[0]]


def walls_in(notes):
    """Those of the notes on a mesh that are about walls."""
    return [note for note in notes if "walls" in note]


def test_a_thin_wall_of_an_imported_solid_is_told(step, tmp_path):
    """All walls are 3 mm thick. Nobody knows before there is a mesh."""
    geometry = FromStep.model_validate({"file": step(), "mesh_size": "5 mm"})
    assert geometry.walls() is None
    (said,) = walls_in(make_mesh(geometry, tmp_path / "solid.msh"))
    assert re.match(r"one element through \d+% of the walls of 'cavity' \(3 mm thick\): ", said)
    finer = geometry.model_copy(update={"through_wall": 2})
    assert walls_in(make_mesh(finer, tmp_path / "solid.msh")) == []
