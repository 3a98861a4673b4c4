"""Nothing goes through anything: on the way to an obstacle, past a thin one, between surfaces."""

import numpy as np
import pytest
from mpi4py import MPI

from softact.contact.crossing import Crossing
from softact.contact.obstacles.block import Block
from softact.contact.obstacles.cylinder import Cylinder
from softact.contact.obstacles.plane import Plane
from softact.contact.obstacles.sphere import Sphere
from softact.contact.rigid import Obstacle
from softact.contact.sight import LITTLE, Sight, spheres
from softact.contact.surfaces import Touching
from softact.contact.way import goes_deeper
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.model import Support
from softact.spec import loads
from tests.analytic.meshes import block
from tests.analytic.solving import CLAMP, build, solve
from tests.bodies.test_soundness import cubic_pouch

SOFT = LAWS["neo_hookean"].of(c10=0.05, bulk_modulus=50.0)
SHAPES = [
    Plane((0, 0, 0), (0, 1, 2)),
    Sphere((0.1, 0, 0), 0.6),
    Cylinder((0, 0, 0), (1, 1, 0), 0.3, 1.5),
    Block((0, 0, 0), (0.4, 1.2, 0.8)),
]


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: type(s).__name__)
def test_depth_on_the_way(shape):
    """Ways through, past and along shapes, beside two thousand places on each."""
    rng = np.random.default_rng(3)
    start, end = rng.uniform(-1.5, 1.5, (2, 500, 3))
    outside = (shape.distance(start)[0] > 0) & (shape.distance(end)[0] > 0)
    start, end = start[outside], end[outside]
    depth = rng.uniform(0.02, 0.15, len(start))
    found = goes_deeper(lambda x: shape.distance(x)[0], start, end, depth)
    t = np.linspace(0, 1, 2001)[:, None, None]
    places = (1 - t) * start + t * end
    deepest = shape.distance(places.reshape(-1, 3))[0].reshape(places.shape[:2]).min(axis=0)
    clear = np.abs(deepest + depth) > 0.11 * depth  # not at the very limit
    assert (found == (deepest < -depth))[clear].all()
    if not isinstance(shape, Plane):
        assert 20 < found.sum() < len(found) - 20


def test_a_way_that_is_no_number_is_left_to_the_residual():
    shape, nowhere = SHAPES[1], np.full((1, 3), np.nan)
    assert not goes_deeper(lambda x: shape.distance(x)[0], nowhere, nowhere, np.ones(1)).any()


def sagging(shape, increment):
    """A beam of 60 × 6 × 4 mm over an obstacle, clamped at x = 0, with 50 mN at its tip."""
    model = build(block((15, 2, 1), (60.0, 6.0, 4.0)), ECOFLEX, obstacles=[Obstacle("rod", shape)])
    traction = {"x_max": (0.0, 0.0, -0.05 / 24)}
    return solve(model, LoadStep("load", traction=traction), [CLAMP], increment)


ECOFLEX = LAWS["neo_hookean"].of(c10=0.0139, bulk_modulus=2.0)


def test_a_beam_rests_on_a_thin_rod():
    """The increments do not decide whether the rod holds it: forces at it balance the moment."""
    rod = Cylinder((40.0, 3.0, -3.1), (0, 1, 0), 3.0)
    coarse, fine = sagging(rod, 1.0), sagging(rod, 0.05)
    forces = []
    for solution in (coarse, fine):
        (contact,) = solution.model.contacts
        forces.append(solution.model.contacts.force(contact, solution.state)[2])
        assert solution.model.contacts.smallest_gap(contact, solution.state)[1] > -0.02
    assert forces[0] == pytest.approx(forces[1], rel=1e-3)
    assert forces[0] > 0.05  # the load itself, at a longer lever than the rod's


