"""The analytical model of Polygerinos et al. (IROS 2013), section III-B, equations 1 to 5.

Its inner walls bulge as arcs of a circle, touch their neighbours where two sagittas fill the gap,
and then turn the chambers about the layer that does not stretch. The estimates of other families
take its balance of wall and pressure moment section by section; what is here says when the walls of
a PneuNet touch. A reader of the paper finds its symbols: a sagitta, b height of the wall (mm),
d gap (mm), s stretch.
"""

from __future__ import annotations

import numpy as np

from softact.estimate.uniaxial import held_across
from softact.materials import Law

Number = float | np.ndarray


def strain_energy(c1: float, c2: float, stretch: Number) -> Number:
    """Equation 1: U in the unit of c1, c2, nothing contracting across the width."""
    x = stretch**2 + 1 / stretch**2 - 2
    return c1 * x + c2 * x**2


def half_angle(a: Number, b: Number) -> np.ndarray:
    """Equation 2: radians; half of the arc whose chord is b and whose sagitta is a."""
    # The sine of the equation has two angles; beyond half a circle it is the larger one.
    angle = np.arcsin(np.clip(4 * a * b / (4 * a**2 + b**2), -1, 1))
    return np.where(2 * np.asarray(a) > b, np.pi - angle, angle)


def stretch(a: Number, b: Number) -> np.ndarray:
    """Of the wall: arc over chord, θ/sin θ."""
    angle = np.maximum(half_angle(a, b), 1e-9)
    return angle / np.sin(angle)


def stress(c1: float, c2: float, s: Number) -> Number:
    """Equation 3: dU/ds."""
    return (s**4 - 1) / s**3 * (2 * c1 + 4 * c2 * (s - 1 / s) ** 2)


def pressure(law: Law, a: Number, b: float, thickness: float) -> np.ndarray:
    """MPa that bulges a wall by a: p R = nominal stress times thickness, with R = b/2 sin θ.

    The paper leaves this step to the reader. Any law, in the mode of equation 1.
    """
    angle = half_angle(a, b)
    return held_across(law)(stretch(a, b)) * thickness * 2 * np.sin(angle) / b


def moment_arm(a: Number, b: float, d: float) -> Number:
    """Equation 5: M_a in mm², by which the pressure's increase raises force times lever (4)."""
    return b**2 * (2 - b**2 / (b**2 - (2 * a - d) ** 2))
