"""Thick tube: exact far from its ends."""

from __future__ import annotations

import numpy as np

from softact.estimate.driven import left_out
from softact.estimate.table import Estimate
from softact.estimate.thick import inner_stretches, rising, tube_pressure
from softact.geometries.tube import Tube
from softact.materials import Law
from softact.spec import Spec

SHORTEST, LONGEST, MOST_ITERATIONS = 0.2, 4.0, 60


def table(spec: Spec, pressure: float, points: int) -> Estimate:
    """Pressure on the bore, stretch there, elongation, and the force that blocks it."""
    g = spec.geometry
    assert isinstance(g, Tube)
    law = spec.materials["body"]
    held = _holds_its_length(spec)
    stretches = inner_stretches()
    axial = np.ones_like(stretches)
    if not held:
        axial = _free_lengths(law, g, stretches)
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
        "far from the ends; a clamp that holds the radius stiffens the tube over about a diameter",
        *left_out(spec, ()),
    ]
    return Estimate(
        spec.name, "Exact for an incompressible material (Ogden 1984, 5.3.3)", columns, notes, ended
    )


def _free_lengths(law: Law, g: Tube, stretches: np.ndarray) -> np.ndarray:
    """(n,) axial stretches without an axial force: false position, of which the end that stays is
    halved (Illinois), all at once."""

    def pull(axial: np.ndarray) -> np.ndarray:
        return tube_pressure(law, g.inner_radius, g.outer_radius, stretches, axial)[1]

    # The volume of the wall must not vanish: a² l > 1 − (R²/A²).
    low = np.maximum(SHORTEST, 1.0001 / stretches**2)
    high = np.full_like(stretches, LONGEST)
    at_low, at_high = pull(low), pull(high)
    side = np.zeros_like(stretches)
    for _ in range(MOST_ITERATIONS):
        between = (low * at_high - high * at_low) / (at_high - at_low)
        found = pull(between)
        if (np.abs(np.where(found < 0, between - low, between - high)) < 1e-9).all():
            break
        below = found < 0
        at_high = np.where(below & (side < 0), at_high / 2, at_high)
        at_low = np.where(~below & (side > 0), at_low / 2, at_low)
        low, at_low = np.where(below, between, low), np.where(below, found, at_low)
        high, at_high = np.where(below, high, between), np.where(below, at_high, found)
        side = np.where(below, -1.0, 1.0)
    return between


def _holds_its_length(spec: Spec) -> bool:
    held = {s.surface for s in spec.supports or () if 0 in s.values}
    return {"clamp", "tip"} <= held
