"""Elements that are turned inside out between their quadrature points, and cavities without air."""

import numpy as np
import pytest

from softact.bodies.soundness import (
    _pieces,
    _to_bernstein,
    lattice,
    smallest_in_the_middle,
    smallest_jacobian,
)
from softact.contact.surfaces import Touching
from softact.errors import SpecError
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.solve import acceptance
from tests.analytic.meshes import block
from tests.analytic.solving import CLAMP, build, solve

SOFT = LAWS["neo_hookean"].of(c10=0.05, bulk_modulus=50.0)


def cubic_pouch(law, touching=False, walls=("inside",)):
    """A block of 18 × 18 × 7 mm with a chamber of 12 × 12 × 1 mm in its middle."""

    def mapping(x):
        return np.column_stack([x[:, :2], np.interp(x[:, 2], [0, 7 / 3, 14 / 3, 7], [0, 3, 4, 7])])

    def keep(c):
        return ~((np.abs(c[:, :2] - 9) < 6).all(axis=1) & (np.abs(c[:, 2] - 3.5) < 1))

    touch = [Touching("walls", (("inside",),))] if touching else []
    tets = block((6, 6, 3), (18.0, 18.0, 7.0), mapping, keep)
    return build(tets, law, touching=touch, cavities={"cavity": walls})


@pytest.mark.parametrize("cuts", [0, 1, 2])
def test_pieces_of_an_element_fill_it(cuts):
    places, members = _pieces(cuts)
    corner = [int(np.flatnonzero((lattice(3) == 3 * e).all(axis=1))[0]) for e in np.eye(4)]
    vertices = places[members][:, corner][:, :, 1:]
    volumes = np.abs(np.linalg.det(vertices[:, 1:] - vertices[:, :1]))
    assert volumes == pytest.approx(np.full(8**cuts, 8.0**-cuts))


def test_coefficients_bound_a_cubic():
    """Those of the whole and, closer, of its pieces, beside a hundred thousand places."""
    rng = np.random.default_rng(0)
    powers = lattice(3)
    coefficients = rng.standard_normal(20)
    times = np.linalg.inv(_to_bernstein())  # values of the basis on its lattice

    def cubic(b):
        monomials = np.prod(b[:, None] ** powers, axis=2)
        on_lattice = np.prod((powers / 3)[:, None] ** powers, axis=2)
        return monomials @ np.linalg.solve(on_lattice, times @ coefficients)

    lowest = cubic(rng.dirichlet(np.ones(4), 100_000)).min()
    places, members = _pieces(2)
    bound = (cubic(places)[members] @ _to_bernstein().T).min()
    assert coefficients.min() < bound < lowest + 1e-12
    assert bound == pytest.approx(lowest, abs=0.05)


def pulled(until):
    """A block, and the first state at which ``until(solid, x)`` is below zero, on the way of a
    corner's node to the opposite one, and of all its neighbours in part."""
    model = build(block((1, 1, 1), (1.0, 1.0, 1.0)), SOFT)
    state, places = model.initial_state(), model.nodes.places
    (solid,) = model.solids.values()
    distance = np.linalg.norm(places - 1.0, axis=1)
    for pull in np.linspace(0, 2, 401):
        away = np.clip(1.0 - distance, 0.0, 1.0)
        state.x[model.displacement_dofs] = -pull * away[:, None]
        if until(solid, state.x).jacobian < 0:
            return model, state
    raise AssertionError("nothing folds")


def test_an_element_that_is_folded_at_its_corner_is_seen():
    model, state = pulled(smallest_jacobian)
    assert model.smallest_jacobian(state.x) > 0  # at the quadrature points
    assert acceptance.state_fault(model, state) is None
    assert acceptance.state_fault(model, model.initial_state()) is None


def test_an_element_whose_middle_is_inside_out_is_refused():
    model, state = pulled(smallest_in_the_middle)
    (solid,) = model.solids.values()
    assert smallest_jacobian(solid, state.x).jacobian < 0
    assert "is turned inside out" in acceptance.state_fault(model, state)


def test_smallest_jacobian_of_a_homogeneous_stretch():
    model = build(block((2, 1, 1), (2.0, 1.0, 1.0)), SOFT)
    state = model.initial_state()
    state.x[model.displacement_dofs] = model.nodes.places * [0.5, -0.2, 0.0]
    (solid,) = model.solids.values()
    assert smallest_jacobian(solid, state.x).jacobian == pytest.approx(1.5 * 0.8)


def test_more_air_than_there_is_cannot_be_drawn():
    """144 mm³ of air: 150 mm³ drawn out end in a line that says so, and never below nothing."""
    model = cubic_pouch(SOFT)
    solution = solve(model, LoadStep("draw", inject={"cavity": -150.0}), [CLAMP], 0.1, stops=True)
    assert all(model.cavity_volume(s, "cavity") > 0 for s in solution.path)
    state = solution.state
    state.x[model.displacement_dofs[:, 2]] -= 1.5 * (model.nodes.places[:, 2] > 3.5)
    assert "no volume left" in acceptance.state_fault(model, state)


def test_a_cavity_whose_outside_is_named_encloses_nothing():
    with pytest.raises(SpecError, match=r"cavities\.cavity: its walls .* enclose a volume of -"):
        cubic_pouch(SOFT, walls=("x_min", "x_max", "y_min", "y_max", "z_min", "z_max"))
