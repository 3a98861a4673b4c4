"""A block under pressures in two directions, and a cylinder twisted at fixed length."""

import numpy as np
import pytest
import scipy.optimize

from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.model import Support
from softact.solve.newton import Newton
from tests.analytic.meshes import block, disc
from tests.analytic.solving import ROLLERS, build, solve

RADIUS, LENGTH = 12.7, 25.4  # mm


def biaxial_stretches(**load):
    """1/λx and λy of a block in plane strain."""
    law = LAWS["mooney_rivlin"].of(c10=80.0, c01=20.0, bulk_modulus=1e9)
    model = build(block((1, 1, 1), (1.0, 2.0, 1.0)), law)
    held = [*ROLLERS, Support("z_max", {2: 0.0})]
    u = solve(model, LoadStep("press", **load), held, 0.25).displacement((1.0, 2.0, 1.0))
    return 1 / (1 + u[0]), 1 + u[1] / 2


def test_biaxial_block():
    """Stretch 1.2012495: Mooney-Rivlin 80/20 MPa, Cauchy −50 MPa right and +100 MPa on top.

    Plane strain (solids4foam longWall): 2 (C10 + C01)(λ² − λ⁻²) = 150 MPa. These are true
    stresses, so the pressure must follow the surface.
    """
    found = biaxial_stretches(surface_pressure={"x_max": 50.0, "y_max": -100.0})
    np.testing.assert_allclose(found, 1.2012495, rtol=1e-5)


def test_biaxial_block_under_dead_loads():
    """The same as nominal stresses: 2 (C10 + C01)(λ² − λ⁻²) = 100 λ + 50/λ, another stretch."""
    dead = {"x_max": (-50.0, 0.0, 0.0), "y_max": (0.0, 100.0, 0.0)}
    exact = scipy.optimize.brentq(lambda s: 200 * (s**2 - s**-2) - 100 * s - 50 / s, 1.0, 2.0)
    assert abs(exact - 1.2012495) > 1e-3
    np.testing.assert_allclose(biaxial_stretches(traction=dead), exact, rtol=1e-5)


def twisted(model, angle):
    """Turn the far end face about the axis, point by point: a Support has one value for all.

    Newton starts from the twist that Rivlin gives to every point.
    """
    newton, state = Newton(model, 1e-9, 15), model.initial_state()
    ends = ("z_min", "z_max")
    newton.set_supports([Support(name, {0: 0.0, 1: 0.0, 2: 0.0}) for name in ends], state)
    x, y, z = model.unknowns.spaces[0].tabulate_dof_coordinates().T
    turn = angle * z / LENGTH
    twist = [
        x * (np.cos(turn) - 1) - y * np.sin(turn),
        x * np.sin(turn) + y * (np.cos(turn) - 1),
        np.zeros_like(z),
    ]
    state.x[model.displacement_dofs] = np.column_stack(twist)
    outcome = newton.solve(state, newton.held(state).start)
    assert outcome.converged, outcome.reason
    return state


def test_torsion_at_fixed_length():
    """M = 450.4629 N·mm and N = −8.867381 N at 1 rad: Rivlin 1949, neo-Hookean C10 = 0.14 MPa.

    M = π C10 ψ R⁴ with ψ the angle per length, N = −½ π C10 ψ² R⁴. The rim is a polygon of 48
    sides, whose polar moment is 0.6 % too small; within 2 %.
    """
    tets = block((12, 12, 4), (1.0, 1.0, LENGTH), lambda points: disc(points, RADIUS))
    law = LAWS["neo_hookean"].of(c10=0.14, bulk_modulus=1e3)
    model = build(tets, law)
    state = twisted(model, 1.0)
    force, _ = model.force(state)
    nodes = model.surfaces.nodes("z_max")
    dofs = model.displacement_dofs[nodes]
    place = model.unknowns.spaces[0].tabulate_dof_coordinates()[nodes] + state.x[dofs]
    moment = np.cross(place, force[dofs]).sum(axis=0)[2]
    assert moment == pytest.approx(450.4629, rel=0.02)
    assert force[dofs[:, 2]].sum() == pytest.approx(-8.867381, rel=0.02)
