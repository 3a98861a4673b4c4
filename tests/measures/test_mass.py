"""Mass, and force and work over it: volumes times densities, however the actuator is cut."""

import numpy as np
import pytest

from softact.results.folder import read
from softact.run import start as runs
from softact.spec import loads
from tests.sensitivities.whole_runs import prepare, rows

G = 9.80665  # m/s²
BLOCK = """
geometry: {type: block, length: 8 mm, width: 4 mm, height: 3 mm, mesh_size: 3 mm}
materials: {body: {law: neo_hookean, c10: 0.14 MPa, density: 1130 kg/m^3}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{gravity: [0, 0, -1]}]
"""
LAYER = """
layers:
  - surface: z_min
    thickness: 0.2 mm
    material: {law: linear, youngs_modulus: 10 MPa, poissons_ratio: 0.3, density: 800 kg/m^3}
"""
FINGER = """
geometry: {type: pneunet, chambers: 2, mesh_size: 6 mm, cavity_mesh_size: 4 mm, symmetry: %s}
materials: {body: {law: neo_hookean, c10: 0.14 MPa, density: 1130 kg/m^3}}
steps: [{pressure: 0.1 kPa}]
"""


def mass(text, folder, processes=1):
    runs.run(loads(text), folder, processes=processes, report=False)
    return read(folder).summary["mass_g"]


@pytest.mark.parametrize("processes", [1, 2])
def test_a_block_with_a_layer_weighs_what_both_do(tmp_path, processes):
    wanted = 1e-3 * (1.13 * 8 * 4 * 3 + 0.8 * 8 * 4 * 0.2)
    assert mass(BLOCK + LAYER, tmp_path / "run", processes) == pytest.approx(wanted, rel=1e-10)


def test_half_a_finger_is_given_the_mass_of_the_whole(tmp_path):
    half, whole = (mass(FINGER % cut, tmp_path / cut) for cut in ("true", "false"))
    volume = loads(FINGER % "false").geometry.volumes()["body"]
    assert half == pytest.approx(1.13e-3 * volume, rel=1e-9)
    assert whole == pytest.approx(half, rel=1e-9)


def test_a_held_block_has_half_of_its_weight_at_each_end(tmp_path):
    held = BLOCK.replace("z]}]", "z]}, {surface: x_max, fix: [x, y, z]}]")
    runs.run(loads(held), tmp_path / "run", report=False)
    found = read(tmp_path / "run").summary["specific_force_N_per_kg"]
    assert found == pytest.approx(G / 2, rel=1e-3)


def test_work_on_a_payload_over_the_mass(tmp_path):
    lifting = "steps: [{payload: {surface: x_max, force: [0 N, 0 N, -2 mN]}}]"
    runs.run(loads(BLOCK[: BLOCK.index("steps")] + lifting), tmp_path / "run", report=False)
    results = read(tmp_path / "run")
    sinks = 1e-3 * np.ptp(results.curve["tip_z_mm"])  # m: what is held up loses energy
    mass = 1.13e-6 * 8 * 4 * 3  # kg
    found = results.summary["specific_work_J_per_kg"]
    assert found == pytest.approx(-2e-3 * sinks / mass, rel=1e-6)
    assert "specific_force_N_per_kg" not in results.curve


def test_the_mass_by_a_length_and_by_the_density(tmp_path):
    spec = loads(BLOCK)
    beside = prepare(spec, tmp_path, ["geometry.length", "materials.body.density"])
    _, slopes = rows(spec, beside.model, beside)[-1]
    by_length, by_density = (slopes[path]["mass_g"] for path in beside.paths)
    assert by_length == pytest.approx(1.13e-3 * 4 * 3, rel=1e-6)
    assert by_density == pytest.approx(1e6 * 8 * 4 * 3, rel=1e-6)
