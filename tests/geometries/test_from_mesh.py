"""Meshes of other programs and closed surfaces, with names and without."""

from math import pi
from pathlib import Path

import gmsh
import meshio
import numpy as np
import pytest
from pydantic import ValidationError

from softact.api import run as softact_run
from softact.errors import MeshError
from softact.geometries.from_mesh import FromMesh
from softact.geometry.base import export, make_mesh
from softact.geometry.mesh_files import shells
from softact.spec import load, loads
from tests import step_files
from tests.geometries.looking import looked
from tests.step_files import BLOCK_VOLUME

ROOM_AREA = 2 * (32 * 8 + 32 * 6 + 8 * 6)


def write(path: Path, make=step_files.bladder, dimension: int = 3, size: float = 8.0) -> str:
    """What ``make(occ)`` adds, meshed up to a dimension, in the format of the suffix."""
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        make(gmsh.model.occ)
        gmsh.model.occ.synchronize()
        gmsh.option.setNumber("Mesh.MeshSizeMax", size)
        gmsh.model.mesh.generate(dimension)
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return str(path)


def of(file: str, **given) -> FromMesh:
    return FromMesh.model_validate({"file": file, "mesh_size": "8 mm", **given})


@pytest.fixture(scope="module")
def stl(tmp_path_factory):
    return write(tmp_path_factory.mktemp("stl") / "bladder.stl", dimension=2)


@pytest.fixture(scope="module")
def vtk(tmp_path_factory):
    return write(tmp_path_factory.mktemp("vtk") / "bladder.vtk")


@pytest.mark.parametrize("kind", ["anew", "kept", "vtk"])
def test_a_body_without_names_has_its_ends_its_room_and_its_outside(kind, stl, vtk, meshed):
    file, remesh = (vtk, True) if kind == "vtk" else (stl, kind == "anew")
    geometry = of(file, surfaces=["outer"], remesh=remesh)
    solid = meshed(geometry)
    assert solid.volumes.sum() == pytest.approx(BLOCK_VOLUME, rel=1e-6)
    areas = {name: solid.area(name) for name in solid.surfaces}
    assert areas == pytest.approx(
        {"clamp": 14 * 12, "tip": 14 * 12, "cavity": ROOM_AREA, "outer": 2 * 40 * (14 + 12)},
        rel=1e-6,
    )


@pytest.fixture(scope="module")
def apart(stl, tmp_path_factory):
    """Folder of body.stl and air.stl, as a simulator of rigid and soft bodies has them."""
    points, found = shells([Path(stl)], 1.0)
    folder = tmp_path_factory.mktemp("apart")
    order = sorted(found, key=lambda shell: -np.ptp(points[shell].reshape(-1, 3)[:, 0]))
    for name, shell in zip(("body.stl", "air.stl"), order, strict=True):
        meshio.Mesh(points, [("triangle", shell)]).write(folder / name)
    return folder


def test_the_air_may_be_in_a_file_of_its_own(apart, meshed):
    text = """
geometry: {type: from_mesh, file: body.stl, air: [air.stl], mesh_size: 8 mm}
materials: {body: ecoflex-00-30}
steps: [{name: inflate, pressure: 1 kPa}]
"""
    (apart / "spec.yaml").write_text(text, encoding="utf-8")
    geometry = load(apart / "spec.yaml").geometry
    assert geometry.air == (str(apart / "air.stl"),)
    solid = meshed(geometry)
    assert solid.volumes.sum() == pytest.approx(BLOCK_VOLUME, rel=1e-6)
    assert solid.area("cavity") == pytest.approx(ROOM_AREA, rel=1e-6)
    other = geometry.model_copy(update={"air": (str(apart / "body.stl"),)})
    assert other.content() != geometry.content()  # a run that is kept is not this one's


