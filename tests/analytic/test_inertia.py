"""Bodies with inertia in real time against closed forms of linear vibration.

A bar without Poisson's effect, of Young's modulus E and density ρ, fixed at one end: waves at
c = √(E/ρ), first period 4 L/c. Strains are 1e-4 and less, so that the law is linear.
"""

import numpy as np
import pytest

from softact.bodies.layer import BondedLayer
from softact.loads.dynamics import Dynamics
from softact.loads.load_step import LoadStep
from softact.loads.timing import Hold, Smooth, Sudden, Timing
from softact.materials import LAWS
from softact.solve.generalised_alpha import VELOCITY, WORK, kinetic_energy
from tests.analytic.meshes import block
from tests.analytic.solving import CLAMP, build, solve

SHEAR, DENSITY, LENGTH, HEIGHT = 0.2, 1e-9, 40.0, 4.0
YOUNG = 2 * SHEAR
PERIOD = 4 * LENGTH / np.sqrt(YOUNG / DENSITY)
WEIGHT = 1e-4 * YOUNG / (DENSITY * LENGTH)  # mm/s², for a static strain of 1e-4 at the clamp
STATIC = DENSITY * WEIGHT * LENGTH**2 / (2 * YOUNG)


def bar(cells=8, density=DENSITY, layers=()):
    law = LAWS["neo_hookean"].of(c10=SHEAR / 2, bulk_modulus=2 * SHEAR / 3, density=density)
    return build(block((cells, 1, 1), size=(LENGTH, HEIGHT, HEIGHT)), law, layers=layers)


def moved(solution, component=0):
    """Times and mean displacements of the tip at all states."""
    model = solution.model
    tip = model.displacement_dofs[model.surfaces.nodes("x_max"), component]
    times = np.array([state.clock.now for state in solution.path])
    return times, np.array([state.x[tip].mean() for state in solution.path])


def dropped(periods, increments, radius=1.0):
    """A bar on which its weight acts suddenly."""
    timing = Timing(periods * PERIOD, Sudden(), Dynamics(radius))
    step = LoadStep("drop", gravity=(WEIGHT, 0, 0), timing=timing)
    return solve(bar(), step, [CLAMP], 1 / (periods * increments), time_tolerance=1.0)


def periods_of(times, values):
    """Mean time between rising passages through zero."""
    up = np.flatnonzero((values[:-1] < 0) & (values[1:] >= 0))
    at = times[up] - values[up] * (times[up + 1] - times[up]) / (values[up + 1] - values[up])
    return np.diff(at).mean()


def test_suddenly_applied_weight():
    """The end of the bar goes twice as far as under its weight at rest, after half a period."""
    times, way = moved(dropped(1, 40))
    assert way.max() == pytest.approx(2 * STATIC, rel=0.01)
    assert times[way.argmax()] == pytest.approx(PERIOD / 2, rel=0.026)
    assert way.min() > -0.01 * STATIC


def test_free_vibration():
    """Let go from a stretched state, in the shape of the first mode for the most part: 8/π² of it,
    and odd higher ones whose periods are its fractions."""
    pull = LoadStep("pull", traction={"x_max": [1e-4 * YOUNG, 0, 0]})
    timing = Timing(4 * PERIOD, Sudden(), Dynamics(1.0))
    free = LoadStep("free", traction={"x_max": [0.0, 0, 0]}, timing=timing)
    solution = solve(bar(), [pull, free], [CLAMP], 1 / 160, time_tolerance=1.0)
    times, way = moved(solution)
    vibrating = times > 0
    assert periods_of(times[vibrating], way[vibrating]) == pytest.approx(PERIOD, rel=0.01)


def test_layers_swing_along():
    """As heavy as the bar, and without stiffness: √2 times the period."""
    heavy = LAWS["linear"].of(youngs_modulus=1e-9 * YOUNG, poissons_ratio=0.0, density=DENSITY)
    layers = [BondedLayer(name, heavy, HEIGHT / 2, bending=0.0) for name in ("z_min", "z_max")]
    pull = LoadStep("pull", traction={"x_max": [1e-4 * YOUNG, 0, 0]})
    timing = Timing(3 * PERIOD, Sudden(), Dynamics(1.0))
    free = LoadStep("free", traction={"x_max": [0.0, 0, 0]}, timing=timing)
    solution = solve(bar(layers=layers), [pull, free], [CLAMP], 1 / 120, time_tolerance=1.0)
    times, way = moved(solution)
    vibrating = times > 0
    found = periods_of(times[vibrating], way[vibrating])
    assert found == pytest.approx(2**0.5 * PERIOD, rel=0.01)


