"""The mass in summary.csv: volumes times densities, however the actuator is cut."""

import pytest

from softact.results.folder import read
from softact.run import start as runs
from softact.spec import loads

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
