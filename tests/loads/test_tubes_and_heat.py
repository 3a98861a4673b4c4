"""Air through tubes, air that keeps its heat, and an ambient that falls: against closed forms."""

import numpy as np
import pytest
import scipy.integrate
import scipy.optimize
from mpi4py import MPI

from softact import spec as specs
from softact.errors import SpecError
from softact.geometries.thick_sphere import ThickSphere
from softact.geometry.base import make_mesh
from softact.loads.air_account import account_of
from softact.loads.gas_flow import AMBIENT, NORMAL_LITRE, SPEED, Valve
from softact.loads.load_step import LoadStep
from softact.loads.timing import Timing
from softact.loads.tube_flow import VISCOSITY, Tube, friction_factor
from softact.materials import LAWS
from softact.mesh.msh_file import read_msh
from softact.mesh.tetrahedra import distribute
from softact.model import Model
from tests.analytic.solving import solve
from tests.loads.supplies import line
from tests.loads.test_air import FIXED, SPHERE, amounts, pressures, vessel

CHOKED = 0.684731  # √γ (2/(γ + 1))^((γ+1)/(2(γ−1)))


def times_of(solution):
    return np.array([s.clock.now for s in solution.path])


# --- a tube ---------------------------------------------------------------------------------------


def test_friction_factor():
    """64/Re where laminar; Prandtl and Kármán's implicit law of smooth tubes where turbulent."""
    for reynolds in (10.0, 300.0, 1500.0):
        assert friction_factor(reynolds) == pytest.approx(64 / reynolds, rel=2e-3)
    for reynolds in (2e4, 1e5, 1e6):
        exact = scipy.optimize.brentq(
            lambda f, re=reynolds: 2 * np.log10(re * np.sqrt(f)) - 0.8 - 1 / np.sqrt(f), 1e-3, 0.1
        )
        assert friction_factor(reynolds) == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize("valve", [{}, {"area": 0.3}, {"conductance": 3e5}])
@pytest.mark.parametrize("length,diameter", [(1000.0, 2.0), (500.0, 0.5), (40.0, 4.0)])
def test_flow_through_a_tube_is_a_slope(length, diameter, valve):
    """Its derivative against differences, laminar, turbulent, choked and backwards."""
    whole = Valve(0.3, **valve, tube=Tube(length, diameter, SPEED))
    for pressure in (0.0, 0.12, 0.2, 0.29, 0.2999, 0.31, 0.5, 1.5):
        ahead, behind = (whole.flow(pressure + h)[0] for h in (1e-7, -1e-7))
        slope = (ahead - behind) / 2e-7
        assert whole.flow(pressure)[1] == pytest.approx(
            slope, rel=1e-4, abs=1e-6 * whole.flow(0.0)[0]
        )
        assert whole.flow(pressure)[0] * (0.3 - pressure) > 0
    assert whole.flow(0.3)[0] == pytest.approx(0.0, abs=1e-9)


def test_equation_of_isothermal_flow_with_friction():
    """Every flow meets it; the largest has a Mach number of 1/√γ at the outlet, by hand."""
    tube, up = Tube(3000.0, 2.0, SPEED), 0.5
    area = np.pi * tube.diameter**2 / 4

    def losses(flow):
        return friction_factor(tube.reynolds(flow)) * tube.length / tube.diameter

    for down in (0.45, 0.3, 0.2):
        flow = tube.between(up, down)[0]
        left = (flow / (area * SPEED)) ** 2 * (losses(flow) + 2 * np.log(up / down))
        assert left == pytest.approx(up**2 - down**2, rel=1e-9)
    choked = tube.between(up, 0.01)[0]
    down = choked / (area * SPEED)  # ρ v² = p there
    left = down**2 * (losses(choked) + 2 * np.log(up / down))
    assert left == pytest.approx(up**2 - down**2, rel=1e-9)


