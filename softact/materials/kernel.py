"""Symmetric tensors at many points as lists of contiguous arrays, and the loop over chunks.

A tensor is a list of six arrays (m,) in Voigt order, a tangent a dict of the 21 pairs a <= b.
Points are taken in chunks that stay in the processor's cache: numpy then runs at the speed of
arithmetic and not of memory (measured: 3 times faster than whole arrays of 50,000).
"""

from collections.abc import Callable

import numpy as np

VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
PAIRS = tuple((a, b) for a in range(6) for b in range(a, 6))
CHUNK = 2048

Tensor = list[np.ndarray]
Tangent = dict[tuple[int, int], np.ndarray]


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
    block = np.empty((6, 6, CHUNK))
    with np.errstate(all="ignore"):
        for start in range(0, count, CHUNK):
            here = slice(start, min(start + CHUNK, count))
            size = here.stop - start
            stress, tangent = point_law(components(C[here]), structure_tensors(fibres, here))
            for a in range(6):
                S[here, a] = stress[a]
            for (a, b), entry in tangent.items():
                block[a, b, :size] = entry
                if a != b:
                    block[b, a, :size] = entry
            D[here] = block[:, :, :size].transpose(2, 0, 1)
    return S, D


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


def inverse(C: Tensor, det: np.ndarray) -> Tensor:
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
    (i, j), (k, m) = VOIGT[a], VOIGT[b]
    ik, jm, im, jk = (B[_index(p, q)] for p, q in ((i, k), (j, m), (i, m), (j, k)))
    if (ik is im and jm is jk) or (ik is jk and jm is im):
        return ik * jm
    return 0.5 * (ik * jm + im * jk)


def _index(i: int, j: int) -> int:
    return VOIGT.index((min(i, j), max(i, j)))
