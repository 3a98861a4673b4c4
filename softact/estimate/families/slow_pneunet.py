"""Slow PneuNet: thin chambers across a block, over a film or (linear kind) within it."""

from __future__ import annotations

from softact.estimate.beam import Beam
from softact.estimate.driven import pressures, title
from softact.estimate.films import film
from softact.estimate.reach import opened, slit_decay
from softact.estimate.sections import Section, rectangle
from softact.estimate.uniaxial import free_across, matrix
from softact.geometries.slow_pneunet import SlowPneunet
from softact.spec import Spec


def beam(spec: Spec) -> Beam:
    """The whole block as one section, for as long as the chambers are felt.

    By reciprocity a pressure in a slit bends the block by as much as bending the block opens the
    slit: as a crack of its area opens. Its own length adds nothing: what bending stretches it by,
    it gets narrower across, and its volume stays.
    """
    g = spec.geometry
    assert isinstance(g, SlowPneunet)
    half, wide = g.chamber_width / 2, g.width / 2
    low, high = g.below, g.below + g.chamber_height
    body = free_across(spec.materials["body"])
    solid = g.below if g.bends else 0.0
    walls = [(rectangle(-wide, wide, solid, high + g.roof), body)]
    if g.bends:
        across = (g.film_width or g.width) / 2
        film_law = free_across(spec.materials["film"])
        walls.append((rectangle(-across, across, 0.0, g.below, 4), film_law))
    films = [film(layer, 0.0, (g.film_width or g.width) if g.bends else g.width)
             for layer in spec.layers if layer.surface == "base"]  # fmt: skip
    air = rectangle(-half, half, low, high)
    decay = slit_decay(g.chamber_width * g.chamber_height)
    gives = g.chambers * opened(0.0, decay, g.inner_wall)
    section = Section(gives, walls, {"cavity": air}, films)
    return Beam([section], g.length, (high + g.roof) / 2, g.clamp_wall, g.tip_wall)


#: Part of the shear modulus from which chambers swell: see docs/estimate.md.
SWELLING = 0.5
#: Height of a chamber by its width from which a round crack is a poor picture of it.
TALL = 1.25


def reservations(spec: Spec) -> list[str]:
    """Why the estimate is poor for a spec: chambers that swell, or are tall."""
    g = spec.geometry
    assert isinstance(g, SlowPneunet)
    found: list[str] = []
    _, most = title(spec, pressures(spec))
    shear = matrix(spec.materials["body"]).shear_modulus
    if abs(most) > SWELLING * shear:
        found.append(
            f"from about {1e3 * SWELLING * shear:.3g} kPa on, half of the shear modulus, chambers "
            "in a block swell like balloons, which is left out: runs bend up to twice as far at "
            "one modulus, and may snap near 2.5"
        )
    if g.chamber_height > TALL * g.chamber_width:
        found.append(
            f"chambers {g.chamber_height:g} mm tall and {g.chamber_width:g} mm wide open less than "
            "the round crack that is assumed: runs bend up to a third less"
        )
    return found