def test_a_moved_rod_does_not_jump_into_a_body():
    """A bar of 1 mm goes 5 mm up in one step: it lifts the beam's tip and does not come out above
    it."""
    bar = Obstacle("bar", Cylinder((38.0, 1.5, -1.1), (0, 1, 0), 1.0))
    model = build(block((12, 1, 1), (40.0, 3.0, 2.0)), SOFT, obstacles=[bar])
    solution = solve(model, LoadStep("lift", shift={"bar": (0.0, 0.0, 5.0)}), [CLAMP])
    (contact,) = model.contacts
    assert model.contacts.force(contact, solution.state)[2] > 0
    reasons = {a.reason for a in solution.stepper.progress.attempts if not a.converged}
    assert "'bar' moved too far into the body in one increment" in reasons
    highest = solution.state.x[model.displacement_dofs[:, 2]].max()
    assert highest > 4.5


def test_an_arch_does_not_jump_to_the_other_side_of_what_pushes_it():
    """A bar over a slender arch that buckles: all the way down, no point of its crown is above the
    bar's middle, where a damped motion had thrown it."""

    def arch(points):
        return points + np.array([0, 0, 6.0]) * np.sin(np.pi * points[:, :1] / 40)

    bar = Obstacle("bar", Cylinder((20.0, 1.5, 8.3), (0, 1, 0), 1.0))
    model = build(block((16, 1, 1), (40.0, 3.0, 1.2), arch), SOFT, obstacles=[bar])
    held = [Support(name, {0: 0.0, 1: 0.0, 2: 0.0}) for name in ("x_min", "x_max")]
    step = LoadStep("push", shift={"bar": (0.0, 0.0, -14.0)})
    solution = solve(model, step, held, 0.5, min_increment=0.005)
    middle = np.abs(model.nodes.places[:, 0] - 20) < 1e-6
    lowest = min(
        7.3
        + s["shift"]["bar"][2]
        - (model.nodes.places + s.x[model.displacement_dofs])[middle, 2].max()
        for s in solution.path
    )
    assert lowest > -0.5  # the crown has not passed the bar's middle, 1 mm above its lowest line
    controls = [a.control for a in solution.stepper.progress.attempts if a.converged]
    assert "dynamics" in controls  # it snapped on the way: what is shown is shown of a motion too


def looked(before: np.ndarray, reach: np.ndarray, side: np.ndarray) -> Sight:
    """Facets that have looked about from where they are."""
    sight = Sight(MPI.COMM_SELF, reach, side)
    sight.look(before)
    return sight


def test_the_search_sees_what_comes_fast():
    """Ratio of how much nearer facets come to how far they are, by groups and pair by pair."""
    rng = np.random.default_rng(1)
    for count, sides in ((5, 1), (33, 2), (700, 1), (1501, 2)):
        before = rng.random((count, 1, 3)) * [100, 10, 10] + 0.3 * rng.standard_normal(
            (count, 6, 3)
        )
        now = before + 0.4 * rng.standard_normal((count, 1, 3)) * [1, 0.3, 0]
        reach, side = 0.5 + rng.random(count), rng.integers(0, sides, count) - (sides == 1)
        centre, radius = spheres(before)
        moved = (now - before)[:, :3].mean(axis=1)
        apart = np.linalg.norm(centre[:, None] - centre, axis=2) - radius[:, None] - radius
        far = apart > np.maximum(reach[:, None], reach)
        far &= (side[:, None] != side) | (side[:, None] < 0)
        between, way = centre[:, None] - centre, moved[:, None] - moved
        nearest = np.linalg.norm(between, axis=2)
        for t in np.linspace(0, 1, 201)[1:]:
            nearest = np.minimum(nearest, np.linalg.norm(between + t * way, axis=2))
        nearer = np.linalg.norm(between, axis=2) - nearest
        expected = (nearer[far] / apart[far]).max(initial=LITTLE)
        found = looked(before, reach, side).strayed(now)
        assert found == pytest.approx(expected, rel=1e-3)


