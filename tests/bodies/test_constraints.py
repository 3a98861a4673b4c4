"""Faces that stay rigid, plane or parallel while they move freely, against exact solutions."""

import numpy as np
import pytest
import scipy.optimize
from mpi4py import MPI

from softact.bodies.constraints import ConstrainedFace, Constraint
from softact.bodies.face_nodes import far_apart
from softact.errors import SpecError
from softact.loads.load_step import LoadStep
from softact.loads.support import Support, Turn
from softact.materials import LAWS
from softact.measures import MEASURES
from softact.measures.snapshot import Snapshot
from softact.mesh.layout import Layout
from softact.mesh.tetrahedra import distribute
from softact.model import Model
from softact.system.rotation import rotation_about
from softact.system.term import Origin, State
from tests.analytic.differences import force, slope, tangent, to_global, to_local
from tests.analytic.meshes import block, disc
from tests.analytic.solving import ROLLERS, solve

C10 = 0.14  # MPa
RUBBER = LAWS["neo_hookean"].of(c10=C10, bulk_modulus=1e3)
KINDS = "rigid", "plane", "parallel"


def built(
    tets, constraints, law=RUBBER, symmetry=None, regions=("body",), clamp="x_min", element="P2/P1"
):
    """A model with constraints, {surface: how it stays}."""
    layout = Layout(
        regions=regions, surfaces=tuple(tets.surfaces), cavities={}, symmetry=symmetry or {},
        clamp=clamp, tip="x_max",
    )  # fmt: skip
    mesh = distribute(MPI.COMM_SELF, lambda: tets, layout)
    laws = law if isinstance(law, dict) else {"body": law}
    parts = [Constraint(surface=name, stays=kind) for name, kind in constraints.items()]
    materials = {name: one.material() for name, one in laws.items()}
    return Model(mesh, materials, element=element, more={"constraints": parts})


def face(model):
    return next(body for body in model.bodies if isinstance(body, ConstrainedFace))


def places(model, state, name):
    nodes = model.surfaces.nodes(name)
    return model.nodes.places[nodes], model.nodes.places[nodes] + state.x[
        model.displacement_dofs[nodes]
    ]


@pytest.mark.parametrize("symmetry", [{}, {"y_min": 1}])
@pytest.mark.parametrize(
    ("kind", "name"), [*((kind, "x_max") for kind in KINDS), ("rigid", "inside")]
)
def test_force_and_tangent_are_derivatives(kind, name, symmetry):
    """Of a flat face, and of the walls of a cave; with mirror images too."""
    keep = None
    if name == "inside":
        keep = lambda c: (np.abs(c - 1.5) > 0.6).any(axis=1)  # noqa: E731
    model = built(block((3, 3, 3), (3.0, 3.0, 3.0), keep=keep), {name: kind}, symmetry=symmetry)
    rng = np.random.default_rng(1)
    state = State(0.04 * rng.standard_normal(model.unknowns.local))
    direction = rng.standard_normal(model.unknowns.local)
    for term in face(model).external:
        found = force(model, term, state) @ direction
        assert found == pytest.approx(slope(term.energy, state, direction), rel=1e-6)
        matrix = tangent(model, [term], state)
        found = to_local(model, matrix @ to_global(model, direction))
        expected = slope(lambda s, term=term: force(model, term, s), state, direction)
        assert np.linalg.norm(found - expected) <= 1e-6 * np.linalg.norm(expected)
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())


@pytest.mark.parametrize("kind", KINDS)
def test_the_stress_that_is_carried_on_is_of_second_order(kind):
    """See ``Origin``: at the same state nothing changes."""
    model = built(block((2, 2, 2), (3.0, 3.0, 3.0)), {"x_max": kind})
    rng = np.random.default_rng(3)
    state, way = (0.05 * rng.standard_normal(model.unknowns.local) for _ in range(2))
    state = State(state)

    def matrix(origin):
        model.assembler.fixed[:] = 0
        model.assembler.clear()
        for term in face(model).external:
            term.add_tangent(state, origin)
        return model.assembler.extra_values.copy()

    exact = matrix(None)
    for origin in (Origin((state.x,), linearised=True), Origin((state.x,) * 2, (1.7, -0.7))):
        np.testing.assert_allclose(matrix(origin), exact, atol=1e-12 * np.abs(exact).max())
    if kind != "parallel":  # which is linear
        away = [
            np.abs(matrix(Origin((state.x - h * way,), linearised=True)) - exact).max()
            for h in (0.1, 0.05)
        ]
        assert away[0] / away[1] == pytest.approx(4.0, rel=0.15)


