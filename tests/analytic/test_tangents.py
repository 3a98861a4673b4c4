"""Every term's force against its energy and its tangent against its force, by finite differences.

The state is random and admissible, so that no symmetry hides a fault. Central differences over a
step h are wrong by h² times a third derivative: 1e-6 is asked for.
"""

from dataclasses import replace

import numpy as np
import pytest

from softact.bodies.inertia import Carried
from softact.bodies.layer import BondedLayer
from softact.bodies.solid import Solid
from softact.bodies.weight import Weight
from softact.loads.surface_pressure import FacePressure
from softact.materials import LAWS
from softact.model import ELEMENTS
from softact.system.term import EVERYTHING, InvertedElementError, Origin, State
from tests.analytic.differences import dense, force, slope, tangent, to_global, to_local
from tests.analytic.meshes import block
from tests.analytic.solving import build

PAPER = LAWS["linear"].of(youngs_modulus=65.0, poissons_ratio=0.2, density=7.5e-10)


LOADS = {
    "pressure": {"cavity": 0.05},
    "gravity": {EVERYTHING: np.array([1e3, -2e3, 9810.0])},
    "traction": {"x_max": np.array([0.01, 0.02, -0.03])},
    "surface_pressure": {"y_max": 0.04, "inside": 0.03},
}


def hollow_block(law, element="P2/P1"):
    """3 × 3 × 3 mm with a closed cavity in its middle and paper on its base."""
    tets = block((3, 3, 3), (3.0, 3.0, 3.0), keep=lambda c: (np.abs(c - 1.5) > 0.6).any(axis=1))
    layers = [BondedLayer("z_min", PAPER, 0.1)]
    model = build(tets, law, element, layers, cavities={"cavity": ("inside",)})
    model.make_room(LOADS)
    return model


@pytest.fixture(scope="module")
def model():
    return hollow_block(LAWS["yeoh"].of(c10=0.11, c20=0.02, bulk_modulus=10.0))


def random_state(model, seed=1, size=0.04):
    rng = np.random.default_rng(seed)
    state = State(size * rng.standard_normal(model.unknowns.local), LOADS)
    assert model.smallest_jacobian(state.x) > 0.1
    return state


def potential(model, term, state):
    """The functional whose derivative is the force: with a pressure unknown it is no energy."""
    if isinstance(term, Solid) and term.pressure_values is not None:
        p = term.hydrostatic_pressure(state.x)
        jacobian = np.linalg.det(term.deformation_gradient(state.x))
        mixed = p * (jacobian - term.pressure_volume(p))
        return term.energy(state) + float((mixed * term.volumes).sum())
    return term.energy(state)


def terms_of(model):
    """Without Carried, which is nothing without a motion (``test_inertia.py``)."""
    others = (FacePressure, Carried)
    kinds = {type(t).__name__: t for t in model.terms if not isinstance(t, others)}
    named = {f"FacePressure {t.name}": t for t in model.terms if isinstance(t, FacePressure)}
    return kinds | named


DEAD = ("Weight", "SurfaceForce")
CONSERVATIVE = ("Solid", "CavityPressure", "LayerMembrane", "LayerBending", *DEAD)
FOLLOWING = ("FacePressure inside", "FacePressure y_max")


def test_every_term_is_here(model):
    assert set(terms_of(model)) == {*CONSERVATIVE, *FOLLOWING}


@pytest.mark.parametrize("name", CONSERVATIVE)
def test_force_is_slope_of_energy(model, name):
    term, state = terms_of(model)[name], random_state(model)
    direction = np.random.default_rng(2).standard_normal(model.unknowns.local)
    expected = slope(lambda s: potential(model, term, s), state, direction)
    found = force(model, term, state) @ direction
    assert found == pytest.approx(expected, rel=1e-6)
    assert abs(found) > 0


@pytest.mark.parametrize("name", [*CONSERVATIVE, "FacePressure inside"])
def test_tangent_is_slope_of_force(model, name):
    """On the closed surface the symmetric part is all that there is."""
    term, state = terms_of(model)[name], random_state(model)
    direction = np.random.default_rng(2).standard_normal(model.unknowns.local)
    matrix = tangent(model, [term], state)
    found = to_local(model, matrix @ to_global(model, direction))
    expected = slope(lambda s: force(model, term, s), state, direction)
    assert np.linalg.norm(found - expected) <= 1e-6 * np.linalg.norm(expected)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max(initial=1e-300))
    assert np.any(matrix) == (name not in DEAD)