def test_a_valve_and_a_tube_in_a_row():
    """What passes one passes the other; on the way out the tube comes first."""
    valve, tube = Valve(0.3, area=0.5), Tube(1000.0, 2.0, SPEED)
    both = Valve(0.3, area=0.5, tube=tube)
    flow = both.flow(0.1)[0]
    between = scipy.optimize.brentq(
        lambda p: valve.flow(p - AMBIENT)[0] - flow, 0.1 + AMBIENT, 0.2999 + AMBIENT
    )
    assert tube.between(between, 0.1 + AMBIENT)[0] == pytest.approx(flow, rel=1e-9)
    out = -both.flow(0.9)[0]
    between = scipy.optimize.brentq(
        lambda p: tube.between(0.9 + AMBIENT, p)[0] - out, 0.4 + AMBIENT, 0.8999 + AMBIENT
    )
    behind = -Valve(0.3, area=0.5).flow(between - AMBIENT)[0]
    assert behind == pytest.approx(out, rel=1e-9)


def test_rigid_vessel_fills_through_a_laminar_tube():
    """V dp/dt = k (pₛ² − p²) with Hagen and Poiseuille's k: p = pₛ tanh(k pₛ t/V + c)."""
    model = vessel(1e4)
    supply, length, diameter = 0.2, 2000.0, 0.04
    step = LoadStep(
        "fill",
        timing=Timing(2.0),
        supply={"cavity": line(supply, length=length, diameter=diameter)},
    )
    solution = solve(model, step, FIXED, 0.1, time_tolerance=3e-4)
    times, volume = times_of(solution), model.cavity_volume(solution.path[0], "cavity")
    k, top = np.pi * diameter**4 / (256 * VISCOSITY * length), supply + AMBIENT
    expected = top * np.tanh(k * top * times / volume + np.arctanh(AMBIENT / top)) - AMBIENT
    np.testing.assert_allclose(pressures(solution), expected, atol=0.005 * supply)
    assert expected[-1] > 0.3 * supply


# --- air that keeps its heat ----------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [1.0, 1.2, 1.4])
def test_rigid_vessel_fills_without_losing_heat(exponent):
    """Choked: p rises n times as fast as at one temperature, (p − p₀) V = n Q t."""
    model, area = vessel(1e4), 1e-6
    step = LoadStep(
        "fill", timing=Timing(0.5), supply={"cavity": line(1.0, area, exponent=exponent)}
    )
    solution = solve(model, step, FIXED, 0.25)
    volume = model.cavity_volume(solution.path[0], "cavity")
    flow = area * (1.0 + AMBIENT) * SPEED * CHOKED
    expected = exponent * flow * times_of(solution) / volume
    np.testing.assert_allclose(pressures(solution)[1:], expected[1:], rtol=5e-3)
    used = account_of(solution.state.memory, "cavity").used
    assert used == pytest.approx(0.5 * flow, rel=1e-5)


@pytest.mark.parametrize("exponent", [1.0, 1.4])
def test_rigid_vessel_is_emptied_without_gaining_heat(exponent):
    """Choked outflow cools what stays: m = (1 + (n − 1) a t/2)^(−2/(n−1)), p ∝ mⁿ."""
    model, area, start = vessel(1e4), 2e-6, 0.9
    steps = [
        LoadStep("up", pressure={"cavity": start}),
        LoadStep(
            "empty", timing=Timing(0.8), exhaust={"cavity": line(0.0, area, exponent=exponent)}
        ),
    ]
    solution = solve(model, steps, FIXED, 0.05, time_tolerance=2e-4)
    path = [s for s in solution.path if s["pressure"].get("cavity", 0.0) and s.clock.now > 0]
    times = np.array([s.clock.now for s in path])
    volume = model.cavity_volume(path[0], "cavity")
    rate = area * SPEED * CHOKED / volume  # ṁ/m at first
    if exponent == 1.0:
        mass = np.exp(-rate * times)
    else:
        mass = (1 + (exponent - 1) / 2 * rate * times) ** (-2 / (exponent - 1))
    expected = (start + AMBIENT) * mass**exponent - AMBIENT
    assert expected[-1] + AMBIENT > AMBIENT / 0.528  # choked to the end
    found = [s["pressure"]["cavity"] for s in path]
    np.testing.assert_allclose(found, expected, rtol=5e-3)
    assert expected[-1] < 0.7 * start


