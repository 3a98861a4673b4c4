"""Parts of a mesh that nothing holds are refused before anything is solved, by name."""

import numpy as np
import pytest

from softact.errors import SoftactError, SpecError
from softact.mesh.components import components
from softact.mesh.layout import Layout
from softact.mesh.msh_file import Tetrahedra
from softact.mesh.nearest_triangle import nearest_triangle
from softact.run.held import refuse_loose
from softact.run.start import run
from softact.spec import load, loads
from tests import step_files

UNIT = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=float)


def two_tetrahedra(shared: int) -> tuple[np.ndarray, np.ndarray]:
    """A tetrahedron and its mirror image that share so many corners, 0 to 3, or lie apart."""
    points = np.vstack([UNIT, UNIT * (1, 1, -1)])
    cells = np.array([[0, 1, 2, 3], [4, 6, 5, 7]])
    for corner in range(shared):
        cells[cells == 4 + corner] = corner
    return points, cells


@pytest.mark.parametrize(("shared", "parts"), [(0, 2), (1, 2), (2, 2), (3, 1)])
def test_a_common_face_joins_and_a_common_edge_is_a_hinge(shared, parts):
    assert components(*two_tetrahedra(shared)).max() + 1 == parts


def test_pieces_that_share_three_nodes_over_different_faces_hang_together():
    """Two tetrahedra with one edge in common and a third that shares other nodes with both."""
    points = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [0, -1, 0], [0, 0, -1], [1, 1, 1], [2, 2, 0]],
        dtype=float,
    )
    # The second and third share a face; the first shares the edge 0-1 with the second and the
    # corner 2 with the third: together three nodes that are not on a line.
    cells = np.array([[0, 1, 2, 3], [0, 1, 4, 5], [1, 4, 5, 2]])
    assert components(points, cells).max() == 0


def test_distances_to_a_triangle_by_hand():
    """Over its middle, beside an edge and beyond a corner."""
    triangle = UNIT[None, :3]
    places = np.array([[0.2, 0.2, 0.7], [0.5, -0.4, 0.3], [-0.3, -0.4, 0.0]])
    distance, nearest = nearest_triangle(places, triangle)
    assert distance == pytest.approx([0.7, 0.5, 0.5])
    assert nearest.tolist() == [0, 0, 0]
    assert nearest_triangle(places, triangle[:0])[1].tolist() == [-1, -1, -1]


BLOCK = """
geometry: {{type: block, mesh_size: 10 mm}}
materials: {{body: ecoflex-00-30}}
supports: {supports}
steps: [{{name: pull, {step}}}]
"""


def of_block(supports: str, step: str = "traction: {surface: x_max, value: [1 kPa, 0 Pa, 0 Pa]}"):
    """A spec of a block, and its mesh: a single tetrahedron with a face in each plane but one."""
    points = UNIT * 10
    faces = {"x_min": [[0, 2, 3]], "y_min": [[0, 1, 3]], "z_min": [[0, 1, 2]], "x_max": [[1, 2, 3]]}
    surfaces = {name: np.array(triangles) for name, triangles in faces.items()}
    tets = Tetrahedra(points, np.array([[0, 1, 2, 3]]), np.zeros(1, np.int32), surfaces)
    layout = Layout(("body",), tuple(surfaces), {})
    return tets, layout, loads(BLOCK.format(supports=supports, step=step))


HELD = "[{surface: x_min, fix: [x, y, z]}]"
SLIDES = "[{surface: x_min, fix: [x]}, {surface: y_min, fix: [y]}, {surface: z_min, fix: [z]}]"


@pytest.mark.parametrize("supports", [HELD, SLIDES])
def test_a_body_that_is_held_is_not_refused(supports):
    refuse_loose(*of_block(supports))


