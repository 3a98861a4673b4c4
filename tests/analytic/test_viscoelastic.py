"""Materials that creep and relax, in the solver, against integrals in time that it knows not of."""

import functools

import numpy as np
import pytest
from mpi4py import MPI

from softact.geometries.thick_sphere import ThickSphere
from softact.geometry.base import make_mesh
from softact.loads.load_step import LoadStep
from softact.loads.timing import Hold, Sine, Smooth, Steady, Timing
from softact.materials import LAWS
from softact.mesh.msh_file import read_msh
from softact.mesh.tetrahedra import distribute
from softact.model import Model, Support, Turn
from softact.system.term import Clock
from tests.analytic import maxwell
from tests.analytic.differences import dense, slope, to_global, to_local
from tests.analytic.meshes import block
from tests.analytic.solving import ROLLERS, build, solve
from tests.analytic.test_tangents import hollow_block, random_state

ONE = {"g": [0.4], "tau": ["0.8 s"], "constants": "long_time"}
THREE = {"g": [0.2, 0.15, 0.1], "tau": ["0.1 s", "1 s", "10 s"], "constants": "instantaneous"}
STEADY = Steady()
SERIES = pytest.mark.parametrize("series", [ONE, THREE], ids=["one", "three"])


def law(series, bulk=1e5, **more):
    return LAWS["neo_hookean"].of(c10=maxwell.C10, bulk_modulus=bulk, viscoelastic=series, **more)


def prony(series):
    return law(series).viscoelastic.prony


def cube(series):
    return build(block((1, 1, 1)), law(series))


def pulled(stretch, duration, amplitude=STEADY):
    supports = [*ROLLERS, Support("x_max", {0: stretch - 1})]
    return LoadStep("pull", supports, timing=Timing(duration, amplitude))


HELD = LoadStep("hold", timing=Timing(5.0, Hold()))


@SERIES
def test_relaxation(series):
    """Stretched to 1.6 in 0.2 s and held: nominal stress to 0.1 % at each increment."""
    solution = solve(cube(series), [pulled(1.6, 0.2), HELD], ROLLERS, 0.1)
    states = solution.path[1:]
    times = np.array([state.clock.now for state in states])
    expected = maxwell.force_of_stretch(prony(series), lambda t: 1 + 0.6 * min(t / 0.2, 1.0), times)
    area = [solution.reaction("x_max", state)[0] for state in states]
    np.testing.assert_allclose(area, expected, rtol=1e-3)
    assert expected[-1] < 0.9 * max(expected)
    if series is THREE:  # what was given up on the way has left no trace
        assert solution.stepper.progress.cutbacks > 0


@SERIES
def test_creep(series):
    """Under 60 kPa, raised in 0.2 s: stretch to 0.1 % of the elongation at each increment."""
    pull = LoadStep("pull", traction={"x_max": [0.06, 0.0, 0.0]}, timing=Timing(0.2))
    model = cube(series)
    solution = solve(model, [pull, HELD], ROLLERS, 0.1)
    states = solution.path[1:]
    times = np.array([state.clock.now for state in states])
    expected = maxwell.stretch_of_force(prony(series), lambda t: 0.06 * min(t / 0.2, 1.0), times)
    tip = model.displacement_dofs[model.surfaces.nodes("x_max"), 0]
    moved = np.array([state.x[tip].mean() for state in states])
    np.testing.assert_allclose(moved, np.array(expected) - 1, rtol=1e-3)
    at_once = np.interp(0.2, times, moved)
    assert moved[-1] > 1.2 * at_once


INNER, OUTER = 10.0, 11.0


@pytest.fixture(scope="module")
def sphere(tmp_path_factory):
    """An octant of a hollow sphere."""
    size = f"{11 * np.pi / 2 / 6:.6f} mm"
    part = ThickSphere.model_validate(
        {
            "type": "thick_sphere",
            "inner_radius": "10 mm",
            "outer_radius": "11 mm",
            "mesh_size": size,
        }
    )
    path, layout = tmp_path_factory.mktemp("sphere") / "mesh.msh", part.layout()
    make_mesh(part, path)
    return distribute(MPI.COMM_SELF, lambda: read_msh(path, layout), layout)


@SERIES
def test_pressurised_sphere(series, sphere):
    """Inflated in 0.2 s and held: stretch of the inner surface to 0.1 %."""
    model = Model(sphere, {"body": law(series, 1e4).material()})
    top = 0.01 if series is THREE else 0.016
    steps = [
        LoadStep("inflate", pressure={"cavity": top}, timing=Timing(0.2, Smooth())),
        LoadStep("hold", timing=Timing(3.0, Hold())),
    ]
    solution = solve(model, steps, [], 0.25, time_tolerance=1e-3)
    states = solution.path[1:]
    first = model.cavity_volume(model.initial_state(), "cavity")
    found = [np.cbrt(model.cavity_volume(state, "cavity") / first) for state in states]
    times = np.array([state.clock.now for state in states])

    def pressure(t):
        part = min(t / 0.2, 1.0)
        return top * part**2 * (3 - 2 * part)

    expected = maxwell.sphere_of_pressure(prony(series), pressure, INNER, OUTER, times)
    np.testing.assert_allclose(found, expected, rtol=1e-3)
    assert found[-1] - 1 > 1.2 * (found[times.searchsorted(0.2)] - 1)


