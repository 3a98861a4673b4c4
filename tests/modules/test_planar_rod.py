"""The planar rod beside the elastica, statics by hand and differences."""

import numpy as np
import pytest

from softact.modules.planar_rod import Linear, Rod

N = 100


def rest(pieces):
    return np.concatenate([np.zeros(pieces), np.ones(pieces)])


@pytest.mark.parametrize(
    ("load", "shortened", "deflection", "angle"),
    [(1, 0.05643, 0.30172, 0.46135), (2, 0.16064, 0.49346, 0.78175)],
)
def test_elastica(load, shortened, deflection, angle):
    """Mattiasson, Int. J. Numer. Meth. Eng. 17 (1981) 145, table of a cantilever's tip."""
    rod = Rod(Linear(1.0, 1e8), N, 1 / N)
    forces = np.zeros(N, complex)
    forces[-1] = 1j * load
    strains = rod.equilibrium(rest(N), forces)
    curvature, stretch = strains.reshape(2, N)
    tip = rod.places(curvature, stretch)[-1]
    found = [1 - tip.real, tip.imag, curvature.sum() / N]
    assert found == pytest.approx([shortened, deflection, angle], abs=3e-5)


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
