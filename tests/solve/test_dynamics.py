"""The last rungs of the ladder: past a snap by volume, and by damped motion.

A thick Gent sphere, A/B = 10/11, μ = 0.28 MPa, Jm = 30: its pressure has a maximum of 34.5 kPa at
an inner stretch of 1.5, falls to 30.9 kPa and rises again without bound. At 40 kPa there is one
equilibrium only, far beyond the maximum; quadrature gives its stretch.
"""

import re
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scipy.optimize
from mpi4py import MPI

from softact.geometries.thick_sphere import ThickSphere
from softact.geometry.base import make_mesh
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.msh_file import read_msh
from softact.mesh.tetrahedra import distribute
from softact.model import Model
from softact.solve.newton import Newton
from softact.solve.passed import Passed
from softact.solve.rungs.motion import PACE
from softact.solve.walk import Walk
from softact.system.term import EVERYTHING, TimeStep
from tests.analytic.differences import force, slope, tangent
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve
from tests.analytic.test_thick_walls import pressure_at

GENT = {"mu": 0.28, "jm": 30.0}
WANTED = 0.04  # MPa
DENSITY = 1.07e-9  # tonne/mm³


def gent(stretch):
    return pressure_at("gent", GENT, stretch)


@pytest.fixture(scope="module")
def mesh_of(tmp_path_factory):
    geometry = ThickSphere.model_validate({"mesh_size": "3 mm"})
    file, layout = tmp_path_factory.mktemp("sphere") / "mesh.msh", geometry.layout()
    make_mesh(geometry, file)
    return lambda: distribute(MPI.COMM_SELF, lambda: read_msh(file, layout), layout)


def inflate(mesh, **step):
    """The run to 40 kPa and the inner stretch at its end."""
    model = Model(mesh, {"body": LAWS["gent"].of(**GENT, bulk_modulus=1e4).material()})
    rest = model.cavity_volume(model.initial_state(), "cavity")
    step = LoadStep("inflate", pressure={"cavity": WANTED}, **step)
    solution = solve(model, step, [], 0.1)
    return solution, np.cbrt(model.cavity_volume(solution.state, "cavity") / rest)


@pytest.fixture(scope="module")
def caught():
    """Stretch at which the sphere holds 40 kPa."""
    return scipy.optimize.brentq(lambda s: gent(s) - WANTED, 3.0, 3.5)


def test_volume_leads_past_a_snap(mesh_of, caught):
    """The unstable branch is traced, the maximum is named, and the load is reached."""
    solution, stretch = inflate(mesh_of())
    assert stretch == pytest.approx(caught, rel=0.005)
    top = scipy.optimize.minimize_scalar(lambda s: -gent(s), bounds=(1.3, 1.8), method="bounded")
    (remark,) = solution.stepper.progress.remarks
    said = re.search(r"snaps at ([\d.]+) kPa", remark)
    assert float(said[1]) == pytest.approx(-1e3 * top.fun, rel=0.005)
    attempts = [a for a in solution.stepper.progress.attempts if a.converged]
    assert sum(a.control == "volume" and a.unstable_modes == 1 for a in attempts) > 3
    assert attempts[-1].unstable_modes == 0
    assert attempts[-1].control == "load"
    # What is tried is told at each iteration, under load and beyond the limit.
    assert {"load", "volume"} <= {told.control for told in solution.tried}
    assert {told.step for told in solution.tried} == {"inflate"}
    beyond = [told.fraction for told in solution.tried if told.control == "volume"]
    assert min(beyond) > 0.3 and all(told.residual > 0 for told in solution.tried)


