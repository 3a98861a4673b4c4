"""Fibre-reinforced bending actuator: a half-round tube whose winding holds its outline."""

from __future__ import annotations

from math import pi

import numpy as np

from softact.estimate.beam import Beam
from softact.estimate.films import film
from softact.estimate.sections import Section, region
from softact.estimate.uniaxial import free_across
from softact.geometries.fiber_reinforced import FiberReinforced
from softact.spec import Spec


def beam(spec: Spec) -> Beam:
    """One section: core, sleeve without its fibres, chamber, base.

    Of fibres nearly round the tube the axis feels nothing: they keep it from bulging, and go slack
    where it gets narrower, so the walls are in uniaxial tension.
    """
    g = spec.geometry
    assert isinstance(g, FiberReinforced)
    r, sleeve = g.radius, g.radius - g.sleeve
    floor, inside = g.sleeve + g.base_wall, g.radius - g.sleeve - g.wall

    def chamber(y: np.ndarray, z: np.ndarray) -> np.ndarray:
        return (y**2 + z**2 < inside**2) & (z > floor)

    def core(y: np.ndarray, z: np.ndarray) -> np.ndarray:
        return (y**2 + z**2 < sleeve**2) & (z > g.sleeve) & ~chamber(y, z)

    def skin(y: np.ndarray, z: np.ndarray) -> np.ndarray:
        return (y**2 + z**2 < r**2) & (z > 0) & ~core(y, z) & ~chamber(y, z)

    walls = [
        (region(core, r), free_across(spec.materials["body"])),
        (region(skin, r), free_across(spec.materials["sleeve"])),
    ]
    films = [film(layer, 0.0, 2 * r) for layer in spec.layers if layer.surface == "base"]
    section = Section(g.length - 2 * g.end, walls, {"cavity": region(chamber, r)}, films)
    return Beam([section], g.length, 4 * r / (3 * pi), g.end, g.end)


#: Part of the radius that walls may be: see docs/estimate.md.
THICK = 0.35


def reservations(spec: Spec) -> list[str]:
    """Why the estimate is poor for a spec: a small chamber in thick walls."""
    g = spec.geometry
    assert isinstance(g, FiberReinforced)
    walls = g.sleeve + g.wall
    if walls <= THICK * g.radius:
        return []
    return [
        f"walls of {walls:g} mm are thick beside a radius of {g.radius:g} mm: the chamber rounds "
        "out, which is left out, and runs bend up to two thirds more"
    ]