def test_bending_period():
    """A slender cantilever (L/h = 20) that its weight falls on: Euler and Bernoulli's first
    frequency ω = 1.8751² √(E I/(ρ A L⁴)), and about twice the static deflection q L⁴/(8 E I)."""
    length, gravity = 2 * LENGTH, 1e-3 * WEIGHT
    omega = 1.8751041**2 * np.sqrt(YOUNG * HEIGHT**2 / 12 / (DENSITY * length**4))
    period = 2 * np.pi / omega
    timing = Timing(2.5 * period, Sudden(), Dynamics(1.0))
    step = LoadStep("drop", gravity=(0, 0, -gravity), timing=timing)
    law = LAWS["neo_hookean"].of(c10=SHEAR / 2, bulk_modulus=2 * SHEAR / 3, density=DENSITY)
    model = build(block((10, 1, 1), size=(length, HEIGHT, HEIGHT)), law)
    times, way = moved(solve(model, step, [CLAMP], 1 / 100, time_tolerance=1.0), 2)
    static = DENSITY * gravity * HEIGHT**2 * length**4 / (8 * YOUNG * HEIGHT**4 / 12)
    assert -way.min() == pytest.approx(2 * static, rel=0.03)  # higher modes add to the first
    # About the static value, not the mean over parts of periods.
    assert periods_of(times, way + static) == pytest.approx(period, rel=0.01)


def test_energy_is_kept_over_a_hundred_periods():
    """Spectral radius 1: the sum of kinetic and stored energy less the weight's work."""
    pull = LoadStep("pull", traction={"x_max": [1e-4 * YOUNG, 0, 0]})
    timing = Timing(100 * PERIOD, Sudden(), Dynamics(1.0))
    free = LoadStep("free", traction={"x_max": [0.0, 0, 0]}, timing=timing, max_increment=1 / 600)
    model = bar(1)
    solution = solve(model, [pull, free], [CLAMP], 1.0, time_tolerance=1.0)
    states = [state for state in solution.path if VELOCITY in state.memory]
    energy = np.array([kinetic_energy(model, s) + model.strain_energy(s) for s in states])
    assert len(states) > 600
    assert np.abs(energy / energy[0] - 1).max() < 1e-3


def test_low_spectral_radius_takes_energy():
    """What the scheme dissipates is the work less what is there, and is no gain."""
    solution = dropped(3, 20, radius=0.0)
    model, states = solution.model, solution.path[1:]
    there = np.array([kinetic_energy(model, s) + model.strain_energy(s) for s in states])
    supplied = np.array([s.memory[WORK] for s in states])
    lost = supplied - there
    assert lost[-1] > 0.01 * supplied.max()
    assert lost.min() > -1e-3 * supplied.max()


@pytest.mark.parametrize("radius", [0.0, 0.8, 1.0])
def test_second_order_in_time(radius):
    """Errors of all displacements and velocities after a period, from one halving of the increment
    to the next. (One displacement alone may have errors that cancel.)"""

    def end(count):
        timing = Timing(PERIOD, Smooth(), Dynamics(radius))
        step = LoadStep("raise", gravity=(WEIGHT, 0, 0), timing=timing)
        solution = solve(bar(1), step, [CLAMP], 1 / count, time_tolerance=1.0, tolerance=1e-12)
        dofs, state = solution.model.displacement_dofs, solution.state
        velocity = state.memory[VELOCITY][dofs] * PERIOD / (2 * np.pi)
        return np.concatenate([state.x[dofs], velocity])

    exact = end(640)
    errors = [np.linalg.norm(end(count) - exact) for count in (40, 80)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.25)


def test_increments_follow_the_accuracy_in_time():
    """A tighter tolerance takes more increments, and the motion comes nearer to the exact one."""

    def end(tolerance):
        timing = Timing(0.5 * PERIOD, Sudden(), Dynamics(1.0))
        step = LoadStep("drop", gravity=(100 * WEIGHT, 0, 0), timing=timing)
        solution = solve(bar(2), step, [CLAMP], 0.2, time_tolerance=tolerance)
        return len(solution.path), moved(solution)[1][-1]

    (few, rough), (more, finer), (most, exact) = map(end, (1e-2, 1e-4, 1e-6))
    assert few < more < most
    assert abs(finer - exact) < 0.5 * abs(rough - exact)


def test_steps_without_inertia_come_to_rest():
    """After a clocked step with inertia, one without a clock ends where it would have ended."""
    drop = LoadStep(
        "drop", gravity=(WEIGHT, 0, 0), timing=Timing(0.3 * PERIOD, Sudden(), Dynamics())
    )
    rest = LoadStep("rest", gravity=(WEIGHT, 0, 0))
    model = bar(2)
    solution = solve(model, [drop, rest], [CLAMP], 0.25)
    alone = solve(bar(2), rest, [CLAMP])
    assert kinetic_energy(model, solution.ends[0]) > 0
    assert kinetic_energy(model, solution.state) == 0
    np.testing.assert_allclose(moved(solution)[1][-1], moved(alone)[1][-1], rtol=1e-6)


def test_velocity_is_carried_into_the_next_step():
    """One step of two halves is two steps."""

    def step(name, part, amplitude):
        timing = Timing(part * PERIOD, amplitude, Dynamics(1.0))
        return LoadStep(name, gravity=(WEIGHT, 0, 0), timing=timing)

    whole = solve(bar(2), step("whole", 0.4, Sudden()), [CLAMP], 1 / 80, time_tolerance=1.0)
    halves = [step("one", 0.2, Sudden()), step("two", 0.2, Hold())]
    parted = solve(bar(2), halves, [CLAMP], 1 / 40, time_tolerance=1.0)
    assert moved(parted)[1][-1] == pytest.approx(moved(whole)[1][-1], rel=1e-3)
