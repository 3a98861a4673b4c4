"""Contact of a body with itself and between bodies: tangents, patch, two blocks, friction."""

import numpy as np
import pytest
from mpi4py import MPI

from softact.contact.closest import Closest
from softact.contact.surfaces import Touching
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.measures import MEASURES
from softact.measures.further_fields import further_fields
from softact.measures.snapshot import Snapshot
from softact.model import Support
from softact.solve.newton import Loaded, Newton
from tests.analytic.differences import (
    assert_contact_tangent,
    force,
)
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve

SOFT = LAWS["neo_hookean"].of(c10=0.05, bulk_modulus=50.0)
GAP = 0.02


def slit(points):
    """Squeezes the middle third of the height to the gap."""
    z = np.interp(points[:, 2], [0, 1, 2, 3], [0, 1, 1 + GAP, 2 + GAP])
    return np.column_stack([points[:, :2], z])


def jaws(friction=0.0, shear=0.0, joined=True):
    """Two blocks of 3 × 1 × 1 mm over each other, joined at x < 1 unless they are not.

    shear: how far the mesh lines inside the upper block lie beside those of the lower one, mm.
    """

    def mapping(points):
        moved = slit(points)
        for c, length in enumerate((3.0, 1.0)):
            inside = (points[:, c] > 0.1) & (points[:, c] < length - 0.1)
            moved[:, c] += shear * inside * (points[:, 2] > 1.5)
        return moved

    def keep(centres):
        return (np.abs(centres[:, 2] - 1.5) > 0.6) | ((centres[:, 0] < 1) & joined)

    tets = block((3, 2, 3), (3.0, 1.0, 3.0), mapping, keep)
    touching = Touching("jaws", (("inside",),), friction)
    return build(tets, SOFT, touching=[touching])


def bitten(friction):
    """The jaws at a random state with overlap, and what they remember of an earlier one."""
    model = jaws(friction, shear=0.13)
    rng = np.random.default_rng(4)
    places = model.unknowns.spaces[0].tabulate_dof_coordinates()
    state = model.initial_state()
    z = model.displacement_dofs[:, 2]
    state.x = 0.004 * rng.standard_normal(model.unknowns.local)
    state.x[z] -= 0.012 * places[:, 0] * (places[:, 2] > 1.01)
    model.contacts.remember(state)
    state.x = state.x + 0.002 * rng.standard_normal(model.unknowns.local)
    return model, state


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_tangent(friction):
    """Force against energy, tangent against force, by central differences."""
    model, state = bitten(friction)
    (term,) = model.contacts
    assert (term.gaps(state.x)[2] < 0).sum() > 20
    assert_contact_tangent(model, term, state, friction, least=0.01, off=2e-4)


@pytest.mark.parametrize("size", [0.0, 0.003, 0.03, 0.1])
def test_what_is_left_out_does_not_touch(size):
    """Of a state that overlaps on, to others by random ways: what points face among the pairs that
    may have come near has all overlaps that a look at all pairs finds, as deep."""
    model, state = bitten(0.0)
    (term,) = model.contacts
    rng = np.random.default_rng(7)
    places = model.unknowns.spaces[0].tabulate_dof_coordinates()
    z, found = model.displacement_dofs[:, 2], 0
    for lift in (0.0, 0.02):  # closed when it looks about, and open
        state.x[z] += lift * (places[:, 2] > 1.01)
        term.resume(state)
        for _ in range(8):
            x = state.x + size * rng.standard_normal(model.unknowns.local)
            x[z] -= lift * (places[:, 2] > 1.01)
            near, every = term._faced.touching(x), term._faced.in_reach(x)
            overlap = every.gap < 0
            np.testing.assert_array_equal(near.gap < 0, overlap)
            np.testing.assert_allclose(near.gap[overlap], every.gap[overlap], atol=1e-14)
            found += overlap.sum()
    assert found > 100


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_action_and_reaction(friction):
    """The forces of a contact of a body with itself add up to nothing."""
    model, state = bitten(friction)
    (term,) = model.contacts
    forces = force(model, term, state)[model.displacement_dofs]
    assert np.abs(forces).sum() > 0.01
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-14)


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_resumed_run(friction):
    """A state stored with its memory gives the same forces in a model that is built anew."""
    model, state = bitten(friction)
    (term,) = model.contacts
    start = model.initial_state()
    start.x, start.memory = state.x, state.memory
    other = jaws(friction, shear=0.13)
    other.contacts.resume(start)
    model.contacts.resume(start)
    (again,) = other.contacts
    found = force(other, again, start)
    assert np.abs(found).max() > 0.001
    np.testing.assert_allclose(found, force(model, term, start), atol=1e-15)
    if friction:
        start.memory = {}
        assert np.abs(force(other, again, start) - found).max() > 1e-4


