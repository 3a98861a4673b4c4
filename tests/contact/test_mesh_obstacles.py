"""Obstacles out of STL files: their distance, what they press with, and what is no body."""

import numpy as np
import pytest

from softact.contact.obstacles import OBSTACLES
from softact.contact.obstacles.block import Block
from softact.contact.obstacles.sphere import Sphere
from softact.contact.rigid import Obstacle
from softact.loads.load_step import LoadStep
from softact.model import Support
from tests.analytic.differences import assert_contact_tangent
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve
from tests.contact import stl_files
from tests.contact.grasping import GRAM, GRAVITY, between_pads, grasp
from tests.contact.test_free_bodies import FACES, MASS, MIDDLE, WEIGHT, Both
from tests.contact.test_rigid_contact import SOFT


def shape_of(path, **more):
    """The shape of a spec's obstacle of a file."""
    return OBSTACLES["mesh"].model_validate({"type": "mesh", "file": str(path), **more}).shape()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("stl")


@pytest.fixture(scope="module")
def box(folder):
    """A box of 2 × 4 × 6 mm in a file in m, as text, put about (1, 2, 3) mm."""
    path = stl_files.write(folder / "box.stl", stl_files.box((2e-3, 4e-3, 6e-3)), text=True)
    return shape_of(path, scale=1000, center=["1 mm", "2 mm", "3 mm"], rounding="0.1 mm")


@pytest.fixture(scope="module")
def ball(folder):
    """A ball of 5 mm, of 2,048 triangles."""
    return shape_of(stl_files.write(folder / "ball.stl", stl_files.ball(5.0)), center=_mm(MIDDLE))


def _mm(place):
    return [f"{c} mm" for c in place]


def test_a_box_is_a_box(box):
    """Volume, middle, inertia and distance to the sides as of the box; its corners are rounded:
    there the distance is greater by (√3 − 1) times the radius at most."""
    assert box.outer.volume == pytest.approx(48.0)
    np.testing.assert_allclose(box.outer.centre, [1, 2, 3], rtol=1e-6)
    exact = Block((1, 2, 3), (2, 4, 6))
    np.testing.assert_allclose(box.filled.gyration, exact.filled.gyration, rtol=1e-5, atol=1e-6)
    points = np.random.default_rng(1).uniform(-3, 8, (2000, 3))
    more = box.distance(points)[0] - exact.distance(points)[0]
    assert more.min() > -1e-6 and more.max() == pytest.approx(0.1 * (3**0.5 - 1), rel=0.05)
    beside = exact.distance(points)[0] < -0.2
    np.testing.assert_allclose(more[beside], 0, atol=1e-6)


def test_distance(ball):
    """First and second derivatives by central differences, where no other triangle is nearer, and
    the distance of the ball but for the flat triangles."""
    points = np.random.default_rng(3).uniform(-6, 6, (4000, 3)) + MIDDLE
    g, n, h = ball.distance(points)
    exact = Sphere(MIDDLE, 5.0).distance(points)[0]
    assert -1e-6 < (g - exact).min() and (g - exact).max() < 0.02
    step = 1e-5
    first, second = np.empty_like(n), np.empty_like(h)
    for c in range(3):
        (more, n_more, _), (less, n_less, _) = (
            ball.distance(points + sign * step * np.eye(3)[c]) for sign in (1, -1)
        )
        first[:, c] = (more - less) / (2 * step)
        second[:, :, c] = (n_more - n_less) / (2 * step)
    outside = g > -0.9 * ball.rounding
    np.testing.assert_allclose(first[outside], n[outside], atol=1e-6)
    off = np.abs(second - h).max(axis=(1, 2))[outside]
    assert np.quantile(off, 0.98) < 1e-6


