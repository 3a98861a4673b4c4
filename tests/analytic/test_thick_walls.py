"""Thick-walled sphere and cylinder under internal pressure."""

import functools

import numpy as np
import pytest
import scipy.integrate
from mpi4py import MPI

from softact.geometries.thick_sphere import ThickSphere
from softact.geometry.base import make_mesh
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.msh_file import read_msh
from softact.mesh.tetrahedra import distribute
from softact.model import Model, Support
from tests.analytic.by_hand import principal_slopes
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve

INNER, OUTER = 10.0, 11.0  # mm
# law, its constants in MPa, and REFERENCE's table: stretch of the inner surface, pressure in kPa.
TABLE = {
    "neo_hookean": (dict(c10=0.14), 1.2, 28.273),
    "yeoh": (dict(c10=0.11, c20=0.02), 1.5, 39.316),
}
# law, its constants, stretch of the inner surface: large, but where the pressure still grows, and
# constants with which the law's own terms matter there.
SPHERES = {
    "neo_hookean": (dict(c10=0.14), 1.25),
    "mooney_rivlin": (dict(c10=0.11, c01=0.03), 1.5),
    "yeoh": (dict(c10=0.11, c20=0.02), 1.5),
    "reduced_polynomial": (dict(c10=0.1, c20=0.02, c40=2e-3), 1.5),
    "ogden": (dict(mu=[0.3, 0.02, 0.05], alpha=[1.3, 5.0, -2.0]), 1.5),
    "arruda_boyce": (dict(mu=0.2, lambda_m=1.3), 1.4),
    "van_der_waals": (dict(mu=0.3, lambda_m=3.0, a=0.2, beta=0.1), 1.5),
    "gent": (dict(mu=0.3, jm=3.0), 1.5),
    "fung": (dict(mu=0.3, b=0.5), 1.5),
    "linear": (dict(youngs_modulus=0.9), 1.25),
    # Fibres in the sphere's wall at ± 45° to its x axis: where two families cross at right angles,
    # their stress is alike in all directions of the wall, so the sphere stays a sphere.
    "holzapfel": (dict(c10=0.14, k1=0.3, k2=0.5, kappa=0.05, angle=45.0, families=2), 1.5),
}


def pressure_at(law, constants, stretch):
    """∫ Ŵ'(λ)/(λ³ − 1) dλ from the outer to the inner stretch (Ogden 1984, 5.3.2), MPa.

    Ŵ(λ) = W(λ, λ, λ⁻²), so λ Ŵ' = 2 (t1 − t3) with ti = λi ∂W/∂λi.
    """
    outer = np.cbrt(1 + (stretch**3 - 1) * (INNER / OUTER) ** 3)

    def integrand(s):
        t1, _, t3 = principal_slopes(law, constants, (s, s, s**-2))
        return 2 * (t1 - t3) / s / (s**3 - 1)

    return scipy.integrate.quad(integrand, outer, stretch, epsabs=1e-14)[0]


@pytest.fixture(scope="module")
def mesh_of(tmp_path_factory):
    """Divisions -> an octant with edges of 90°/divisions."""
    folder = tmp_path_factory.mktemp("spheres")

    @functools.cache
    def mesh(divisions):
        sphere = ThickSphere.model_validate(
            {
                "type": "thick_sphere",
                "inner_radius": "10 mm",
                "outer_radius": "11 mm",
                "mesh_size": f"{11 * np.pi / 2 / divisions:.6f} mm",
            }
        )
        path, layout = folder / f"{divisions}.msh", sphere.layout()
        make_mesh(sphere, path)
        return distribute(MPI.COMM_SELF, lambda: read_msh(path, layout), layout)

    return mesh


def inner_stretch(law, pressure, mesh):
    """Cube root of how much the cavity has grown."""
    model = Model(mesh, {"body": law.material()}, wall_normal=lambda region, points: points)
    before = model.cavity_volume(model.initial_state(), "cavity")
    solution = solve(model, LoadStep("inflate", pressure={"cavity": pressure}), [], 0.25)
    return np.cbrt(model.cavity_volume(solution.state, "cavity") / before)


def law_of(name, constants):
    """The law, nearly incompressible."""
    if name == "linear":  # K = E/(3 (1 − 2ν)) = 1e6 MPa
        return LAWS[name].of(**constants, poissons_ratio=0.5 - constants["youngs_modulus"] / 6e6)
    return LAWS[name].of(**constants, bulk_modulus=1e6)


@pytest.mark.parametrize("name", TABLE)
def test_sphere_converges(name, mesh_of):
    """Within 0.5 % at the second refinement, and the order of convergence.

    The facets are flat, which alone would give order two, but the inner and the outer polyhedron
    are alike and the volumes are compared with their own: what is left is the error of the
    quadratic elements, of order four in the energy.
    """
    constants, exact, tabulated = TABLE[name]
    pressure = pressure_at(name, constants, exact)
    assert 1e3 * pressure == pytest.approx(tabulated, rel=3e-5)
    law = law_of(name, constants)
    errors = [abs(inner_stretch(law, pressure, mesh_of(n)) / exact - 1) for n in (2, 4, 8)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[2] < 0.005
    assert (orders > 3).all(), f"errors {errors}, orders {orders}"


@pytest.mark.parametrize("name", SPHERES)
def test_sphere_of_law(name, mesh_of):
    """The inner surface's stretch at the pressure from quadrature, within 0.5 %."""
    constants, exact = SPHERES[name]
    pressure = pressure_at(name, constants, exact)
    found = inner_stretch(law_of(name, constants), pressure, mesh_of(8))
    assert found == pytest.approx(exact, rel=0.005)


def test_every_law_has_a_sphere():
    assert set(SPHERES) == set(LAWS)


def test_cylinder():
    """7.181871 in at the inner radius (Oden 1972; ANSYS VM56): plane strain, 150 psi in 7 in.

    A quarter with flat facets of 7.5°; inches and psi are taken as mm and MPa.
    """

    def mapping(points):
        radius = 7.0 * (18.625 / 7.0) ** points[:, 0]
        angle = np.pi / 2 * points[:, 1]
        return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), points[:, 2]])

    law = LAWS["mooney_rivlin"].of(c10=80.0, c01=20.0, bulk_modulus=1e6)
    model = build(block((6, 12, 1), mapping=mapping), law)
    held = [
        Support("y_min", {1: 0.0}),
        Support("y_max", {0: 0.0}),
        Support("z_min", {2: 0.0}),
        Support("z_max", {2: 0.0}),
    ]
    load = LoadStep("inflate", surface_pressure={"x_min": 150.0})
    solution = solve(model, load, held, 0.1)
    assert solution.displacement((7.0, 0.0, 0.0))[0] == pytest.approx(7.181871, rel=0.005)
