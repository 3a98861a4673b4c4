"""A run with inertia, with a material that creeps, goes on exactly as it would have."""

import numpy as np
import pytest

from softact import spec as specs
from softact.errors import SpecError
from softact.results.folder import read
from softact.run.start import run
from softact.verdict.step_response import responses
from tests.run.test_resume import interrupt
from tests.run.test_resume_in_time import assert_same, columns

BAR = """
name: bar
geometry: {type: block, length: 20 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials:
  body:
    law: neo_hookean
    c10: 0.1 MPa
    density: 1070 kg/m^3
    viscoelastic: {g: [0.2], tau: [20 ms], constants: long_time}
supports: [{surface: x_min, fix: [x, y, z]}]
steps:
  - {name: drop, gravity: [0, 0, -1], duration: 20 ms, amplitude: sudden, dynamics: true}
  - {name: swing, duration: 10 ms, amplitude: hold, dynamics: {spectral_radius: 0.9}}
solver: {initial_increment: 0.05, max_increment: 0.1, time_tolerance: 0.1}
measures: [tip, energy]
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of a run that nobody disturbs."""
    folder = tmp_path_factory.mktemp("whole") / "out"
    run(specs.loads(BAR), folder, report=False)
    return folder


def test_energies_are_told(whole):
    names, values = columns(whole)
    kinetic = values[:, names.index("kinetic_energy_mJ")]
    supplied = values[:, names.index("supplied_energy_mJ")]
    lost = values[:, names.index("dissipated_energy_mJ")]
    stored = values[:, names.index("strain_energy_mJ")]
    np.testing.assert_allclose(supplied, kinetic + stored + lost, atol=1e-12)
    assert kinetic[0] == 0.0
    assert kinetic.max() > 0.1 * stored.max()
    assert lost[-1] > 0


@pytest.mark.parametrize("after", [5, 15])
def test_resumed_run_is_the_undisturbed_one(whole, tmp_path, after):
    """In both steps: to 1e-10 in every column."""
    interrupt(specs.loads(BAR), tmp_path / "cut", after)
    run(specs.loads(BAR), tmp_path / "cut", report=False, resume=True)
    assert_same(whole, tmp_path / "cut")


def test_two_processes_are_as_one(whole, tmp_path):
    run(specs.loads(BAR), tmp_path / "two", report=False, processes=2)
    names, one = columns(whole)
    _, two = columns(tmp_path / "two")
    assert len(one) == len(two)
    for name in ("time_s", "tip_z_mm", "kinetic_energy_mJ", "supplied_energy_mJ"):
        at = names.index(name)
        np.testing.assert_allclose(one[:, at], two[:, at], rtol=1e-6, atol=1e-9)


def test_response_is_told(whole):
    found = responses(read(whole))
    assert [response.step for response in found][:1] == ["drop"]
    assert found[0].overshoot > 0


REFUSED = {
    "no_duration": (", duration: 20 ms, amplitude: sudden", "", "needs a duration"),
    "zero": ("duration: 20 ms", "duration: 0 s", "greater than 0"),
    "radius": ("spectral_radius: 0.9", "spectral_radius: 1.1", "must be at most 1"),
    "negative": ("spectral_radius: 0.9", "spectral_radius: -0.1", "must be at least 0"),
    "density": ("    density: 1070 kg/m^3\n", "", "materials.body.density: missing"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_bad_input_is_one_line(case):
    written, instead, why = REFUSED[case]
    assert written in BAR
    with pytest.raises(SpecError) as caught:
        specs.loads(BAR.replace(written, instead))
    assert len(caught.value.lines) == 1, caught.value.lines
    assert why in caught.value.lines[0]
