"""Thick-walled sphere and cylinder under internal pressure."""

import numpy as np
import pytest
import scipy.integrate
from meshes import block
from mpi4py import MPI
from solving import build, solve

from softact.geometries.thick_sphere import ThickSphere
from softact.geometry import make_mesh
from softact.materials import LAWS
from softact.mesh import distribute, read_msh
from softact.model import Model, Support
from softact.stepping import LoadStep

# law, its constants, Ŵ'(λ) in MPa by hand, and REFERENCE's table: stretch of the inner surface and
# pressure in kPa for radii of 10 and 11 mm.
SPHERES = {
    "neo_hookean": (dict(c10=0.14), lambda s, i: 0.56 * (s - s**-5), 1.2, 28.273),
    "yeoh": (
        dict(c10=0.11, c20=0.02),
        lambda s, i: (0.44 + 0.16 * (i - 3)) * (s - s**-5),
        1.5,
        39.316,
    ),
}
INNER, OUTER = 10.0, 11.0


def pressure_at(slope, stretch):
    """∫ Ŵ'(λ)/(λ³ − 1) dλ from the outer to the inner stretch (Ogden 1984, 5.3.2), MPa.

    Ŵ(λ) = W(λ, λ, λ⁻²), so Ŵ' = 4 (λ − λ⁻⁵) ∂W/∂I1 for laws of I1 = 2 λ² + λ⁻⁴.
    """
    outer = np.cbrt(1 + (stretch**3 - 1) * (INNER / OUTER) ** 3)

    def integrand(s):
        return slope(s, 2 * s**2 + s**-4) / (s**3 - 1)

    return scipy.integrate.quad(integrand, outer, stretch, epsabs=1e-14)[0]


def inner_stretch(law, pressure, divisions, folder):
    """Cube root of how much the cavity has grown, on an octant with edges of 90°/divisions."""
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
    mesh = distribute(MPI.COMM_SELF, lambda: read_msh(path, layout), layout)
    model = Model(mesh, {"body": law.material()})
    before = model.cavity_volume(model.initial_state(), "cavity")
    solution = solve(model, LoadStep("inflate", pressure={"cavity": pressure}), [], 0.25)
    return np.cbrt(model.cavity_volume(solution.state, "cavity") / before)


@pytest.mark.parametrize("name", SPHERES)
def test_sphere(name, tmp_path):
    """Within 0.5 % at the second refinement, and the order of convergence.

    The facets are flat, which alone would give order two, but the inner and the outer polyhedron
    are alike and the volumes are compared with their own: what is left is the error of the
    quadratic elements, of order four in the energy.
    """
    constants, slope, exact, tabulated = SPHERES[name]
    pressure = pressure_at(slope, exact)
    assert 1e3 * pressure == pytest.approx(tabulated, rel=3e-5)
    law = LAWS[name].of(**constants, bulk_modulus=1e6)
    errors = [abs(inner_stretch(law, pressure, n, tmp_path) / exact - 1) for n in (2, 4, 8)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert errors[2] < 0.005
    assert (orders > 3).all(), f"errors {errors}, orders {orders}"


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
