"""Antagonistic bellows: two pairs of PneuNets at right angles, on both sides of a central wall."""

from __future__ import annotations

from math import acos, sqrt

import numpy as np

from softact.estimate.beam import Beam
from softact.estimate.reach import gives, spread
from softact.estimate.sections import Inside, Section, joined, region
from softact.estimate.uniaxial import Stress, free_across
from softact.geometries.antagonistic import Antagonistic
from softact.spec import Spec

PAIRS = ("upper", "lower")


def beam(spec: Spec) -> Beam:
    """Chambers and necks of both pairs."""
    g = spec.geometry
    assert isinstance(g, Antagonistic)
    stress = free_across(spec.materials["body"])
    bends = gives(*_bulging(g), g.pitch if g.chambers > 1 else g.chamber_length)
    reach = min(spread(g.midsection_radius, bends), g.radius)
    between, ends = g.pitch - bends, (g.pitch - g.chamber_length) / 2
    sections = []
    for pair in PAIRS:
        turned = pair != g.in_plane
        chambers = g.chambers * bends
        sections.append(_section(g, pair, turned, reach, g.chamber_radius, chambers, stress))
        necks = (g.chambers - 1) * between
        if necks > 0:
            of_necks = g.midsection_radius, g.channel_radius, necks, stress
            sections.append(_section(g, pair, turned, *of_necks))
    return Beam(sections, g.length, 0.0, g.clamp_plate + ends, g.tip_plate + ends)


def _bulging(g: Antagonistic) -> tuple[float, float]:
    """Area and perimeter of the wall of one cavity that faces a gap."""

    def arc(radius: float) -> float:
        return 2 * radius * acos(g.central_wall / 2 / radius)

    low, high = g.midsection_radius, g.chamber_radius
    half = g.central_wall / 2
    area = g._segment(high) - g._segment(low)
    sides = sqrt(high**2 - half**2) - sqrt(low**2 - half**2)
    return area, arc(high) + arc(low) + 2 * sides


def _section(
    g: Antagonistic,
    pair: str,
    turned: bool,
    reach: float,
    radius: float,
    length: float,
    stress: Stress,
) -> Section:
    """The central wall as wide as the actuator, and round it what is within a radius."""
    wall = g.central_wall / 2

    def up(y: np.ndarray, z: np.ndarray) -> np.ndarray:
        return y if turned else z

    def air(sign: int) -> Inside:
        def inside(y: np.ndarray, z: np.ndarray) -> np.ndarray:
            return (sign * up(y, z) > wall) & (np.hypot(y, z) < min(radius, reach))

        return inside

    def solid(y: np.ndarray, z: np.ndarray) -> np.ndarray:
        r = np.hypot(y, z)
        within = (r < reach) | ((np.abs(up(y, z)) < wall) & (r < g.radius))
        return within & ~air(1)(y, z) & ~air(-1)(y, z)

    cavities = {
        f"{pair}_{name}": region(air(sign), g.radius, 160) for name, sign in (("a", 1), ("b", -1))
    }
    if g.symmetry and turned:  # the cavity beside the plane of symmetry gets the pressure of a
        cavities = {f"{pair}_a": joined(list(cavities.values()))}
    return Section(length, [(region(solid, g.radius, 160), stress)], cavities)


def reservations(spec: Spec) -> list[str]:
    """Why the estimate is poor for a spec."""
    return []