@pytest.mark.parametrize("series,frequency", [(ONE, 0.2), (THREE, 1.0)], ids=["one", "three"])
def test_storage_and_loss_modulus(series, frequency):
    """Third cycle of a stretch of 0.2 %: E' = 3 G (1 + Σ b x²/(1 + x²)), E'' = 3 G Σ b x/(1 + x²)
    with x = ω τ, to 0.5 %."""
    strain = 2e-3
    step = pulled(1 + strain, 3 / frequency, Sine(3.0))
    solution = solve(cube(series), step, ROLLERS, 0.1, time_tolerance=1e-4)
    omega = 2 * np.pi * frequency
    states = [s for s in solution.path if s.clock.now > 2 / frequency]
    times = np.array([s.clock.now for s in states])
    stress = [solution.reaction("x_max", s)[0] for s in states]
    columns = [np.ones_like(times), times, -np.cos(omega * times), np.sin(omega * times)]
    _, _, storage, loss = np.linalg.lstsq(np.array(columns).T, np.array(stress), rcond=None)[0]
    p = prony(series)
    x = omega * p.times
    modulus = 6 * maxwell.C10 * strain / 2
    expected = (
        modulus * (p.elastic + p.shares @ (x**2 / (1 + x**2))),
        modulus * (p.shares @ (x / (1 + x**2))),
    )
    assert storage == pytest.approx(expected[0], rel=5e-3)
    assert loss == pytest.approx(expected[1], rel=5e-3)


def test_rotating_block_is_free_of_stress():
    """Turned by half a turn in 1 s, slower and faster than it relaxes."""
    turning = [Support("x_min", turn=Turn((0.0, 0.0, 1.0), 180.0, (0.0, 0.0, 0.0)))]
    model = build(block((2, 1, 1), (2.0, 1.0, 1.0)), law(THREE, 10.0))
    step = LoadStep("turn", turning, timing=Timing(1.0))
    solution = solve(model, step, [Support("x_min", {0: None, 1: None, 2: None})], 0.1)
    assert len(solution.path) > 5
    for state in solution.path:
        stress = model.solids["body"].cauchy(state)
        assert np.abs(stress).max() < 1e-9 * maxwell.C10
    assert solution.displacement((2.0, 0.0, 0.0))[0] == pytest.approx(-4.0)


def test_second_order_in_time():
    """Error of the stress at the end of a smooth stretch, over two halvings of the increment."""
    exact = maxwell.force_of_stretch(
        prony(ONE), lambda t: 1 + 0.6 * t**2 * (3 - 2 * t), np.array([0.0, 1.0])
    )[1]
    errors = []
    for count in (5, 10, 20):
        step = pulled(1.6, 1.0, Smooth())
        solution = solve(cube(ONE), step, ROLLERS, 1 / count, time_tolerance=1e9)
        assert len(solution.path) == count + 1
        errors.append(abs(solution.reaction("x_max")[0] - exact) / exact)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[-1] < 1e-3
    np.testing.assert_allclose(orders, 2.0, atol=0.15)


def test_increments_follow_the_tolerance():
    """A tolerance 9 times smaller wants three times as many: the error grows with the square."""
    counts = []
    for tolerance in (3.6e-3, 4e-4):
        step = pulled(1.6, 4.0, Smooth())
        counts.append(len(solve(cube(ONE), step, ROLLERS, 1.0, time_tolerance=tolerance).path))
    assert counts[0] > 4
    assert 2.0 < counts[1] / counts[0] < 4.0


@pytest.mark.parametrize("element", ["P2/P1", "P2"])
@pytest.mark.parametrize("mullins", [None, {"r": 1.5, "m": "1 kPa", "beta": 0.1}])
def test_tangent_is_slope_of_force(element, mullins):
    """Of a state in the middle of a time step, points on their way up and down."""
    made = LAWS["yeoh"].of(
        c10=0.11, c20=0.02, bulk_modulus=10.0, viscoelastic=THREE, mullins=mullins
    )
    model = hollow_block(made, element)
    before = random_state(model)
    before.clock = Clock(0.3, 0.0, True)
    model.remember(before)
    state = random_state(model, seed=3)
    state.put("surface_pressure", {"inside": 0.03})  # closed, so that it has a potential
    state.memory, state.clock = before.memory, Clock(0.7, 0.3, True)
    direction = np.random.default_rng(2).standard_normal(model.unknowns.local)
    matrix = dense(model.tangent(state))
    found = to_local(model, matrix @ to_global(model, direction))
    expected = slope(lambda s: model.force(s)[0], state, direction)
    follows = random_state(model, seed=3)  # without what was before
    assert np.linalg.norm(found - expected) <= 1e-6 * np.linalg.norm(expected)
    assert np.linalg.norm(model.force(state)[0] - model.force(follows)[0]) > 1e-3
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())


def test_nothing_that_relaxes_changes_no_bit():
    """Without terms, with terms of nothing, and without a clock."""
    plain = LAWS["neo_hookean"].of(c10=maxwell.C10, bulk_modulus=50.0)
    step = functools.partial(LoadStep, "pull", traction={"x_max": [0.06, 0.01, 0.0]})

    def end(series, timing=None):
        made = plain if series is None else law(series, 50.0)
        model = build(block((2, 1, 1)), made)
        fixed = [Support("x_min", {0: 0.0, 1: 0.0, 2: 0.0})]
        return solve(model, step(timing=timing), fixed, 0.25).state.x

    nothing = {"g": [0.0], "tau": ["1 s"], "constants": "long_time"}
    none = {"g": [], "tau": [], "constants": "instantaneous"}
    expected = end(None)
    assert np.array_equal(end(nothing), expected)
    assert np.array_equal(end(none), expected)
    np.testing.assert_allclose(end(ONE), expected, rtol=1e-9, atol=1e-12)
    assert np.array_equal(end(none, Timing(2.0)), end(None, Timing(2.0)))
    assert np.abs(end(ONE, Timing(0.01)) - expected).max() > 0.01
