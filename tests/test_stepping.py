"""The size of increments."""

import pytest

from softact.stepping import SMALL, next_size


@pytest.mark.parametrize("iterations", [1, 5, 8, 15, 100])
def test_accepted_increments_never_shrink_to_nothing(iterations):
    size = 0.5
    for _ in range(200):
        size = next_size(size, iterations, 0.5)
        assert SMALL * 0.5 * 0.7 <= size <= 0.5


def test_few_iterations_let_it_grow_and_many_shrink():
    assert next_size(0.1, 3, 0.5) == pytest.approx(0.16)
    assert next_size(0.1, 7, 0.5) == 0.1
    assert next_size(0.1, 12, 0.5) == pytest.approx(0.07)
    assert next_size(0.01, 12, 0.5) == pytest.approx(0.0125)
    assert next_size(0.4, 3, 0.5) == 0.5
