"""A balloon of Mooney's rubber whose pressure rises again beyond its limit, to large stretches.

P = ∫ Ŵ'(λ)/(λ³ − 1) dλ gives the pressure at every stretch (Ogden 1984, 5.3.2). With C01/C10 = 0.2
the stress grows with C01 λ⁴: at λ = 5 it is a hundred times the shear modulus.
"""

import numpy as np
import pytest
from mpi4py import MPI

from softact.geometries.thick_sphere import ThickSphere
from softact.geometry.base import make_mesh
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.msh_file import read_msh
from softact.mesh.tetrahedra import distribute
from softact.model import Model
from softact.solve.diagnosis import causes
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve
from tests.analytic.test_thick_walls import pressure_at

CONSTANTS = {"c10": 0.14, "c01": 0.028}


@pytest.fixture(scope="module")
def balloon(tmp_path_factory):
    """Function from an element to a model of an eighth of the sphere."""
    geometry = ThickSphere.model_validate({"mesh_size": "6 mm"})
    file, layout = tmp_path_factory.mktemp("balloon") / "mesh.msh", geometry.layout()
    make_mesh(geometry, file)
    law = LAWS["mooney_rivlin"].of(**CONSTANTS, bulk_modulus=1e4)

    def model(element):
        mesh = distribute(MPI.COMM_SELF, lambda: read_msh(file, layout), layout)
        return Model(mesh, {"body": law.material()}, element=element)

    return model


def inflated(model, stretch, **settings):
    """Filled to a stretch of its inside; the stretches and pressures on the way."""
    rest = model.cavity_volume(model.initial_state(), "cavity")
    step = LoadStep("fill", inject={"cavity": (stretch**3 - 1) * rest})
    solution = solve(model, step, [], 0.1, initial_increment=0.01, **settings)
    volumes = [model.cavity_volume(state, "cavity") for state in solution.path[1:]]
    pressures = [state["pressure"]["cavity"] for state in solution.path[1:]]
    return solution, np.cbrt(np.array(volumes) / rest), np.array(pressures)


def test_a_pressure_of_each_element_holds_the_balloon_to_a_stretch_of_six(balloon):
    """The exact pressure within 0.5 %, all the way."""
    _, stretches, pressures = inflated(balloon("P2/P0"), 6.0)
    exact = [pressure_at("mooney_rivlin", CONSTANTS, stretch) for stretch in stretches]
    assert stretches[-1] == pytest.approx(6.0)
    assert pressures == pytest.approx(exact, rel=5e-3)


@pytest.mark.parametrize(
    ("element", "pressure", "told"),
    [("P2/P1", 10.0, True), ("P2/P1", 1.0, False), ("P2/P0", 10.0, False)],
)
def test_a_continuous_pressure_that_lets_go_is_told(element, pressure, told):
    """Points of an element gain and lose volume under a mean stress of 50 times the shear modulus
    (0.2 MPa), which holds them with P2/P0. With P2/P1 the balloon ends so at a stretch of 7.2."""
    law = LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=1e3)
    model = build(block((2, 2, 2)), law, element)
    state = model.initial_state()
    state.x[:] = pressure
    draw = np.random.default_rng(1).uniform(-0.03, 0.03, model.displacement_dofs.shape)
    state.x[model.displacement_dofs] = draw
    said = [
        line for line in causes(model, state, 0, 1.0) if "solver: {element: P2/P0} does" in line
    ]
    assert len(said) == told
    if told:
        assert "under a mean stress of 50 times the shear modulus" in said[0]
