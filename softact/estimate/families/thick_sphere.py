"""Thick sphere: exact."""

from __future__ import annotations

import numpy as np

from softact.estimate.driven import left_out
from softact.estimate.table import Estimate
from softact.estimate.thick import inner_stretches, rising, sphere_pressure
from softact.geometries.thick_sphere import ThickSphere
from softact.spec import Spec


def table(spec: Spec, pressure: float, points: int) -> Estimate:
    """Pressure, stretch at the inside and volume; up to the first limit of the pressure."""
    g = spec.geometry
    assert isinstance(g, ThickSphere)
    stretches = inner_stretches()
    found = sphere_pressure(spec.materials["body"], g.inner_radius, g.outer_radius, stretches)
    count = rising(found)
    known = np.concatenate([[0.0], found[:count]])
    inner = np.concatenate([[1.0], stretches[:count]])
    reached = min(pressure, known[-1])
    p = np.linspace(0.0, reached, points)
    stretch = np.interp(p, known, inner)
    columns = {
        "pressure_kPa": 1e3 * p,
        "max_principal_stretch": stretch,
        "cavity_volume_mm3": 4 / 3 * np.pi * (g.inner_radius * stretch) ** 3,
    }
    notes = left_out(spec, ("pressure",))
    ended = [f"the pressure has a limit at {1e3 * known[-1]:.4g} kPa"] if reached < pressure else []
    return Estimate(
        spec.name, "Exact for an incompressible material (Ogden 1984, 5.3.2)", columns, notes, ended
    )
