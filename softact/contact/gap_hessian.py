"""Second derivative of the gap between a point of one facet and the facet that it faces."""

from __future__ import annotations

import numpy as np


def gap_hessian(
    gap: np.ndarray,
    across: np.ndarray,
    tangents: np.ndarray,
    normal: np.ndarray,
    first: np.ndarray,
    bend: np.ndarray,
    outer: np.ndarray,
    inner: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """outer ∇g ∇gᵀ + inner ∇∇g with respect to the nodes of both facets, as factors left and right
    (m, 5, 6 n) of leftᵀ right.

    With v = δx − δy at the fixed place, t_α = y,α·v, s_α = n·δy,α, a the metric, b the curvature
    and A = a − g b: δg = n·v and δ²g = −(t a⁻¹ b A⁻¹ t + t A⁻¹ s + s A⁻¹ t + g s A⁻¹ s). It
    follows from g² = min |x − y|² over the facet, and holds at g = 0 too.
    """
    metric = tangents @ tangents.transpose(0, 2, 1)
    curvature = bend[:, [0, 1, 1, 2]].reshape(-1, 2, 2)
    whole = np.linalg.inv(metric - gap[:, None, None] * curvature)
    first_part = np.linalg.solve(metric, curvature @ whole)
    turning = np.concatenate([np.zeros_like(first), first], axis=2)
    t = (across[:, None, :, None] * tangents[:, :, None]).reshape(len(gap), 2, -1)
    s = (turning[..., None] * normal[:, None, None]).reshape(len(gap), 2, -1)
    g = (across[:, :, None] * normal[:, None]).reshape(len(gap), -1)
    # Two rank-two products: t (X t + A⁻¹ s) + s (A⁻¹ t + g A⁻¹ s).
    right_t = first_part @ t + whole @ s
    right_s = whole @ (t + gap[:, None, None] * s)
    left = np.concatenate([g[:, None], t, s], axis=1)
    right = np.concatenate(
        [
            outer[:, None, None] * g[:, None],
            -inner[:, None, None] * right_t,
            -inner[:, None, None] * right_s,
        ],
        axis=1,
    )
    return left, right
