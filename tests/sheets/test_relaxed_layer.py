"""Bonded layers that wrinkle finely instead of being compressed: exact answers on one block."""

import numpy as np
import pytest

from softact.bodies.green_sheet import GreenTensionField
from softact.bodies.layer import BondedLayer
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.materials.plane_stress import GreenLaw
from softact.materials.tension_field import KEPT_BONDED, TensionField
from softact.model import Support
from softact.run.films import compressed_layers
from tests.analytic.meshes import block
from tests.analytic.solving import ROLLERS, build, solve

RUBBER = LAWS["neo_hookean"].of(c10=0.2, bulk_modulus=400.0)
FILM = LAWS["linear"].of(youngs_modulus=50.0, poissons_ratio=0.1)
THICKNESS, LENGTH, WIDTH = 0.05, 2.0, 1.0
HELD_ACROSS = [*ROLLERS, Support("y_max", {1: 0.0})]


def pull(stretch, supports, layers=(), bulge=0.0):
    """Force (N) on the far end of a block at a stretch along x."""

    def mapping(x):
        return x + np.outer(bulge * np.sin(np.pi * x[:, 1]) * (1 - x[:, 2]), [0, 0, -1])

    model = build(block((3, 2, 2), (LENGTH, WIDTH, 1.0), mapping=mapping), RUBBER, layers=layers)
    move = [*supports, Support("x_max", {0: LENGTH * (stretch - 1)})]
    step = LoadStep("pull", supports=move)
    return solve(model, step, supports, increment=0.5).reaction("x_max")[0]


def film(relaxed):
    return BondedLayer("z_min", FILM, THICKNESS, bending=0.0, relaxed=relaxed)


def test_pulled_it_has_uniaxial_stress():
    """Rubber contracts across more than the film would: it wrinkles, and its stress is uniaxial,
    S11 = E (λ² − 1)/2."""
    stretch = 1.1
    exact = FILM.youngs_modulus * stretch * (stretch**2 - 1) / 2 * THICKNESS * WIDTH
    alone = pull(stretch, ROLLERS)
    unrelaxed = pull(stretch, ROLLERS, [film(False)]) - alone
    kept = KEPT_BONDED * (unrelaxed - exact)
    assert pull(stretch, ROLLERS, [film(True)]) - alone == pytest.approx(exact + kept, rel=1e-4)
    assert unrelaxed > 1.01 * exact


def test_pressed_it_carries_nothing():
    alone = pull(0.95, HELD_ACROSS)
    carried = pull(0.95, HELD_ACROSS, [film(False)]) - alone
    assert carried < 0.1 * alone < 0
    kept = pull(0.95, HELD_ACROSS, [film(True)]) - alone
    assert kept == pytest.approx(KEPT_BONDED * carried, rel=0.01)


@pytest.mark.parametrize(("stretch", "relaxed"), [(0.9, False), (0.9, True), (1.05, False)])
def test_compression_that_a_film_would_not_carry_is_told(stretch, relaxed):
    """Along x the film is pressed by E' (1 − λ²)/2 = 4.8 MPa, E' = 50.5 MPa in plane strain, and
    wrinkles at ¼ (3 · 4 μ/E')^(2/3) E' = 2.6 MPa."""
    model = build(block((3, 2, 2), (LENGTH, WIDTH, 1.0)), RUBBER, layers=[film(relaxed)])
    move = [*HELD_ACROSS, Support("x_max", {0: LENGTH * (stretch - 1)})]
    solution = solve(model, LoadStep("pull", supports=move), HELD_ACROSS)
    told = list(compressed_layers(model, solution.state))
    assert len(told) == (stretch < 1 and not relaxed)
    if told:
        modulus = 50.0 / (1 - 0.1**2)
        pressed = modulus * (1 - 0.9**2) / 2
        limit = 0.25 * (3 * 1.6 / modulus) ** (2 / 3) * modulus
        assert f"down to {-pressed:.3g} MPa" in told[0]
        assert f"wrinkles at {-limit:.2g} MPa, which 100% of it" in told[0]


def test_taut_it_is_the_facet_layer():
    forces = [pull(1.1, HELD_ACROSS, [film(relaxed)]) for relaxed in (True, False)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-7)


def test_the_closed_form_is_the_least_energy():
    """Of St. Venant-Kirchhoff: the general minimisation over all folds finds the same."""
    draw = np.random.default_rng(3)
    f = np.eye(2) + draw.uniform(-0.1, 0.1, (300, 2, 2))
    c = np.swapaxes(f, 1, 2) @ f
    law = GreenLaw(50.0, 0.3)
    closed, general = GreenTensionField(law), TensionField(law, 0.3)
    state = closed.state(c)
    assert np.bincount(state, minlength=3).min() > 20
    np.testing.assert_array_equal(state, general.state(c))
    for one, two, size in zip(closed.evaluate(c), general.evaluate(c), (0.5, 5, 50), strict=True):
        np.testing.assert_allclose(one, two, atol=1e-6 * size)


@pytest.mark.parametrize(("bending", "bulge"), [(1.0, 0.0), (0.0, 0.0), (1.0, 0.05)])
def test_what_does_not_bend_wrinkles(bending, bulge):
    """By default: a flat layer with bending stiffness carries compression, others do not."""
    layer = BondedLayer("z_min", FILM, THICKNESS, bending)
    with_film = pull(0.99, HELD_ACROSS, [layer], bulge)
    alone = pull(0.99, HELD_ACROSS, bulge=bulge)
    bends = bending > 0 and bulge == 0
    assert (with_film < 1.5 * alone) == bends
    if not bends:
        assert with_film == pytest.approx(alone, rel=0.05)
