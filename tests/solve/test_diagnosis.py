"""What a run says of the physics where it finds no further equilibrium."""

import numpy as np
import pytest

from softact.bodies.layer import BondedLayer
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.solve.diagnosis import causes
from tests.analytic.meshes import block
from tests.analytic.solving import ROLLERS, build, solve

SOFT = LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=100.0)
FOIL = LAWS["linear"].of(youngs_modulus=100.0, poissons_ratio=0.3, density=1e-9)


def told(model, gradient, modes=0, faster=1.0):
    """Causes in the state u = (F − I) X."""
    state = model.initial_state()
    x = model.unknowns.spaces[0].tabulate_dof_coordinates()
    state.x[model.displacement_dofs] = x @ (np.asarray(gradient) - np.eye(3)).T
    return causes(model, state, modes, faster)


def hollow():
    keep = lambda c: (np.abs(c - 1.5) > 0.6).any(axis=1)  # noqa: E731
    return build(block((3, 3, 3), (3.0,) * 3, keep=keep), SOFT, cavities={"air": ("inside",)})


def test_nothing_to_tell():
    assert told(hollow(), np.diag([1.1, 0.95, 0.95])) == []


def test_a_cavity_that_is_sucked_flat():
    said = told(hollow(), np.diag([0.04, 1.0, 1.0]))
    assert said[0].startswith("cavity 'air' is sucked flat (4.0% of its volume is left)")


@pytest.mark.parametrize("left", [0.45, 0.55])
def test_a_crushed_element(left):
    said = told(hollow(), np.diag([left, 1.0, 1.0]))
    assert ["mm is crushed into a fold (45% of" in line for line in said] == [True] * (left < 0.5)


def test_a_compressible_element_may_lose_volume():
    foam = LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=0.5)
    assert told(build(block((1, 1, 1)), foam), np.diag([0.3, 1.0, 1.0])) == []


def test_jumps_on_the_way():
    model = hollow()
    (said,) = causes(model, model.initial_state(), 0, 1.0, jumps=3)
    assert said.startswith("the actuator has jumped 3 time(s)")


def test_stretch():
    (said,) = told(hollow(), np.diag([5.0, 0.5, 0.4]))
    assert "stretched up to 5.0 times, 100.0% of it" in said


@pytest.mark.parametrize("along", [0.97, 1.03])
def test_a_layer_in_compression(along):
    """On a bulged face, where a layer has no bending stiffness; all of it is pressed, or nothing.

    Stretched alike in both directions of its plane, a layer has the same stress in all.
    """

    def bulge(x):
        return x + np.outer(0.1 * np.sin(np.pi * x[:, 0]) * (1 - x[:, 2]), [0, 0, -1])

    foil = BondedLayer("z_min", FOIL, 0.1, relaxed=False)
    model = build(block((3, 1, 1), mapping=bulge), SOFT, layers=[foil])
    said = told(model, along * np.eye(3))
    assert [s.startswith("the layer on 'z_min' wrinkles: 100% of it") for s in said] == (
        [True] if along < 1 else []
    )


def test_a_flat_layer_bends_and_is_not_blamed():
    model = build(block((3, 1, 1)), SOFT, layers=[BondedLayer("z_min", FOIL, 0.1)])
    assert told(model, 0.97 * np.eye(3)) == []


def test_instability_and_runaway():
    model = hollow()
    assert "unstable in 2 direction(s)" in told(model, np.eye(3), modes=2)[0]
    assert "grow 30 times as fast" in told(model, np.eye(3), faster=30.0)[0]


def test_the_largest_load_of_hencky_law():
    """Nominal stress of an incompressible Hencky bar, E ln λ/λ, has its maximum E/e at λ = e."""
    law = LAWS["linear"].of(youngs_modulus=1.0, poissons_ratio=0.4999)
    model = build(block((1, 1, 1)), law)
    step = LoadStep("pull", traction={"x_max": np.array([0.5, 0.0, 0.0])})
    solution = solve(model, step, ROLLERS, 0.1, stops=True, dynamics=False)
    progress = solution.stepper.progress
    reached = max(a.fraction for a in progress.attempts if a.converged) * 0.5
    assert reached == pytest.approx(np.exp(-1), rel=0.01)
    assert "a limit of the load is near" in progress.stopped or "unstable" in progress.stopped
