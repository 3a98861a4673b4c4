"""A module's energy is found again from its derivatives, and drives a rod."""

import numpy as np
import pytest

from softact.modules.planar_rod import Loads, Points, Rod
from softact.modules.response import AtPressure, errors, fit

LOW, HIGH = (-0.02, 0.9, 0.0), (0.06, 1.3, 0.04)


def answers(states):
    """Derivatives of 200 k^2 + 5 (s-1)^2 + 3 k (s-1) - p (40 s + 900 k + 6000 k^2)."""
    k, s, p = states.T
    moment = 400 * k + 3 * (s - 1) - p * (900 + 12000 * k)
    force = 10 * (s - 1) + 3 * k - 40 * p
    return np.stack([moment, force, 40 * s + 900 * k + 6000 * k**2])


@pytest.fixture
def states():
    return np.random.default_rng(1).uniform(LOW, HIGH, size=(60, 3))


def test_held_out_states(states):
    response = fit(states, answers(states), 3)
    inside = response.low + (response.high - response.low) * np.random.default_rng(2).random(
        (20, 3)
    )
    assert errors(response, inside, answers(inside)).max() < 1e-10
    assert errors(fit(states, answers(states), 2), inside, answers(inside)).max() > 1e-3


def test_nothing_is_extrapolated(states):
    response = fit(states, answers(states), 3)
    with pytest.raises(ValueError, match=r"pressure 0\.05 to 0\.05 is outside of the table"):
        response.check(np.array([[0.0, 1.0, 0.05]]))


def test_too_few_states(states):
    with pytest.raises(ValueError, match="4 states are too few"):
        fit(states[:4], answers(states[:4]), 3)


def test_free_rod_is_so_many_free_modules(states):
    """The free module by hand: two linear equations in curvature and stretch."""
    pressure = 0.01
    law = AtPressure(fit(states, answers(states), 3), pressure)
    rod = Rod(law, 8, 12.0)
    start = np.concatenate([np.zeros(8), np.ones(8)])
    strains = rod.equilibrium(start, Loads(Points.ends(8), np.zeros(8, complex)))
    free = np.linalg.solve([[400 - 12000 * pressure, 3], [3, 10]], [900 * pressure, 40 * pressure])
    assert strains == pytest.approx(np.repeat(free + np.array([0.0, 1.0]), 8), abs=1e-9)
