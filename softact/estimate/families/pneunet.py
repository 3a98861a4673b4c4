"""Fast PneuNet: chambers over a base that does not stretch, joined by bridges low down."""

from __future__ import annotations

from softact.errors import SpecError
from softact.estimate.beam import Beam
from softact.estimate.films import film
from softact.estimate.reach import gives, spread
from softact.estimate.sections import Section, rectangle
from softact.estimate.uniaxial import free_across
from softact.geometries.pneunet import Pneunet
from softact.spec import Spec


def beam(spec: Spec) -> Beam:
    """One section: base, and the side walls as far above the bridges as bending reaches.

    Not the chambers' length counts but what their inner walls can open: a long chamber's middle is
    a stiff box. Nothing gives in more than a whole pitch. Raises SpecError where chambers are
    unequal.
    """
    g = spec.geometry
    assert isinstance(g, Pneunet)
    for name in g.lists:
        raise SpecError(f"geometry.{name}: there is no estimate of unequal chambers yet")
    row = g.row
    stress = free_across(spec.materials["body"])
    half, wide = g.chamber_width / 2, g.chamber_width / 2 + g.outer_wall
    ceiling = g.base + g.chamber_height
    pitch = row.pitch if g.chambers > 1 else row.chamber_length
    around = 2 * (g.chamber_width + g.chamber_height)
    bends = gives(g.chamber_width * g.chamber_height, around, pitch)
    bridge = g.base + g.channel_height + g.channel_roof
    top = min(spread(bridge, bends), ceiling + g.roof) if g.chambers > 1 else ceiling + g.roof
    walls = [
        rectangle(-wide, wide, 0.0, g.base),
        rectangle(half, wide, g.base, top),
        rectangle(-wide, -half, g.base, top),
        rectangle(-half, half, ceiling, top),
    ]
    air = rectangle(-half, half, g.base, min(top, ceiling))
    films = [film(layer, g.layer_height, 2 * wide) for layer in spec.layers
             if layer.surface == "strain_limiting_layer"]  # fmt: skip
    section = Section(g.chambers * bends, [(w, stress) for w in walls], {"cavity": air}, films)
    return Beam([section], row.length, (ceiling + g.roof) / 2, g.clamp_plug, g.tip_plug)


#: Where coarse runs differ by more than a third: see docs/estimate.md.
LONG, TALL = 1.6, 2.0


def reservations(spec: Spec) -> list[str]:
    """Why the estimate is poor for a spec: chambers that are long, or narrow."""
    g = spec.geometry
    assert isinstance(g, Pneunet)
    found: list[str] = []
    around = 2 * (g.chamber_width + g.chamber_height)
    bends = gives(g.chamber_width * g.chamber_height, around, g.row.pitch)
    if g.row.chamber_length > LONG * bends:
        found.append(
            f"chambers {g.row.chamber_length:g} mm long are long beside the {bends:.3g} mm of each "
            "that bend: runs bend up to a third less"
        )
    if g.chamber_height > TALL * g.chamber_width:
        found.append(
            f"chambers {g.chamber_height:g} mm tall and {g.chamber_width:g} mm wide bulge to the "
            "sides as much as into the gaps: runs bend up to a half less, long ones even back"
        )
    return found