def test_a_body_that_turns_does_not_meet_itself():
    """However far facets are from the axis, their distances stay: ninety degrees at once."""
    rng = np.random.default_rng(2)
    before = rng.random((400, 1, 3)) * [100, 10, 10] + 0.1 * rng.standard_normal((400, 6, 3))
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    reach, side = np.full(400, 5.0), np.full(400, -1)
    look = looked(before, reach, side)
    assert look.strayed(before @ turn.T) < 0.5
    assert look.strayed(before * [0.01, 1, 1]) > 1.0


#: A quadratic facet that looks up, and points on a facet.
FLAT = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0.5, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0]], float)
POINTS = np.eye(6)[:3] * 0.8 + 0.2 / 6


@pytest.mark.parametrize("through", [False, True])
def test_crossing(through):
    """A facet in front of another that turns with it, and then goes through it."""
    before = np.stack([FLAT, FLAT + np.array([0.05, 0.05, 0.1])])
    angle = 0.6
    turn = np.array(
        [[np.cos(angle), 0, np.sin(angle)], [0, 1, 0], [-np.sin(angle), 0, np.cos(angle)]]
    )
    after = before.copy()
    after[1, :, 2] -= 0.2 if through else 0.0
    after = after @ turn.T + [3.0, 0, 1.0]
    start, candidate = np.array([0, 0, 1]), np.array([0])
    crossed = Crossing(MPI.COMM_SELF)
    assert crossed(before, after, POINTS, start, candidate, np.ones(2)) == through


@pytest.mark.parametrize(
    ("height", "met", "entered"),
    [(5.0, False, False), (0.01, True, False), (-0.01, True, True), (-5.0, True, True)],
)
def test_what_comes_from_out_of_reach(height, met, entered):
    """A facet falls from 10 mm onto another that saw 1 mm far: to above it, to just above it, a
    hundredth of its size into it, which contact that knew of it would allow, and through it."""
    below = FLAT * 2 - [0.5, 0.5, 0]
    before = np.stack([below, FLAT + np.array([0, 0, 10.0])])
    after = np.stack([below, FLAT + np.array([0, 0, height])])
    i, j = looked(before, np.ones(2), np.full(2, -1)).met(after)
    assert (sorted(zip(i, j, strict=True)) == [(0, 1), (1, 0)]) == met
    start = np.searchsorted(i, np.arange(3))
    crossed = Crossing(MPI.COMM_SELF)
    assert crossed(before, after, POINTS, start, j, np.ones(2), touching=False) == entered
    if height == -0.01:
        assert not crossed(before, after, POINTS, start, j, np.ones(2))


def test_a_facet_that_swings_round_is_looked_at():
    """Its corner comes 4 mm down, to the other facet, while its middle goes away from that."""
    before = np.stack([FLAT, FLAT + np.array([0, 0, 4.0])])
    after = before.copy()
    after[1, :3, 2] += [-4.0, 3.0, 3.0]
    after[1, 3:, 2] += [-0.5, 3.0, -0.5]
    i, _ = looked(before, np.ones(2), np.full(2, -1)).met(after)
    assert len(i) == 2


def test_pairs_that_may_have_met():
    """All of them, however the facets are grouped."""
    rng = np.random.default_rng(4)
    before = rng.random((700, 1, 3)) * 60 + 0.3 * rng.standard_normal((700, 6, 3))
    now = before + 4 * rng.standard_normal((700, 1, 3))
    i, j = looked(before, np.full(700, 0.5), np.full(700, -1)).met(now)
    centre, radius = spheres(before)
    between, way = centre[:, None] - centre, ((now - before)[:, None] - (now - before))[..., 0, :]
    far = np.linalg.norm(between, axis=2) - radius[:, None] - radius
    part = -(between * way).sum(axis=2) / np.maximum((way**2).sum(axis=2), 1e-300)
    nearest = np.linalg.norm(between + np.clip(part, 0, 1)[..., None] * way, axis=2)
    expected = (far > 0.5) & (nearest < radius[:, None] + radius)
    assert 50 < expected.sum() == len(i)
    assert expected[i, j].all()