@pytest.mark.parametrize("nearer", [-1e-13, 0.0, 1e-13])
def test_rounding_does_not_choose_between_two_facets(nearer):
    """A point over the edge between two facets in one plane faces the first of them, also where
    rounding has put the second one nearer; where that is really nearer, it faces that one."""
    search = Closest(MPI.COMM_SELF)
    one = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    other = np.array([[1, 1, 0], [0, 1, 0], [1, 0, 0]], float)
    above = np.array([[1, 0, 1], [0, 0, 1], [0, 1, 1]], float)  # looks down
    point, reach, depth = np.array([[[0.5, 0.5, 0.01]]]), np.array([1.0]), np.array([0.25])

    def faced(height):
        nodes = np.stack([above, one, other + np.array([0, 0, height])])
        arrays = point, nodes[:1], nodes, np.array([0, 2]), np.array([1, 2], np.int32)
        return search(*arrays, reach, depth)[0].item()

    assert faced(nearer) == 1
    assert faced(1e-6) == 2


@pytest.mark.parametrize(("beside", "leans", "faced"), [(1, 100, 0), (1, 125, 1), (0, 100, 1)])
def test_an_end_face_that_leans_on_a_wall_touches_it(beside, leans, faced):
    """Of what is a little inside, a wall that meets it at 100° is touched, as well as one that
    faces it, unless both are beside each other at rest: then it is the next face of one edge."""
    turn = np.radians(leans)
    normal = np.array([np.sin(turn), 0.0, np.cos(turn)])  # of the face, the wall looks up
    along = np.array([normal[2], 0.0, -normal[0]])
    face = np.array([[0, 0, 0], -along, [0, 1, 0]]) + np.array([0.3, 0.2, -0.01])
    face = face if np.cross(face[1] - face[0], face[2] - face[0]) @ normal > 0 else face[[0, 2, 1]]
    wall = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], float)
    nodes, point = np.stack([face, wall]), face[:1][None]
    pairs = nodes[:1], nodes, np.array([0, 1]), np.array([1], np.int32)
    lies = np.array([[0.0, 0, 0, 1]]), np.array([[0.0, 0, 0, 1], [3.0 - 2 * beside, 0, 0, 1]])
    found = Closest(MPI.COMM_SELF)(point, *pairs, np.ones(1), np.full(1, 0.25), lies=lies)
    assert found[0].item() == (1 if faced else -1)
    assert not faced or found[2].item() == pytest.approx(-0.01)


def wavy():
    """Two blocks of 3 × 1 × 1 mm, whose faces that touch are waves of flat facets."""

    def mapping(points):
        moved = slit(points)
        inside = (points[:, 2] > 0.9) & (points[:, 2] < 2.1)
        moved[:, 2] += inside * 0.12 * np.cos(2.0 * np.pi * points[:, 0])
        return moved

    tets = block((12, 2, 3), (3.0, 1.0, 3.0), mapping, lambda c: np.abs(c[:, 2] - 1.5) > 0.6)
    return build(tets, SOFT, touching=[Touching("waves", (("inside",),))])


def test_a_state_is_in_balance_whatever_its_points_faced():
    """Wavy blocks dragged over each other without friction: points cross edges between facets that
    lie at an angle. Each state is in balance in a model that knows nothing of the way there, or
    remembers what its points face."""
    model = wavy()
    hold = Support("z_min", dict.fromkeys(range(3), 0.0))

    def top(x, z):
        return [hold, Support("z_max", {0: x, 1: 0.0, 2: z})]

    ways = {"press": (0.0, -0.1), "drag": (0.3, -0.1)}
    steps = [LoadStep(name, supports=top(*way)) for name, way in ways.items()]
    solution = solve(model, steps, top(0.0, 0.0), 0.25)
    other = wavy()
    for state in solution.path[1:]:
        other.contacts.resume(state)
        newton = Newton(other, 1e-8, 15)
        newton.set_supports(top(0.0, 0.0), state)
        supported = newton.held(state)
        assert newton.imbalance(Loaded(state, state.x[supported.dofs])) <= 1e-8


def test_a_state_remembers_what_its_points_face():
    """Asked to, where they would face something else if nothing were known of the way there."""
    model, (x, _, z) = wavy(), np.arange(3)
    (term,) = model.contacts
    state = model.initial_state()
    places, corners = model.nodes.places, np.linspace(0.0, 3.0, 13)
    wave = np.interp(places[:, x], corners, 0.12 * np.cos(2.0 * np.pi * corners))
    above = places[:, z] - wave > 1.0 + GAP / 2
    state.x[model.displacement_dofs[above, z]] = -0.04
    term.resume(state)
    term.gaps(state.x)  # what they face there is kept
    state.x[model.displacement_dofs[above, x]] = 0.035
    here = force(model, term, state)
    assert not model.contacts.look_afresh(state, keep=True)
    assert any(name.endswith(".faced") for name in state.memory)
    other = wavy()
    other.contacts.resume(state)
    (again,) = other.contacts
    np.testing.assert_allclose(force(other, again, state), here, atol=1e-15)
    assert model.contacts.look_afresh(state)
    assert not state.memory
    assert np.abs(force(model, term, state) - here).max() > 1e-6
    assert not model.contacts.look_afresh(state)


