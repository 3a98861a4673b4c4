"""Contact of a body with itself and between bodies: tangents, patch, two blocks, friction."""

import numpy as np
import pytest
from meshes import block
from solving import build, solve
from test_tangents import force, slope, tangent, to_global, to_local

from softact.contact.surfaces import Touching
from softact.materials import LAWS
from softact.model import Support
from softact.stepping import LoadStep

SOFT = LAWS["neo_hookean"].of(c10=0.05, bulk_modulus=50.0)
GAP = 0.02


def slit(points):
    """Squeezes the middle third of the height to the gap."""
    z = np.interp(points[:, 2], [0, 1, 2, 3], [0, 1, 1 + GAP, 2 + GAP])
    return np.column_stack([points[:, :2], z])


def jaws(friction=0.0, twist=0.0, element="P2/P1", joined=True):
    """Two blocks of 3 × 1 × 1 mm over each other, joined at x < 1 unless they are not."""

    def mapping(points):
        moved = slit(points)
        moved[:, 1] += twist * (points[:, 2] > 1.5) * (points[:, 1] - 0.4)
        return moved

    def keep(centres):
        return (np.abs(centres[:, 2] - 1.5) > 0.6) | ((centres[:, 0] < 1) & joined)

    tets = block((3, 2, 3), (3.0, 1.0, 3.0), mapping, keep)
    touching = Touching("jaws", (("inside",),), friction)
    return build(tets, SOFT, element, touching=[touching])


def bitten(friction):
    """The jaws at a random state with overlap, and what they remember of an earlier one."""
    model = jaws(friction, twist=0.13)
    rng = np.random.default_rng(4)
    places = model.unknowns.spaces[0].tabulate_dof_coordinates()
    state = model.initial_state()
    z = model.displacement_dofs[:, 2]
    state.x = 0.004 * rng.standard_normal(model.unknowns.local)
    state.x[z] -= 0.012 * places[:, 0] * (places[:, 2] > 1.01)
    model.contacts.remember(state)
    state.x = state.x + 0.002 * rng.standard_normal(model.unknowns.local)
    return model, state


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_tangent(friction):
    """Force against energy, tangent against force, by central differences."""
    model, state = bitten(friction)
    (term,) = model.contacts
    assert (term.gaps(state.x)[2] < 0).sum() > 20
    direction = np.random.default_rng(2).standard_normal(model.unknowns.local)
    matrix = tangent(model, [term], state)
    assert np.abs(matrix).max() > 0.01
    found = to_local(model, matrix @ to_global(model, direction))
    expected = slope(lambda s: force(model, term, s), state, direction)
    # A point that begins to touch, to slip or to face another facet has no derivative there.
    assert np.linalg.norm(found - expected) <= 2e-4 * np.linalg.norm(expected)
    if friction:
        assert np.abs(matrix - matrix.T).max() > 1e-3 * np.abs(matrix).max()
    else:
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())
        work = slope(lambda s: term.energy(s), state, direction)
        assert force(model, term, state) @ direction == pytest.approx(work, rel=1e-5)


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_action_and_reaction(friction):
    """The forces of a contact of a body with itself add up to nothing."""
    model, state = bitten(friction)
    (term,) = model.contacts
    forces = force(model, term, state)[model.displacement_dofs]
    assert np.abs(forces).sum() > 0.01
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-14)


SIDES = [Support("x_min", {0: 0.0}), Support("y_min", {1: 0.0}), Support("z_min", {2: 0.0})]


@pytest.mark.parametrize("element", ["P2/P1", "P2"])
def test_two_blocks(element):
    """Two blocks over each other, pressed: both are strained alike and uniformly, to 1e-6."""
    model = jaws(element=element, joined=False)
    press = [*SIDES, Support("z_max", {2: -0.4})]
    start = [*SIDES, Support("z_max", {2: 0.0}), ]
    solution = solve(model, LoadStep("press", supports=press), [*start], 0.5)
    f = model.solids["body"].deformation_gradient(solution.state.x)
    (term,) = model.contacts
    _, _, gap = term.gaps(solution.state.x)
    inside = gap[np.isfinite(gap)]
    print(inside.min(), inside.max(), [a.iterations for a in solution.stepper.progress.attempts])
    assert -0.02 * term.facets.size.min() < inside.mean() < 0
    expected = (2 - 0.4 + GAP - inside.mean()) / 2
    np.testing.assert_allclose(f[..., 2, 2], expected, rtol=1e-3)
