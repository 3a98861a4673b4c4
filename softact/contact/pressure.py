"""Contact pressure as a function of the gap, with its potential and its slope."""

from __future__ import annotations

import numpy as np

# Ratio of the stiffness to shear modulus over element size: a pressure of one shear modulus presses
# 1 % of an element in. It is raised where that is not enough (see ``limits``).
STIFFNESS = 100.0
# Of sheets: to Young's modulus times thickness over the element size squared. A pressure p then
# presses p h/(E t) of an element h in: the strain of a cylinder of the radius h under it, less than
# that of the sheet itself, whose radius is larger. The forces on a node change with its place as
# those of the membrane do, by E t.
SHEET_STIFFNESS = 4.0
# Overlap over which the pressure sets in, of the element size.
ONSET = 0.005


def pressure(
    gap: np.ndarray, stiffness: np.ndarray, onset: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Contact pressure, slope and potential at signed gaps (mm; below zero: overlap).

    All arrays of one shape. stiffness k: MPa/mm; onset d: mm. Returns (p, −dp/dg, φ), in MPa,
    MPa/mm and mJ/mm²; p = −dφ/dg. The pressure is zero for g > 0, k g²/(2 d) for −d < g < 0, and
    −k (g + d/2) below: a linear penalty whose slope sets in continuously, and that does not push
    what only touches.
    """
    near = np.clip(-gap, 0.0, onset)
    overlap = np.maximum(-gap - onset, 0.0)  # beyond the onset
    p = stiffness * (near**2 / (2 * onset) + overlap)
    slope = stiffness * near / onset
    potential = near**3 / (6 * onset) + overlap * (onset + overlap) / 2
    return p, slope, stiffness * potential