@pytest.mark.parametrize(
    ("file", "air", "words"),
    [
        ("body.stl", "none.stl", "there is no file"),
        ("body.stl", "spec.yaml", "'spec.yaml' is none of .stl, .ply, .off"),
        ("body.vtk", "air.stl", "body.vtk holds tetrahedra: its rooms are those left free"),
    ],
)
def test_air_that_cannot_be_is_refused(apart, vtk, file, air, words):
    (apart / "body.vtk").write_bytes(Path(vtk).read_bytes())
    with pytest.raises(ValidationError, match=words):
        of(str(apart / file), air=[str(apart / air)])


def test_surfaces_are_meshed_anew_with_the_mesh_size(stl, tmp_path):
    counts = []
    for size in ("12 mm", "3 mm"):
        make_mesh(of(stl, mesh_size=size), tmp_path / "m.msh")
        cells = meshio.read(tmp_path / "m.msh").cells_dict["tetra"]
        counts.append(len(cells))
    # Walls of 3 mm: more triangles on them, and more tetrahedra through them. Sid's gmsh makes more
    # large ones than that of Debian 12.
    assert counts[1] > 2.5 * counts[0]


def test_rooms_of_round_bodies_are_found_one_by_one(tmp_path, meshed):
    def rooms(occ):
        balls = [(3, occ.addSphere(x, 0, 0, 4)) for x in (10, 30)]
        occ.cut([(3, occ.addBox(0, -6, -6, 40, 12, 12))], balls)

    file = write(tmp_path / "balls.stl", rooms, dimension=2, size=1.5)
    cavities = {"near": ["cavity_1"], "far": ["cavity_2"]}
    solid = meshed(of(file, cavities=cavities, mesh_size="2 mm"))
    for name, x in (("cavity_1", 10), ("cavity_2", 30)):
        middles, areas = solid.outward_areas(name)
        assert middles.mean(axis=0) == pytest.approx([x, 0, 0], abs=0.5)
        assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(4 * pi * 4**2, rel=0.07)
        assert (np.einsum("ij,ij->i", areas, middles - [x, 0, 0]) < 0).all()  # into the room


def test_names_of_groups_come_along(tmp_path, meshed):
    spec = loads(
        "geometry: {type: pneunet, chambers: 1, chamber_length: 7 mm, mesh_size: 8 mm}\n"
        "materials: {body: ecoflex-00-30}\nsteps: [{pressure: 1 kPa}]"
    )
    export(spec.geometry, tmp_path / "finger.vtu")
    export(spec.geometry, tmp_path / "finger.msh")
    expected = meshed(spec.geometry)
    for suffix in (".vtu", ".msh"):
        geometry = of(str(tmp_path / f"finger{suffix}"), symmetry={"y": "symmetry"})
        solid = meshed(geometry)
        assert len(solid.cells) == len(expected.cells)
        for name in ("clamp", "tip", "cavity", "symmetry"):
            assert solid.area(name) == pytest.approx(expected.area(name)), (suffix, name)


def test_two_bodies_in_a_file_are_two_solids_and_units_count(tmp_path, meshed):
    def two(occ):
        occ.addBox(0, 0, 0, 1, 1, 1)
        occ.addBox(2, 0, 0, 2, 1, 1)

    file = write(tmp_path / "two.vtk", two, size=1.0)
    geometry = of(file, regions=["solid_1", "solid_2"], cavities={}, unit="cm", tip="end",
                  select={"end": {"plane": {"x": "40 mm"}, "normal": [1, 0, 0]}})  # fmt: skip
    solid = meshed(geometry)
    assert solid.volumes.sum() == pytest.approx(3 * 10**3)
    assert solid.area("end") == pytest.approx(10**2)
    said = looked(geometry)
    assert any("part 1 of 2, 'solid_1'" in text for text in said)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"select": {"roof": {"numbers": [1]}}, "surfaces": ["roof"]}, "a mesh has no faces"),
        ({"select": {"roof": {"plane": {"z": "1 mm"}}}}, "is no surface of this geometry"),
    ],
)
def test_wrong_selections_are_told(given, words, vtk):
    with pytest.raises(ValidationError, match=words):
        of(vtk, **given)


