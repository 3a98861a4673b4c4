"""Slender and stout cantilevers under pressure, a dead load and their weight."""

import numpy as np
import pytest

from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.model import Support
from tests.analytic.meshes import block
from tests.analytic.solving import CLAMP, build, solve

# The cross-section is free to become broader and narrower at its root, as beam theory has it.
BEAM_ROOT = Support("x_min", {0: 0.0, 2: 0.0})


@pytest.mark.parametrize("root,lowest,highest", [(BEAM_ROOT, 4.18, 4.24), (CLAMP, 4.13, 4.18)])
def test_land_problem_1(root, lowest, highest):
    """Deformed z of (10, 0.5, 1) between 4.18 and 4.24 mm: Land et al. 2015, problem 1, isotropic.

    10 × 1 × 1 mm, follower pressure 0.004 kPa on the underside, neo-Hookean μ = 6 kPa; half of it
    meshed, finer towards the root. The bounds are by elastica (REFERENCE). A full clamp stiffens
    the root of so stout a beam: it shortens the beam by about a tenth of its height, and
    (3.2 mm) × 4 × 0.01 × 0.5 (large deflections grow with half the power) makes 4.15.
    """
    law = LAWS["neo_hookean"].of(c10=3e-3, bulk_modulus=3.0)

    def mapping(points):
        x, y, z = points.T
        return np.column_stack([10 * x**1.5, y, z])

    tets = block((16, 2, 4), (1.0, 0.5, 1.0), mapping)
    model = build(tets, law, symmetry={"y_min": 1})
    load = LoadStep("press", surface_pressure={"z_min": 4e-6})
    z = 1.0 + solve(model, load, [root], 0.34).displacement((10.0, 0.0, 1.0))[2]
    assert lowest < z < highest


# PL²/EI and w/L of the inextensible elastica (Bisshopp and Drucker 1945; REFERENCE).
ELASTICA = [(1.0, 0.301721), (2.0, 0.493457), (5.0, 0.713792)]


def test_elastica():
    """Tip deflection of a cantilever of 60 times its height under a dead end load, within 1 %."""
    length, modulus = 60.0, 1.0
    law = LAWS["neo_hookean"].of(c10=modulus / 6, bulk_modulus=1e3)
    model = build(block((60, 1, 2), (length, 1.0, 1.0)), law)
    loads = [factor * modulus / 12 / length**2 for factor, _ in ELASTICA]
    steps = [LoadStep("pull", traction={"x_max": (0.0, 0.0, -load)}) for load in loads]
    solution = solve(model, steps, [CLAMP], 0.25)
    assert len(solution.ends) == len(ELASTICA)
    node = model.surfaces.nodes("x_max")
    found = [-state.x[model.displacement_dofs[node, 2]].mean() / length for state in solution.ends]
    np.testing.assert_allclose(found, [w for _, w in ELASTICA], rtol=0.01)


def test_dragon_skin_beam():
    """Sag under its own weight: measured −6.63 and −6.84 mm, COMSOL −6.774 mm, within 5 %.

    ETH diffPD_sim2real (MIT): 100 × 30 × 30 mm, clamped at one end, ρ = 1070 kg/m³,
    E = 0.263824 MPa, ν = 0.499, at the top middle of the free end.
    """
    shear = 0.263824 / (2 * 1.499)
    law = LAWS["neo_hookean"].of(c10=shear / 2, poissons_ratio=0.499, density=1.07e-9)
    model = build(block((10, 4, 4), (100.0, 30.0, 30.0)), law)
    load = LoadStep("gravity", gravity=(0.0, 0.0, -9810.0))
    sag = solve(model, load, [CLAMP], 0.5).displacement((100.0, 15.0, 30.0))[2]
    np.testing.assert_allclose([sag] * 3, [-6.63, -6.84, -6.774], rtol=0.05)
