"""Derivatives beside a run against Richardson's differences of whole runs on meshes that follow."""

from __future__ import annotations

import pytest

from softact.spec import loads
from tests.sensitivities.whole_runs import TOLERANCE, Beside, by_differences, prepare, rows

#: What both sides may differ by, relative; and percentiles, which are those of single points.
CLOSE, PERCENTILE = 1e-4, 1e-3
FIGURES = (
    "bending_angle_deg", "tip_x_mm", "tip_z_mm", "elongation_mm", "cavity_volume_mm3",
    "cavity_volume_cavity_1_mm3", "strain_energy_mJ", "reaction_x_N", "pressure_kPa",
)  # fmt: skip
SOLVER = f"solver: {{initial_increment: 1, max_increment: 1, tolerance: {TOLERANCE}}}"
RUBBER = "{law: yeoh, c10: 0.1 MPa, c20: 0.01 MPa, poissons_ratio: 0.49}"
BLOCK = """
geometry: {type: block, length: 6 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.02 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
"""
CASES = {
    "pneunet": (
        f"""
geometry: {{type: pneunet, chambers: 2, chamber_length: 6 mm, mesh_size: 6 mm}}
materials: {{body: {RUBBER}}}
layers: [{{surface: strain_limiting_layer, thickness: 0.1 mm, material: paper}}]
steps: [{{gravity: [0, 0, -1]}}, {{pressure: 8 kPa, payload: {{force: [0 N, 0 N, 10 mN]}}}}]
""",
        "geometry.inner_wall geometry.chamber_length materials.body.c10 layers.0.thickness "
        "steps.0.gravity.2 steps.1.payload.force.2",
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
    "contact": (
        f"""
{BLOCK}
obstacles:
  table: {{type: plane, point: [0 mm, 0 mm, -0.1 mm], normal: [0, 0, 1]}}
steps: [{{gravity: [0, 0, -1]}}, {{payload: {{surface: x_max, force: [0 N, 0 N, -20 mN]}}}}]
""",
        "obstacles.table.point.2 geometry.length materials.body.c10",
    ),
    "chambers that touch": (
        f"""
geometry: {{type: pneunet, chambers: 2, chamber_length: 6 mm, gap: 0.3 mm, mesh_size: 6 mm}}
materials: {{body: {RUBBER}}}
steps: [{{pressure: 5 kPa}}, {{pressure: 11 kPa}}]
contact: auto
""",
        "geometry.inner_wall geometry.gap materials.body.c10",
    ),
    "supports": (
        f"""
{BLOCK}
steps:
  - {{payload: {{surface: x_max, force: [0 N, 0 N, -10 mN]}}}}
  - supports: [{{surface: x_min, fix: [x, y, z]}}, {{surface: x_max, fix: [z], move: {{x: 1 mm}}}}]
  - {{traction: {{surface: y_max, value: [0 kPa, 0 kPa, 1 kPa]}}}}
""",
        "geometry.height materials.body.c10 steps.0.payload.force.2 steps.1.supports.1.move.x",
    ),
    "inject": (
        f"""
geometry: {{type: thick_sphere, mesh_size: 8 mm}}
materials: {{body: {RUBBER}}}
steps: [{{inject: 300 mm^3}}, {{surface_pressure: {{outer: 1 kPa}}}}]
""",
        "geometry.inner_radius materials.body.c10 steps.0.inject steps.1.surface_pressure",
    ),
    "sheet": (
        """
geometry: {type: woven_contracting, n_a: 2, l_i: 50 mm, w_a: 30 mm, h_a: 20 mm, passage: 5 mm,
  mesh_size: 10 mm}
sheets:
  pouches: {plies: [{material: &film {law: linear, youngs_modulus: 100 MPa, poissons_ratio: 0.35},
    thickness: 0.2 mm}]}
  tabs: {plies: [{material: *film, thickness: 0.2 mm}]}
steps: [{pressure: 50 kPa}]
""",
        "geometry.h_a",
    ),
}  # fmt: skip


def compared(beside: Beside) -> list[tuple[str, str, float]]:
    """Parameter, measure, and how far the derivative beside a run is from that by whole runs at the
    last state, by what it may be."""
    row, slopes = rows(beside.spec, beside.model, beside)[-1]
    found = []
    for parameter in beside.parameters:
        wanted = by_differences(beside, parameter)
        scale = max(abs(parameter.value), 1e-12)
        for name, slope in slopes[parameter.path].items():
            p999 = name.startswith("principal_stress_p999")
            if (name in FIGURES or p999) and abs(row[name]) > 1e-6:
                least = 1e-3 * abs(row[name]) / scale  # what hangs on it next to nothing
                error = abs(slope - wanted[name]) / max(abs(wanted[name]), least)
                found.append((parameter.path, name, error / (PERCENTILE if p999 else CLOSE)))
    return found


@pytest.mark.parametrize("name", CASES)
def test_the_derivatives_are_those_of_whole_runs(name, tmp_path):
    text, paths = CASES[name]
    beside = prepare(loads(text + SOLVER, name), tmp_path, paths.split())
    found = compared(beside)
    assert {path for path, _, _ in found} == {p.path for p in beside.parameters}
    assert len(found) >= 3 * len(beside.parameters)
    assert [line for line in found if line[2] > 1.0] == []
