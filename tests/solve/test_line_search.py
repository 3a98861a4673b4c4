"""The part of a step at which the energy's slope along it has fallen far enough."""

import math

import pytest

from softact.solve.line_search import NEAREST, SEARCHES, SLACKENED, part_of_step


def seen_by(slope, part=1.0):
    """What is found, and the parts at which the slope was asked for after the first."""
    asked = []

    def told(t):
        asked.append(t)
        return slope(t)

    return part_of_step(told, part), asked[1:]


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_where_the_whole_step_will_do_it_is_taken(sign):
    assert seen_by(lambda t: sign * (1 - t)) == (1.0, [1.0])
    assert seen_by(lambda t: sign * (2 - t)) == (1.0, [1.0])  # short of the place
    assert seen_by(lambda t: sign * (1 - t), 0.25) == (0.25, [0.25])
    assert seen_by(lambda t: 0.0) == (1.0, [])


@pytest.mark.parametrize("stiff", [3.0, 30.0, 300.0, 3000.0])
def test_a_kink_beyond_which_it_is_stiff(stiff):
    """The slope falls to a kink at 0.3 and then, so many times as fast, through zero."""

    def slope(t):
        return 1 - t if t < 0.3 else 0.7 - stiff * (t - 0.3)

    part, asked = seen_by(slope)
    assert len(asked) <= SEARCHES
    assert abs(slope(part)) <= SLACKENED
    assert all(0.0 < t <= 1.0 for t in asked)


def test_of_places_that_will_not_do_the_best_is_taken():
    """A jump of the slope in between, which no place gets round."""

    def slope(t):
        return 1.0 if t < 0.62 else -2.0 - t

    part, asked = seen_by(slope)
    assert len(asked) == SEARCHES and part in asked
    assert abs(slope(part)) == min(abs(slope(t)) for t in asked)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_beyond(bad):
    """Beyond 0.4 an element is inverted."""
    part, asked = seen_by(lambda t: 1 - 2 * t if t < 0.4 else bad)
    assert NEAREST <= part < 0.4
    assert len(asked) <= SEARCHES
