"""Carried masses against closed forms: a bar that stretches and swings, a rigid plate that turns.

A bar without Poisson's effect, of Young's modulus E and density ρ, with a mass M at its free end:
ω = β c/L with β tan β = ρ A L/M and c = √(E/ρ) (S. S. Rao, Mechanical Vibrations, section 8.3).
"""

import numpy as np
import pytest
import scipy.optimize

from softact import spec
from softact.bodies.carried_mass import CarriedMass
from softact.errors import SpecError
from softact.estimate.driven import left_out
from softact.estimate.weight import last_loads
from softact.export.states import _Ramps
from softact.fields import STANDARD_GRAVITY
from softact.loads.dynamics import Dynamics
from softact.loads.load_step import LoadStep
from softact.loads.timing import Sudden, Timing
from softact.materials import LAWS
from softact.results.folder import read
from softact.run import start as runs
from tests.analytic.meshes import block
from tests.analytic.solving import CLAMP, build, solve


def carried(mass):
    return CarriedMass(mass=f"{mass!r} tonne")


SHEAR, DENSITY, LENGTH, HEIGHT = 0.2, 1e-9, 40.0, 4.0
YOUNG, AREA = 2 * SHEAR, HEIGHT**2
OWN = DENSITY * AREA * LENGTH
MASS = 3 * OWN


def bar(*masses, symmetry=None):
    law = LAWS["neo_hookean"].of(c10=SHEAR / 2, bulk_modulus=2 * SHEAR / 3, density=DENSITY)
    tets = block((8, 1, 1), size=(LENGTH, HEIGHT, HEIGHT))
    return build(tets, law, symmetry=symmetry, more={"masses": masses})


def test_gravity_pulls_at_it_as_a_payload_of_its_weight():
    pull = 1e-2 * YOUNG * AREA / MASS
    hung = solve(bar(carried(MASS)), LoadStep("hang", gravity=(pull, 0, 0)), [CLAMP])
    weight = {"x_max": np.array([MASS * pull / AREA, 0, 0])}
    alike = LoadStep("pull", gravity=(pull, 0, 0), payload=weight)
    wanted = solve(bar(), alike, [CLAMP]).displacement((LENGTH, 0, 0))
    assert hung.displacement((LENGTH, 0, 0)) == pytest.approx(wanted, rel=1e-9)
    whole = -(MASS + OWN) * pull
    assert hung.reaction("x_min")[0] == pytest.approx(whole, rel=1e-8)


def test_a_half_carries_half():
    one, half = bar(carried(MASS)), bar(carried(MASS), symmetry={"y_min": 1})
    assert [m.masses[0].mass for m in (one, half)] == pytest.approx([MASS, MASS / 2])


def test_a_bar_swings_slower_with_it():
    """Let go under a weight: the first mode for the most part; its period to 1 %."""
    beta = scipy.optimize.brentq(lambda b: b * np.tan(b) - OWN / MASS, 1e-6, 1.5)
    period = 2 * np.pi * LENGTH / (beta * np.sqrt(YOUNG / DENSITY))
    gravity = 1e-4 * YOUNG * AREA / (MASS * 1.0)
    timing = Timing(1.4 * period, Sudden(), Dynamics(1.0))
    step = LoadStep("drop", gravity=(gravity, 0, 0), timing=timing)
    model = bar(carried(MASS))
    solution = solve(model, step, [CLAMP], 1 / 56, time_tolerance=1.0)
    tip = model.displacement_dofs[model.surfaces.nodes("x_max"), 0]
    times = np.array([state.clock.now for state in solution.path])
    way = np.array([state.x[tip].mean() for state in solution.path])
    middle = way - way.max() / 2
    up = np.flatnonzero((middle[:-1] < 0) & (middle[1:] >= 0))
    at = times[up] - middle[up] * (times[up + 1] - times[up]) / (middle[up + 1] - middle[up])
    assert np.diff(at).mean() == pytest.approx(period, rel=0.01)
    assert way.max() == pytest.approx(2 * (MASS + OWN / 2) * gravity * LENGTH / (YOUNG * AREA),
                                      rel=0.01)  # fmt: skip


