"""Thick tube: exact far from its ends."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from softact.estimate.table import Estimate
from softact.estimate.thick import inner_stretches, rising, tube_pressure
from softact.geometries.tube import Tube
from softact.materials import Law
from softact.spec import Spec

SHORTEST, LONGEST = 0.2, 4.0


def table(spec: Spec, pressure: float, points: int) -> Estimate:
    """Pressure on the bore, stretch there, elongation, and the force that blocks it."""
    g = spec.geometry
    assert isinstance(g, Tube)
    law = spec.materials["body"]
    held = _holds_its_length(spec)
    stretches = inner_stretches()
    axial = np.ones_like(stretches)
    if not held:
        axial = np.array([_free_length(law, g, stretch) for stretch in stretches])
    found, pull = tube_pressure(law, g.inner_radius, g.outer_radius, stretches, axial)
    count = rising(found)
    known = np.concatenate([[0.0], found[:count]])
    reached = min(pressure, known[-1])
    p = np.linspace(0.0, reached, points)

    def at(values: np.ndarray, start: float) -> np.ndarray:
        return np.interp(p, known, np.concatenate([[start], values[:count]]))

    columns = {"pressure_kPa": 1e3 * p, "max_principal_stretch": at(stretches, 1.0)}
    columns["elongation_mm"] = g.length * (at(axial, 1.0) - 1)
    if held:
        columns["blocked_force_N"] = -at(pull, 0.0)
    ended = [f"the pressure has a limit at {1e3 * known[-1]:.4g} kPa"] if reached < pressure else []
    notes = [
        "far from the ends; a clamp that holds the radius stiffens the tube over about a diameter"
    ]
    return Estimate(
        spec.name, "Exact for an incompressible material (Ogden 1984, 5.3.3)", columns, notes, ended
    )


def _free_length(law: Law, g: Tube, stretch: float) -> float:
    """Axial stretch without an axial force."""

    def pull(axial: float) -> float:
        at = np.array([stretch]), np.array([axial])
        return float(tube_pressure(law, g.inner_radius, g.outer_radius, *at)[1][0])

    # The volume of the wall must not vanish: a² l > 1 − (R²/A²).
    return brentq(pull, max(SHORTEST, 1.0001 / stretch**2), LONGEST)


def _holds_its_length(spec: Spec) -> bool:
    held = {s.surface for s in spec.supports or () if 0 in s.values}
    return {"clamp", "tip"} <= held
