"""3×3 tensors at many points, faster than numpy.linalg on stacks of small matrices.

Symmetric tensors are (n, 6) in Voigt's order 11, 22, 33, 12, 13, 23.
"""

import numpy as np

from softact.materials.eigen import eigen_system

ROWS, COLUMNS = [0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]


def determinant(f: np.ndarray) -> np.ndarray:
    """Determinants (...) of tensors (..., 3, 3)."""
    return (
        f[..., 0, 0] * (f[..., 1, 1] * f[..., 2, 2] - f[..., 1, 2] * f[..., 2, 1])
        - f[..., 0, 1] * (f[..., 1, 0] * f[..., 2, 2] - f[..., 1, 2] * f[..., 2, 0])
        + f[..., 0, 2] * (f[..., 1, 0] * f[..., 2, 1] - f[..., 1, 1] * f[..., 2, 0])
    )


def volumetric_response(
    inverse: np.ndarray, jacobian: np.ndarray, slope: np.ndarray, curvature: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """S (n, 6) and D (n, 6, 6) of an energy U(J), with respect to C.

    inverse: C⁻¹ (n, 3, 3). slope, curvature: U' and U'' (n,). S = J U' C⁻¹ and
    D = (J² U'' + J U') C⁻¹ ⊗ C⁻¹ − 2 J U' C⁻¹ ⊙ C⁻¹ (Holzapfel 2000, section 6.6).
    """
    v, product = inverse[:, ROWS, COLUMNS], symmetric_product(inverse)
    first = jacobian * slope
    moduli = (jacobian**2 * curvature + first)[:, None, None] * v[:, :, None] * v[:, None]
    return first[:, None] * v, moduli - (2 * first)[:, None, None] * product


def symmetric_product(a: np.ndarray) -> np.ndarray:
    """A ⊙ A (n, 6, 6) of tensors A (n, 3, 3): ½ (A_ik A_jl + A_il A_jk) in Voigt pairs."""
    i, j = np.array(ROWS)[:, None], np.array(COLUMNS)[:, None]
    k, m = np.array(ROWS)[None], np.array(COLUMNS)[None]
    return (a[:, i, k] * a[:, j, m] + a[:, i, m] * a[:, j, k]) / 2


def symmetric(whole: np.ndarray) -> np.ndarray:
    """(n, 6) of symmetric tensors (..., 3, 3)."""
    return whole.reshape(-1, 3, 3)[:, ROWS, COLUMNS]


def full(six: np.ndarray) -> np.ndarray:
    """(n, 3, 3) of symmetric tensors (n, 6)."""
    return six[:, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3)


def largest_eigenvalue(tensors: np.ndarray) -> np.ndarray:
    """(n,) of symmetric tensors (n, 6), to rounding."""
    return np.maximum.reduce(eigen_system(list(np.ascontiguousarray(tensors.T)))[0])


def bounds(tensors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two values (n,) between which the largest eigenvalue of symmetric tensors (n, 6) lies.

    It is mean + 2 p cos φ with 0 ≤ φ ≤ 60°, 6 p² the deviator's square (Smith 1961, Comm. ACM
    4:168).
    """
    mean, p = tensors[:, :3].mean(axis=1), _deviator(tensors) / np.sqrt(6)
    return mean + p, mean + 2 * p


def von_mises(tensors: np.ndarray) -> np.ndarray:
    """Equivalent stress (n,) of stresses (n, 6)."""
    return np.sqrt(1.5) * _deviator(tensors)


def _deviator(tensors: np.ndarray) -> np.ndarray:
    """Frobenius norm (n,) of the deviators."""
    normal = tensors[:, :3] - tensors[:, :3].mean(axis=1, keepdims=True)
    return np.sqrt((normal**2).sum(axis=1) + 2 * (tensors[:, 3:] ** 2).sum(axis=1))