def test_a_rigid_motion_costs_nothing_and_any_other_does():
    model = built(block((2, 2, 2), (3.0, 3.0, 3.0)), {"x_max": "rigid"})
    dofs = model.displacement_dofs
    turn = rotation_about((1.0, 2.0, -1.0), 70.0)
    state = model.initial_state()
    state.x[dofs] = model.nodes.places @ (turn - np.eye(3)).T + (1.0, 2.0, 3.0)
    terms = face(model).external
    assert sum(term.energy(state) for term in terms) == pytest.approx(0.0, abs=1e-12)
    for stretch in np.eye(3)[1:]:
        state.x[dofs] = 0.1 * model.nodes.places * stretch
        assert sum(term.energy(state) for term in terms) > 1.0


def test_two_rubbers_side_by_side_under_one_plate():
    """Both keep λ across, so F = A (C₁ + C₂)(λ − λ⁻²): exact only where the face stays parallel.
    The pressure jumps between them, which P2/P0 can follow."""
    tets = block((2, 2, 2), (4.0, 4.0, 4.0))
    centres = tets.points[tets.cells].mean(axis=1)
    tets.region[:] = centres[:, 1] > 2.0
    laws = {
        "soft": LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=1e4),
        "stiff": LAWS["neo_hookean"].of(c10=0.3, bulk_modulus=1e4),
    }
    model = built(tets, {"x_max": "parallel"}, laws, regions=("soft", "stiff"), element="P2/P0")
    stretch = 1.3
    pull = (0.1 + 0.3) * (stretch - stretch**-2)
    step = LoadStep("pull", payload={"x_max": np.array([pull, 0.0, 0.0])})
    solution = solve(model, step, ROLLERS, 0.5)
    _, after = places(model, solution.state, "x_max")
    np.testing.assert_allclose(after[:, 0], 4.0 * stretch, rtol=2e-4)  # K/μ
    assert np.ptp(after[:, 0]) < 2e-4
    columns = MEASURES["faces"].evaluate(Snapshot(model, solution.state))
    assert columns["face_x_max_x_mm"] == pytest.approx(4.0 * stretch, rel=2e-4)
    assert columns["face_x_max_turn_z_deg"] == pytest.approx(0.0, abs=1e-2)


def flexure(length: float, thickness: float, width: float, angle: float) -> float:
    """N·mm that bend a block of neo-Hookean rubber into a sector (Rivlin 1949): θ = X/a,
    r_o² − r_i² = 2 a h, and r_i r_o = a² where both sides are free."""
    a = length / angle
    inner = scipy.optimize.brentq(
        lambda r: r**2 * (r**2 + 2 * a * thickness) - a**4, 0.1 * a, a, xtol=1e-14
    )
    outer = np.sqrt(inner**2 + 2 * a * thickness)
    r = np.linspace(inner, outer, 20001)
    stretch = r / a

    def energy(s):
        return C10 * (s**2 + s**-2 - 2)

    hoop = energy(stretch) - energy(inner / a) + 2 * C10 * (stretch**2 - stretch**-2)
    return width * float(
        np.trapezoid(hoop * r, r) if hasattr(np, "trapezoid") else np.trapz(hoop * r, r)
    )


@pytest.mark.parametrize("half", [False, True])
def test_a_plane_face_under_a_torque_is_rivlins_flexure(half):
    """In plane strain; half: of the width, with a symmetry plane. 1.2 rad in two increments."""
    length, thickness, width, angle = 4.0, 2.0, 1.0, 1.2
    tets = block((6, 1, 3), (length, width, thickness))
    symmetry = {"y_min": 1} if half else {}
    model = built(tets, {"x_max": "plane"}, symmetry=symmetry)
    moment = flexure(length, thickness, width, angle)
    sides = [Support("y_min", {1: 0.0}), Support("y_max", {1: 0.0})]
    held = [Support("x_min", {0: 0.0}), *sides[half:], Support("pin", {2: 0.0})]
    step = LoadStep("bend", torque={"x_max": np.array([0.0, moment, 0.0])})
    # The block may move along z: its lower left edge stays.
    nodes = model.surfaces.nodes("x_min")
    pin = nodes[model.nodes.places[nodes, 2] < 1e-9]
    known = model.surfaces.nodes
    model.surfaces.nodes = lambda name: pin if name == "pin" else known(name)
    solution = solve(model, step, held, 0.5)
    _, after = places(model, solution.state, "x_max")
    turned = np.linalg.lstsq(
        np.column_stack([after[:, 2], np.ones(len(after))]), after[:, 0], rcond=None
    )[0][0]
    assert np.arctan(turned) == pytest.approx(angle, rel=5e-3)
    plane = after - after.mean(axis=0)
    assert np.linalg.svd(plane)[1][2] < 1e-4
    # Its points slide: the face is thinner than it was.
    assert np.ptp(after[:, 2]) / np.cos(angle) < 0.99 * thickness


