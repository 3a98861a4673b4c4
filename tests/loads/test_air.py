"""Air in cavities: flow through valves, rigid vessels that fill, and a balloon that is closed."""

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize

from softact import spec as specs
from softact.errors import SpecError
from softact.loads.gas_flow import AMBIENT, CRITICAL, SPEED, Valve
from softact.loads.load_step import LoadStep
from softact.loads.timing import Timing
from softact.materials import LAWS
from softact.model import Support
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve
from tests.loads.supplies import line

FIXED = [Support("x_min", {0: 0.0, 1: 0.0, 2: 0.0})]


def vessel(c10):
    """3 × 3 × 3 mm with a closed cavity of 1 mm³ in its middle."""
    tets = block((3, 3, 3), (3.0, 3.0, 3.0), keep=lambda c: (np.abs(c - 1.5) > 0.6).any(axis=1))
    law = LAWS["neo_hookean"].of(c10=c10, bulk_modulus=100 * c10)
    return build(tets, law, cavities={"cavity": ("inside",)})


def pressures(solution):
    return np.array([s["pressure"].get("cavity", 0.0) for s in solution.path])


def amounts(model, solution):
    volumes = [model.cavity_volume(s, "cavity") for s in solution.path]
    return (pressures(solution) + AMBIENT) * volumes


@pytest.mark.parametrize("valve", [Valve(0.3, area=0.5), Valve(0.3, conductance=40.0)])
def test_flow_is_a_slope(valve):
    """Its derivative against differences, choked, not choked and backwards; no jump at no flow."""
    for pressure in (0.0, 0.12, 0.2, 0.29, 0.2999, 0.31, 0.5, 1.5):
        ahead, behind = (valve.flow(pressure + h)[0] for h in (1e-8, -1e-8))
        assert valve.flow(pressure)[1] == pytest.approx((ahead - behind) / 2e-8, rel=1e-5, abs=1e-3)
        assert valve.flow(pressure)[0] * (0.3 - pressure) > 0
    assert valve.flow(0.3)[0] == pytest.approx(0.0, abs=1e-12)


def test_choked_flow_by_hand():
    """C A p √(R T) √γ (2/(γ + 1))^((γ+1)/(2(γ−1))): 0.6847 for air."""
    flow, slope = Valve(0.4, area=0.2).flow(0.0)
    assert flow == pytest.approx(0.2 * (0.4 + AMBIENT) * SPEED * 0.68473, rel=1e-5)
    assert slope == 0.0
    assert CRITICAL == pytest.approx(0.5283, rel=1e-4)


def test_rigid_vessel_fills_through_a_choked_orifice():
    """p rises along a straight line, Q/V: to 0.5 % at each increment."""
    model, area = vessel(1e4), 1e-6
    step = LoadStep("fill", timing=Timing(0.5), supply={"cavity": line(1.0, area)})
    solution = solve(model, step, FIXED, 0.25)
    times = np.array([s.clock.now for s in solution.path])
    volume = model.cavity_volume(solution.path[0], "cavity")
    flow = area * (1.0 + AMBIENT) * SPEED * 0.684731
    expected = flow * times / volume
    assert (expected[-1] + AMBIENT) / (1.0 + AMBIENT) < CRITICAL
    np.testing.assert_allclose(pressures(solution)[1:], expected[1:], rtol=5e-3)


def test_rigid_vessel_fills_up_and_is_emptied():
    """Choked, then not, to the supply's pressure; and out again: against the differential equation
    to 0.5 % of the supply's pressure."""
    model, area = vessel(1e4), 3e-6
    steps = [
        LoadStep("fill", timing=Timing(1.0), supply={"cavity": line(0.2, area)}),
        LoadStep("empty", timing=Timing(1.0), supply={"cavity": line(0.0, area)}),
    ]
    solution = solve(model, steps, FIXED, 0.1, time_tolerance=1.5e-4)
    volume = model.cavity_volume(solution.path[0], "cavity")
    times = np.array([s.clock.now for s in solution.path])

    def rate(t, p):
        return [Valve(0.2 if t < 1.0 else 0.0, area=area).flow(float(p[0]))[0] / volume]

    first = scipy.integrate.solve_ivp(rate, (0, 1), [0.0], "LSODA", times[times <= 1], rtol=1e-9)
    rest = (1, times[-1]), first.y[:, -1], "LSODA", times[times > 1]
    then = scipy.integrate.solve_ivp(rate, *rest, rtol=1e-9)
    expected = np.concatenate([first.y[0], then.y[0]])
    np.testing.assert_allclose(pressures(solution), expected, atol=0.005 * 0.2)
    assert max(expected) > 0.15
    assert expected[-1] < 0.5 * max(expected)


