"""Volume instead of pressure: past a pressure limit, and the limit itself.

The thick neo-Hookean sphere, A/B = 10/11, C10 = 0.14 MPa, cannot hold more than 33.0435 kPa (at
an inner stretch of 1.42638); P = ∫ Ŵ'(λ)/(λ³ − 1) dλ gives the pressure at every stretch.
"""

import re

import numpy as np
import pytest
from mpi4py import MPI
from scipy.interpolate import CubicSpline

from softact.geometries.thick_sphere import ThickSphere
from softact.geometry.base import make_mesh
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.msh_file import read_msh
from softact.mesh.tetrahedra import distribute
from softact.model import Model
from softact.solve.rungs import volume
from tests.analytic.solving import solve
from tests.analytic.test_thick_walls import pressure_at

LIMIT = 33.0435e-3  # MPa
CONSTANTS = {"c10": 0.14}


@pytest.fixture(scope="module")
def sphere(tmp_path_factory):
    """Function that makes a model of an eighth of the sphere."""
    geometry = ThickSphere.model_validate({"mesh_size": "2.2 mm"})
    file, layout = tmp_path_factory.mktemp("sphere") / "mesh.msh", geometry.layout()
    make_mesh(geometry, file)
    law = LAWS["neo_hookean"].of(**CONSTANTS, bulk_modulus=1e4)

    def model():
        mesh = distribute(MPI.COMM_SELF, lambda: read_msh(file, layout), layout)
        return Model(mesh, {"body": law.material()})

    return model


@pytest.fixture(scope="module")
def injected(sphere):
    """The model, its volume at rest, and the states up to 27 times that volume."""
    model = sphere()
    rest = model.cavity_volume(model.initial_state(), "cavity")
    step = LoadStep("inject", inject={"cavity": 26.5 * rest})
    return model, rest, solve(model, step, [], 0.05, initial_increment=0.01)


def test_pressure_at_prescribed_volume(injected):
    """The curve to a stretch of 3, most of it falling, within 1 %."""
    model, rest, solution = injected
    volumes = [model.cavity_volume(state, "cavity") for state in solution.path]
    stretch = np.cbrt(np.array(volumes) / rest)
    pressure = [state["pressure"].get("cavity", 0.0) for state in solution.path]
    for state, wide in zip(solution.path[1:], stretch[1:], strict=True):
        exact = pressure_at("neo_hookean", CONSTANTS, wide)
        assert state["pressure"]["cavity"] == pytest.approx(exact, rel=0.01), wide
    assert stretch[-1] > 3
    at_three = CubicSpline(stretch, pressure)(3.0)
    assert 1e3 * at_three == pytest.approx(18.596, rel=0.01)


def test_prescribed_volume_is_met(injected):
    model, rest, solution = injected
    found = model.cavity_volume(solution.state, "cavity")
    assert found == pytest.approx(27.5 * rest, rel=1e-8)


def test_limit_under_pressure_control(sphere):
    """The run stops, names the limit within 0.5 %, and has traced the branch beyond it."""
    model = sphere()
    steps = [LoadStep("inflate", pressure={"cavity": 0.04})]
    solution = solve(model, steps, [], 0.1, stops=True)
    stopped = solution.stepper.progress.stopped
    said = re.search(r"pressure cannot exceed ([\d.]+) kPa: the structure snaps", stopped)
    assert float(said[1]) == pytest.approx(1e3 * LIMIT, rel=0.005)
    attempts = [a for a in solution.stepper.progress.attempts if a.converged]
    stable = [a for a in attempts if a.unstable_modes == 0]
    beyond = [a for a in attempts if a.control == "volume" and a.unstable_modes == 1]
    assert max(a.fraction for a in stable) * 40 == pytest.approx(1e3 * LIMIT, rel=0.01)
    assert len(beyond) > 5
    assert beyond[-1].fraction < 0.5 * LIMIT / 0.04


def test_way_through_the_displacements(sphere, monkeypatch):
    """What is used where the volume turns back follows the same curve, within 1 %."""
    monkeypatch.setattr(volume, "BOUNDS", volume.Bounds(turns_back=0))
    model = sphere()
    rest = model.cavity_volume(model.initial_state(), "cavity")
    steps = [LoadStep("inflate", pressure={"cavity": 0.04})]
    solution = solve(model, steps, [], 0.1, stops=True)
    attempts = [a for a in solution.stepper.progress.attempts if a.converged]
    traced = [
        state
        for state, attempt in zip(solution.path, attempts, strict=True)
        if attempt.control == "arc" and attempt.unstable_modes == 1
    ]
    assert len(traced) > 5
    for state in traced:
        wide = np.cbrt(model.cavity_volume(state, "cavity") / rest)
        exact = pressure_at("neo_hookean", CONSTANTS, wide)
        assert state["pressure"]["cavity"] == pytest.approx(exact, rel=0.01), wide
