"""The eigen-decomposition against its definition, also where eigenvalues coincide."""

import numpy as np
import pytest

from softact.materials.eigen import eigen_system
from softact.materials.kernel import components
from tests.materials.samples import rotations


def decompose(C):
    values, axes = eigen_system(components(C))
    return np.stack(values, axis=1), np.stack([np.stack(a, axis=1) for a in axes], axis=1)


@pytest.mark.parametrize("gap", [0.0, 1e-15, 1e-12, 1e-8, 1e-4, 0.1, 1.0])
@pytest.mark.parametrize("base", [(1.0, 1.0, 1.0), (2.0, 2.0, 0.3), (0.5, 3.0, 3.0)])
def test_rebuilds_the_tensor(gap, base):
    Q = rotations(200)
    diagonal = np.array(base) + gap * np.array([0.0, 1.0, -0.3])
    C = Q @ np.diag(diagonal) @ np.swapaxes(Q, 1, 2)
    C = 0.5 * (C + np.swapaxes(C, 1, 2))
    values, axes = decompose(C)
    assert np.allclose(np.sort(values, axis=1), np.linalg.eigvalsh(C), rtol=0, atol=5e-15 * 3)
    assert np.allclose(axes @ np.swapaxes(axes, 1, 2), np.eye(3), rtol=0, atol=1e-14)
    again = np.einsum("nk,nki,nkj->nij", values, axes, axes)
    assert np.allclose(again, C, rtol=0, atol=2e-14)


def test_widely_spread_values_and_axes_along_the_coordinates():
    C = np.array([np.diag(d) for d in ([1e4, 1.0, 1e-4], [1.0, 1e4, 1e-4], [2.0, 2.0, 1e6])])
    values, axes = decompose(C)
    again = np.einsum("nk,nki,nkj->nij", values, axes, axes)
    assert np.allclose(again, C, rtol=0, atol=1e-15 * 1e6)
