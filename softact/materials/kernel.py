"""Symmetric tensors at many points as lists of contiguous arrays, and the loop over chunks.

A tensor is a sequence of six arrays (m,) in Voigt order, a tangent an array (6, 6, m) of which the
pairs a <= b are filled. Points are taken in chunks that stay in the processor's cache: numpy then
runs at the speed of arithmetic and not of memory.
"""

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np

VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
PAIRS = tuple((a, b) for a in range(6) for b in range(a, 6))
CHUNK = 4096

Tensor: TypeAlias = Sequence[np.ndarray] | np.ndarray
Tangent = np.ndarray


def by_chunks(
    C: np.ndarray,
    fibres: np.ndarray | None,
    point_law: Callable[[Tensor, list[Tensor]], tuple[Tensor, Tangent]],
) -> tuple[np.ndarray, np.ndarray]:
    """Return S (n,6) and D (n,6,6) from ``point_law``, called with components of C in chunks.

    ``point_law`` also gets M = a⊗a of each fibre family.
    """
    C = np.asarray(C, dtype=float)
    count = len(C)
    S, D = np.empty((count, 6)), np.empty((count, 6, 6))
    with np.errstate(all="ignore"):
        for start in range(0, count, CHUNK):
            here = slice(start, min(start + CHUNK, count))
            stress, tangent = point_law(components(C[here]), structure_tensors(fibres, here))
            S[here] = np.transpose(stress)
            for a, b in PAIRS:
                if a != b:
                    tangent[b, a] = tangent[a, b]
            D[here] = tangent.transpose(2, 0, 1)
    return S, D


def sum_of_products(left: np.ndarray, right: np.ndarray) -> Tangent:
    """Return Σ_k left[k] ⊗ right[k] for arrays (k, 6, m), pairs a <= b only."""
    result = np.empty((6, 6, left.shape[2]))
    for a, b in PAIRS:
        np.einsum("km,km->m", left[:, a], right[:, b], out=result[a, b])
    return result


def components(C: np.ndarray) -> Tensor:
    """Return the six Voigt components of symmetric tensors (n,3,3), each contiguous."""
    return [np.ascontiguousarray(C[:, i, j]) for i, j in VOIGT]


def structure_tensors(fibres: np.ndarray | None, here: slice) -> list[Tensor]:
    """Return M = a⊗a of each family of unit vectors ``fibres`` (n, families, 3)."""
    if fibres is None:
        return []
    part = np.asarray(fibres, dtype=float)[here]
    return [
        [np.ascontiguousarray(part[:, f, i] * part[:, f, j]) for i, j in VOIGT]
        for f in range(part.shape[1])
    ]


def determinant(C: Tensor) -> np.ndarray:
    """Return det C (n,)."""
    xx, yy, zz, xy, xz, yz = C
    return xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)


def inverse(C: Tensor, det: np.ndarray) -> list[np.ndarray]:
    """Return the components of C⁻¹."""
    xx, yy, zz, xy, xz, yz = C
    r = 1.0 / det
    return [
        (yy * zz - yz * yz) * r,
        (xx * zz - xz * xz) * r,
        (xx * yy - xy * xy) * r,
        (xz * yz - xy * zz) * r,
        (xy * yz - xz * yy) * r,
        (xy * xz - xx * yz) * r,
    ]


def contract(A: Tensor, B: Tensor) -> np.ndarray:
    """Return A : B (n,) of symmetric tensors."""
    return A[0] * B[0] + A[1] * B[1] + A[2] * B[2] + 2.0 * (A[3] * B[3] + A[4] * B[4] + A[5] * B[5])


def symmetric_square(B: Tensor, a: int, b: int) -> np.ndarray:
    """Return component (a, b) of ½ (B_ik B_jl + B_il B_jk), that is of −∂B/∂C with B = C⁻¹."""
    first, second = _SQUARE[a, b]
    if first == second:
        return B[first[0]] * B[first[1]]
    return 0.5 * (B[first[0]] * B[first[1]] + B[second[0]] * B[second[1]])


def _index(i: int, j: int) -> int:
    return VOIGT.index((min(i, j), max(i, j)))


_SQUARE = {
    (a, b): tuple(
        tuple(sorted((_index(i, p), _index(j, q)))) for p, q in (VOIGT[b], VOIGT[b][::-1])
    )
    for a, b in PAIRS
    for i, j in (VOIGT[a],)
}
