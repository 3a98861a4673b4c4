"""Antagonistic bellows: two pairs of PneuNets at right angles, on both sides of a central wall."""

from __future__ import annotations

import numpy as np

from softact.estimate.beam import Beam
from softact.estimate.reach import spread
from softact.estimate.sections import Section, region
from softact.estimate.uniaxial import free_across
from softact.spec import Spec

PAIRS = ("upper", "lower")


def beam(spec: Spec) -> Beam:
    """Chambers and necks of both pairs."""
    g = spec.geometry
    stress = free_across(spec.materials["body"])
    reach = min(spread(g.midsection_radius, g.chamber_length), g.radius)
    between = g.pitch - g.chamber_length
    sections = []
    for pair in PAIRS:
        turned = pair != g.in_plane
        chambers = g.chambers * g.chamber_length
        sections.append(_section(g, pair, turned, reach, g.chamber_radius, chambers, stress))
        necks = (g.chambers - 1) * between
        if necks:
            of_necks = g.midsection_radius, g.channel_radius, necks, stress
            sections.append(_section(g, pair, turned, *of_necks))
    return Beam(sections, g.length, 0.0, g.clamp_plate + between / 2, g.tip_plate + between / 2)


def _section(g, pair, turned, reach, radius, length, stress) -> Section:
    """The central wall as wide as the actuator, and round it what is within a radius."""
    wall = g.central_wall / 2

    def up(y, z):
        return y if turned else z

    def air(sign):
        def inside(y, z):
            return (sign * up(y, z) > wall) & (np.hypot(y, z) < min(radius, reach))

        return inside

    def solid(y, z):
        r = np.hypot(y, z)
        within = (r < reach) | ((np.abs(up(y, z)) < wall) & (r < g.radius))
        return within & ~air(1)(y, z) & ~air(-1)(y, z)

    cavities = {
        f"{pair}_{name}": region(air(sign), g.radius, 160) for name, sign in (("a", 1), ("b", -1))
    }
    return Section(length, [(region(solid, g.radius, 160), stress)], cavities)
