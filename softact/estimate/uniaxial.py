"""Nominal stress of an incompressible material in simple modes, from the law that the solver uses.

Polygerinos et al. (2013), equations 1 and 3, have the Yeoh law where nothing contracts across the
width: sigma = dU/d(stretch) with U = sum C_i (s^2 + s^-2 - 2)^i. Here any law, and either mode.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from softact.materials import Law
from softact.materials.laws.holzapfel import Holzapfel
from softact.materials.laws.neo_hookean import NeoHookean

#: Where the laws are evaluated; between these stresses are interpolated.
STRETCHES = np.concatenate([np.geomspace(0.05, 1.0, 2001), np.geomspace(1.0, 15.0, 2001)[1:]])
#: Nominal stress (n,) in MPa at stretches (n,).
Stress = Callable[[np.ndarray], np.ndarray]


def matrix(law: Law) -> Law:
    """A law without its fibres."""
    return NeoHookean(c10=f"{law.c10!r} MPa") if isinstance(law, Holzapfel) else law


def free_across(law: Law) -> Stress:
    """Uniaxial stress: nothing holds the material across."""
    return _stress(law, lambda s: (1 / np.sqrt(s), 1 / np.sqrt(s)))


def held_across(law: Law) -> Stress:
    """Pure shear: the width stays as it is, as equation 1 of Polygerinos et al. assumes."""
    return _stress(law, lambda s: (np.ones_like(s), 1 / s))


def _stress(law: Law, across: Callable) -> Stress:
    material = matrix(law).material()

    def nominal(stretch: np.ndarray) -> np.ndarray:
        s = np.atleast_1d(np.asarray(stretch, float))
        width, thickness = across(s)
        C = np.zeros((len(s), 3, 3))
        for axis, values in enumerate((s, width, thickness)):
            C[:, axis, axis] = values**2
        S, _ = material.stress_tangent(C)
        # The pressure that keeps the volume leaves no stress through the thickness.
        return s * S[:, 0] - thickness**2 / s * S[:, 2]

    with np.errstate(all="ignore"):
        tabled = nominal(STRETCHES)
    usable = _usable(tabled)
    return lambda stretch: np.interp(stretch, STRETCHES[usable], tabled[usable])


def _usable(tabled: np.ndarray) -> np.ndarray:
    """From the unstretched state on, up to where a law has no value or, as one that locks, pulls
    where it should push."""
    good = np.isfinite(tabled) & (np.sign(STRETCHES - 1) * tabled >= 0)
    one = int(np.argmin(np.abs(STRETCHES - 1)))
    up = np.logical_and.accumulate(good[one:])
    down = np.logical_and.accumulate(good[one::-1])[::-1]
    return np.concatenate([down, up[1:]])


def youngs_modulus(law: Law) -> float:
    """Initial modulus in MPa of an incompressible material; of law linear its own."""
    own = getattr(law, "youngs_modulus", None)
    return float(own) if own is not None else 3.0 * matrix(law).shear_modulus
