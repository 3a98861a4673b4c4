"""Omnidirectional bellows: wide chambers around the axis, joined by narrow necks."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, pi, sin

import numpy as np

from softact.estimate.beam import Beam
from softact.estimate.reach import gives, spread
from softact.estimate.sections import Inside, Section, joined, region
from softact.estimate.uniaxial import Stress, free_across
from softact.geometries.omnidirectional import Omnidirectional
from softact.spec import Spec


def beam(spec: Spec) -> Beam:
    """Chambers and necks of each segment; of a chamber only what is near enough to the neck takes
    part."""
    g = spec.geometry
    assert isinstance(g, Omnidirectional)
    stress = free_across(spec.materials["body"])
    bends = gives(*_bulging(g), g.pitch if g.pitches > 1 else g.chamber_length)
    reach = min(spread(g.midsection_radius, bends), g.actuator_radius)
    core = g.core_radius or 0.0
    inner, neck = g.channel_radius if g.channels else 0.0, g.pitch - bends
    sections = []
    for names in g.in_segments():
        lengths = g.modules * bends, (g.modules - 1) * neck
        chambers = _section(g, names, reach, g.chamber_radius, core, lengths[0], stress)
        necks = _section(g, names, g.midsection_radius, inner, core, lengths[1], stress)
        sections += [chambers, necks] if lengths[1] > 0 else [chambers]
    between = (len(g.in_segments()) - 1) * neck
    if between > 0:
        sections.append(_section(g, {}, g.midsection_radius, 0.0, core, between, stress))
    ends = (g.pitch - g.chamber_length) / 2
    return Beam(sections, g.length, 0.0, ends, ends)


def _bulging(g: Omnidirectional) -> tuple[float, float]:
    """Area and perimeter of the wall of one cavity that faces a gap."""
    share, low, high = 2 * pi / g.cavities, g.midsection_radius, g.chamber_radius
    return share * (high**2 - low**2) / 2, share * (high + low) + 2 * (high - low)


def _section(
    g: Omnidirectional,
    names: Mapping[str, str],
    reach: float,
    radius: float,
    core: float,
    length: float,
    stress: Stress,
) -> Section:
    """Within a radius: cavities between walls that are planes through the axis. names: of those
    of a module, in the whole arm."""

    def cavity(number: int) -> Inside:
        middle = pi / 2 - 2 * pi * (number + (0.5 if g.on_top == "wall" else 0.0)) / g.cavities
        half = pi / g.cavities

        def inside(y: np.ndarray, z: np.ndarray) -> np.ndarray:
            along, across = y * cos(middle) + z * sin(middle), y * -sin(middle) + z * cos(middle)
            # Distance from the two planes that bound the sector.
            walls = along * sin(half) - np.abs(across) * cos(half) > g.inner_wall / 2
            r = np.hypot(y, z)
            return walls & (r < min(radius, reach)) & (r > core)

        return inside

    regions = [cavity(number) for number in range(g.cavities)]

    def wall(y: np.ndarray, z: np.ndarray) -> np.ndarray:
        taken = np.any([inside(y, z) for inside in regions], axis=0)
        return (np.hypot(y, z) < reach) & ~taken

    patches = [region(inside, reach) for inside in regions]
    cavities = {
        names[name]: joined([patches[other] for other in sorted({n, _mirrored(g, n)})])
        for n in range(g.cavities)
        if (name := f"cavity_{n + 1}") in names
    }
    return Section(length, [(region(wall, reach), stress)], cavities)


def _mirrored(g: Omnidirectional, number: int) -> int:
    """The cavity that gets the same pressure: where half is modelled, its mirror image."""
    if not g.symmetry:
        return number
    return (g.cavities - number - (1 if g.on_top == "wall" else 0)) % g.cavities


#: Where coarse runs differ by about a third or more: see docs/estimate.md.
LONG, THICK = 1.6, 1.5


def reservations(spec: Spec) -> list[str]:
    """Why the estimate is poor for a spec: chambers that are long, or stiff towards the gaps."""
    g = spec.geometry
    assert isinstance(g, Omnidirectional)
    found: list[str] = []
    bends = gives(*_bulging(g), g.pitch)
    if g.chamber_length > LONG * bends:
        found.append(
            f"chambers {g.chamber_length:g} mm long are long beside the {bends:.3g} mm of each "
            "that bend: runs bend up to a third less"
        )
    if g.side_wall > THICK * g.inner_wall:
        found.append(
            f"side walls of {g.side_wall:g} mm beside inner walls of {g.inner_wall:g} mm bulge "
            "less than is assumed: runs bend up to a half less"
        )
    return found
