"""The planar rod beside the elastica, statics by hand and differences."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from softact.modules.planar_rod import Linear, Loads, Points, Rod

N = 100


def rest(pieces):
    return np.concatenate([np.zeros(pieces), np.ones(pieces)])


def elastica(load):
    """What a cantilever of unit length and stiffness is shortened by, its deflection and the angle
    of its tip under a dead load across its end, by elliptic integrals of the modulus k (Bisshopp
    and Drucker, Q. Appl. Math. 3 (1945) 272)."""

    def lacking(k):
        return ellipk(k**2) - ellipkinc(np.arcsin(1 / (k * np.sqrt(2))), k**2) - np.sqrt(load)

    k = brentq(lacking, np.sqrt(0.5) + 1e-12, 1 - 1e-12)
    start = np.arcsin(1 / (k * np.sqrt(2)))
    slope = np.arcsin(2 * k**2 - 1)
    deflection = 1 - 2 * (ellipe(k**2) - ellipeinc(start, k**2)) / np.sqrt(load)
    return 1 - np.sqrt(2 * np.sin(slope) / load), deflection, slope


def test_elastica_is_the_published_one():
    """0.301721, 0.493457, 0.713792 (docs/validation.md)."""
    found = [elastica(load)[1] for load in (1, 2, 5)]
    assert found == pytest.approx([0.301721, 0.493457, 0.713792], abs=1e-6)


@pytest.mark.parametrize("load", [1, 2, 5])
def test_a_rod_bends_as_the_elastica(load):
    rod = Rod(Linear(1.0, 1e8), N, 1 / N)
    forces = np.zeros(N, complex)
    forces[-1] = 1j * load
    strains = rod.equilibrium(rest(N), Loads(Points.ends(N), forces))
    curvature, stretch = strains.reshape(2, N)
    tip = rod.places(curvature, stretch)[-1]
    found = [1 - tip.real, tip.imag, curvature.sum() / N]
    assert found == pytest.approx(elastica(load), abs=1e-4)


def test_tip_moment_bends_to_a_circle():
    rod = Rod(Linear(2.0, 10.0), 14, 3.0)
    strains = rod.equilibrium(rest(14), Loads(Points.ends(14), np.zeros(14, complex), 0.1))
    assert strains == pytest.approx([0.05] * 14 + [1.0] * 14, abs=1e-12)
    tip = rod.places(*strains.reshape(2, 14))[-1]
    assert tip == pytest.approx((np.exp(1j * 0.05 * 42) - 1) / (1j * 0.05))


def test_hanging_weight_stretches_each_piece_by_what_hangs_below():
    rod = Rod(Linear(2.0, 10.0), 4, 3.0)
    strains = rod.equilibrium(rest(4), Loads(Points.ends(4), np.full(4, 0.5 + 0j)))
    assert strains[4:] == pytest.approx([1.2, 1.15, 1.1, 1.05])


def circle(places):
    """Distance from a round obstacle of radius 4 mm below the rod."""
    away = places - (12 - 5j)
    far = np.abs(away)
    return far - 4, away / far, 1 / far


def flat(places):
    """Distance from a floor 1 mm below the rod."""
    return places.imag + 1, np.full(len(places), 1j), np.zeros(len(places))


@pytest.mark.parametrize("obstacles", [(), (circle, flat)])
def test_balance_is_the_derivative_of_the_energy(obstacles):
    rod = Rod(Linear(2.0, 10.0), 5, 3.0)
    random = np.random.default_rng(0)
    at = rest(5) + 0.1 * random.normal(size=10)
    arms = random.normal(size=5) + 1j * random.normal(size=5)
    points = Points(np.array([0, 2, 4, 4, 1]), arms)
    forces = random.normal(size=5) + 1j * random.normal(size=5)
    loads = Loads(points, forces, 0.3, points, obstacles)
    residual, tangent = rod.balance(at, loads, 2.0)
    step = 1e-6
    energy = [
        (rod.energy(at + move, loads, 2.0) - rod.energy(at - move, loads, 2.0)) / (2 * step)
        for move in step * np.eye(10)
    ]
    assert residual == pytest.approx(energy, abs=1e-7)
    changes = [
        (rod.balance(at + move, loads, 2.0)[0] - rod.balance(at - move, loads, 2.0)[0]) / (2 * step)
        for move in step * np.eye(10)
    ]
    assert np.array(changes).T == pytest.approx(tangent, abs=1e-6)
    assert tangent == pytest.approx(tangent.T, abs=1e-12)


def test_propped_cantilever():
    """A tip load beside a prop at two thirds, by the theory of small deflections."""
    n, load, reach = 90, 1e-6, 60
    rod = Rod(Linear(1e-3, 1e3), n, 1 / n)
    forces = np.zeros(n, complex)
    forces[-1] = -1j * load

    def prop(places):
        gap = np.where(np.arange(n) == reach - 1, places.imag, 1.0)
        return gap, np.full(n, 1j), np.zeros(n)

    loads = Loads(Points.ends(n), forces, 0.0, Points.ends(n), (prop,))
    strains = rod.equilibrium(rest(n), loads)
    (pressed,) = rod.pressed(strains, loads)
    a = reach / n
    by_hand = load * (3 - a) / (2 * a)  # deflection at a of load and prop, a^2 (3 - a) and 2 a^3
    assert pressed.sum().imag == pytest.approx(by_hand, rel=2e-3)
