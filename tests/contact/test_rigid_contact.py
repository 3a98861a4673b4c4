"""Contact with rigid obstacles: patch test, Hertz, tangents, energy, friction."""

import numpy as np
import pytest

from softact.contact.obstacles.block import Block
from softact.contact.obstacles.cylinder import Cylinder
from softact.contact.obstacles.plane import Plane
from softact.contact.obstacles.sphere import Sphere
from softact.contact.pressure import pressure
from softact.contact.rigid import Obstacle
from softact.errors import SpecError
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.measures import MEASURES
from softact.measures.further_fields import further_fields
from softact.measures.snapshot import Snapshot
from softact.model import Support
from softact.solve.settings import Settings
from softact.solve.stepping import Stepper
from tests.analytic.differences import (
    assert_contact_tangent,
)
from tests.analytic.meshes import block
from tests.analytic.solving import ROLLERS, build, solve

SOFT = LAWS["neo_hookean"].of(c10=0.05, bulk_modulus=50.0)
GROUND = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
FLOOR = Obstacle("floor", GROUND)
TURNED = ((0.6, 0.8, 0.0), (-0.8, 0.6, 0.0), (0.0, 0.0, 1.0))
SHAPES = {
    "plane": Plane((0.1, 0.2, 0.3), (1.0, 2.0, 3.0)),
    "sphere": Sphere((0.1, 0.2, 0.3), 0.7),
    "cylinder": Cylinder((0.1, 0.2, 0.3), (1.0, 2.0, -1.0), 0.7, 1.0),
    "endless": Cylinder((0.1, 0.2, 0.3), (1.0, 2.0, -1.0), 0.7),
    "block": Block((0.1, 0.2, 0.3), (1.0, 1.2, 0.6), TURNED),
}


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_distance(shape):
    """Gradient of unit length, first and second derivatives by central differences."""
    x = np.random.default_rng(3).uniform(-1.5, 1.5, (400, 3))
    g, n, h = shape.distance(x)
    np.testing.assert_allclose(shape.gap(x), g, rtol=1e-13)
    np.testing.assert_allclose(np.linalg.norm(n, axis=1), 1.0, rtol=1e-12)
    step = 1e-6
    smooth = np.ones(len(x), bool)
    first, second = np.empty_like(n), np.empty((len(x), 3, 3))
    for c in range(3):
        (more, n_more, _), (less, n_less, _) = (
            shape.distance(x + sign * step * np.eye(3)[c]) for sign in (1, -1)
        )
        first[:, c] = (more - less) / (2 * step)
        second[:, :, c] = (n_more - n_less) / (2 * step)
        smooth &= np.linalg.norm(n_more - n_less, axis=1) < 1e-2  # no other side is nearest
    assert smooth.mean() > 0.97
    assert (g < 0).any() and (g > 0).any()
    np.testing.assert_allclose(first[smooth], n[smooth], atol=1e-8)
    np.testing.assert_allclose(second[smooth], h[smooth], atol=1e-4 * np.abs(h).max())
    np.testing.assert_allclose(shape.distance(x - g[:, None] * n)[0][g > 0], 0, atol=1e-12)


def test_distance_by_hand():
    """Corner, edge, face and inside of a box; rim of a cylinder."""
    box = Block((0, 0, 0), (2, 4, 6))
    points = np.array([[2, 3, 3.0], [2, 3, 0], [0, 0, 5], [0.5, 0, 0]])
    np.testing.assert_allclose(box.distance(points)[0], [2**0.5, 2**0.5, 2, -0.5])
    bar = Cylinder((0, 0, 0), (0, 0, 1), 1.0, 2.0)
    points = np.array([[4.0, 0, 5.0], [0, 3, 0], [0, 0.5, 0], [0.1, 0, -1.5]])
    np.testing.assert_allclose(bar.distance(points)[0], [5, 2, -0.5, 0.5])


