"""Where a material breaks, as nominal stress, as Cauchy stress and as stretch.

A data sheet gives force over undeformed area. A body breaks where it is thin: there the Cauchy
stress is larger by the stretch. One is made of the other by the law that the solver uses, in
uniaxial tension, so that a bar in tension breaks at the same load by both.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from softact.materials.base import Material

#: Where uniaxial tension is looked at; the strength lies between two of these, taken as a line.
STRETCHES = np.geomspace(1.0, 20.0, 1201)
_HALVINGS = 48


@dataclass(frozen=True)
class Breaking:
    """nominal: largest nominal stress, MPa; cauchy: largest Cauchy stress, MPa; stretch: at break.

    None for what neither the card nor the law tells.
    """

    nominal: float | None
    cauchy: float | None
    stretch: float | None


@functools.lru_cache(maxsize=128)  # asked for at each state, of the same few materials
def breaking(material: Material) -> Breaking:
    """What a material bears, from the strength and the elongation of its card.

    The other stress is None where the law does not come to the strength below a stretch of 20, or
    has fibres: which way they were pulled, the card does not say.
    """
    card = material.card
    stretch = None if card.elongation is None else 1 + card.elongation
    if card.strength is None:
        return Breaking(None, None, stretch)
    nominal = card.strength_is == "nominal"
    other = None if material.law.anisotropic else _other(material, card.strength, nominal)
    if nominal:
        return Breaking(card.strength, other, stretch)
    return Breaking(other, card.strength, stretch)


def uniaxial(material: Material, stretch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nominal and Cauchy stress (n,) in MPa of a bar that is free across, at stretches (n,) >= 1.

    NaN where the law has no value, or no width between that of equal volume and the undeformed one
    leaves the sides free.
    """
    thin, wide = stretch**-0.5, np.ones_like(stretch)
    with np.errstate(all="ignore"):
        _, most = _cauchy(material, stretch, wide)
        for _ in range(_HALVINGS):
            middle = (thin + wide) / 2
            _, across = _cauchy(material, stretch, middle)
            thin, wide = np.where(across < 0, middle, thin), np.where(across < 0, wide, middle)
        along, _ = _cauchy(material, stretch, thin)
        along = np.where(most >= 0, along, np.nan)
    return along * thin**2, along


def _cauchy(
    material: Material, stretch: np.ndarray, width: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Cauchy stress along and across (n,) of a bar of a stretch and a width."""
    C = np.zeros((len(stretch), 3, 3))
    C[:, 0, 0], C[:, 1, 1], C[:, 2, 2] = stretch**2, width**2, width**2
    volume = stretch * width**2
    S, _ = material.stress_tangent(C)
    _, extra, _ = material.extra_volumetric(volume)
    pressure = material.bulk_modulus * (volume - 1) + extra
    return tuple(C[:, i, i] * S[:, i] / volume + pressure for i in (0, 1))


def _other(material: Material, strength: float, nominal: bool) -> float | None:
    """The Cauchy stress at a nominal strength, or the nominal stress at a true one."""
    stresses = uniaxial(material, STRETCHES)
    given, wanted = stresses if nominal else stresses[::-1]
    beyond = np.flatnonzero(given >= strength)
    if not len(beyond):
        return None
    n = int(beyond[0])
    if not np.isfinite(given[: n + 1]).all():
        return None
    return float(np.interp(strength, given[n - 1 : n + 1], wanted[n - 1 : n + 1]))
