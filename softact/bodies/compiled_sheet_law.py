"""Which laws of sheets are compiled; the others are evaluated by numpy."""

from __future__ import annotations

import numpy as np

from softact.bodies.green_sheet import GreenSheet, GreenTensionField
from softact.bodies.invariant_sheet import InvariantSheet, InvariantTensionField
from softact.materials.invariants import InvariantLaw
from softact.materials.plane_stress import GreenLaw, IncompressibleLaw, SheetLaw
from softact.materials.tension_field import KEPT, TensionField


def compiled(law: SheetLaw) -> SheetLaw:
    """The same law, compiled where it can be."""
    if isinstance(law, GreenLaw):
        return GreenSheet(law)
    if (formula := _formula(law)) is not None:
        return InvariantSheet(*formula)
    return law


def relaxed(law: SheetLaw, poisson: float, kept: float = KEPT) -> SheetLaw:
    """The relaxed form of a law with this Poisson's ratio, compiled where it can be."""
    if isinstance(law, GreenLaw):
        return GreenTensionField(law, kept)
    if (formula := _formula(law)) is not None:
        return InvariantTensionField(*formula, poisson, kept)
    return TensionField(law, poisson, kept)


def _formula(law: SheetLaw) -> tuple[InvariantLaw, np.ndarray | None] | None:
    """A law of invariants at constant volume with its fibres in the sheet; None: it is another."""
    if not isinstance(law, IncompressibleLaw) or not isinstance(law.material.law, InvariantLaw):
        return None
    if law.fibres is not None and np.any(law.fibres[..., 2]):
        return None
    return law.material.law, law.fibres
