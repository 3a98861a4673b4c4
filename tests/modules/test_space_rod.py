"""The rod beside the elastica, a published curved beam, statics by hand and differences."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

from softact.modules.rod import Linear, Loads, Points, Rod
from softact.modules.screws import Between, exponential, logarithm

X = np.array([1.0, 0.0, 0.0])
ALL, IN_PLANE = np.ones(6, dtype=bool), np.array([False, True, False, True, False, True])
STRAIGHT = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
N = 100


def rod_of(stiffness, pieces, length, natural=STRAIGHT, free=ALL):
    return Rod(Linear(np.diag(stiffness).astype(float), natural), pieces, length, X, free)


def at_tip(pieces, force):
    forces = np.zeros((pieces, 3))
    forces[-1] = force
    return Loads(Points.ends(pieces), forces)


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


@pytest.mark.parametrize("free", [ALL, IN_PLANE])
@pytest.mark.parametrize("load", [1, 2, 5])
def test_a_rod_bends_as_the_elastica(load, free):
    rod = rod_of([1, 1, 1, 1e8, 1e8, 1e8], N, 1 / N, free=free)
    frames = rod.equilibrium(rod.straight(), at_tip(N, [0, 0, load]))
    tip = frames.places[-1]
    slope = np.arctan2(*(frames.turns[-1] @ X)[[2, 0]])
    assert [1 - tip[0], tip[2], slope] == pytest.approx(elastica(load), abs=1e-4)
    assert tip[1] == pytest.approx(0.0, abs=1e-9)


def test_pieces_of_several_lengths_bend_as_the_elastica():
    """Longer ones in the second half."""
    lengths = np.repeat([0.4, 0.6], [60, 40]) / [*[60] * 60, *[40] * 40]
    rod = rod_of([1, 1, 1, 1e8, 1e8, 1e8], N, lengths)
    assert rod.straight().places[-1] == pytest.approx([1.0, 0.0, 0.0])
    frames = rod.equilibrium(rod.straight(), at_tip(N, [0, 0, 2.0]))
    tip, slope = frames.places[-1], np.arctan2(*(frames.turns[-1] @ X)[[2, 0]])
    assert [1 - tip[0], tip[2], slope] == pytest.approx(elastica(2.0), abs=2e-4)
    forces = rod.unbalanced(frames, at_tip(N, [0, 0, 2.0]))
    assert np.abs(forces[1:]).max() < 1e-4  # of forces of 1e8 by the strain
    assert forces[0, 5] == pytest.approx(-2.0, rel=1e-4)


def test_a_quarter_of_a_right_angle_lifted_out_of_its_plane():
    """An arc of 45° and radius 100, clamped, under 600 across its plane: the tip at 15.79, 47.23,
    53.37 (Simo and Vu-Quoc, CMAME 58 (1986) 79, table 5; eight linear elements)."""
    n, arc = 32, 100 * np.pi / 4
    bent = np.array([0.0, 0.0, -0.01, 1.0, 0.0, 0.0])
    stiffness = [1e7 / 12, 1e7 / 12, 1e7 / 12, 1e7, 5e6, 5e6]
    rod = rod_of(stiffness, n, arc / n, natural=bent)
    frames = rod.equilibrium(rod.alike(bent), at_tip(n, [0, 0, 600.0]))
    assert rod.alike(bent).places[-1] == pytest.approx([70.71, -29.29, 0], abs=0.01)
    along, across, up = frames.places[-1]
    assert [-across, along, up] == pytest.approx([15.79, 47.23, 53.37], abs=0.2)


def test_natural_curvature_bends_to_a_circle_and_twist_to_a_helix():
    rod = rod_of([2, 2, 2, 10, 10, 10], 14, 3.0, natural=np.array([0, 0.05, 0, 1, 0, 0]))
    frames = rod.equilibrium(rod.straight(), at_tip(14, np.zeros(3)))
    angle, radius = 0.05 * 42, 20.0
    tip = [radius * np.sin(angle), 0, -radius * (1 - np.cos(angle))]
    assert frames.places[-1] == pytest.approx(tip)
    twisted = np.array([0.03, 0.04, 0, 1, 0, 0])
    ends = rod_of(np.ones(6), 1, 2 * np.pi / 0.05, natural=twisted).alike(twisted).places[-1]
    # Once around: along the axis of the helix by its pitch.
    assert np.linalg.norm(ends) == pytest.approx(2 * np.pi / 0.05 * 0.03 / 0.05)


def test_hanging_weight_stretches_each_piece_by_what_hangs_below():
    rod = rod_of([2, 2, 2, 10, 10, 10], 4, 3.0)
    forces = np.tile([0.5, 0.0, 0.0], (4, 1))
    frames = rod.equilibrium(rod.straight(), Loads(Points.ends(4), forces))
    assert rod.strains(frames)[:, 3] == pytest.approx([1.2, 1.15, 1.1, 1.05])


def test_screws():
    random = np.random.default_rng(3)
    screws = random.uniform(-0.9, 0.9, size=(20, 6))
    screws[0] = 0.0
    turns, shifts = exponential(screws)
    assert turns @ turns.swapaxes(1, 2) == pytest.approx(np.tile(np.eye(3), (20, 1, 1)))
    assert logarithm(turns, shifts) == pytest.approx(screws, abs=1e-12)
    # A move of the second frame in its own axes, by differences.
    between, step = Between(screws), 1e-6
    for i in range(6):
        move = np.tile(step * np.eye(6)[i], (20, 1))
        ends = []
        for sign in (1, -1):
            turn, shift = exponential(sign * move)
            there = np.einsum("nij,nj->ni", turns, shift) + shifts
            ends.append(logarithm(turns @ turn, there))
        slope = (ends[0] - ends[1]) / (2 * step)
        assert between.at_end[:, :, i] == pytest.approx(slope, abs=1e-8)


def ball(places):
    """Distance from a ball of radius 4 mm."""
    away = places - np.array([8.0, 1.0, -2.0])
    far = np.linalg.norm(away, axis=1)
    out = away / far[:, None]
    second = (np.eye(3) - out[:, :, None] * out[:, None]) / far[:, None, None]
    return far - 4.0, out, second


@pytest.mark.parametrize("obstacles", [(), (ball,)])
def test_balance_is_the_derivative_of_the_energy(obstacles):
    random = np.random.default_rng(0)
    root = random.normal(size=(6, 6))
    natural = np.array([0.01, 0.03, -0.02, 1.0, 0.05, -0.02])
    rod = Rod(Linear(root @ root.T + 6 * np.eye(6), natural), 5, 3.0, X, ALL)
    frames = rod.chained(natural + 0.05 * random.normal(size=(5, 6)))
    points = Points(np.array([1, 3, 5, 5]), random.normal(size=(4, 3)))
    loads = Loads(points, random.normal(size=(4, 3)), points, obstacles)
    residual, diagonal, beside = rod.balance(frames, loads, 2.0)

    def energy(move):
        return rod.energy(frames.moved(move.reshape(6, 6)), loads, 2.0)

    step = 1e-4
    unit = step * np.eye(36)
    slopes = [(energy(u) - energy(-u)) / (2 * step) for u in unit]
    assert residual.ravel() == pytest.approx(slopes, abs=1e-7)
    tangent = np.zeros((6, 6, 6, 6))
    for n in range(6):
        tangent[n, :, n] = diagonal[n]
    for n in range(5):
        tangent[n, :, n + 1], tangent[n + 1, :, n] = beside[n], beside[n].T
    curved = [
        [
            (energy(a + b) - energy(a - b) - energy(b - a) + energy(-a - b)) / (4 * step**2)
            for b in unit
        ]
        for a in unit
    ]
    assert tangent.reshape(36, 36) == pytest.approx(np.array(curved), abs=1e-6)


def test_propped_cantilever():
    """A tip load beside a prop at two thirds, by the theory of small deflections."""
    n, load, reach = 90, 1e-6, 60
    rod = rod_of([1e-3, 1e-3, 1e-3, 1e3, 1e3, 1e3], n, 1 / n)
    touched = Points(np.array([reach]), np.zeros((1, 3)))

    def prop(places):
        up = np.tile([0.0, 0.0, 1.0], (len(places), 1))
        return places[:, 2], up, np.zeros((len(places), 3, 3))

    loads = at_tip(n, [0, 0, -load])
    loads = Loads(loads.points, loads.forces, touched, (prop,))
    (pressed,) = rod.pressed(rod.equilibrium(rod.straight(), loads), loads)
    a = reach / n
    by_hand = load * (3 - a) / (2 * a)  # deflection at a of load and prop, a^2 (3 - a) and 2 a^3
    assert pressed[:, 2].sum() == pytest.approx(by_hand, rel=2e-3)


def test_what_pushes_itself_apart_is_told():
    rod = rod_of([1, 1, 1, -1, 1, 1], 4, 1.0)
    with pytest.raises(ArithmeticError, match="no equilibrium"):
        rod.equilibrium(rod.straight(), at_tip(4, [1.0, 0, 0]))
