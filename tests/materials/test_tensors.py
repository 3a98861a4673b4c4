"""Tensors at many points, against numpy's linear algebra on stacks of matrices."""

import numpy as np
import pytest

from softact.materials import tensors

DRAW = np.random.default_rng(3)
F = DRAW.normal(size=(50, 4, 3, 3))
FULL = F @ F.swapaxes(-1, -2)
FULL[0] = np.eye(3)  # three equal eigenvalues
FULL[1] = np.diag([2.0, 2.0, -1.0])
FULL[2] = np.diag([2.0, -1.0, -1.0])
FULL[3] = 0.0
S = tensors.symmetric(FULL)
EIGENVALUES = np.linalg.eigvalsh(FULL.reshape(-1, 3, 3))


def test_determinant():
    assert tensors.determinant(F) == pytest.approx(np.linalg.det(F), rel=1e-12)


def test_largest_eigenvalue_lies_between_its_bounds():
    largest = EIGENVALUES[:, 2]
    assert tensors.largest_eigenvalue(S) == pytest.approx(largest, rel=1e-12, abs=1e-14)
    low, high = tensors.bounds(S)
    assert (low <= largest + 1e-12).all() and (largest <= high + 1e-12).all()
    # Two equal eigenvalues at the top, or at the bottom, are where the bounds are reached.
    assert low[4] == pytest.approx(2) and high[8] == pytest.approx(2)


def test_von_mises():
    one, two, three = EIGENVALUES.T
    exact = np.sqrt(((one - two) ** 2 + (two - three) ** 2 + (three - one) ** 2) / 2)
    assert tensors.von_mises(S) == pytest.approx(exact, rel=1e-9, abs=1e-14)
