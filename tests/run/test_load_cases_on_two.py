"""Points, lines, plates and further fields on two processes, which each hold a part of the mesh."""

import numpy as np
import pytest

from softact import spec as specs
from softact.results.folder import read
from softact.run import start as runs

C10, STRETCH, SIDE = 0.14, 1.3, 8.0
PULL = 2 * C10 * (STRETCH - STRETCH**-2)  # MPa
SPEC = f"""
geometry: {{type: block, length: 20 mm, width: {SIDE} mm, height: {SIDE} mm, mesh_size: 4 mm}}
materials: {{body: {{law: neo_hookean, c10: {C10} MPa, bulk_modulus: 1000 MPa}}}}
points: {{one: [0 mm, 0 mm, 0 mm], two: [20 mm, 0 mm, 0 mm]}}
lines:
  back: {{between: [x_min, z_min]}}
  front: {{ends: [[20 mm, 0 mm, 8 mm], [20 mm, 8 mm, 8 mm]]}}
constraints: [{{surface: x_max, stays: parallel}}, {{surface: x_min, stays: parallel}}]
supports:
  - {{surface: one, fix: [x, y]}}
  - {{surface: two, fix: [y]}}
  - {{surface: back, fix: [z]}}
  - {{surface: two, fix: [z]}}
probes: {{middle: [10 mm, 4 mm, 4 mm]}}
fields: [stress, contact_pressure]
solver: {{initial_increment: 0.5, max_increment: 0.5}}
steps:
  - payload:
      - {{surface: front, force: [{PULL * SIDE**2} N, 0 N, 0 N]}}
      - {{surface: x_min, force: [{-PULL * SIDE**2} N, 0 N, 0 N]}}
"""


def test_a_block_between_two_plates_stretches_as_its_law_says(tmp_path):
    """A force on the edge of a plate that does not turn is one on all of it: uniaxial stress."""
    outcome = runs.run(specs.loads(SPEC), tmp_path / "result", processes=2, report=False)
    assert outcome.status == "complete", outcome.message
    results = read(tmp_path / "result")
    last = {name: values[-1] for name, values in results.curve.items()}
    assert last["face_x_max_x_mm"] == pytest.approx(20 * STRETCH, rel=2e-4)
    assert last["probe_middle_stress_xx_MPa"] == pytest.approx(PULL * STRETCH, rel=1e-3)
    for name in ("one", "two", "back"):
        force = [last[f"reaction_{name}_{c}_N"] for c in "xyz"]
        assert force == pytest.approx(np.zeros(3), abs=1e-4)
    number = len(results.increments) - 1
    np.testing.assert_allclose(results.field(number, "stress_xx"), PULL * STRETCH, rtol=5e-3)
    assert not results.field(number, "contact_pressure").any()
