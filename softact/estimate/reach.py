"""How much of a wide chamber takes part where narrow necks join it to its neighbours.

A bending moment comes out of the neck and spreads into the walls of the chamber over a length that
is a part of the chamber's own (Saint-Venant); what is farther away is neither stretched by the
bending nor, by reciprocity, bends the actuator when the pressure pushes on it.
"""

from __future__ import annotations

from math import pi, sqrt, tanh

#: Part of the chamber's length by which the bending spreads beyond the neck, on both sides alike.
SPREAD = 0.3


def spread(neck: float, chamber_length: float) -> float:
    """Height or radius (mm) up to which a chamber takes part, that of the neck being ``neck``."""
    return neck + SPREAD * chamber_length


def opened(length: float, decay: float, wall: float) -> float:
    """Length (mm) that gives as a soft section of ``length`` does, with what the walls beside it
    give: they are ``wall`` long and feel it as far as ``decay``."""
    return length + 2 * decay * tanh(wall / (2 * decay))


def slit_decay(area: float) -> float:
    """How far (mm) a thin slit across a solid is felt: half of what a penny-shaped crack of its
    area opens, 16 a³ s/(3 E/(1 − ν²)) by volume, spread over the area (Sneddon 1946; ν = 1/2)."""
    return 2 / pi * sqrt(area / pi)