def test_soft_vessel_keeps_its_balance_of_mass():
    """What is in it is what has flowed in, to 1e-8 of it; and it is wider than a rigid one."""
    model, valve = vessel(0.1), Valve(0.03, conductance=2.0)
    step = LoadStep("fill", timing=Timing(1.0), supply={"cavity": line(0.03, conductance=2.0)})
    solution = solve(model, step, FIXED, 0.1, tolerance=1e-11)
    inside = amounts(model, solution)
    times = np.array([s.clock.now for s in solution.path])
    flowed = [valve.flow(p)[0] for p in pressures(solution)[1:]] * np.diff(times)
    np.testing.assert_allclose(np.diff(inside).sum(), flowed.sum(), rtol=1e-8)
    volumes = [model.cavity_volume(s, "cavity") for s in (solution.path[0], solution.state)]
    assert volumes[1] > 1.05 * volumes[0]


@pytest.mark.parametrize("pull", [0.0, 0.3])
def test_sealed_vessel_is_heated_or_pulled(pull):
    """p V = n R T with the wall's own p(V), which a run by pressure gives: to 1e-6."""
    model = vessel(0.1)
    held = [*FIXED, Support("x_max", {0: pull})]
    start = LoadStep("up", pressure={"cavity": 0.005})
    sealed = LoadStep(
        "sealed", held if pull else None, sealed={"cavity": [1.0 if pull else 1.15, 1.0]}
    )
    solution = solve(model, [start, sealed], FIXED, 0.25)
    end = solution.ends[0]
    before = (0.005 + AMBIENT) * model.cavity_volume(end, "cavity")
    p = float(solution.state["pressure"]["cavity"])
    now = (p + AMBIENT) * model.cavity_volume(solution.state, "cavity")
    assert now == pytest.approx(before * (1.0 if pull else 1.15), rel=1e-7)
    driven = [start, LoadStep("p", held if pull else None, pressure={"cavity": p})]
    other = solve(vessel(0.1), driven, FIXED, 0.25)
    np.testing.assert_allclose(solution.state.x, other.state.x, atol=1e-6)
    assert abs(p - 0.005) > 1e-3 if not pull else abs(p - 0.005) > 1e-5


SPHERE = """
geometry: {type: thick_sphere, inner_radius: 10 mm, outer_radius: 11 mm}
materials: {body: ecoflex-00-30}
steps: [{%s}]
"""


@pytest.mark.parametrize(
    "step,line",
    [
        ("supply: {pressure: 60 kPa, diameter: 1 mm}", "air takes time to flow; give the step"),
        ("supply: {pressure: 60 kPa}, duration: 1 s", "a diameter or a conductance"),
        (
            "supply: {pressure: 60 kPa, diameter: 1 mm}, pressure: 3 kPa, duration: 1 s",
            "this step has 'pressure' too; drive cavities by one of them",
        ),
        ("sealed: {other: {}}", "the geometry has no cavity 'other'"),
    ],
)
def test_what_is_wrong_is_one_line(step, line):
    with pytest.raises(SpecError) as raised:
        specs.loads(SPHERE % step)
    assert len(raised.value.lines) == 1, raised.value.lines
    assert line in raised.value.lines[0]


def test_what_a_spec_may_write():
    spec = specs.loads(
        SPHERE % "supply: {pressure: 60 kPa, conductance: 2 l/(min*bar)}, duration: 1 s"
    )
    (supply,) = spec.steps[0].supply.values()
    assert supply.conductance == pytest.approx(2e6 / 60 / 0.1)
    assert specs.loads(spec.to_yaml()) == spec
    closed = specs.loads(SPHERE % "sealed: true, gravity: [0, 0, -1]")
    assert [s.heated for s in closed.steps[0].sealed.values()] == [1.0]
