"""Which laws of sheets are compiled; the others are evaluated by numpy."""

from __future__ import annotations

from softact.bodies.green_sheet import GreenSheet, GreenTensionField
from softact.bodies.invariant_sheet import InvariantSheet, InvariantTensionField
from softact.materials.invariants import InvariantLaw
from softact.materials.plane_stress import GreenLaw, IncompressibleLaw, SheetLaw
from softact.materials.tension_field import KEPT, TensionField


def compiled(law: SheetLaw) -> SheetLaw:
    """The same law, compiled where it can be."""
    if isinstance(law, GreenLaw):
        return GreenSheet(law)
    if isinstance(law, IncompressibleLaw) and isinstance(law.material.law, InvariantLaw):
        return InvariantSheet(law.material.law, law.fibres)
    return law


def relaxed(law: SheetLaw, poisson: float, kept: float = KEPT) -> SheetLaw:
    """The relaxed form of a law with this Poisson's ratio, compiled where it can be."""
    if isinstance(law, GreenLaw):
        return GreenTensionField(law, kept)
    if isinstance(law, IncompressibleLaw) and isinstance(law.material.law, InvariantLaw):
        return InvariantTensionField(law.material.law, law.fibres, poisson, kept)
    return TensionField(law, poisson, kept)