def test_closed_air_keeps_its_heat_as_it_is_squeezed():
    """p Vⁿ stays, to 1e-7, and the pressure is that of a run by pressure, to 1e-6 mm."""
    from softact.model import Support

    model, held = vessel(0.1), [*FIXED, Support("x_max", {0: -0.4})]
    steps = [
        LoadStep("up", pressure={"cavity": 0.005}),
        LoadStep("squeezed", held, sealed={"cavity": [1.0, 1.4]}),
    ]
    solution = solve(model, steps, FIXED, 0.25)
    ends = [solution.ends[0], solution.state]
    volumes = [model.cavity_volume(s, "cavity") for s in ends]
    absolute = [float(s["pressure"]["cavity"]) + AMBIENT for s in ends]
    assert volumes[1] < 0.97 * volumes[0]
    kept = [p * v**1.4 for p, v in zip(absolute, volumes, strict=True)]
    assert kept[1] == pytest.approx(kept[0], rel=1e-7)
    p = absolute[1] - AMBIENT
    other = solve(vessel(0.1), LoadStep("p", held, pressure={"cavity": p}), FIXED, 0.25)
    np.testing.assert_allclose(solution.state.x, other.state.x, atol=1e-6)


@pytest.mark.parametrize("exponent", [1.0, 1.4])
def test_balance_of_mass_of_a_soft_vessel(exponent):
    """Filled, closed, emptied: what is in it is what has flowed in less what has flowed out, to
    1e-8, and what was used and its exergy are the integrals of the flow."""
    model, valve = vessel(0.1), Valve(0.03, conductance=2.0)
    steps = [
        LoadStep(
            "fill",
            timing=Timing(1.0),
            supply={"cavity": line(0.03, conductance=2.0, exponent=exponent)},
        ),
        LoadStep("closed", sealed={"cavity": [1.0, exponent]}),
        LoadStep(
            "empty",
            timing=Timing(0.5),
            exhaust={"cavity": line(conductance=1.0, exponent=exponent)},
        ),
    ]
    solution = solve(model, steps, FIXED, 0.2, tolerance=1e-11)
    first = AMBIENT * model.cavity_volume(solution.path[0], "cavity")
    times, p = times_of(solution), pressures(solution)
    filled = len([t for t in times if t <= 1.0 + 1e-12])
    known = [account_of(s.memory, "cavity") for s in solution.path[1:]]
    brought = [a.flow * dt for a, dt in zip(known, np.diff(times), strict=True)]
    assert known[-1].mass == pytest.approx(first + sum(brought), rel=1e-8)
    inflow = [valve.flow(x)[0] * dt for x, dt in zip(p[1:], np.diff(times), strict=True)]
    used = sum(inflow[: filled - 1])
    assert known[-1].used == pytest.approx(used, rel=1e-8)
    assert known[-1].exergy == pytest.approx(used * np.log(1 + 0.03 / AMBIENT), rel=1e-8)
    if exponent == 1.0:
        inside = amounts(model, solution)[-1]
        assert known[-1].mass == pytest.approx(inside, rel=1e-8)


# --- an ambient that falls ------------------------------------------------------------------------

INNER, OUTER, C10 = 10.0, 11.0, 0.1


@pytest.fixture(scope="module")
def balloon(tmp_path_factory):
    part = ThickSphere.model_validate(
        {
            "type": "thick_sphere",
            "inner_radius": f"{INNER} mm",
            "outer_radius": f"{OUTER} mm",
            "mesh_size": f"{11 * np.pi / 2 / 6:.6f} mm",
        }
    )
    path, layout = tmp_path_factory.mktemp("sphere") / "mesh.msh", part.layout()
    make_mesh(part, path)
    tets = distribute(MPI.COMM_SELF, lambda: read_msh(path, layout), layout)
    law = LAWS["neo_hookean"].of(c10=C10, bulk_modulus=1e4)
    return Model(tets, {"body": law.material()})


