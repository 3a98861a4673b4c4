"""The size of increments and their first guesses."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from softact.solve.increments import INCREMENTS, next_size
from softact.solve.path import Point, extrapolate
from softact.solve.progress import Attempt
from softact.solve.rungs import volume
from softact.solve.walk import Walk


@pytest.mark.parametrize("iterations", [1, 5, 8, 15, 100])
def test_accepted_increments_never_shrink_to_nothing(iterations):
    size = 0.5
    for _ in range(200):
        size = next_size(size, iterations, 0.5)
        assert INCREMENTS.small * 0.5 * 0.7 <= size <= 0.5


def test_few_iterations_let_it_grow_and_many_shrink():
    assert next_size(0.1, 3, 0.5) == pytest.approx(0.16)
    assert next_size(0.1, 7, 0.5) == 0.1
    assert next_size(0.1, 12, 0.5) == pytest.approx(0.07)
    assert next_size(0.01, 12, 0.5) == pytest.approx(0.0125)
    assert next_size(0.4, 3, 0.5) == 0.5


def path_of(curve, places):
    return [Point(s, curve(s), np.array([2.0 * s])) for s in places]


def parabola(s):
    return (
        np.array([1.0, -2.0, 0.5])
        + np.array([3.0, 0.0, 1.0]) * s
        + np.array([0.5, 4.0, 0.0]) * s**2
    )


def test_a_parabola_is_continued_exactly():
    """By three points, and by two and the rate at the last."""
    path = path_of(parabola, (0.1, 0.3, 0.4))
    guess = extrapolate(path, 0.7)
    np.testing.assert_allclose(guess.x, parabola(0.7), rtol=1e-12)
    np.testing.assert_allclose(guess.q, [1.4], rtol=1e-12)
    # The weights with which the stresses of these states are extrapolated.
    weighted = sum(w * x for w, x in zip(guess.origin.weights, guess.origin.states, strict=True))
    np.testing.assert_allclose(weighted, guess.x, rtol=1e-12)
    rate = (parabola(0.4 + 1e-6) - parabola(0.4 - 1e-6)) / 2e-6
    guess = extrapolate([path[1], replace(path[2], rate=rate)], 0.7)
    np.testing.assert_allclose(guess.x, parabola(0.7), rtol=1e-8)


def test_a_rate_bears_on_the_newest_part_of_the_path():
    """Before a kink at 0.3 the path says nothing of what comes."""

    def kinked(s):
        return np.array([0.0 if s < 0.3 else s - 0.3])

    path = path_of(kinked, (0.1, 0.3, 0.4))
    path[-1] = replace(path[-1], rate=np.array([1.0]))
    np.testing.assert_allclose(extrapolate(path, 0.7).x, [0.4], rtol=1e-12)


def limit_ahead(*attempts):
    walk = Walk.__new__(Walk)
    walk.step = SimpleNamespace(name="inflate")
    walk.progress = SimpleNamespace(attempts=attempts)
    return walk.limit_ahead()


def accepted(fraction, speed, converged=True):
    return Attempt("inflate", fraction, 3, converged, [], "", 0, speed=speed)


def test_a_limit_is_seen_coming():
    """Where the load is t − (x − x₀)², x moves at ½ (t − s)^-½."""
    fold = [accepted(s, 0.5 * (0.7 - s) ** -0.5) for s in (0.1, 0.4, 0.5)]
    assert limit_ahead(*fold) == pytest.approx(0.7, rel=1e-12)
    rejected = accepted(0.75, 0.0, converged=False)
    assert limit_ahead(*fold, rejected) == pytest.approx(0.7, rel=1e-12)


@pytest.mark.parametrize(
    "speeds", [(1.0,), (1.0, 1.0, 1.0), (1.0, 1.1, 1.2), (2.0, 4.0, 3.0), (1.0, 3.0, 0.0)]
)
def test_no_limit_is_seen(speeds):
    """A steady way, one that slows down, and one whose last speed is not known."""
    way = [accepted(0.1 * (n + 1), speed) for n, speed in enumerate(speeds)]
    assert limit_ahead(*way) == np.inf


def test_a_traced_limit_lies_below_the_end_of_the_step():
    """A parabola through three points of uneven distances rises above what was reached."""

    def limit(fractions):
        places = (0.0, 1.0, 1.1)
        seen = [Point(s, None, np.array([t])) for s, t in zip(places, fractions, strict=True)]
        return volume._Trace._limit(None, seen)

    assert 0.7 < limit((0.5, 0.7, 0.65)) < 1.0
    assert limit((0.9, 0.99, 0.7)) == 0.99
    assert limit((0.5, 0.6, 0.7)) is None