def test_a_plate_that_turns_has_the_inertia_of_a_plate():
    """Kinetic energy of the face turning about its middle: M (b² + h²)/24 for 1 rad/s."""
    model = bar(carried(MASS))
    model.add_inertia()
    x = np.zeros(model.unknowns.local)
    nodes = model.surfaces.nodes("x_max")
    arms = model.nodes.places[nodes] - [LENGTH, HEIGHT / 2, HEIGHT / 2]
    x[model.displacement_dofs[nodes]] = np.cross([1.0, 0, 0], arms)
    energy = model.inertia[-1].momentum(x) @ x / 2
    assert energy == pytest.approx(MASS * 2 * HEIGHT**2 / 24, rel=1e-12)


TEXT = """
geometry: {type: block, length: 8 mm, width: 4 mm, height: 3 mm, mesh_size: 3 mm}
materials: {body: {law: neo_hookean, c10: 0.14 MPa, density: 1130 kg/m^3}}
supports: [{surface: x_min, fix: [x, y, z]}]
masses: [{surface: x_max, mass: 2 g}, {surface: end, mass: 500 mg}]
points: {end: [8 mm, 2 mm, 1.5 mm]}
steps: [{name: weight, gravity: [0, 0, -1]}]
measures: [pressure, energy, tip, mass]
"""


@pytest.mark.parametrize("processes", [1, 2])
def test_the_actuator_weighs_what_it_did_and_the_work_on_them_is_told(tmp_path, processes):
    runs.run(spec.loads(TEXT), tmp_path / "run", processes=processes, report=False)
    results = read(tmp_path / "run")
    assert results.summary["mass_g"] == pytest.approx(1.13e-3 * 8 * 4 * 3, rel=1e-9)
    energy = results.curve["payload_energy_mJ"][-1]
    sunk = results.curve["tip_z_mm"][-1] - results.curve["tip_z_mm"][0]
    assert energy == pytest.approx(2.5e-6 * 9806.65 * sunk, rel=0.05) and energy < 0


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("mass: 2 g", "mass: 0 g", "masses.0.mass: "),
        ("mass: 2 g", "mass: 2 N", "masses.0.mass: '2 N' is a force"),
        ("mass: 2 g", "mass: 2", "masses.0.mass: "),
        ("x_max, mass", "x_mx, mass", "masses.0.surface: the geometry has no surface 'x_mx'"),
    ],
)
def test_wrong_masses_are_one_line(old, new, said):
    with pytest.raises(SpecError) as caught:
        spec.loads(TEXT.replace(old, new), "block.yaml")
    (line,) = caught.value.lines
    assert said in line


FINGER = """
geometry: {type: pneunet, chambers: 2, mesh_size: 6 mm}
materials: {body: elastosil-m4601}
%s
steps: [{name: down, gravity: [0, 0, -1]%s}, {name: up, pressure: 10 kPa}]
"""


def test_estimates_and_exports_take_its_weight_for_a_payload():
    weight = 20e-6 * STANDARD_GRAVITY
    masses = "masses: [{mass: 15 g}, {surface: tip, mass: 5 g}, {surface: base, mass: 1 kg}]"
    carried = spec.loads(FINGER % (masses, ""))
    loaded = spec.loads(FINGER % ("", f", payload: {{force: [0 N, 0 N, {-weight} N]}}"))
    assert last_loads(carried)[1] == pytest.approx(last_loads(loaded)[1], rel=1e-12)
    steps = {"step": np.array(["down", "down", "up"]), "step_fraction": np.array([0.5, 1.0, 1.0])}
    one, other = (_Ramps(each, steps).force_on("tip") for each in (carried, loaded))
    assert one == pytest.approx(other, rel=1e-12) and one[0, 2] == pytest.approx(-weight / 2)
    assert "mass on base" in left_out(carried, ("pressure", "gravity", "payload"))[0]
