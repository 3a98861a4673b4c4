"""Coulomb friction by return mapping: an elastic stick, and a slip that keeps |t| = μ p.

The tangential traction is −(μ p/l) s, where s is the elastic part of the slip since contact began,
kept from equilibrium to equilibrium; what would make |s| more than the length l is true slip and
is forgotten (Giannakopoulos, Comput. Struct. 32 (1989) 157; Wriggers, Computational Contact
Mechanics, 2006, sec. 5.2). The length is the same at any pressure, so that a point that hardly
touches does not turn its traction within nanometres. The tangent is exact, and not symmetric.
"""

from __future__ import annotations

import numpy as np

# Largest elastic slip, of the element size.
ELASTIC_SLIP = 0.005


def _mapped(along: np.ndarray, limit: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Elastic part (n, 3) of a slip ``along`` (n, 3) the surface, mm, no longer than ``limit``
    (n,), and its derivative with respect to ``along`` (n, 3, 3)."""
    length = np.linalg.norm(along, axis=1)
    slips = length > limit
    part = np.where(slips, limit / np.where(slips, length, 1.0), 1.0)
    direction = along / np.where(slips, length, 1.0)[:, None]
    across = np.eye(3) - np.where(slips, 1.0, 0.0)[:, None, None] * (
        direction[:, :, None] * direction[:, None]
    )
    return part[:, None] * along, part[:, None, None] * across


def friction(
    coefficient: float,
    pressure: np.ndarray,
    slope: np.ndarray,
    limit: np.ndarray,
    normal: np.ndarray,
    curvature: np.ndarray,
    trial: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Tangential traction and its derivative with respect to the place of the point.

    pressure p (n,) MPa; slope −dp/dg (n,); limit (n,) of the elastic slip, mm; normal (n, 3) and
    curvature (n, 3, 3) of the distance; trial (n, 3) elastic slip of the last equilibrium plus
    the motion since, mm. Returns (traction (n, 3) on the point, modulus (n, 3, 3), elastic slip
    (n, 3)), none of it where there is no pressure.
    """
    tangent = np.eye(3) - normal[:, :, None] * normal[:, None]
    along = np.einsum("nab,nb->na", tangent, trial)
    # Derivative of the tangential part: the normal turns as the point moves over the surface.
    inward = np.einsum("na,na->n", normal, trial)
    turning = np.einsum("na,nab->nb", trial, curvature)
    change = tangent - inward[:, None, None] * curvature - normal[:, :, None] * turning[:, None]
    elastic, mapped = _mapped(along, limit)
    stick = (coefficient * pressure / limit)[:, None]
    # p falls along the normal by the slope.
    gap_derivative = (coefficient * slope / limit)[:, None] * elastic
    modulus = gap_derivative[:, :, None] * normal[:, None] - stick[:, None] * (mapped @ change)
    return -stick * elastic, modulus, elastic * (pressure > 0.0)[:, None]


def slide(
    coefficient: float,
    pressure: np.ndarray,
    slope: np.ndarray,
    limit: np.ndarray,
    normal: np.ndarray,
    trial: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The same where the normal is that of the last equilibrium and the point faced moves too.

    Arguments as in ``friction``. Returns (traction (n, 3), its derivatives with respect to the
    trial slip (n, 3, 3) and to the gap (n, 3), elastic slip (n, 3)), none where no pressure is.
    """
    tangent = np.eye(3) - normal[:, :, None] * normal[:, None]
    elastic, mapped = _mapped(np.einsum("nab,nb->na", tangent, trial), limit)
    stick = (coefficient * pressure / limit)[:, None]
    gap_derivative = (coefficient * slope / limit)[:, None] * elastic
    kept = elastic * (pressure > 0.0)[:, None]
    return -stick * elastic, -stick[:, None] * (mapped @ tangent), gap_derivative, kept