def test_tangent_of_pressure_on_open_surface(model):
    """It is the symmetric part: the same quadratic form, but not the same matrix."""
    term, state = terms_of(model)["FacePressure y_max"], random_state(model)
    direction = np.random.default_rng(2).standard_normal(model.unknowns.local)
    matrix = tangent(model, [term], state)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-14)
    change = slope(lambda s: force(model, term, s), state, direction)
    there = to_global(model, direction)
    assert there @ matrix @ there == pytest.approx(direction @ change, rel=1e-6)
    assert np.linalg.norm(to_local(model, matrix @ there) - change) > 1e-2 * np.linalg.norm(change)


@pytest.mark.parametrize("element", [name for name in ELEMENTS if name != "P1"])
def test_curved_cells(element):
    """Their own shape is quadratic: gradients differ from point to point."""

    def bulge(points):
        return points + 0.05 * np.sin(points[:, ::-1])

    tets = block((2, 2, 2), (3.0, 3.0, 3.0), bulge, curved=True)
    model = build(tets, LAWS["yeoh"].of(c10=0.11, c20=0.02, bulk_modulus=10.0), element)
    assert model.assembler.shape_degree == 2
    rng = np.random.default_rng(1)
    state = State(0.04 * rng.standard_normal(model.unknowns.local))
    direction = rng.standard_normal(model.unknowns.local)
    matrix = dense(model.tangent(state))
    found = to_local(model, matrix @ to_global(model, direction))
    expected = slope(lambda s: model.force(s)[0], state, direction)
    assert np.linalg.norm(found - expected) <= 1e-6 * np.linalg.norm(expected)


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("law", ["yeoh", "ogden", "arruda_boyce", "holzapfel"])
def test_all_terms_together(element, law):
    """Newton's own force and matrix, for each element and for each kind of law."""
    laws = {
        "yeoh": LAWS["yeoh"].of(c10=0.11, c20=0.02, bulk_modulus=10.0, d2=0.3),
        "ogden": LAWS["ogden"].of(mu=[0.3, 0.02], alpha=[1.3, -2.0], bulk_modulus=10.0),
        "arruda_boyce": LAWS["arruda_boyce"].of(mu=0.2, lambda_m=3.0, bulk_modulus=10.0),
        "holzapfel": LAWS["holzapfel"].of(
            c10=0.1,
            k1=0.4,
            k2=0.3,
            kappa=0.1,
            angle=35.0,
            normal=[0.1, 0.3, 1.0],
            bulk_modulus=10.0,
        ),
    }
    model = hollow_block(laws[law], element)
    state = random_state(model)
    state.put("surface_pressure", {"inside": 0.03})
    direction = np.random.default_rng(2).standard_normal(model.unknowns.local)
    matrix = dense(model.tangent(state))
    found = to_local(model, matrix @ to_global(model, direction))
    expected = slope(lambda s: model.force(s)[0], state, direction)
    assert np.linalg.norm(found - expected) <= 1e-6 * np.linalg.norm(expected)
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())


OFF = {
    "pressure": {"cavity": 0.0},
    "gravity": {EVERYTHING: np.zeros(3)},
    "traction": {},
    "surface_pressure": {"y_max": 0.0, "inside": 0.0},
}


@pytest.mark.parametrize("load", OFF)
def test_load_switched_off(model, load):
    """The whole force changes with each load, and the tangent with those that follow."""
    state = random_state(model)
    without = replace(state)
    without.put(load, OFF[load])
    assert np.linalg.norm(model.force(state)[0] - model.force(without)[0]) > 1e-6
    changed = np.abs(dense(model.tangent(state)) - dense(model.tangent(without))).max()
    assert (changed > 1e-6) == (load in ("pressure", "surface_pressure"))


@pytest.mark.parametrize("name", ["LayerMembrane", "LayerBending"])
def test_layer_left_out(model, name):
    """Without the layer the body is softer along the random direction."""
    state = random_state(model)
    term = terms_of(model)[name]
    rest = [t for t in model.terms if t is not term]
    with_it, without = (tangent(model, terms, state) for terms in (model.terms, rest))
    assert np.abs(with_it - without).max() > 1e-4 * np.abs(without).max()


