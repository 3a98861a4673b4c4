"""With rounded edges the failure pressure stays under refinement, by all three criteria."""

from pathlib import Path

import pytest

import softact

SPEC = Path(__file__).parents[2] / "configs" / "pneunet_filleted.yaml"
# A card that breaks early, so that both runs are short.
EARLY = {
    "materials.body.strength": "1 MPa",
    "materials.body.elongation": "0.3",
    "steps.0.pressure": "220 kPa",
}
# What was asked. Below 2 % on Debian 12's meshes, 3.1 % by the Cauchy stress on those that Debian
# 13's gmsh makes.
WITHIN = 0.05
SIZES = (("3 mm", "1.2 mm"), ("2.4 mm", "0.8 mm"))


def test_failure_pressure_under_refinement(tmp_path):
    found = []
    for size, finest in SIZES:
        mesh = {"geometry.mesh_size": size, "geometry.fillet_mesh_size": finest}
        spec = softact.load(SPEC, EARLY | mesh)
        found.append(softact.run(spec, tmp_path / size.replace(" ", "")).summary)
    for criterion in ("nominal", "cauchy", "stretch"):
        coarse, fine = (float(row[f"failure_pressure_{criterion}_kPa"]) for row in found)
        assert coarse == pytest.approx(fine, rel=WITHIN), criterion
