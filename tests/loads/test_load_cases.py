"""Load cases written as steps: payloads, held tips, differential pressures."""

import csv

import numpy as np
import pytest

from softact import spec as specs
from softact.errors import SpecError
from softact.run import start as runs

SOFT = "{law: neo_hookean, c10: 0.14 MPa}"
# The state at the end of a step does not depend on how its load was cut up: test_run.py.
AT_ONCE = "solver: {initial_increment: 1, max_increment: 1}"
BEAM = f"""
geometry: {{type: block, length: 60 mm, width: 6 mm, height: 4 mm, mesh_size: 5 mm}}
materials: {{body: {SOFT}}}
{AT_ONCE}
"""
FINGER = """
geometry: {type: pneunet, chambers: 2, mesh_size: 6 mm}
materials: {body: elastosil-m4601}
"""
BELLOWS = f"""
geometry: {{type: omnidirectional, cavities: 4, modules: 1, symmetry: true, mesh_size: 5 mm}}
materials: {{body: {SOFT}}}
{AT_ONCE}
"""


@pytest.fixture
def rows(tmp_path):
    """Function from the text of a spec to the rows of its curve, as numbers."""

    def solve(text):
        outcome = runs.run(specs.loads(text), tmp_path / "result", report=False)
        assert outcome.status == "complete", outcome.message
        with (tmp_path / "result" / "curve.csv").open() as file:
            read = list(csv.DictReader(file))
        texts = "step", "control"
        return [{k: float(v) for k, v in row.items() if k not in texts and v} for row in read]

    return solve


def triple(row, title):
    return np.array([row[title.replace("*", c)] for c in "xyz"])


def test_payload_stretches_a_bar_as_its_law_says(rows):
    """F/A = 2 C10 (λ − λ⁻²) at λ = 1.2 and A = 24 mm², so F = 3.397 N."""
    stretch, area = 1.2, 6.0 * 4.0
    force = area * 2 * 0.14 * (stretch - stretch**-2)
    last = rows(
        BEAM
        + f"""
supports:
  - {{surface: x_min, fix: [x]}}
  - {{surface: y_min, fix: [y]}}
  - {{surface: z_min, fix: [z]}}
steps: [{{payload: {{force: [{force} N, 0 N, 0 N]}}}}]
"""
    )[-1]
    assert last["elongation_mm"] == pytest.approx(60 * (stretch - 1), rel=2e-3)  # K/G = 1000
    # x_min is no 'clamp' that holds y and z; along x it takes all of the payload.
    assert last["max_principal_stretch"] == pytest.approx(stretch, rel=2e-3)


def test_payload_is_the_force_on_the_whole_actuator(rows):
    """Half a finger with 0.02 N at the tip: the clamp of the whole takes 0.02 N."""
    last = rows(f"{FINGER}{AT_ONCE}\nsteps: [{{payload: {{force: [0 N, 0 N, -0.02 N]}}}}]")[-1]
    assert triple(last, "reaction_*_N") == pytest.approx([0, 0, 0.02], abs=2e-6)


def test_held_tip_of_a_beam_takes_the_moments_of_beam_theory(rows):
    """Both ends clamped, uniform load w: forces w L/2, moments w L²/12; 3 % for shear and the
    clamped sections, L/h = 15."""
    pressure, width, length = 2e-6, 6.0, 60.0  # MPa, mm
    last = rows(
        BEAM
        + """
supports: [{surface: x_min, fix: [x, y, z]}, {surface: x_max, fix: [x, y, z]}]
steps: [{surface_pressure: {z_min: 0.002 kPa}}]
"""
    )[-1]
    load = pressure * width
    assert last["tip_force_z_N"] == pytest.approx(load * length / 2, rel=1e-3)
    # Pushed up, the beam's end slopes down where nothing holds its angle: about +y.
    assert last["tip_moment_y_Nmm"] == pytest.approx(load * length**2 / 12, rel=0.03)


def test_blocked_torque_in_two_steps(rows):
    """Inflate, hold the tip where it is, inflate further: the tip stays, its torque grows from
    zero, and clamp and tip balance each other: pressure in a closed cavity has no resultant."""
    found = rows(
        FINGER.replace("chambers: 2", "chambers: 6")
        + """
layers: [{surface: strain_limiting_layer, thickness: 0.1 mm, material: paper}]
solver: {initial_increment: 0.5, max_increment: 0.5}
steps:
  - {name: bend, pressure: 10 kPa}
  - name: hold
    pressure: 20 kPa
    supports: [{surface: clamp, fix: [x, y, z]}, {surface: tip, fix: [x, y, z]}]
"""
    )
    free = [row for row in found if "blocked_torque_Nmm" not in row]
    held = [row for row in found if "blocked_torque_Nmm" in row]
    assert free[-1]["pressure_kPa"] == pytest.approx(10) and free[-1]["bending_angle_deg"] > 5
    for name in ("tip_x_mm", "tip_z_mm", "bending_angle_deg"):
        assert held[-1][name] == pytest.approx(free[-1][name], abs=1e-9)
    torques = [row["blocked_torque_Nmm"] for row in held]
    assert all(np.diff([0.0, *torques]) > 0)
    last = held[-1]
    force = triple(last, "tip_force_*_N")
    assert triple(last, "reaction_*_N") == pytest.approx(force, abs=1e-6)
    moment = triple(last, "tip_moment_*_Nmm") + np.cross(triple(last, "tip_*_mm"), force)
    assert triple(last, "reaction_moment_*_Nmm") == pytest.approx(moment, abs=1e-4)
    assert last["blocked_torque_Nmm"] > 1 and last["tip_moment_y_Nmm"] == torques[-1]


def test_differential_pressures_bend_the_other_way_when_they_are_exchanged(rows):
    """Four cavities: +p above and −p below against −p above and +p below; the mesh is not the
    same above and below, so 3 %. The same pressure in all: no bending to speak of."""

    found = rows(
        BELLOWS
        + """
steps:
  - {name: down, pressure: {cavity_1: 4 kPa, cavity_3: -4 kPa}}
  - {name: up, pressure: {cavity_1: -4 kPa, cavity_3: 4 kPa}}
  - {name: together, pressure: 4 kPa}
"""
    )
    down, up, together = (row for row in found if row["step_fraction"] == 1)
    assert down["bending_angle_deg"] > 0.1
    assert up["bending_angle_deg"] == pytest.approx(-down["bending_angle_deg"], rel=0.03)
    assert abs(together["bending_angle_deg"]) < 0.05 * down["bending_angle_deg"]
    assert together["elongation_mm"] > 0


@pytest.mark.parametrize(
    ("payload", "place", "words"),
    [
        ("{force: [0 N, 1 N, 0 N]}", "steps.0.payload.force.1", "across the symmetry plane"),
        ("{surface: tips, force: [0 N, 0 N, 1 N]}", "steps.0.payload.surface", "no surface 'tips'"),
        ("{force: [0 N, 0 N]}", "steps.0.payload.force", "write a list of three for x, y, z"),
        ("{force: [0, 0, 1 kPa]}", "steps.0.payload.force", "N"),
    ],
)
def test_payloads_that_make_no_sense(payload, place, words):
    with pytest.raises(SpecError) as caught:
        specs.loads(FINGER + f"steps: [{{payload: {payload}}}]")
    assert any(place in line and words in line for line in caught.value.lines), caught.value.lines