def test_pressure():
    """p is minus the slope of the potential, the slope that of p; linear with stiffness k below."""
    g = np.linspace(-0.05, 0.02, 1001)
    p, down, potential = pressure(g, 7.0, 0.01)
    np.testing.assert_allclose(np.gradient(potential, g)[1:-1], -p[1:-1], atol=1e-6)
    np.testing.assert_allclose(np.gradient(p, g)[1:-1], -down[1:-1], atol=2e-2)
    np.testing.assert_allclose(p[g < -0.01], -7.0 * (g[g < -0.01] + 0.005), rtol=1e-12)
    assert not p[g > 0].any() and (p[g < -1e-6] > 0).all()


def pressed(shape, friction):
    """A block that a random motion presses into a shape, with what it remembers of friction."""
    obstacle = Obstacle("thing", shape, friction)
    model = build(block((2, 2, 2), (1.0, 1.0, 1.0)), SOFT, obstacles=[obstacle])
    rng = np.random.default_rng(5)
    state = model.initial_state()
    state.x = 0.02 * rng.standard_normal(model.unknowns.local)
    state.put("shift", {"thing": np.array([0.01, -0.02, 0.03])})
    model.contacts.remember(state)
    state.x = state.x + 0.003 * rng.standard_normal(model.unknowns.local)
    return model, state


@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("shape", ["plane", "sphere", "cylinder"])
def test_tangent(shape, friction):
    """Force against energy, tangent against force, by central differences."""
    model, state = pressed(SHAPES[shape], friction)
    (term,) = model.contacts
    assert_contact_tangent(model, term, state, friction, least=0.01, off=1e-4, step=1e-6)


def irregular(points):
    """Moves the points inside the underside of a block of 2 × 2 × 2 mm and those above them."""
    shake = np.random.default_rng(7).uniform(-0.12, 0.12, points.shape)
    shake[:, 2] *= points[:, 2] > 0.1
    low = ((points > 0.1) & (points < 1.9))[:, :2].all(axis=1) & (points[:, 2] < 1.5)
    return points + shake * low[:, None]


@pytest.mark.parametrize("element", ["P2/P1", "P2"])
def test_patch(element):
    """An irregular block pressed on a plane by a fifth: uniform strain as on rollers, to 1e-8.

    The penalty has one stiffness here; in use it follows the size of each facet.
    """
    model = build(block((3, 3, 3), (2.0, 2.0, 2.0), irregular), SOFT, element, obstacles=[FLOOR])
    (term,) = model.contacts
    term.facets.stiffness[:], term.facets.onset[:] = 20.0, 0.002
    held = [*ROLLERS[:2], Support("z_max", {2: -0.4})]
    steps = LoadStep("press", supports=held)
    at_rest = [*ROLLERS[:2], Support("z_max", {2: 0.0})]
    solution = solve(model, steps, at_rest, 0.5, tolerance=1e-10)
    f = model.solids["body"].deformation_gradient(solution.state.x)
    for c in range(3):
        assert np.ptp(f[..., c, c]) < 1e-8
    down = (term.facets.points[..., 2] < 1e-9).all(axis=1)
    gaps = term.gaps(solution.state)[down]
    assert np.ptp(gaps) < 1e-8
    assert f[..., 2, 2].mean() == pytest.approx((1.6 - gaps.mean()) / 2, rel=1e-9)
    # Pressure times undeformed area is the force, equal and opposite to that of the support.
    push = model.contacts.force(term, solution.state)
    assert push[2] == pytest.approx(-20.0 * (gaps.mean() + 0.001) * 4, rel=1e-6)
    np.testing.assert_allclose(push + solution.reaction("z_max"), 0, atol=1e-8)
    found = MEASURES["contact"].evaluate(Snapshot(model, solution.state))
    assert found["contact_area_floor_mm2"] == pytest.approx(4.0, rel=1e-12)
    # The pressure is the same at all nodes on the floor, also at its edges, and nowhere else.
    assert found["contact_pressure_floor_kPa"] == pytest.approx(1e3 * push[2] / 4, rel=1e-6)
    pressed = further_fields(Snapshot(model, solution.state), ["contact_pressure"])
    on_floor = model.nodes.places[:, 2] < 1e-9
    everywhere = np.where(on_floor, push[2] / 4, 0.0)
    np.testing.assert_allclose(pressed["contact_pressure"], everywhere, rtol=1e-6)


