"""Shell-reinforced actuator: a soft tube in a shell that gives way in its slits alone."""

from __future__ import annotations

from math import asin, pi

from softact.estimate.beam import Beam
from softact.estimate.reach import opened
from softact.estimate.sections import Film, Section, region
from softact.estimate.uniaxial import free_across, youngs_modulus
from softact.geometries.shell_reinforced import ShellReinforced
from softact.spec import Spec


def beam(spec: Spec) -> Beam:
    """One section: the tube in the slits and as far under the rings as shear brings the stretch.

    Under a ring of the shell, bonded to its outside, the wall feels the slit over about its own
    thickness t: t G u'' = 3 G u / t for a displacement that grows from nothing at the shell, with
    an axial modulus of 3 G.
    """
    g = spec.geometry
    assert isinstance(g, ShellReinforced)
    outer, inner = g.radius, g.chamber_radius
    stress = free_across(spec.materials["body"])
    tube = region(lambda y, z: (y**2 + z**2 < outer**2) & (y**2 + z**2 > inner**2), outer)
    air = region(lambda y, z: y**2 + z**2 < inner**2, outer)
    ring = (g.length - 2 * g.end - g.cuts * g.slit) / (g.cuts + 1)
    gives = g.cuts * opened(g.slit, outer - inner, ring)
    films = [
        Film(z, width, youngs_modulus(layer.material) * layer.thickness)
        for layer in spec.layers
        for z, width in _strips(g)
    ]
    section = Section(gives, [(tube, stress)], {"cavity": air}, films)
    return Beam([section], g.length, 0.0, g.end, g.end)


def _strips(g: ShellReinforced) -> list[tuple[float, float]]:
    """Height and width of the parts of the shell that run through a row of slits.

    Those of the linear kind lie across each other from row to row and hold nothing together.
    """
    if g.kind == "linear":
        return []
    return [(-g.radius, 2 * g.radius * asin(g.strip / 2 / g.radius))] if g.cuts else [
        (0.0, 2 * pi * g.radius)
    ]  # fmt: skip


#: Part of the radius that a wall may be: see docs/estimate.md.
THICK = 0.4


def reservations(spec: Spec) -> list[str]:
    """Why the estimate is poor for a spec: a shell that slides, a thick wall."""
    g = spec.geometry
    assert isinstance(g, ShellReinforced)
    found: list[str] = []
    if g.shell == "sliding":
        found.append(
            "the shell slides: the whole core stretches under it, not the part near the slits "
            "alone, so a run bends or grows far more"
        )
    if g.radius - g.chamber_radius > THICK * g.radius:
        found.append(
            f"a wall of {g.radius - g.chamber_radius:g} mm is thick beside a radius of "
            f"{g.radius:g} mm: its inside stretches farther under the rings than is assumed, and "
            "runs bend up to a half more"
        )
    return found
