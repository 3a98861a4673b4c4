"""Weighted percentiles by hand."""

import numpy as np

from softact.mesh.percentile import percentile


def test_what_is_exceeded_in_a_part_of_the_volume():
    stretch, part = np.array([1.0, 3.0, 2.0]), np.array([0.9, 0.02, 0.08])
    assert percentile(stretch, part, 0.99) == 3.0
    assert percentile(stretch, part, 0.95) == 2.0
    assert percentile(stretch, part, 0.5) == 1.0
