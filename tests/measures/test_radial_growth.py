"""Swelling of tubes that are bent, twisted and stretched as well: closed forms."""

import numpy as np
import pytest

from softact.measures.radial_growth import radial_growth

X = np.array([1.0, 0.0, 0.0])


def tube(seed=1, count=20000, half=False):
    """Nodes of a tube of radius 8 to 10 mm and 80 mm; the half of it at y > 0."""
    draw = np.random.default_rng(seed)
    angle = draw.uniform(0, np.pi if half else 2 * np.pi, count)
    radius = np.where(draw.random(count) < 0.5, 10.0, draw.uniform(8, 10, count))
    return np.stack([draw.uniform(0, 80, count), radius * np.sin(angle), radius * np.cos(angle)], 1)


def swollen(points, growth, stretch=1.0, turn=0.0, twist=0.0):
    """Radii times ``growth(x)``, length times ``stretch``, twisted, then bent by ``turn``."""
    x, y, z = points.T
    y, z = growth(x) * y, growth(x) * z
    c, s = np.cos(twist * x), np.sin(twist * x)
    y, z = c * y - s * z, s * y + c * z
    if turn == 0:
        return np.stack([stretch * x, y, z], 1)
    radius, at = 80 * stretch / turn, x / 80 * turn
    return np.stack([(radius + z) * np.sin(at), y, radius - (radius + z) * np.cos(at)], 1)


@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize("turn", [0.0, 1.0, 4.0])
def test_a_tube_that_swells_and_bends(turn, half):
    points = tube(half=half)
    after = swollen(points, lambda x: 1.2 + 0 * x, stretch=1.5, turn=turn)
    found, _ = radial_growth(points, after, X, {1} if half else ())
    assert found == pytest.approx(0.2, abs=0.01)


def test_the_slice_that_swells_most_counts():
    def growth(x):
        return 1 + 0.3 * np.exp(-(((x - 30) / 5) ** 2))

    assert radial_growth(tube(), swollen(tube(), growth), X)[0] == pytest.approx(0.3, abs=0.02)


def test_rotation_and_twist_are_no_growth():
    points = tube()
    angle = np.radians(70)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    assert radial_growth(points, points @ turn.T + 5, X)[0] == pytest.approx(0, abs=1e-9)
    twisted = swollen(points, np.ones_like, twist=np.pi / 80)
    assert radial_growth(points, twisted, X)[0] == pytest.approx(0, abs=2e-3)
