"""A run with a clock and a material that creeps and softens goes on exactly as it would have."""

import numpy as np
import pytest

from softact import spec as specs
from softact.errors import SoftactError
from softact.results.folder import read
from softact.run.start import run
from tests.run.test_resume import curve, interrupt

CUBE = """
name: cube
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}
materials:
  body:
    law: neo_hookean
    c10: 0.1 MPa
    viscoelastic: {g: [0.2, 0.1], tau: [0.1 s, 2 s], constants: long_time}
    mullins: {r: 1.5, m: 2 kPa, beta: 0.1}
layers:
  - surface: z_min
    thickness: 0.1 mm
    wrinkling: resolved
    material:
      law: linear
      youngs_modulus: 1 MPa
      poissons_ratio: 0.3
      viscoelastic: {g: [0.3], tau: [0.5 s], constants: long_time}
      mullins: {r: 2, m: 1 kPa}
supports: [{surface: x_min, fix: [x, y, z]}]
steps:
  - name: cycle
    traction: {surface: x_max, value: [40 kPa, 5 kPa, 0 kPa]}
    amplitude: {triangle: {cycles: 1}}
    duration: 0.4 s
  - {name: creep, duration: 3 s, traction: {surface: x_max, value: [30 kPa, 0 kPa, 0 kPa]}}
solver: {initial_increment: 0.08, max_increment: 0.08, time_tolerance: 5e-3}
measures: [tip, energy, stress]
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of a run that nobody disturbs."""
    folder = tmp_path_factory.mktemp("whole") / "out"
    run(specs.loads(CUBE), folder, report=False)
    return folder


def columns(folder):
    rows = curve(folder)
    numbers = [name for name in rows[0] if name not in ("step", "control")]
    return numbers, np.array([[float(row[name]) for name in numbers] for row in rows])


def assert_same(one, other, tolerance=1e-10):
    names, first = columns(one)
    there, second = columns(other)
    assert names == there
    size = np.abs(first).max(axis=0)
    assert (np.abs(first - second).max(axis=0) <= tolerance * size).all()
    ends = [read(folder).field(-1, "displacement") for folder in (one, other)]
    np.testing.assert_allclose(*ends, rtol=0, atol=tolerance * np.abs(ends[0]).max())


def test_time_is_told(whole):
    names, values = columns(whole)
    times = values[:, names.index("time_s")]
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(3.4)
    assert (np.diff(times) > 0).all()
    assert 0.2 in times.round(9)
    pulled = values[:, names.index("softening_loss_mJ")]
    assert (np.diff(pulled) >= -1e-15).all()
    assert pulled[-1] > 0


@pytest.mark.parametrize("after", [5, 32])
def test_resumed_run_is_the_undisturbed_one(whole, tmp_path, after):
    """In the middle of the loading, and of the creep: to 1e-10 in every column."""
    interrupt(specs.loads(CUBE), tmp_path / "cut", after)
    run(specs.loads(CUBE), tmp_path / "cut", report=False, resume=True)
    assert_same(whole, tmp_path / "cut")


def test_extended_run_is_the_whole_one(whole, tmp_path):
    """A later step is added to a run that had ended."""
    data = specs.loads(CUBE)
    first = data.model_copy(update={"steps": data.steps[:1]})
    run(specs.loads(first.to_yaml()), tmp_path / "cut", report=False)
    run(data, tmp_path / "cut", report=False, resume=True)
    assert_same(whole, tmp_path / "cut")


def test_two_processes_compute_the_same(whole, tmp_path):
    """Each remembers its own part; to what the order of sums leaves, and resumed as well."""
    two = tmp_path / "two"
    interrupt(specs.loads(CUBE), two, 4, processes=2)
    with pytest.raises(
        SoftactError, match=r"creeps or softens.* goes on with as many, not with -n 1"
    ):
        run(specs.loads(CUBE), two, report=False, resume=True)
    run(specs.loads(CUBE), two, processes=2, report=False, resume=True)
    names, first = columns(whole)
    _, second = columns(two)
    assert len(first) == len(second)
    for name in ("time_s", "tip_x_mm", "strain_energy_mJ", "softening_loss_mJ"):
        at = names.index(name)
        np.testing.assert_allclose(first[:, at], second[:, at], rtol=1e-6, atol=1e-9)


SPHERE = """
name: sphere
geometry: {type: thick_sphere, inner_radius: 10 mm, outer_radius: 11 mm, mesh_size: 9 mm}
materials: {body: {law: neo_hookean, c10: 0.14 MPa}}
steps:
  - name: fill
    supply:
      {pressure: 30 kPa, diameter: 0.3 mm, tube: {length: 300 mm, diameter: 1 mm}, polytropic: 1.3}
    duration: 100 ms
  - {name: closed, sealed: {heated: 1.1}, ambient: 99 kPa}
solver: {initial_increment: 0.25, max_increment: 0.25, time_tolerance: 2e-2}
measures: [pressure, volume, air]
"""


def test_air_goes_on_flowing(tmp_path):
    """A run that is interrupted while air flows in; a step that keeps it follows."""
    run(specs.loads(SPHERE), tmp_path / "whole", report=False)
    names, values = columns(tmp_path / "whole")
    times, pressure = (values[:, names.index(n)] for n in ("time_s", "pressure_kPa"))
    assert times[-1] == pytest.approx(0.1)
    assert pressure[-1] > pressure[-5] > 1.0
    interrupt(specs.loads(SPHERE), tmp_path / "cut", 3)
    run(specs.loads(SPHERE), tmp_path / "cut", report=False, resume=True)
    assert_same(tmp_path / "whole", tmp_path / "cut", 1e-9)