def test_a_block_is_not_pulled_through_another():
    """Two blocks that are not joined; the upper one is pressed down by more than the lower is high
    in one step: the lower is squeezed, or the run says why it goes no further."""
    tets = block(
        (2, 2, 3),
        (3.0, 3.0, 3.0),
        lambda p: np.column_stack([p[:, :2], np.interp(p[:, 2], [0, 1, 2, 3], [0, 0.4, 1.9, 4.9])]),
        lambda c: np.abs(c[:, 2] - 1.5) > 0.6,
    )
    model = build(tets, SOFT, touching=[Touching("gap", (("inside",),))])
    held = [Support("z_min", {0: 0.0, 1: 0.0, 2: 0.0}), Support("z_max", {0: 0.0, 1: 0.0, 2: -3.5})]
    solution = solve(model, LoadStep("press", supports=held), held[:1], stops=True)
    (contact,) = model.contacts
    assert model.contacts.smallest_gap(contact, solution.state)[1] > -0.02
    force, _ = model.force(solution.state)
    pressing = [
        force[model.displacement_dofs[model.surfaces.nodes(name), 2]].sum()
        for name in ("z_min", "z_max")
    ]
    assert pressing[0] == pytest.approx(-pressing[1], rel=1e-6)
    assert pressing[0] > 0.3 * 9.0 * 0.5  # Young's modulus, area, and half of the height


def test_walls_that_are_sucked_flat_carry_the_pressure():
    """A shallow chamber under vacuum: its roof comes down on its floor and stays there while the
    pressure doubles; without contact there is no such state."""
    model = cubic_pouch(SOFT, touching=True)
    solution = solve(model, LoadStep("suck", pressure={"cavity": -0.06}), [CLAMP], 0.25)
    first = model.cavity_volumes_at_rest["cavity"]
    for state in solution.path:
        assert 0 < model.cavity_volume(state, "cavity") <= first
        assert all(model.contacts.smallest_gap(c, state)[1] > -0.02 for c in model.contacts)
    touching = [s for s in solution.path if model.contacts.touch(s)]
    assert len(touching) >= 2 and touching[0]["pressure"]["cavity"] > -0.04
    # What touches is carried by contact: work of the volume that is left is small.
    assert model.cavity_volume(solution.state, "cavity") < 0.2 * first
    bare = cubic_pouch(SOFT, touching=False)
    stopped = solve(bare, LoadStep("suck", pressure={"cavity": -0.06}), [CLAMP], 0.25, stops=True)
    assert bare.cavity_volume(stopped.state, "cavity") > 0


SUCKED = """
geometry: {{type: pneunet, chambers: 2, mesh_size: 4 mm}}
materials: {{body: dragon-skin-10}}
{contact}
steps: [{{name: suck, {load}}}]
"""


OUTSIDE = ("clamp", "tip", "outer", "base")


@pytest.mark.parametrize(
    ("contact", "load", "expected"),
    [
        ("", "pressure: -20 kPa", [("outside", OUTSIDE), ("cavity_walls", ("cavity",))]),
        ("", "inject: -0.2 ml", [("outside", OUTSIDE), ("cavity_walls", ("cavity",))]),
        ("", "pressure: 20 kPa", [("outside", OUTSIDE)]),
        ("contact: auto", "pressure: 20 kPa", [("outside", OUTSIDE)]),
        ("contact: none", "pressure: -20 kPa", []),
        ("contact: [{self: cavity}]", "pressure: -20 kPa", [("contact_1", ("cavity",))]),
        (
            "contact: [{self: outer}]",
            "pressure: -20 kPa",
            [("contact_1", ("outer",)), ("cavity_walls", ("cavity",))],
        ),
    ],
)
def test_walls_of_evacuated_cavities_touch(contact, load, expected):
    spec = loads(SUCKED.format(contact=contact, load=load))
    assert [(c.name, c.groups[0]) for c in spec.contact] == expected
    assert loads(spec.to_yaml()) == spec
