"""Points that none beats, against a comparison of each with each."""

import numpy as np
import pytest

from softact.sweep.front import best, unbeaten


@pytest.mark.parametrize("goals", [1, 2, 3])
def test_none_beats_them(goals):
    values = np.random.default_rng(goals).integers(0, 12, (600, goals)).astype(float)
    beaten = [any((o >= v).all() and (o > v).any() for o in values) for v in values]
    assert unbeaten(values).tolist() == np.flatnonzero(~np.array(beaten)).tolist()


def test_the_best_of_one_goal_are_the_largest():
    values = np.array([[3.0], [5.0], [1.0], [4.0]])
    assert best(values, 3) == [1, 3, 0]
    assert best(values, 9) == [1, 3, 0, 2]


def test_more_than_the_front_are_taken_from_the_next():
    """On the line x + y = 4 none beats another; two points lie below it."""
    values = np.array([[0.0, 4.0], [1.0, 3.0], [2.0, 2.0], [3.0, 1.0], [4.0, 0.0], [1.0, 1.0],
                       [0.0, 0.0]])  # fmt: skip
    assert best(values, 3) == [4, 2, 0]  # both ends and the middle
    assert best(values, 6) == [4, 3, 2, 1, 0, 5]


def test_of_nothing_there_is_nothing():
    assert best(np.zeros((0, 2)), 3) == []
    assert unbeaten(np.zeros((0, 2))).tolist() == []