def test_dead_loads_add_up(model):
    """Weight ρ V g of 26 mm³ and of the paper, and traction t A on 9 mm², whatever the state."""
    state = random_state(model)
    mass = 1.07e-9 * 26 + 7.5e-10 * 0.1 * 9
    weights = [t for t in model.terms if isinstance(t, Weight)]
    assert len(weights) == 2
    total = sum(force(model, t, state)[model.displacement_dofs].sum(axis=0) for t in weights)
    np.testing.assert_allclose(total, -mass * state["gravity"][EVERYTHING], rtol=1e-12)
    load = terms_of(model)["SurfaceForce"]
    total = force(model, load, state)[model.displacement_dofs].sum(axis=0)
    np.testing.assert_allclose(total, -9 * state["traction"]["x_max"], rtol=1e-12)


def test_pressure_on_closed_surface_has_no_resultant(model):
    """∮ cof(F) N dA = 0 (Piola's identity), of force and of moment, in any state."""
    state = random_state(model)
    for name in ("CavityPressure", "FacePressure inside"):
        forces = force(model, terms_of(model)[name], state)[model.displacement_dofs]
        places = model.unknowns.spaces[0].tabulate_dof_coordinates()
        places = places + state.x[model.displacement_dofs]
        np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-14)
        np.testing.assert_allclose(np.cross(places, forces).sum(axis=0), 0, atol=1e-14)
    both = (terms_of(model)[n] for n in ("CavityPressure", "FacePressure inside"))
    cavity, surface = (force(model, t, state) for t in both)
    np.testing.assert_allclose(cavity / 0.05, surface / 0.03, atol=1e-13)


def test_inverted_element(model):
    """An inverted element is told, and makes the whole force not a number."""
    state = State(np.zeros(model.unknowns.local))
    places = model.unknowns.spaces[0].tabulate_dof_coordinates()
    state.x[model.displacement_dofs[:, 0]] = -2 * places[:, 0]
    with pytest.raises(InvertedElementError):
        model.solids["body"].second_piola(state)
    assert np.isnan(model.force(state)[0]).all()
    assert model.smallest_jacobian(state.x) == pytest.approx(-1.0)


def test_no_term_is_left_out_where_an_element_is_inverted(monkeypatch):
    """Terms talk to the other processes, which may have no inverted element and would wait."""
    model = hollow_block(LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=10.0))
    state = model.initial_state()
    state.x[model.displacement_dofs] -= 2.0 * model.unknowns.spaces[0].tabulate_dof_coordinates()
    bending = model.layers[0].bending
    asked = []
    monkeypatch.setattr(bending, "add_force", lambda state, out: asked.append(state))
    assert np.isnan(model.force(state)[0]).all()
    assert asked


@pytest.mark.parametrize("part", ["solid", "layer"])
def test_stress_that_is_carried_on(part):
    """The tangent with the stress of the states before is the tangent itself, but for what the
    stress does not carry: nothing at the same state, and the second order of the way to it."""
    model = hollow_block(LAWS["yeoh"].of(c10=0.1, c20=0.03, bulk_modulus=10.0))
    term = model.solids["body"] if part == "solid" else model.layers[0].membrane
    draw = np.random.default_rng(5)
    state, way = model.initial_state(), np.zeros(model.unknowns.local)
    places = model.unknowns.spaces[0].tabulate_dof_coordinates()
    state.x[model.displacement_dofs] = places @ draw.uniform(-0.1, 0.1, (3, 3))
    way[model.displacement_dofs] = draw.uniform(-0.02, 0.02, places.shape)

    def matrix(origin):
        model.assembler.fixed[:] = 0
        model.assembler.clear()
        term.add_tangent(state, origin)
        return dense(model.assembler.finish_matrix())

    exact = matrix(None)
    size = np.abs(exact).max()
    for origin in (
        Origin((state.x,), linearised=True),
        Origin((state.x, state.x), (1.7, -0.7)),
    ):
        np.testing.assert_allclose(matrix(origin), exact, atol=1e-12 * size)
    away = [
        np.abs(matrix(Origin((state.x - h * way,), linearised=True)) - exact).max()
        for h in (1.0, 0.5)
    ]
    assert away[1] > 1e-9 * size
    assert away[0] / away[1] == pytest.approx(4.0, rel=0.15)
    # Two states on either side of it: the mean of their stresses differs by the second order, too.
    around = [
        np.abs(matrix(Origin((state.x - h * way, state.x + h * way), (0.5, 0.5))) - exact).max()
        for h in (1.0, 0.5)
    ]
    assert around[0] / around[1] == pytest.approx(4.0, rel=0.15)