def test_the_branch_that_was_left_is_not_the_way_on(mesh_of, caught, monkeypatch):
    """Newton's method falls back to the stable branch under a load that is higher than the last:
    such a state is no "stable again", and the run goes on to where the sphere holds its load."""
    attempt, fallen = Walk.attempt, []

    def falls_back(walk, drive, path, s, options=None):
        outcome = attempt(walk, drive, path, s, options)
        seen = [a for a in walk.progress.attempts if a.converged]
        beyond = sum(a.unstable_modes > 0 for a in seen)
        if drive.control == "volume" and beyond == 3 and not fallen and outcome.converged:
            ends = [(p, q) for p, q in zip(states, seen, strict=True) if q.control == "load"]
            state, known = max(
                (e for e in ends if e[1].fraction > path[-1].q[0]), key=lambda e: e[1].fraction
            )
            walk.state.x = state.x.copy()
            walk.state.put("pressure", state["pressure"])
            fallen.append(known.fraction)
            return replace(outcome, unstable_modes=0)
        return outcome

    states = []
    monkeypatch.setattr(Walk, "attempt", falls_back)
    record = Walk.record

    def keep(walk, tried):
        if tried.converged:
            states.append(replace(walk.state, x=walk.state.x.copy()))
        record(walk, tried)

    monkeypatch.setattr(Walk, "record", keep)
    solution, stretch = inflate(mesh_of())
    assert fallen
    assert stretch == pytest.approx(caught, rel=0.005)
    volumes = [solution.model.cavity_volume(state, "cavity") for state in solution.path]
    assert np.all(np.diff(volumes) > 0)
    reasons = [a.reason for a in solution.stepper.progress.attempts if not a.converged]
    assert "that equilibrium lies back" in reasons


def test_states_that_a_step_has_passed(mesh_of):
    """Under each load between its ends the stable branch is known again, the far one is not it."""
    solution, _ = inflate(mesh_of())
    attempts = [a for a in solution.stepper.progress.attempts if a.converged]
    passed = Passed(solution.model)
    kinds = [a.control for a in attempts]
    first = kinds.index("volume")
    for state, attempt in zip(solution.path[:first], attempts[:first], strict=True):
        passed.add(attempt.fraction, state.x)
    passed.leave()
    beyond = list(zip(solution.path, attempts, strict=True))[first:]
    # The very last of them, too, under a load that is its own but for rounding.
    end = solution.path[first - 1].x
    assert passed.returned(beyond[4][0].x, end, attempts[first - 1].fraction * (1 + 1e-15))
    for (before, _), (state, attempt) in pairwise(beyond):
        assert not passed.returned(before.x, state.x, attempt.fraction)
        assert passed.returned(state.x, solution.path[first - 3].x, attempts[first - 3].fraction)


def test_motion_leads_past_a_snap(mesh_of, caught):
    """Where other loads change too, volume cannot stand for them, and the sphere moves."""
    solution, stretch = inflate(mesh_of(), gravity=(0.0, 0.0, 0.0))
    assert stretch == pytest.approx(caught, rel=0.005)
    moved = [a for a in solution.stepper.progress.attempts if a.control == "dynamics"]
    assert moved
    assert all(a.converged and a.unstable_modes == 0 for a in moved)
    assert all(0 < a.kinetic_ratio < PACE.quasi_static for a in moved)
    assert "damped time steps (kinetic energy at most" in solution.stepper.progress.remarks[0]
    # Each time step is told too, long before the state at its end is accepted.
    assert sum(told.control == "dynamics" and told.iteration == 0 for told in solution.tried) > 10


def test_motion_may_be_forbidden(mesh_of):
    model = Model(mesh_of(), {"body": LAWS["gent"].of(**GENT, bulk_modulus=1e4).material()})
    step = LoadStep("inflate", pressure={"cavity": WANTED}, gravity=(0.0, 0.0, 0.0))
    solution = solve(model, step, [], 0.1, stops=True, dynamics=False, min_increment=0.01)
    assert "no equilibrium found beyond" in solution.stepper.progress.stopped
    reached = solution.stepper.progress.attempts
    assert max(a.fraction for a in reached if a.converged) * WANTED < 0.0345


@pytest.fixture
def free_block():
    """A block of 2 × 1 × 1 mm that nothing holds."""
    law = LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=10.0, density=DENSITY)
    model = build(block((2, 1, 1), (2.0, 1.0, 1.0)), law)
    model.add_inertia()
    return model


