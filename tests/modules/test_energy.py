"""A module's energy is found again from its derivatives, and drives a rod."""

import numpy as np
import pytest

from softact.modules.energy import Samples, errors, fit
from softact.modules.rod import Loads, Points, Rod

LOW, HIGH = np.array([-0.02, 0.9, -0.1, 0.0]), np.array([0.06, 1.3, 0.1, 0.04])
NAMES = ("curvature_y", "stretch_x", "stretch_z", "pressure")
SECONDARY = (False, False, True, False)


def answers(places):
    """Samples of 200 k² + 5 (s−1)² + 3 k (s−1) + 2 g² − p (40 s + 900 k + 6000 k²)."""
    k, s, g, p = places.T
    zero = np.zeros_like(k)
    air = 40 * s + 900 * k + 6000 * k**2
    first = [
        400 * k + 3 * (s - 1) - p * (900 + 12000 * k),
        10 * (s - 1) + 3 * k - 40 * p,
        4 * g,
        -air,
    ]
    by_air = -(900 + 12000 * k)
    second = [
        [400 - 12000 * p, zero + 3, zero, by_air],
        [zero + 3, zero + 10, zero, zero - 40],
        [zero, zero, zero + 4, zero],
        [by_air, zero - 40, zero, zero],
    ]
    return Samples(places, np.array(first).T, np.moveaxis(np.array(second), -1, 0))


@pytest.fixture
def samples():
    places = np.random.default_rng(1).uniform(LOW, HIGH, size=(30, 4))
    places[0] = 0.0, 1.0, 0.0, 0.0
    return answers(places)


def fitted(samples, degree=3):
    return fit(samples, NAMES, degree, SECONDARY, (LOW, HIGH))


def test_held_out_states(samples):
    inside = answers(np.random.default_rng(2).uniform(LOW, HIGH, size=(20, 4)))
    assert errors(fitted(samples), inside, np.abs(inside.first).max(axis=0)).max() < 1e-10
    assert errors(fitted(samples, 2), inside, np.abs(inside.first).max(axis=0)).max() > 1e-3


def test_derivatives_are_those_of_the_value(samples):
    energy, place = fitted(samples), np.array([0.01, 1.1, 0.02, 0.02])
    first, second = energy.both(place[None])
    steps = 1e-5 * np.diag(HIGH - LOW)
    size = 2 * np.diag(steps)
    moved = [np.array([place + step, place - step]) for step in steps]
    assert [np.ptp(energy.value(m)[::-1]) for m in moved] == pytest.approx(
        np.abs(first[0]) * size, rel=1e-6
    )
    slopes = [
        (energy.first(m)[0] - energy.first(m)[1]) / s for m, s in zip(moved, size, strict=True)
    ]
    assert second[0] == pytest.approx(np.array(slopes), rel=1e-6, abs=1e-5)
    assert second[0] == pytest.approx(second[0].T)


def test_too_few_states(samples):
    with pytest.raises(ValueError, match="2 states are too few for an energy of degree 5"):
        fitted(samples.part(np.arange(30) < 2), 5)


class AtPressure:
    """The law of a rod."""

    def __init__(self, energy, pressure):
        self.own, self.pressure, self.free = energy, pressure, [1, 3, 5]

    def places(self, strains):
        return np.column_stack([strains[:, self.free], np.full(len(strains), self.pressure)])

    def energy(self, strains):
        return self.own.value(self.places(strains))

    def conjugates(self, strains):
        return self.derivatives(strains)[0]

    def derivatives(self, strains):
        first, second = np.zeros((len(strains), 6)), np.zeros((len(strains), 6, 6))
        one, two = self.own.both(self.places(strains))
        first[:, self.free] = one[:, :3]
        second[np.ix_(np.arange(len(strains)), self.free, self.free)] = two[:, :3, :3]
        return first, second


def test_a_free_rod_is_so_many_free_modules(samples):
    """The free module by hand: two linear equations in curvature and stretch."""
    pressure, free = 0.01, np.array([False, True, False, True, False, True])
    rod = Rod(AtPressure(fitted(samples), pressure), 8, 12.0, np.array([1.0, 0, 0]), free)
    frames = rod.equilibrium(rod.straight(), Loads(Points.ends(8), np.zeros((8, 3))))
    by_hand = np.linalg.solve(
        [[400 - 12000 * pressure, 3], [3, 10]], [900 * pressure, 40 * pressure]
    )
    strains = rod.strains(frames)
    assert strains[:, [1, 3]] == pytest.approx(
        np.tile([by_hand[0], 1.0 + by_hand[1]], (8, 1)), abs=1e-9
    )
    assert strains[:, [0, 2, 4, 5]] == pytest.approx(np.zeros((8, 4)), abs=1e-9)
