"""A rod in motion and in friction beside closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from softact.loads.dynamics import Dynamics
from softact.modules.grip import SLIP, Grip
from softact.modules.rod import Linear, Loads, Points, Rod
from softact.modules.rod_motion import Motion, RodMotion, error_in_time, inertias

X = np.array([1.0, 0.0, 0.0])
SIDE, LENGTH, N = 10.0, 200.0, 20
MASS = 1e-9 * SIDE**2 * LENGTH / N  # tonne of a piece of a bar of 1000 kg/m³
BENDING, AXIAL = SIDE**4 / 12, SIDE**2  # of 1 MPa


@pytest.fixture
def bar():
    """A square bar in which a frame carries half of each piece beside it."""
    stiffness = np.diag([0.1406 * SIDE**4 / 2.6, BENDING, BENDING, AXIAL, AXIAL, AXIAL])
    rod = Rod(Linear(stiffness, np.eye(6)[3]), N, LENGTH / N, X, np.ones(6, dtype=bool))
    masses = np.full(N + 1, MASS)
    masses[[0, -1]] /= 2
    at, nothing = np.arange(N + 1), np.zeros((N + 1, 3))
    spreads = masses[:, None, None] * np.eye(3) * SIDE**2 / 12
    return rod, inertias(at, masses, nothing, spreads, N + 1)


def nothing_acts():
    return Loads(Points.ends(N), np.zeros((N, 3)))


def test_a_cantilever_swings_with_its_first_frequency(bar):
    """1.8751² √(EI / ρ A L⁴) / 2π; shear and the turning of sections take 0.5 %."""
    rod, inertia = bar
    push = np.zeros((N, 3))
    push[-1, 2] = 1e-4
    bent = rod.equilibrium(rod.straight(), Loads(Points.ends(N), push), 2)
    frequency = 1.875104**2 / (2 * np.pi) * np.sqrt(BENDING * LENGTH / (N * MASS * LENGTH**4))
    moving, step = RodMotion(rod, inertia, Dynamics(1.0)), 1 / (100 * frequency)
    state, heights, energies = moving.start(Motion.at_rest(bent), nothing_acts()), [], []
    for _ in range(400):
        state = moving.after(state, nothing_acts(), step)
        heights.append(state.frames.places[-1, 2])
        stored = rod.energy(state.frames, nothing_acts(), 1.0)
        energies.append(moving.energy(state) + stored)
    up = np.flatnonzero((np.array(heights[:-1]) < 0) & (np.array(heights[1:]) >= 0))
    crossed = [u - heights[u] / (heights[u + 1] - heights[u]) for u in up]
    found = (len(crossed) - 1) / ((crossed[-1] - crossed[0]) * step)
    assert found == pytest.approx(frequency, rel=1e-2)
    assert max(energies) / min(energies) - 1 < 2e-3


def test_the_error_of_an_increment_falls_with_its_square(bar):
    rod, inertia = bar
    loads = nothing_acts()
    loads = replace(loads, forces=np.tile([0.0, 0.0, 1e-3], (N, 1)))
    moving = RodMotion(rod, inertia, Dynamics())
    start = moving.start(Motion.at_rest(rod.straight()), loads)
    small, large = (
        error_in_time(start, moving.after(start, loads, step), Dynamics(), step)
        for step in (2e-5, 4e-5)
    )
    assert 3 < large / small < 20


def test_a_turning_frame_keeps_its_momentum():
    """A free frame with three inertias (no rod holds it: no stiffness at all)."""
    rod = Rod(Linear(np.zeros((6, 6)), np.eye(6)[3]), 1, 1.0, X, np.ones(6, dtype=bool))
    spreads = np.zeros((2, 3, 3))
    spreads[1] = np.diag([3.0, 2.0, 1.0])
    inertia = inertias(np.arange(2), np.array([0.0, 1.0]), np.zeros((2, 3)), spreads, 2)
    moving, still = RodMotion(rod, inertia, Dynamics(1.0)), Loads(Points.none(), np.empty((0, 3)))
    velocity = np.zeros((2, 6))
    velocity[1, :3] = 0.01, 2.0, 0.0  # about the middle axis: it tumbles
    state = replace(Motion.at_rest(rod.straight()), velocity=velocity)
    state, first = moving.start(state, still), None
    for _ in range(300):
        state = moving.after(state, still, 0.01)
        turn = inertia[1][:3, :3] @ state.velocity[1, :3]
        here = state.frames.turns[1] @ turn
        first = here if first is None else first
        assert here == pytest.approx(first, abs=0.02 * np.linalg.norm(first))


def test_friction_holds_until_the_cone_and_then_slides():
    """A tip that is pressed on a floor and pulled along it: Coulomb by hand."""
    rod = Rod(
        Linear(np.diag([100.0, 100, 100, 50, 1e4, 1e4]), np.eye(6)[3]),
        N,
        5.0,
        X,
        np.ones(6, dtype=bool),
    )

    def floor(places):
        up = np.tile([0.0, 0.0, 1.0], (len(places), 1))
        return places[:, 2] + 2.0, up, np.zeros((len(places), 3, 3))

    tip, forces, frames = Points(np.array([N]), np.zeros((1, 3))), np.zeros((N, 3)), rod.straight()
    grips, seen = [Grip.none(0.3, tip.places(frames))], []
    for pull in [*np.zeros(5), *np.linspace(0.0, 0.06, 16)]:
        forces[-1] = pull, 0.0, min(0.0, forces[-1, 2] - 0.02) if pull == 0 else forces[-1, 2]
        loads = Loads(Points.ends(N), forces.copy(), tip, (floor,), grips)
        frames = rod.settle(frames, loads)
        loads = rod.held(frames, loads)
        (force,) = rod.pressed(frames, loads)[0]
        grips = rod.followed(frames, loads)
        seen.append((-force[0] / force[2], frames.places[-1, 0]))
    ratio, along = np.array(seen).T
    assert ratio.max() == pytest.approx(0.3, abs=1e-3)
    sticks = ratio < 0.29
    assert np.ptp(along[5:][sticks[5:]]) < 2 * SLIP
    assert along[-1] - along[5:][sticks[5:]].max() > 0.005