@pytest.fixture(scope="module")
def held():
    """A bar whose end is turned by 2 rad and moved: the state, and what holds the end."""
    model = built(bar(), {})
    turn = Support("z_max", turn=Turn((0.0, 0.0, 1.0), np.degrees(2.0)))
    clamp = Support("z_min", dict.fromkeys(range(3), 0.0))
    solution = solve(model, LoadStep("turn", [clamp, turn]), [clamp], 0.25)
    forces = model.force(solution.state)[0]
    nodes = model.surfaces.nodes("z_max")
    _, after = places(model, solution.state, "z_max")
    on_face = forces[model.displacement_dofs[nodes]]
    middle = after.mean(axis=0)
    return solution.state, on_face.sum(axis=0), np.cross(after - middle, on_face).sum(axis=0)


def bar():
    return block((4, 4, 3), (1.0, 1.0, 12.0), lambda points: disc(points, 5.0))


def test_a_rigid_face_goes_where_its_loads_take_it(held):
    """Under the force and the moment about its axis that held it in a turned support, it stands
    there again, but for the other moments that the mesh, which is not symmetric, asked for."""
    state, pull, moment = held
    model = built(bar(), {"z_max": "rigid"})
    area = model.surfaces.area("z_max")
    clamp = Support("z_min", dict.fromkeys(range(3), 0.0))
    twist = moment * (0.0, 0.0, 1.0)
    step = LoadStep("load", payload={"z_max": pull / area}, torque={"z_max": twist})
    solution = solve(model, step, [clamp], 0.25)
    before, found = places(model, solution.state, "z_max")
    wanted = places(model, state, "z_max")[1]
    assert found[:, 2].mean() == pytest.approx(wanted[:, 2].mean(), abs=2e-3)
    columns = MEASURES["faces"].evaluate(Snapshot(model, solution.state))
    assert columns["face_z_max_turn_z_deg"] == pytest.approx(np.degrees(2.0), rel=2e-3)
    lengths = [np.linalg.norm(p[:, None] - p[None], axis=2) for p in (before, found)]
    assert np.abs(lengths[1] - lengths[0]).max() < 1e-3


def test_what_cannot_be_kept_plane_is_refused():
    tets = block((3, 3, 3), (3.0, 3.0, 3.0), keep=lambda c: (np.abs(c - 1.5) > 0.6).any(axis=1))
    with pytest.raises(SpecError, match="'inside' is not flat"):
        built(tets, {"inside": "plane"})


def test_nodes_that_span_a_face():
    """Four in space, three in a plane, two on a line."""
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 4)] * 3), axis=-1).reshape(-1, 3)
    assert len(far_apart(grid)) == 4
    assert len(far_apart(grid[grid[:, 0] == 0])) == 3
    assert len(far_apart(grid[(grid[:, :2] == 0).all(axis=1)])) == 2
    assert len(far_apart(grid[:1])) == 1


@pytest.mark.parametrize("kind", KINDS)
def test_a_soft_long_beam_under_small_loads_meets_the_solvers_tolerance(kind):
    """Rounding, which stiff ties multiply, once kept the residual at 1e-7."""
    law = LAWS["neo_hookean"].of(c10=0.01, bulk_modulus=10.0)
    model = built(block((5, 2, 2), (40.0, 8.0, 8.0)), {"x_max": kind}, law)
    area = model.surfaces.area("x_max")
    clamp = Support("x_min", dict.fromkeys(range(3), 0.0))
    for pull in (1e-4, 1e-2):
        step = LoadStep("load", payload={"x_max": np.array([pull, 0.0, -pull / 10]) / area})
        solution = solve(model, step, [clamp], 0.5, dynamics=False)
        attempts = [a for a in solution.stepper.progress.attempts if a.iterations]
        assert all(a.converged and a.iterations < 9 for a in attempts)