LINES = np.array([0, 0.3, 0.6, 0.9, 1.25, 2.2, 5, 11, 25.0])  # mm


def graded(points):
    """A quarter of a block of 25 mm, fine where x, y and z are near 0."""
    return np.interp(points, np.linspace(0, 1, len(LINES)), LINES) * [1, 1, -1]


def test_hertz():
    """A rigid ball pressed 0.12 mm into a half space: force and contact radius within 3 %.

    R = 8 mm, E = 0.3 MPa: F = 4/3 E/(1 − ν²) √R δ^1.5, a = √(R δ), and for the pressure
    p₀ √(1 − r²/a²) the mean of r² over the force is 2/5 a² (Hertz 1882; Johnson, Contact
    Mechanics, 1985, sec. 4.2).
    """
    radius, depth, nu = 8.0, 0.12, 0.4995
    law = LAWS["neo_hookean"].of(c10=0.05, bulk_modulus=100.0)
    ball = Obstacle("ball", Sphere((0.0, 0.0, radius), radius), surfaces=("z_min",))
    cells = (len(LINES) - 1,) * 3
    sides = {"x_min": 0, "y_min": 1}
    model = build(block(cells, mapping=graded), law, symmetry=sides, obstacles=[ball])
    far = Support("z_max", dict.fromkeys(range(3), 0.0))
    step = LoadStep("press", shift={"ball": (0.0, 0.0, -depth)})
    solution = solve(model, step, [far])
    (term,) = model.contacts
    expected = 4 / 3 * 0.3 / (1 - nu**2) * radius**0.5 * depth**1.5
    assert -4 * model.contacts.force(term, solution.state)[2] == pytest.approx(expected, rel=0.03)
    share = term.tractions(solution.state)[..., 2] * term.facets.areas
    places = term.facets.places(solution.state.x)
    moment = np.sum(share * (places[..., :2] ** 2).sum(axis=-1)) / share.sum()
    assert np.sqrt(2.5 * moment) == pytest.approx(np.sqrt(radius * depth), rel=0.03)
    assert 0 < -model.contacts.smallest_gap(term, solution.state)[1] < 0.02


def test_energy_of_closing_and_opening():
    """Without friction the work of closing comes back: elastic and contact energy end at zero,
    and on the way they grow by the work of the obstacle's motion, ∫ F dz."""
    ball = Obstacle("ball", Sphere((0.5, 0.5, 2.0), 1.0), surfaces=("z_max",))
    model = build(block((2, 2, 2)), SOFT, obstacles=[ball])
    steps = [
        LoadStep("close", shift={"ball": (0.0, 0.0, -0.3)}),
        LoadStep("open", shift={"ball": (0.0, 0.0, 0.1)}),
    ]
    solution = solve(model, steps, [Support("z_min", dict.fromkeys(range(3), 0.0))], 0.1)
    (term,) = model.contacts
    closing = next(n for n, s in enumerate(solution.path) if s["shift"]["ball"][2] < -0.2999)
    energy = np.array([model.energy(state) for state in solution.path])
    # The ball's force on the body works through the ball's own motion.
    force = np.array([model.contacts.force(term, state)[2] for state in solution.path])
    place = np.array([state["shift"]["ball"][2] for state in solution.path])
    work = np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(place))
    assert energy[closing] == pytest.approx(work[closing - 1], rel=0.02)
    assert abs(work[-1]) < 0.02 * energy[closing]
    assert abs(energy[-1]) < 1e-9 * energy[closing]
    assert np.abs(solution.state.x).max() < 1e-6


