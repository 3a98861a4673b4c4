"""Derivatives beside a run against Richardson's differences of whole runs on meshes that follow."""

from __future__ import annotations

from pathlib import Path

import pytest

from softact.spec import loads
from tests.sensitivities.whole_runs import TOLERANCE, Beside, by_differences, prepare, rows

#: What both sides may differ by, relative; and percentiles, which are those of single points.
CLOSE, PERCENTILE = 1e-4, 1e-3
FIGURES = (
    "bending_angle_deg", "tip_x_mm", "tip_z_mm", "elongation_mm", "cavity_volume_mm3",
    "cavity_volume_cavity_1_mm3", "strain_energy_mJ", "reaction_x_N", "pressure_kPa",
)  # fmt: skip
SOLVER = f"solver: {{initial_increment: 0.5, max_increment: 0.5, tolerance: {TOLERANCE}}}"
RUBBER = "{law: yeoh, c10: 0.1 MPa, c20: 0.01 MPa, poissons_ratio: 0.49}"
CASES = {
    "pneunet": (
        f"""
geometry: {{type: pneunet, chambers: 2, chamber_length: 6 mm, mesh_size: 6 mm}}
materials: {{body: {RUBBER}}}
layers: [{{surface: strain_limiting_layer, thickness: 0.1 mm, material: paper}}]
steps: [{{gravity: [0, 0, -1]}}, {{pressure: 8 kPa, payload: {{force: [0 N, 0 N, 10 mN]}}}}]
""",
        "geometry.inner_wall geometry.chamber_length geometry.outer_wall materials.body.c10 "
        "layers.0.thickness steps.0.gravity.2 steps.1.pressure steps.1.payload.force.2",
    ),
    "slow_pneunet": (
        f"""
geometry: {{type: slow_pneunet, chambers: 2, mesh_size: 8 mm}}
materials: {{body: {RUBBER}, film: {{law: linear, youngs_modulus: 5 MPa, poissons_ratio: 0.4}}}}
steps: [{{pressure: 10 kPa}}]
""",
        "geometry.roof geometry.chamber_height materials.film.youngs_modulus",
    ),
    "omnidirectional": (
        f"""
geometry: {{type: omnidirectional, modules: 1, symmetry: true, mesh_size: 12 mm}}
materials: {{body: {RUBBER}}}
steps: [{{pressure: {{cavity_1: 3 kPa}}}}]
""",
        "geometry.top_wall geometry.midsection_radius materials.body.c10",
    ),
    "shell_reinforced": (
        f"""
geometry: {{type: shell_reinforced, cuts: 1, length: 30 mm, mesh_size: 12 mm}}
materials: {{body: {RUBBER}}}
layers:
  - {{surface: shell, thickness: 0.2 mm, material: {{law: linear, youngs_modulus: 20 MPa,
     poissons_ratio: 0.3}}}}
steps: [{{pressure: 10 kPa}}]
""",
        "geometry.chamber_radius geometry.slit layers.0.thickness",
    ),
    "tube": (
        f"""
geometry: {{type: tube, mesh_size: 5 mm}}
materials: {{body: {RUBBER}}}
supports: [{{surface: clamp, fix: [x]}}, {{surface: tip, move: {{x: 1 mm}}}}]
steps: [{{surface_pressure: {{bore: 10 kPa}}}}]
""",
        "geometry.inner_radius geometry.length supports.1.move.x steps.0.surface_pressure",
    ),
    "sheet": (
        """
geometry: {type: woven_stiffening, mesh_size: 40 mm}
sheets: %s
steps: [{pressure: 5 kPa}]
""",
        "geometry.l_i",
    ),
}  # fmt: skip


def compared(beside: Beside, width: float = 2e-4) -> list[tuple[str, str, float, float]]:
    """Parameter, measure, derivative beside a run and by whole runs, of the last state."""
    row, slopes = rows(beside.spec, beside.model, beside)[-1]
    found = []
    for parameter in beside.parameters:
        wanted = by_differences(beside, parameter, width=width)
        scale = max(abs(parameter.value), 1e-12)
        for name, slope in slopes[parameter.path].items():
            p999 = name.startswith("principal_stress_p999")
            if (name in FIGURES or p999) and abs(row[name]) > 1e-6:
                least = 1e-3 * abs(row[name]) / scale  # what hangs on it next to nothing
                error = abs(slope - wanted[name]) / max(abs(wanted[name]), least)
                found.append((parameter.path, name, error / (PERCENTILE if p999 else CLOSE)))
    return found


@pytest.mark.parametrize("name", [name for name in CASES if name != "sheet"])
def test_the_derivatives_are_those_of_whole_runs(name, tmp_path):
    text, paths = CASES[name]
    beside = prepare(loads(text + SOLVER, name), tmp_path, paths.split())
    found = compared(beside)
    assert len(found) >= 4 * len(paths.split())
    assert [line for line in found if line[2] > 1.0] == []


def _unused(path: Path) -> None:
    """Nothing."""