def test_what_cannot_be_a_solid_is_told(tmp_path, stl, vtk):
    mesh = meshio.read(stl)
    meshio.Mesh(mesh.points, [("triangle", mesh.cells[0].data[1:])]).write(tmp_path / "open.stl")
    with pytest.raises(MeshError, match="is not watertight: 3 edges"):
        shells([tmp_path / "open.stl"], 1.0)
    cube = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    meshio.Mesh(cube, [("hexahedron", [[0, 1, 3, 2, 4, 5, 7, 6]])]).write(tmp_path / "hex.vtk")
    (tmp_path / "odd.vtu").write_text("no mesh")
    meshio.Mesh(mesh.points, mesh.cells).write(tmp_path / "skin.vtk")
    for name, words in (
        ("hex.vtk", "cells of another kind"),
        ("odd.vtu", "cannot be read as a mesh"),
        ("skin.vtk", "holds no tetrahedra"),
    ):
        with pytest.raises(MeshError, match=words):
            make_mesh(of(str(tmp_path / name)), tmp_path / "out.msh")
    with pytest.raises(MeshError, match=r"select\.roof chooses no triangle"):
        select = {"roof": {"plane": {"z": "99 mm"}}}
        make_mesh(of(vtk, select=select, surfaces=["roof"]), tmp_path / "out.msh")


# The columns of a matrix are where x, y and z of the file are turned to.
TURNED = {
    "-x": np.diag([-1.0, -1.0, 1.0]),
    "y": np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
    "z": np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
}
PRESSED = """
geometry: {{type: from_mesh, file: {file}, axis: {axis}, mesh_size: 8 mm}}
materials: {{body: {{law: neo_hookean, c10: 0.1 MPa}}}}
steps: [{{name: inflate, pressure: 30 kPa}}]
solver: {{initial_increment: 1, max_increment: 1}}
measures: [bending, elongation, twist, volume]
"""


@pytest.fixture(scope="module")
def pressed(vtk, tmp_path_factory):
    """Function from an axis to the measures of the same mesh, turned that way, under pressure."""
    known = {}

    def of_axis(axis: str):
        if axis not in known:
            folder, mesh = tmp_path_factory.mktemp("turned"), meshio.read(vtk)
            turn = TURNED.get(axis, np.eye(3))
            mesh.points[:, 2] += 0.02 * mesh.points[:, 2] ** 2  # so that it bends
            cells = [("tetra", mesh.cells_dict["tetra"])]
            meshio.Mesh(mesh.points @ turn.T, cells).write(folder / "part.vtk")
            spec = loads(PRESSED.format(file=folder / "part.vtk", axis=axis))
            known[axis] = softact_run(spec, folder / "run", report=False).summary
        return known[axis]

    return of_axis


@pytest.mark.parametrize("axis", TURNED)
def test_a_part_that_points_another_way_measures_the_same(axis, pressed):
    straight, turned = pressed("x"), pressed(axis)
    assert straight["elongation_mm"] > 0.08 and abs(straight["bending_angle_deg"]) > 0.1
    for column in ("elongation_mm", "twist_angle_deg", "cavity_volume_mm3"):
        assert turned[column] == pytest.approx(straight[column], rel=1e-6, abs=1e-6)
    for column in ("bending_angle_deg", "chord_angle_deg"):  # their sign is the axis's
        assert abs(turned[column]) == pytest.approx(abs(straight[column]), rel=1e-5, abs=1e-6)


def test_a_tip_behind_the_clamp_is_refused(vtk, tmp_path):
    ends = {"clamp": {"plane": {"x": "40 mm"}}, "tip": {"plane": {"x": "0 mm"}}}
    with pytest.raises(MeshError, match=r"'tip' lies behind 'clamp' along x, .*; write axis: -x"):
        make_mesh(of(vtk, select=ends), tmp_path / "m.msh")
    make_mesh(of(vtk, select=ends, axis="-x"), tmp_path / "m.msh")
