"""The planar rod beside the elastica, statics by hand and differences."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from softact.modules.planar_rod import Linear, Rod

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
    strains = rod.equilibrium(rest(N), forces)
    curvature, stretch = strains.reshape(2, N)
    tip = rod.places(curvature, stretch)[-1]
    found = [1 - tip.real, tip.imag, curvature.sum() / N]
    assert found == pytest.approx(elastica(load), abs=1e-4)


def test_tip_moment_bends_to_a_circle():
    rod = Rod(Linear(2.0, 10.0), 14, 3.0)
    strains = rod.equilibrium(rest(14), np.zeros(14, complex), moment=0.1)
    assert strains == pytest.approx([0.05] * 14 + [1.0] * 14, abs=1e-12)
    tip = rod.places(*strains.reshape(2, 14))[-1]
    assert tip == pytest.approx((np.exp(1j * 0.05 * 42) - 1) / (1j * 0.05))


def test_hanging_weight_stretches_each_piece_by_what_hangs_below():
    rod = Rod(Linear(2.0, 10.0), 4, 3.0)
    strains = rod.equilibrium(rest(4), np.full(4, 0.5 + 0j))
    assert strains[4:] == pytest.approx([1.2, 1.15, 1.1, 1.05])


def test_tangent_is_the_derivative_of_the_balance():
    rod = Rod(Linear(2.0, 10.0), 5, 3.0)
    random = np.random.default_rng(0)
    at = rest(5) + 0.1 * random.normal(size=10)
    forces = random.normal(size=5) + 1j * random.normal(size=5)
    _, tangent = rod.balance(at, forces, 0.3)
    step = 1e-6
    differences = [
        (rod.balance(at + move, forces, 0.3)[0] - rod.balance(at - move, forces, 0.3)[0])
        / (2 * step)
        for move in step * np.eye(10)
    ]
    assert np.array(differences).T == pytest.approx(tangent, abs=1e-6)
    assert tangent == pytest.approx(tangent.T, abs=1e-12)
