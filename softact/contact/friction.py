"""Coulomb friction by return mapping: an elastic stick, and a slip that keeps |t| = μ p.

The tangential traction is −k s where s is the elastic part of the slip since contact began, kept
from equilibrium to equilibrium; where k |s| would exceed μ p, the rest is true slip and is
forgotten (Giannakopoulos, Comput. Struct. 32 (1989) 157; Wriggers, Computational Contact
Mechanics, 2006, sec. 5.2). The tangent is exact, and not symmetric where there is slip.
"""

from __future__ import annotations

import numpy as np

# Stick stiffness by that of the penalty.
STICK = 1.0
# ... of a sheet on a solid, which slips so far that it shall begin to gently.
STICK_ON_SOLID = 0.1


def friction(coefficient, pressure, slope, stiffness, normal, curvature, trial):
    """Tangential traction and its derivative by the place of the point.

    pressure p (n,) MPa; slope −dp/dg (n,); stiffness of the stick (n,) MPa/mm; normal (n, 3) and
    curvature (n, 3, 3) of the distance; trial (n, 3) elastic slip of the last equilibrium plus
    the motion since, mm. Returns (traction (n, 3) on the point, modulus (n, 3, 3), elastic slip
    (n, 3)).
    """
    tangent = np.eye(3) - normal[:, :, None] * normal[:, None]
    along = np.einsum("nab,nb->na", tangent, trial)
    # Derivative of the tangential part: the normal turns as the point moves over the surface.
    inward = np.einsum("na,na->n", normal, trial)
    turning = np.einsum("na,nab->nb", trial, curvature)
    change = tangent - inward[:, None, None] * curvature - normal[:, :, None] * turning[:, None]
    length = np.linalg.norm(along, axis=1)
    bound = coefficient * pressure
    slips = stiffness * length > bound
    safe = np.where(slips, length, 1.0)
    direction = along / safe[:, None]
    across = np.eye(3) - direction[:, :, None] * direction[:, None]
    # p falls along the normal by the slope: t = −μ p e.
    sliding = (bound / safe)[:, None, None] * (across @ change) - coefficient * slope[
        :, None, None
    ] * direction[:, :, None] * normal[:, None]
    modulus = -np.where(slips[:, None, None], sliding, stiffness[:, None, None] * change)
    elastic = np.where(slips[:, None], (bound / stiffness)[:, None] * direction, along)
    return -stiffness[:, None] * elastic, modulus, elastic


def slide(coefficient, pressure, slope, stiffness, normal, trial):
    """The same where the normal is that of the last equilibrium and the point faced moves too.

    Arguments as in ``friction``. Returns (traction (n, 3), its derivative by the trial slip
    (n, 3, 3), its derivative by the gap (n, 3), elastic slip (n, 3)).
    """
    tangent = np.eye(3) - normal[:, :, None] * normal[:, None]
    along = np.einsum("nab,nb->na", tangent, trial)
    length = np.linalg.norm(along, axis=1)
    bound = coefficient * pressure
    slips = stiffness * length > bound
    safe = np.where(slips, length, 1.0)
    direction = along / safe[:, None]
    across = np.eye(3) - direction[:, :, None] * direction[:, None]
    sliding = (bound / safe)[:, None, None] * (across @ tangent)
    modulus = -np.where(slips[:, None, None], sliding, stiffness[:, None, None] * tangent)
    by_gap = np.where(slips, coefficient * slope, 0.0)[:, None] * direction
    elastic = np.where(slips[:, None], (bound / stiffness)[:, None] * direction, along)
    return -stiffness[:, None] * elastic, modulus, by_gap, elastic