def test_normals_do_not_jump(ball, box):
    """Along a way around a body, as deep in it as contact goes, the normal turns with the way."""
    for shape, centre, size in ((ball, MIDDLE, 5.0), (box, (1.0, 2.0, 3.0), 4.0)):
        angles = np.linspace(0, 2 * np.pi, 20001)
        places = np.column_stack([np.cos(angles), np.sin(angles), 0.1 * np.ones_like(angles)])
        ways = centre + 2 * size * places / np.linalg.norm(places, axis=1)[:, None]
        for _ in range(30):  # on to the surface at the depth
            g, n, _ = shape.distance(ways)
            ways -= (g + 0.5 * shape.rounding)[:, None] * n
        g, n, _ = shape.distance(ways)
        np.testing.assert_allclose(g, -0.5 * shape.rounding, atol=1e-6)
        gone = np.linalg.norm(np.diff(ways, axis=0), axis=1)
        turned = np.linalg.norm(np.diff(n, axis=0), axis=1)
        assert (turned <= 1.01 * gone / (0.5 * shape.rounding) + 1e-9).all()


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_tangent(folder, friction):
    """Force against energy, tangent against force, of a free body out of a file."""
    path = stl_files.write(folder / "small.stl", stl_files.ball(0.7, halvings=2))
    shape = shape_of(path, center=_mm((0.1, 0.2, 0.3)), rounding="0.2 mm")
    model = build(block((2, 2, 2)), SOFT, obstacles=[Obstacle("thing", shape, friction, mass=1e-5)])
    rng = np.random.default_rng(5)
    state = model.initial_state()
    state.x = 0.02 * rng.standard_normal(model.unknowns.local)
    model.remember(state)
    state.x = state.x + 0.003 * rng.standard_normal(model.unknowns.local)
    assert_contact_tangent(model, Both(model), state, friction, least=0.01, off=1e-3, step=1e-6)


def pressed(shape):
    """Force (3,) of a shape that is pressed 0.3 mm into a block of 4 × 4 × 2 mm from above."""
    model = build(block((4, 4, 2), (4.0, 4.0, 2.0)), SOFT, obstacles=[Obstacle("stamp", shape)])
    floor = Support("z_min", dict.fromkeys(range(3), 0.0))
    step = LoadStep("press", shift={"stamp": (0.0, 0.0, -0.3)})
    solution = solve(model, step, [floor], 0.5)
    (term,) = model.contacts
    return model.contacts.force(term, solution.state)


def test_a_box_presses_as_a_block(folder):
    """The same, where its edges are rounded less than it presses in."""
    path = stl_files.write(folder / "stamp.stl", stl_files.box((2.0, 2.0, 2.0)))
    found = pressed(shape_of(path, center=_mm((2.0, 2.0, 3.0)), rounding="0.005 mm"))
    exact = pressed(Block((2.0, 2.0, 3.0), (2.0, 2.0, 2.0)))
    np.testing.assert_allclose(found, exact, atol=1e-4 * abs(exact[2]))


def test_a_ball_presses_as_a_sphere(folder):
    """Within 3 %: between corners on the sphere, triangles lie up to 0.005 mm within it."""
    path = stl_files.write(folder / "marble.stl", stl_files.ball(2.0))
    found = pressed(shape_of(path, center=_mm((2.0, 2.0, 4.0))))
    exact = pressed(Sphere((2.0, 2.0, 4.0), 2.0))
    np.testing.assert_allclose(found, exact, atol=0.03 * abs(exact[2]))


def test_it_is_grasped(ball):
    """As a free body it hangs by its friction between two pads."""
    obstacle = Obstacle("ball", ball, 0.5, surfaces=FACES, mass=MASS, held=True)
    model = between_pads(SOFT, [obstacle])
    solution = grasp(model)
    (term,) = model.contacts
    force = model.contacts.force(term, solution.state)
    np.testing.assert_allclose(force, [0, 0, -WEIGHT], atol=1e-4 * WEIGHT)
    assert 20 * GRAM * GRAVITY == WEIGHT


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"PK\x03\x04 something else", "is no STL file"),
        (b"solid a\nvertex 1 2\nendsolid", "not every triangle has three corners"),
        (b"solid a\nendsolid", "has no triangles"),
        (None, "there is no file"),
    ],
)
def test_what_is_no_body(tmp_path, content, line):
    """One line says what is wrong with the file."""
    path = tmp_path / "part.stl"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ValueError, match=line):
        shape_of(path)


def test_an_open_surface(tmp_path):
    """A box without a lid is told, with the number of its open edges."""
    path = stl_files.write(tmp_path / "open.stl", stl_files.box()[2:])
    with pytest.raises(ValueError, match="do not close it: 4 edges"):
        shape_of(path)


def test_too_much_rounding(tmp_path):
    """Edges that are rounded to more than there is leave nothing."""
    path = stl_files.write(tmp_path / "box.stl", stl_files.box())
    with pytest.raises(ValueError, match="leave nothing of"):
        shape_of(path, rounding="0.6 mm")