def test_a_body_that_can_turn_is_refused_with_the_axis():
    """x on the plane x = 0, and y and z on one line: it turns about that line, along z."""
    tets, layout, spec = of_block("[{surface: x_min, fix: [x, y, z]}]")
    tets.surfaces["x_min"] = np.array([[0, 3, 3]])  # its nodes lie on the axis z
    with pytest.raises(SpecError) as caught:
        refuse_loose(tets, layout, spec)
    (line,) = caught.value.lines
    assert line == (
        "the supports do not hold the body: it can turn about z; fix it on some surface"
    )


def test_supports_of_a_step_have_to_hold_too():
    """All components, but of one node: it turns about all axes."""
    held_there = "supports: [{surface: x_max, fix: [x, y, z]}], gravity: [0, 0, -1]"
    tets, layout, spec = of_block(HELD, held_there)
    tets.surfaces["x_max"] = np.array([[3, 3, 3]])
    with pytest.raises(SpecError) as caught:
        refuse_loose(tets, layout, spec)
    turns = "it can turn about x and turn about y and turn about z"
    assert caught.value.lines == [
        f"step pull: the supports do not hold the body: {turns}; fix it on some surface"
    ]


def test_symmetry_planes_hold():
    """Free along x and about no axis once y and z are symmetry planes."""
    tets, layout, spec = of_block("[{surface: x_min, fix: [x, y, z]}]")
    tets.surfaces["x_min"] = np.array([[0, 0, 0]])
    planes = {"y_min": 1, "z_min": 2}
    refuse_loose(tets, Layout(layout.regions, layout.surfaces, {}, symmetry=planes), spec)


LOOSE = """
name: loose
geometry:
  type: from_step
  file: two.step
  regions: [rubber, base]
  separate: true
  select: {clamp: 1, tip: 6}
  mesh_size: 8 mm
materials: {rubber: ecoflex-00-30, base: ecoflex-00-30}
steps: [{name: inflate, pressure: 1 kPa}]
"""


@pytest.fixture
def two(tmp_path):
    """Function that writes a block and a plate under it with a spec; the clamp is the block's."""
    make = step_files.on_a_plate()
    names = ("rubber", "base")
    step_files.write(tmp_path / "two.step", make, step_files.ends_and_room, solids=names)

    def write(more: str = ""):
        (tmp_path / "loose.yaml").write_text(LOOSE + more)
        return load(tmp_path / "loose.yaml")

    return write


def test_a_solid_that_nothing_holds_is_refused_by_name_and_nothing_is_written(two, tmp_path):
    with pytest.raises(SoftactError) as caught:
        run(two(), tmp_path / "out", report=False)
    (line,) = caught.value.lines
    assert caught.value.exit_code == SpecError.exit_code
    assert line.startswith("the part 'base' touches another near (0, ")
    assert "nothing holds it; join it, fix it on some surface, or write a contact" in line
    assert not (tmp_path / "out").exists()


def test_a_solid_that_a_contact_may_hold_is_left_to_the_solver(two):
    from softact.run.held import _touching

    spec = two("obstacles: {floor: {type: plane, point: [0 mm, 0 mm, -1 mm], normal: [0, 0, 1]}}\n")
    assert _touching(spec.geometry.layout(), spec) == {"clamp", "tip"}


NO_CLAMP = """
geometry: {type: from_step, file: two.step, regions: [rubber, base], clamp: ''}
materials: {rubber: ecoflex-00-30, base: ecoflex-00-30}
steps: [{name: inflate, pressure: 1 kPa}]
"""


def test_a_part_without_a_clamp_needs_supports_and_says_so_in_the_spec(two, tmp_path):
    """Not in the solver's copy of it."""
    two()
    path = tmp_path / "free.yaml"
    path.write_text(NO_CLAMP)
    with pytest.raises(SpecError) as caught:
        load(path)
    assert [line.removeprefix(f"{path}:2: ") for line in caught.value.lines] == [
        f"supports: nothing holds the actuator, which has no clamp, along {axis}; fix it on some "
        "surface"
        for axis in "xyz"
    ]
    path.write_text(NO_CLAMP + "supports: [{surface: tip, fix: [x, y, z]}]\n")
    assert loads(load(path).to_yaml()) == load(path)
