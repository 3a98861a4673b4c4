"""Derivatives against those of exact solutions: thick sphere and tube of neo-Hookean rubber."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from softact.sensitivities.parameters import SMALL
from softact.spec import loads
from tests.sensitivities.whole_runs import prepare, rows

SOLVER = "solver: {initial_increment: 1, max_increment: 1, tolerance: 1e-9}"
# 0.49999: its volume change is far below 1 %.
RUBBER = "{law: neo_hookean, c10: 0.1 MPa, poissons_ratio: 0.49999}"
SPHERE = """
geometry: {type: thick_sphere, inner_radius: 10 mm, outer_radius: 14 mm, mesh_size: %s mm}
materials: {body: %s}
steps: [{pressure: 40 kPa}]
"""
TUBE = """
geometry: {type: tube, inner_radius: 5 mm, outer_radius: 7 mm, length: 1 mm, mesh_size: %s mm}
materials: {body: %s}
supports: [{surface: clamp, fix: [x]}, {surface: tip, fix: [x]}]
steps: [{surface_pressure: {bore: 25 kPa}}]
"""
PARTS = 1e-5  # of a parameter, for the slope of a closed form


def sphere_volume(inner: float, outer: float, c10: float, pressure: float) -> float:
    """Volume (mm³) of the cavity: p = c10 [4/λ + 1/λ⁴] from the inner to the outer stretch."""

    def lacking(stretch: float) -> float:
        far = np.cbrt(1 + (stretch**3 - 1) * (inner / outer) ** 3)
        return c10 * (4 / far + far**-4 - 4 / stretch - stretch**-4) - pressure

    return 4 / 3 * np.pi * (inner * brentq(lacking, 1.0, 1.5, xtol=1e-14)) ** 3


def tube_energy(inner: float, outer: float, c10: float, pressure: float) -> float:
    """Strain energy (mJ per mm of length) of a tube of a fixed length: r² = R² + C, λ = r/R,
    p = ∫ 2 c10 (λ² − λ⁻²) dr/r, W = c10 (λ² + λ⁻² − 2)."""

    def square(radius: float, c: float) -> float:
        return 1 + c / radius**2

    def lacking(c: float) -> float:
        def slope(radius: float) -> float:
            s = square(radius, c)
            return 2 * c10 * (s - 1 / s) / (s * radius)

        return quad(slope, inner, outer, epsabs=1e-14)[0] - pressure

    c = brentq(lacking, 0.0, inner**2, xtol=1e-12)
    density = [lambda r: c10 * (square(r, c) + 1 / square(r, c) - 2) * 2 * np.pi * r]
    return quad(density[0], inner, outer, epsabs=1e-14)[0]


CASES = {
    "sphere": (
        SPHERE, (7.2, 3.6), sphere_volume, "cavity_volume_mm3", 1.0,
        {"geometry.inner_radius": 10.0, "geometry.outer_radius": 14.0,
         "materials.body.c10": 0.1, "steps.0.pressure.cavity": 0.04},
    ),
    "tube": (
        TUBE, (2.8, 1.4), tube_energy, "strain_energy_mJ", 1.0,
        {"geometry.inner_radius": 5.0, "geometry.outer_radius": 7.0,
         "materials.body.c10": 0.1, "steps.0.surface_pressure.bore": 0.025},
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_one_refinement_is_within_a_thousandth(name, tmp_path):
    text, sizes, exact, measure, length, values = CASES[name]
    errors = []
    for size in sizes:
        spec = loads(text % (size, RUBBER) + SOLVER)
        beside = prepare(spec, tmp_path, [*values])
        row, slopes = rows(spec, beside.model, beside)[-1]
        of = list(values.values())
        assert row[measure] == pytest.approx(length * exact(*of), rel=0.1)
        worst = 0.0
        for k, path in enumerate(values):
            ends = [
                [v * (1 + s * PARTS) if i == k else v for i, v in enumerate(of)] for s in (-1, 1)
            ]
            low, high = (length * exact(*end) for end in ends)
            wanted = (high - low) / (2 * PARTS * of[k])
            worst = max(worst, abs(slopes[path][measure] / wanted - 1))
        errors.append(worst)
    assert errors[-1] < 1e-3
    assert errors[0] > 5 * errors[-1]
    assert errors[-1] > SMALL  # it is the mesh's error, not that of a formula used twice