@pytest.mark.parametrize(("coefficient", "dynamics"), [(0.2, False), (0.6, True)])
def test_inclined_plane(coefficient, dynamics):
    """A block on a plane that is tilted slides at tan θ = μ: no equilibrium beyond, within 2 %.

    Gravity (a thousandfold) is turned instead of the plane; contact alone holds the block, which
    begins pressed in by 1 % of its elements, as without weight nothing would hold it. A damped
    motion does not come to rest there either.
    """
    floor = Obstacle("floor", Plane((0.0, 0.0, 0.02), (0.0, 0.0, 1.0)), coefficient)
    model = build(block((2, 2, 1), (4.0, 4.0, 1.0)), SOFT, obstacles=[floor])
    heavy = 1e3 * 9810.0
    settle = LoadStep("settle", gravity=(0.0, 0.0, -heavy))
    tilt = LoadStep("tilt", gravity=(heavy, 0.0, -heavy))
    stepper = Stepper(
        model, Settings(min_increment=2e-3, dynamics=dynamics), lambda *accepted: None
    )
    progress = stepper.run([settle, tilt], [])
    assert "step 'tilt'" in progress.stopped
    reached = max(a.fraction for a in progress.attempts if a.converged and a.step == "tilt")
    assert reached == pytest.approx(coefficient, rel=0.02)


def test_friction_of_dragged_block():
    """Dragged over a plane, a block resists with μ times the pressing force, to 1e-3."""
    floor = Obstacle("floor", GROUND, 0.3, surfaces=("z_min",))
    model = build(block((2, 2, 2), (2.0, 2.0, 2.0)), SOFT, obstacles=[floor])
    top = Support("z_max", {0: 0.0, 1: 0.0, 2: -0.2})
    steps = [LoadStep("press", supports=[top]), LoadStep("drag", shift={"floor": (1.5, 0.0, 0.0)})]
    start = Support("z_max", dict.fromkeys(range(3), 0.0))
    solution = solve(model, steps, [start], 0.2)
    (term,) = model.contacts
    force = model.contacts.force(term, solution.state)
    assert force[2] > 0.1
    assert force[0] == pytest.approx(0.3 * force[2], rel=1e-3)


def test_removed_obstacle():
    """A removed obstacle lets go over the step: as much less force as is done of it, then none."""
    model = build(block((2, 2, 2)), SOFT, obstacles=[FLOOR])
    held = [*ROLLERS[:2], Support("z_max", {2: -0.2})]
    steps = [LoadStep("press", supports=held), LoadStep("remove", presence={"floor": 0.0})]
    solution = solve(model, steps, [*ROLLERS[:2], Support("z_max", {2: 0.0})], 0.5)
    (term,) = model.contacts
    pressed = model.contacts.force(term, solution.ends[0])[2]
    assert pressed > 0.05
    going = [state for state in solution.path if state["presence"].get("floor", 1.0) < 1.0]
    forces = [model.contacts.force(term, state)[2] for state in going]
    there = [state["presence"]["floor"] for state in going]
    assert there == [0.5, 0.0]
    np.testing.assert_allclose(forces, pressed * np.array(there), atol=1e-12)
    f = model.solids["body"].deformation_gradient(solution.state.x)
    np.testing.assert_allclose(f, np.broadcast_to(np.eye(3), f.shape), atol=1e-6)


def test_overlap_at_the_start():
    """One line that names the obstacle, how deep it is, and where."""
    deep = Obstacle("post", Block((0.5, 0.5, -0.4), (4.0, 4.0, 1.0)))
    model = build(block((2, 2, 2)), SOFT, obstacles=[deep])
    with pytest.raises(SpecError, match=r"obstacles.post: overlaps the body by 0.1 mm near"):
        solve(model, LoadStep("none", gravity=(0, 0, -1.0)), ROLLERS)