SIDES = [Support("x_min", {0: 0.0}), Support("y_min", {1: 0.0}), Support("z_min", {2: 0.0})]


@pytest.mark.parametrize(("shear", "exact"), [(0.0, 1e-9), (0.17, 0.01)])
def test_two_blocks(shear, exact):
    """Two blocks over each other, pressed by a fifth: both are strained alike and uniformly.

    To 1e-9 where their meshes match, within 1 % where the facets of one lie across the other's.
    """
    model = jaws(shear=shear, joined=False)
    press = [*SIDES, Support("z_max", {2: -0.4})]
    start = [*SIDES, Support("z_max", {2: 0.0})]
    solution = solve(model, LoadStep("press", supports=press), start, 0.5)
    f = model.solids["body"].deformation_gradient(solution.state.x)
    (term,) = model.contacts
    _, _, gap = term.gaps(solution.state.x)
    inside = gap[np.isfinite(gap)]
    assert -0.02 * term.facets.size.min() < inside.min() and inside.max() < 0
    expected = (2 + GAP - 0.4 - inside.mean()) / 2
    np.testing.assert_allclose(f[..., 2, 2], expected, rtol=exact)
    found = MEASURES["contact"].evaluate(Snapshot(model, solution.state))
    area = model.surfaces.area("z_max")  # as large as each of the two faces that touch
    assert found[f"contact_area_{term.name}_mm2"] == pytest.approx(area, rel=max(exact, 1e-6))
    # As a field the pressure is the force by the area, on both sides.
    pressed = further_fields(Snapshot(model, solution.state), ["contact_pressure"])
    pressure = pressed["contact_pressure"]
    uniform = -solution.reaction("z_max")[2] / area
    assert pressure[pressure > 0] == pytest.approx(uniform, rel=max(20 * exact, 1e-6))
    assert len(pressure[pressure > 0]) == len(np.unique(term.facets.nodes))


def test_energy_of_closing_and_opening():
    """Jaws that close and open without friction give back the work, and end as they began."""
    model = jaws()
    hold = Support("z_min", dict.fromkeys(range(3), 0.0))
    ends = [Support("z_max", {2: value}) for value in (-0.06, 0.0)]
    steps = [LoadStep(name, supports=[hold, e]) for name, e in zip("co", ends, strict=True)]
    solution = solve(model, steps, [hold, ends[1]], 0.25)
    (term,) = model.contacts
    closed, opened = solution.ends
    assert term.energy(closed) > 1e-6 and term.energy(opened) == 0.0
    assert abs(model.energy(opened)) < 1e-9 * model.energy(closed)
    forces = [solution.reaction("z_max", state)[2] for state in solution.path]
    assert forces[4] < -0.001 and abs(forces[-1]) < 1e-9


@pytest.mark.parametrize(("pressed", "exact"), [(0.1, 0.07), (0.03, 0.01)])
def test_friction(pressed, exact):
    """One block dragged over the other resists with μ times the pressing force. The couple of the
    forces turns the faces in touch by an angle in proportion to them, 1.0° where they are pressed
    by 0.1 mm: μ between faces is then less between axes, by 6.4 %, and by 0.9 % at 0.03 mm."""
    model = jaws(friction=0.3, joined=False)
    hold = Support("z_min", dict.fromkeys(range(3), 0.0))

    def top(x, z):
        return [hold, Support("z_max", {0: x, 1: 0.0, 2: z})]

    ways = {"press": 0.0, "drag": 0.5}
    steps = [LoadStep(name, supports=top(x, -pressed)) for name, x in ways.items()]
    solution = solve(model, steps, top(0.0, 0.0), 0.25)
    (term,) = model.contacts
    normal, sliding = term.pressed(solution.state)
    assert normal.sum() > (pressed - GAP) / 4  # N, of more than 0.5 N/mm
    slipping = np.linalg.norm(sliding, axis=1) / normal
    assert np.median(slipping) == pytest.approx(0.3, rel=1e-5) and slipping.max() < 0.3001
    assert np.average(slipping, weights=normal) == pytest.approx(0.3, rel=0.01)
    force = solution.reaction("z_max")
    assert force[0] == pytest.approx(0.3 * -force[2], rel=exact)
    assert force[0] < 0.3 * -force[2]


@pytest.mark.parametrize("shear", [0.25, 0.5])
def test_a_sheared_corner_does_not_touch_itself(shear):
    """Faces that meet at 76° or 63° instead of 90°: points near the edge are inside of the other
    face's plane, and do not touch it."""
    sides = ("x_min", "x_max", "z_min", "z_max")
    touching = Touching("self", (sides,))
    model = build(block((4, 2, 4), (2.0, 1.0, 2.0)), SOFT, touching=[touching])
    state = model.initial_state()
    state.x[model.displacement_dofs[:, 0]] = shear * model.nodes.places[:, 2]
    (contact,) = model.contacts
    contact.resume(state)
    assert not model.contacts.touch(state)
