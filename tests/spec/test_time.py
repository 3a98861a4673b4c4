"""Clocks and materials with memory in a spec: what is read, and what is told of what is wrong."""

from pathlib import Path

import pytest

from softact import spec as specs
from softact.errors import SpecError

SPEC = """
geometry: {{type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}}
materials: {{body: {{law: neo_hookean, c10: 0.1 MPa{material}}}}}
supports: [{{surface: x_min, fix: [x, y, z]}}]
steps: [{{traction: {{surface: x_max, value: [1 kPa, 0 kPa, 0 kPa]}}{step}}}]
"""
MAXWELL = ", viscoelastic: {{g: {g}, tau: {tau}, constants: {constants}}}"


def read(step="", material=""):
    return specs.loads(SPEC.format(step=step, material=material))


def creeps(g="[0.2, 0.1]", tau="[1 s, 100 ms]", constants="long_time"):
    return MAXWELL.format(g=g, tau=tau, constants=constants)


def test_what_is_read():
    spec = read(", amplitude: {sine: {frequency: 2 Hz, cycles: 3}}", creeps())
    (step,) = spec.steps
    assert step.timing(spec.geometry.layout()).duration == pytest.approx(1.5)
    assert spec.materials["body"].viscoelastic.tau == (1.0, 0.1)
    assert specs.loads(spec.to_yaml()) == spec
    assert read(", duration: 2 s").steps[0].timing(spec.geometry.layout()).duration == 2.0
    assert read().steps[0].timing(spec.geometry.layout()) is None
    assert read().hash == specs.loads(read().to_yaml()).hash


WRONG = {
    "sum": (
        "",
        creeps("[0.6, 0.4]"),
        "materials.body.viscoelastic: the g add up to 1: nothing would be left",
    ),
    "negative tau": ("", creeps("[0.2]", "[-1 s]"), "tau.0: '-1 s' must be greater than 0"),
    "negative g": ("", creeps("[-0.2]", "[1 s]"), "g.0: '-0.2' must be at least 0"),
    "counts": ("", creeps("[0.2]", "[1 s, 2 s]"), "1 g and 2 tau; each g has a tau"),
    "constants": ("", creeps(constants="slow"), "'slow' is not one of: long_time, instantaneous"),
    "unsaid": (
        "",
        ", viscoelastic: {g: [0.1], tau: [1 s]}",
        "viscoelastic.constants: missing; of which state the law's own constants are",
    ),
    "mullins r": ("", ", mullins: {r: 0.9, m: 1 kPa}", "r: '0.9' must be greater than 1"),
    "mullins width": ("", ", mullins: {r: 2, m: 0 kPa}", "m and beta are both zero"),
    "negative duration": (", duration: -1 s", "", "duration: '-1 s' must be greater than 0"),
    "no duration": (", amplitude: smooth", "", "an amplitude needs a duration"),
    "two durations": (
        ", duration: 1 s, amplitude: {sine: {frequency: 1 Hz}}",
        "",
        "frequency and cycles says how long the step lasts; leave duration out",
    ),
    "word": (
        ", duration: 1 s, amplitude: fast",
        "",
        "amplitude: 'fast' is not one of: ramp, smooth, hold",
    ),
    "hold": (", duration: 1 s, amplitude: hold", "", "hold leaves loads as they are"),
    "both": (
        ", duration: 1 s, amplitude: {shape: ramp, triangle: {cycles: 1}}",
        "",
        "shape and triangle given; write one of",
    ),
    "frequency": (
        ", amplitude: {sine: {frequency: 0 Hz}}",
        "",
        "sine.frequency: '0 Hz' must be greater than 0",
    ),
    "no such file": (", amplitude: {file: none.csv}", "", "none.csv: cannot be read"),
    "wlf": (
        "",
        ", viscoelastic: {g: [0.1], tau: [1 s], constants: long_time, "
        "wlf: {c1: 17.4, c2: 51.6, reference: 20, temperature: -40}}",
        "wlf: the shift has no value at or below -31.6 °C",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_wrong_is_one_line(name):
    step, material, expected = WRONG[name]
    with pytest.raises(SpecError) as raised:
        read(step, material)
    (line,) = raised.value.lines
    assert expected in line
    assert line.startswith("spec:")


def test_a_file_that_runs_back_and_one_for_another_cavity(tmp_path):
    text = SPEC.replace(
        "{{traction: {{surface: x_max, value: [1 kPa, 0 kPa, 0 kPa]}}{step}}}", "{step}"
    )
    spec = tmp_path / "spec.yaml"
    spec.write_text(text.format(step="{amplitude: {file: p.csv}}", material=""))
    (tmp_path / "p.csv").write_text("time (s),pressure (kPa)\n0,0\n2,1\n1,3\n")
    with pytest.raises(SpecError, match=r"amplitude\.file: p\.csv: time runs back from 2 s to 1 s"):
        specs.load(spec)
    (tmp_path / "p.csv").write_text("time (s),pressure (kPa)\n0,0\n2,1\n")
    with pytest.raises(SpecError, match=r"amplitude\.file: the geometry has no cavity"):
        specs.load(spec)


LAYERS = (
    "layers: [{{surface: z_min, thickness: 0.1 mm, wrinkling: {wrinkling}, material: "
    "{{law: linear, youngs_modulus: 1 MPa, poissons_ratio: 0.3, mullins: {{r: 2, m: 1 kPa}}}}}}]"
)


def test_wrinkles_remember_nothing():
    text = SPEC.format(step="", material="")
    with pytest.raises(SpecError, match=r"layers\.0: fine wrinkles remember nothing: .*: resolved"):
        specs.loads(text + LAYERS.format(wrinkling="tension_field"))
    assert specs.loads(text + LAYERS.format(wrinkling="resolved")).layers
    sheet = (
        "geometry: {type: woven_contracting}\nsteps: [{pressure: 1 kPa}]\nsheets: {pouches: &s {"
        "wrinkling: %s, plies: [{thickness: 0.2 mm, material: {law: neo_hookean, c10: 1 MPa, "
        "viscoelastic: {g: [0.1], tau: [1 s], constants: long_time}}%s}]}, tabs: *s}"
    )
    with pytest.raises(SpecError, match=r"sheets\.pouches: fine wrinkles remember nothing"):
        specs.loads(sheet % ("tension_field", ", incompressible: true"))
    with pytest.raises(SpecError, match=r"plies\.0: a ply that creeps .*: incompressible: true"):
        specs.loads(sheet % ("resolved", ""))
    assert specs.loads(sheet % ("resolved", ", incompressible: true")).sheets


def test_the_example_of_the_docs_is_a_spec():
    spec = specs.load(Path(__file__).resolve().parents[2] / "docs/examples/cycled_finger.yaml")
    durations = [step.timing(spec.geometry.layout()).duration for step in spec.steps]
    assert durations == pytest.approx([3.0, 0.5, 30.0])
