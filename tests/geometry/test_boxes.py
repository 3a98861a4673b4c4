"""The grid mesh of boxes on solids that no geometry has: two regions, two cavities, odd grids."""

import itertools

import numpy as np
import pytest

from softact.geometry.boxes import OUTSIDE, Box, Boxes, Plane
from softact.mesh.cells import upright


def volumes(points, tets):
    x = points[tets]
    return np.linalg.det(x[:, 1:] - x[:, :1]) / 6


def faces_of(tets):
    faces = itertools.chain.from_iterable(itertools.combinations(sorted(t), 3) for t in tets)
    return list(faces)


TWO_STOREYS = Boxes(
    boxes=(
        Box("lower", (0, 0, 0), (9, 6, 3)),
        Box("upper", (0, 0, 3), (9, 6, 8)),
        Box("left", (1, 1, 1), (4, 5, 6)),
        Box("right", (5, 1, 4), (8, 5, 6)),
        Box(OUTSIDE, (4, 0, 7), (5, 6, 8)),
    ),
    regions=("lower", "upper"),
    cavities=("left", "right"),
    sheets=(Box("film", (0, 0, 0.5), (9, 6, 0.5)),),
    planes=(Plane("clamp", 0, 0.0), Plane("floor", 2, 0.0, outer=True)),
)


@pytest.fixture(scope="module")
def mesh():
    return TWO_STOREYS.mesh(1.7, 1.3)


def test_regions_have_their_volumes(mesh):
    lower = 9 * 6 * 3 - 3 * 4 * 2
    upper = 9 * 6 * 5 - 3 * 4 * 3 - 3 * 4 * 2 - 1 * 6 * 1
    for number, wanted in enumerate((lower, upper)):
        tets = upright(mesh.points(), mesh.tetrahedra(number))
        found = volumes(mesh.points(), tets)
        assert found.min() > 0 and found.sum() == pytest.approx(wanted, rel=1e-12)


def test_cells_fit_to_each_other(mesh):
    """No edge of a tetrahedron crosses a neighbour's: each face is on the skin or shared."""
    tets = np.vstack([mesh.tetrahedra(0), mesh.tetrahedra(1)]).tolist()
    faces, count = np.unique(faces_of(tets), axis=0, return_counts=True)
    assert count.max() == 2
    skin = {tuple(face) for face in faces[count == 1].tolist()}
    named = {
        tuple(sorted(triangle))
        for names, triangles in mesh.triangles()
        if "film" not in names
        for triangle in triangles.tolist()
    }
    assert named == skin


def test_walls_of_each_cavity_are_its_own(mesh):
    """Area of a box 3 x 4 x 5 and of one 3 x 4 x 2."""
    areas = {}
    for names, triangles in mesh.triangles():
        x = mesh.points()[triangles]
        area = np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum() / 2
        for name in names:
            areas[name] = areas.get(name, 0) + area
    assert areas["left"] == pytest.approx(2 * (3 * 4 + 3 * 5 + 4 * 5))
    assert areas["right"] == pytest.approx(2 * (3 * 4 + 3 * 2 + 4 * 2))
    assert areas["clamp"] == pytest.approx(6 * 8)
    assert areas["floor"] == pytest.approx(9 * 6)
    assert areas["film"] == pytest.approx(9 * 6)
    skin = 2 * (9 * 6 + 9 * 8 + 6 * 8) + 2 * 6 - 2 * 1  # the notch: two flanks more, two ends less
    assert areas["outer"] == pytest.approx(skin - 6 * 8)


def test_occ_solid_is_the_same():
    gmsh = pytest.importorskip("gmsh")
    gmsh.initialize(readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        solids = TWO_STOREYS.build(gmsh)
        found = {
            name: sum(gmsh.model.occ.getMass(*part) for part in parts)
            for name, parts in solids.items()
        }
    finally:
        gmsh.finalize()
    assert found["lower"] == pytest.approx(9 * 6 * 3 - 3 * 4 * 2)
    assert found["upper"] == pytest.approx(9 * 6 * 5 - 3 * 4 * 3 - 3 * 4 * 2 - 1 * 6 * 1)


def test_planes_that_differ_by_rounding_are_one():
    """0.1 + 0.2 is not 0.3; without merging there would be a cell of 5e-17 mm."""
    boxes = Boxes(
        (Box("a", (0, 0, 0), (1, 1, 0.1 + 0.2)), Box("a", (0, 0, 0.3), (1, 1, 1))), ("a",)
    )
    mesh = boxes.mesh(10.0, 10.0)
    assert len(mesh.lines[2]) == 3
    tets = upright(mesh.points(), mesh.tetrahedra(0))
    assert volumes(mesh.points(), tets).min() > 0.01
