"""How much of a wide chamber takes part where narrow necks join it to its neighbours.

Its walls that face the gaps bulge, and open the neck's side as far as they can: a long chamber's
middle is a stiff box that neither bends the actuator nor is bent. Beyond the neck, across the
actuator, bending spreads into the chamber over a part of that length (Saint-Venant). Both parts
were fitted to coarse runs of PneuNets and bellows: docs/estimate.md says to which and how well.
"""

from __future__ import annotations

from math import pi, sqrt, tanh

#: Length of a chamber that bends the actuator, by the hydraulic diameter of the wall that bulges.
GIVES = 0.58
#: How far beyond the neck bending spreads, by that length.
SPREAD = 0.3


def gives(area: float, perimeter: float, pitch: float) -> float:
    """Length (mm) of each chamber that bends, where a wall of an area and perimeter bulges; no more
    than there is from one chamber to the next."""
    return min(GIVES * 4 * area / perimeter, pitch)


def spread(neck: float, length: float) -> float:
    """Height or radius (mm) up to which a chamber takes part: beyond that of the neck by a part of
    the length that bends."""
    return neck + SPREAD * length


def opened(length: float, decay: float, wall: float) -> float:
    """Length (mm) that gives as a soft section of ``length`` does, with what the walls beside it
    give: they are ``wall`` long and feel it as far as ``decay``."""
    return length + 2 * decay * tanh(wall / (2 * decay))


def slit_decay(area: float) -> float:
    """How far (mm) a thin slit across a solid is felt: half of what a penny-shaped crack of its
    area opens, 16 a³ s/(3 E/(1 − ν²)) by volume, spread over the area (Sneddon 1946; ν = 1/2)."""
    return 2 / pi * sqrt(area / pi)
