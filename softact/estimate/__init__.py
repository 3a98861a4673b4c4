"""A first answer in a second: what an actuator does, by beams and moments of cavities.

After the analytical model of Polygerinos et al. (2013), equations 1 to 5, for every family of
elastomer: how the pressure on a cavity's section (its area and first moments) and the walls'
stresses balance. An estimate, for a first choice of dimensions; ``softact run`` is what decides.
See docs/estimate.md for what it leaves out and how far it is from runs.

A new family is one file in ``families/`` with ``beam(spec)`` and ``reservations(spec)``, and one
line in ``BEAMS``.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from softact.errors import SpecError
from softact.estimate.driven import inside, pressures
from softact.estimate.table import Estimate
from softact.spec import Spec

__all__ = ["BEAMS", "EXACT", "Estimate", "estimate", "has_estimate"]

#: Type of the geometry -> file in ``families``.
BEAMS = {
    "pneunet": "pneunet",
    "slow_pneunet": "slow_pneunet",
    "fiber_reinforced": "fiber_reinforced",
    "shell_reinforced": "shell_reinforced",
    "omnidirectional": "omnidirectional",
    "antagonistic": "antagonistic",
}
EXACT = {"thick_sphere": "thick_sphere", "tube": "tube"}
POINTS = 21


def has_estimate(spec: Spec) -> bool:
    """Whether there is an estimate for the spec's geometry."""
    return spec.geometry.type in (*BEAMS, *EXACT)


def estimate(spec: Spec, points: int = POINTS) -> Estimate:
    """Estimate what the actuator of a spec does up to the pressures of its steps.

    points: rows of the table, the unloaded state among them. Raises SpecError where the geometry
    has no estimate or the steps have no pressure.
    """
    kind = spec.geometry.type
    if not has_estimate(spec):
        raise SpecError(
            f"geometry: there is no estimate for {kind}; there is one for "
            f"{', '.join((*BEAMS, *EXACT))}"
        )
    driven = pressures(spec)
    if kind in EXACT:
        return _family(EXACT[kind]).table(spec, inside(spec), points)
    from softact.estimate.bending import bending  # which takes the rod of the exports

    family = _family(BEAMS[kind])
    return bending(spec, family.beam(spec), driven, points, family.reservations(spec))


def _family(name: str) -> Any:
    return import_module(f"softact.estimate.families.{name}")