def wall(stretch):
    """p of a neo-Hookean sphere, ∫ 2 (σθ − σr) dr/r by quadrature over the undeformed radius."""

    def slope(radius):
        r3 = radius**3 + (stretch**3 - 1) * INNER**3
        hoop = np.cbrt(r3) / radius
        return 2 * 2 * C10 * (hoop**2 - hoop**-4) * radius**2 / r3

    return scipy.integrate.quad(slope, INNER, OUTER)[0]


def expected_stretch(outside, heated, exponent):
    """Inner stretch of a balloon that was closed at no pressure."""

    def off(stretch):
        inside = (wall(stretch) + outside) * stretch ** (3 * exponent)
        return inside - AMBIENT * heated

    return scipy.optimize.brentq(off, 0.8, 1.5)


@pytest.mark.parametrize(
    "outside,heated,exponent",
    [(0.085, 1.0, 1.0), (0.085, 1.0, 1.4), (AMBIENT, 1.15, 1.0), (0.09, 1.08, 1.0)],
)
def test_sealed_balloon(balloon, outside, heated, exponent):
    """Its ambient falls, it is heated, or both: pressure and stretch by quadrature, 0.5 %."""
    air = {"sealed": {"cavity": [heated, exponent]}, "ambient": {"": outside}}
    step = LoadStep("up", **air)
    solution = solve(balloon, step, [], 0.25)
    first = balloon.cavity_volume(balloon.initial_state(), "cavity")
    stretch = np.cbrt(balloon.cavity_volume(solution.state, "cavity") / first)
    expected = expected_stretch(outside, heated, exponent)
    assert expected > 1.02
    assert stretch - 1 == pytest.approx(expected - 1, rel=5e-3)
    p = float(solution.state["pressure"]["cavity"])
    assert p == pytest.approx(wall(expected), rel=5e-3)


# --- in a spec ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "step,said",
    [
        (
            "supply: {pressure: 6 kPa, tube: {length: 1 m}}, duration: 1 s",
            "tube.diameter: missing",
        ),
        (
            "supply: {pressure: 6 kPa, diameter: 1 mm, polytropic: 1.6}, duration: 1 s",
            "must be at most 1.4",
        ),
        (
            "supply: {pressure: 6 kPa, diameter: 1 mm, conductance: 2 l/(min*bar)}, duration: 1 s",
            "a diameter or a conductance, not both",
        ),
        ("sealed: {heated: 1.1, polytropic: 1.2}", "heated says the temperature"),
        ("exhaust: {diameter: 1 mm}", "air takes time to flow"),
        (
            "exhaust: {diameter: 1 mm}, supply: {pressure: 6 kPa, diameter: 1 mm}, duration: 1 s",
            "drive cavities by one of them",
        ),
        ("pressure: 3 kPa, ambient: 90 kPa", "it acts on a sealed cavity only"),
        ("sealed: true, ambient: 0 kPa", "greater than 0"),
    ],
)
def test_what_is_wrong_is_said(step, said):
    with pytest.raises(SpecError) as raised:
        specs.loads(SPHERE % step)
    assert any(said in line for line in raised.value.lines), raised.value.lines


def test_what_a_spec_may_write():
    spec = specs.loads(
        SPHERE % "supply: {pressure: 60 kPa, tube: {length: 1 m, diameter: 2 mm}, "
        "polytropic: 1.2}, duration: 1 s"
    )
    assert specs.loads(spec.to_yaml()) == spec
    for step in ("exhaust: {diameter: 2 mm}, duration: 1 s", "sealed: true, ambient: 80 kPa"):
        other = specs.loads(SPHERE % step)
        assert specs.loads(other.to_yaml()) == other


def test_normal_litre():
    """A litre at 0 °C and 101.325 kPa is 1.0732 litres at 20 °C."""
    assert NORMAL_LITRE / (AMBIENT * 1e6) == pytest.approx(1.07322, rel=1e-5)