def test_free_fall(free_block):
    """Backward Euler from rest: x = g Δt², then 3 g Δt², without any strain."""
    model, state, step = free_block, free_block.initial_state(), 1e-3
    newton = Newton(model, 1e-8, 15)
    newton.set_supports([], state)
    state.put("gravity", {EVERYTHING: np.array([0.0, 0.0, -9810.0])})
    before, velocity = state.x.copy(), np.zeros_like(state.x)
    for fallen in (1, 3):
        state.motion = TimeStep(1 / step**2, before + step * velocity, before)
        assert newton.solve(state, np.empty(0)).converged
        velocity, before = (state.x - before) / step, state.x.copy()
        wanted = [0.0, 0.0, -9810.0 * step**2 * fallen]
        np.testing.assert_allclose(
            state.x[model.displacement_dofs], np.tile(wanted, (len(model.displacement_dofs), 1)),
            atol=1e-9,
        )  # fmt: skip


def test_kinetic_energy_of_a_spin(free_block):
    """½ ∫ ρ |ω × x|² of the block about the z axis: ρ V (a² + b²)/3 · ω²/2."""
    model, omega = free_block, 7.0
    x = model.unknowns.spaces[0].tabulate_dof_coordinates()
    velocity = np.zeros(model.unknowns.local)
    velocity[model.displacement_dofs] = omega * np.column_stack([-x[:, 1], x[:, 0], 0 * x[:, 0]])
    energy = sum(velocity @ inertia.momentum(velocity) for inertia in model.inertia) / 2
    assert energy == pytest.approx(DENSITY * 2.0 * (4 + 1) / 3 * omega**2 / 2, rel=1e-12)


def test_tangent_of_inertia(free_block):
    """Force by energy, tangent by force: both are exact, the energy being quadratic."""
    (inertia,) = free_block.inertia
    draw = np.random.default_rng(3)
    state = free_block.initial_state()
    away_from = draw.standard_normal(free_block.unknowns.local)
    state.motion = TimeStep(1e6, away_from, away_from)
    state.x = draw.standard_normal(free_block.unknowns.local)
    change = draw.standard_normal(free_block.unknowns.local)
    force = np.zeros_like(change)
    inertia.add_force(state, force)
    energies = []
    for sign in (1, -1):
        moved = replace(state, x=state.x + sign * 1e-3 * change)
        energies.append(inertia.energy(moved))
    assert (energies[0] - energies[1]) / 2e-3 == pytest.approx(force @ change, rel=1e-8)


def test_viscous_tangent(free_block):
    """Tangent by finite differences of the force, from a state that is strained already."""
    (solid,) = free_block.solids.values()
    draw = np.random.default_rng(5)
    before, x, change = (0.02 * draw.standard_normal(free_block.unknowns.local) for _ in range(3))
    motion = TimeStep(0.0, before, before, 3.0)
    state = replace(free_block.initial_state(), x=x, motion=motion)
    numeric = slope(lambda moved: force(free_block, solid, moved), state, change, step=1e-6)
    found = tangent(free_block, [solid], state) @ change
    np.testing.assert_allclose(found, numeric, atol=1e-7 * np.abs(numeric).max())


@pytest.mark.parametrize("angle", [0.0, 0.7])
def test_viscosity_resists_shear_and_no_rotation(free_block, angle):
    """One time step of a slow shear: viscosity by time step beside the shear modulus."""
    resistance, shear = 4.0, 1e-5
    dofs = free_block.displacement_dofs
    x = free_block.unknowns.spaces[0].tabulate_dof_coordinates()
    turned = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    state = free_block.initial_state()

    def force_at(places):
        state.x[dofs] = places @ turned.T - x
        return np.abs(free_block.force(state)[0]).max()

    sheared = x + shear * np.column_stack([x[:, 2], 0 * x[:, 0], 0 * x[:, 0]])
    elastic = force_at(sheared)
    rest = np.zeros(free_block.unknowns.local)
    state.motion = TimeStep(0.0, rest, rest, resistance)
    assert force_at(x) < 1e-7 * elastic
    assert force_at(sheared) == pytest.approx((1 + resistance) * elastic, rel=1e-4)
    state.motion = None
    assert force_at(sheared) == pytest.approx(elastic, rel=1e-9)
