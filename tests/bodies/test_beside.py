"""A solid beside a state of another one, and parts of solids, against the whole."""

from dataclasses import replace

import numpy as np
import pytest

from softact.materials import LAWS
from softact.measures import MEASURES
from softact.measures.snapshot import Snapshot
from softact.system.kernels import Coefficient
from softact.system.term import InvertedElementError, State
from tests.analytic.meshes import block
from tests.analytic.solving import CLAMP, build

RUBBER = LAWS["yeoh"].of(c10=0.11, c20=0.02, bulk_modulus=10.0)
LOGARITHMIC = LAWS["ogden"].of(mu=[0.1], alpha=[3.0], bulk_modulus=10.0)


def bent(model, seed=1, size=0.02):
    """A state with a bend and some noise, so that nothing is the largest twice."""
    rng = np.random.default_rng(seed)
    state = State(np.zeros(model.unknowns.local))
    x, y, z = model.nodes.places.T
    noise = size * rng.standard_normal((len(x), 3))
    move = np.column_stack([-0.05 * x * z, 0.02 * x * y, 0.03 * x**2])
    state.x[model.displacement_dofs] = move + noise
    pressures = np.setdiff1d(np.arange(model.unknowns.local), model.displacement_dofs)
    state.x[pressures] = 0.01 * rng.standard_normal(len(pressures))
    assert model.smallest_jacobian(state.x) > 0.1
    return state


@pytest.mark.parametrize("law", [RUBBER, LOGARITHMIC])
@pytest.mark.parametrize("element", ["P2/P1", "P2/P0", "P2", "P1"])
def test_the_force_in_one_loop_is_that_of_its_stress(law, element):
    tets = block((3, 2, 2), (3.0, 2.0, 2.0))
    model, other = build(tets, law, element), build(tets, law, element)
    solid = other.solids["body"]
    state = bent(model)
    solid.stand_beside(model.solids["body"], state)
    there = replace(state, x=bent(model, seed=1, size=0.021).x)
    force = np.zeros(model.unknowns.local)
    solid.add_force(there, force)
    stress = solid.second_piola(there)[0]
    wanted = np.zeros_like(force)
    known = [
        Coefficient(there.x, solid._size, solid.assembler.unknowns.cell_dofs),
        Coefficient(np.ascontiguousarray(stress), 6 * len(solid.weights)),
    ]
    solid._residual.add_vector(wanted, solid._size, known, solid.constants())
    assert force == pytest.approx(wanted, rel=1e-10, abs=1e-14 * np.abs(wanted).max())


def test_energy_beside_a_state_has_the_force_as_its_slope():
    tets = block((3, 2, 2), (3.0, 2.0, 2.0))
    model, other = build(tets, RUBBER, "P2"), build(tets, RUBBER, "P2")
    solid, state = other.solids["body"], bent(model)
    solid.stand_beside(model.solids["body"], state)
    assert solid.energy(state) == pytest.approx(model.solids["body"].energy(state), rel=1e-12)
    way = bent(model, seed=2).x - state.x
    force = np.zeros_like(way)
    there = replace(state, x=state.x + 0.1 * way)
    solid.add_force(there, force)
    step = 1e-4
    ahead, behind = (solid.energy(replace(state, x=there.x + s * step * way)) for s in (1, -1))
    assert (ahead - behind) / (2 * step) == pytest.approx(float(force @ way), rel=1e-7)


def test_an_inverted_element_beside_a_state_is_told():
    tets = block((1, 1, 1), (1.0, 1.0, 1.0))
    model, other = build(tets, RUBBER), build(tets, RUBBER)
    solid, state = other.solids["body"], State(np.zeros(model.unknowns.local))
    solid.stand_beside(model.solids["body"], state)
    state.x[model.displacement_dofs] = -2.0 * model.nodes.places
    with pytest.raises(InvertedElementError):
        solid.add_force(state, np.zeros_like(state.x))


def test_a_part_says_what_the_whole_says_there():
    tets = block((4, 2, 2), (4.0, 2.0, 2.0))
    model, other = build(tets, RUBBER), build(tets, RUBBER)
    solid, state, chosen = other.solids["body"], bent(model), np.array([3, 17, 40])
    for there in (state, bent(model, seed=2)):  # by its law, then beside the first one
        part = solid.part(chosen)
        assert np.array_equal(part.cells, solid.cells[chosen])
        assert part.cauchy(there) == pytest.approx(solid.cauchy(there)[chosen], rel=1e-12)
        solid.stand_beside(model.solids["body"], state)


def test_force_at_supports_is_that_of_the_whole_there():
    model = build(block((4, 2, 2), (4.0, 2.0, 2.0)), RUBBER)
    model.set_supports([CLAMP], State(np.zeros(model.unknowns.local)))
    state = bent(model)
    held = model.displacement_dofs[model.surfaces.nodes("x_min")].ravel()
    whole, part = model.force(state)[0], model.parts.force_at_supports(state)
    assert part[held] == pytest.approx(whole[held], rel=1e-12)
    far = model.displacement_dofs[model.surfaces.nodes("x_max")].ravel()
    assert not part[far].any() and whole[far].any()


def test_a_row_beside_the_actuators_is_that_of_all_points():
    """Of a state so near that what is largest stays where it is."""
    model = build(block((6, 2, 2), (6.0, 2.0, 2.0)), RUBBER, tip="x_max", clamp="x_min")
    model.set_supports([CLAMP], State(np.zeros(model.unknowns.local)))
    state = bent(model)
    actuator = Snapshot(model, state)
    for measure in MEASURES.values():
        measure.evaluate(actuator)
    near = replace(state, x=state.x * (1 + 1e-7))
    whole, beside = {}, {}
    for measure in MEASURES.values():
        whole |= measure.evaluate(Snapshot(model, near))
    seen = Snapshot(model, near, actuator=actuator)
    for measure in MEASURES.values():
        beside |= measure.evaluate(seen)
    assert beside.keys() == whole.keys() and "radial_growth_percent" in whole
    for name, value in whole.items():
        assert beside[name] == pytest.approx(value, rel=1e-10, abs=1e-12), name
    assert np.isneginf(seen.von_mises).any() and not np.isneginf(actuator.von_mises).any()
