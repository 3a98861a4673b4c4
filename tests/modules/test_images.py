"""Contact of a module with the images of itself in the modules around it."""

import numpy as np
import pytest
import scipy.sparse

from softact.contact.surfaces import Touching
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.measures.cross_section import CrossSection
from softact.mesh.layout import Repeats
from softact.system.motions import Motions
from softact.system.rotation import RotationVector
from softact.system.term import State
from tests.analytic.meshes import block
from tests.analytic.solving import build, solve
from tests.modules.test_repeat import in_a_row

RUBBER = LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=10.0)
PITCH, GAP = 2.0, 0.06
ALONG_X = Repeats("x_min", "x_max")
TURN = np.array([0.7, -0.4, 0.9])


def test_a_motion_done_again_and_taken_back():
    """By matrices of four by four, one after the other."""
    step, back = np.eye(4), np.eye(4)
    step[:3, :3], step[:3, 3] = RotationVector(TURN).matrix, [2.0, 0.3, -0.5]
    times = [-2, -1, 0, 1, 3]
    motions = Motions(TURN, times)
    for place, k in enumerate(times):
        wanted = np.linalg.matrix_power(step if k >= 0 else np.linalg.inv(step), abs(k)) @ back
        np.testing.assert_allclose(motions.turns[0][place], wanted[:3, :3], atol=1e-14)
        np.testing.assert_allclose(motions.sums[0][place] @ step[:3, 3], wanted[:3, 3], atol=1e-14)


@pytest.mark.parametrize("order", [1, 2])
def test_its_derivatives(order):
    times, step = [-2, -1, 0, 1, 3], 1e-5
    motions = Motions(TURN, times)
    for way in range(3):
        change = step * np.eye(3)[way]
        ahead, behind = (Motions(TURN + sign * change, times) for sign in (1, -1))
        for kind in ("turns", "sums"):
            slope = getattr(ahead, kind)[order - 1] - getattr(behind, kind)[order - 1]
            found = getattr(motions, kind)[order][:, way]
            np.testing.assert_allclose(found, slope / (2 * step), atol=1e-8)


def mushrooms(modules=1, repeats=ALONG_X, half=False, wide=1.0, begins=0.0):
    """Modules of 2 mm with a base of 1 mm; the cap on each is GAP away from the next one's. wide:
    mm across; half: a plane of symmetry halves them there. begins: part of a module between its
    left face and the middle of a gap."""

    def lines(places):
        """Those of the gap are GAP / 2 to both sides of it, others a quarter of a module."""
        number, along = np.divmod(places + begins * PITCH, PITCH)
        narrow = [0.0, GAP / 2, PITCH / 2, PITCH - GAP / 2, PITCH]
        return PITCH * (number - begins) + np.interp(along, np.linspace(0, PITCH, 5), narrow)

    def keep(centres):
        beside = abs((centres[:, 0] / PITCH + begins) % 1 - 0.5) < 0.25
        return (centres[:, 2] < 1) | beside

    cells = 4 * modules, 2 if wide < PITCH else 1, 3
    tets = block(
        cells,
        (PITCH * modules, wide, 3.0),
        lambda points: np.column_stack([lines(points[:, 0]), points[:, 1:]]),
        keep,
    )
    touching = [Touching("caps", (("inside",),))]
    symmetry = {"y_min": 1} if half else {}
    return build(tets, RUBBER, symmetry=symmetry, touching=touching, repeats=repeats)


def pressed_together(model):
    """A state in which neighbours overlap: bent, nearer to each other, drawn at random besides."""
    draw = np.random.default_rng(3).standard_normal
    state = model.initial_state()
    held = model.set_supports([], model.initial_state())
    state.x = 0.001 * draw(model.unknowns.local)
    repeat = model.repeat
    state.x[repeat.dofs] = repeat.free * [0.01, -0.07, 0.02, -0.003, 0.004, 0.002]
    turn, shift = repeat.motion(state.x)
    part = np.interp(
        model.nodes.places[:, :1], [0, GAP / 2, PITCH - GAP / 2, PITCH], [0, 0.5, 0.5, 1]
    )
    arms = model.nodes.places - part * repeat.pitch - repeat.centre
    way = arms @ (RotationVector(turn).matrix - np.eye(3)).T + shift - repeat.pitch
    state.x[model.displacement_dofs] += part * way
    state.x[held.dofs] = held.end
    model.follow(state.x)
    return state, held


CASES = {
    "whole": mushrooms,
    "half": lambda: mushrooms(half=True),
    "farther": lambda: mushrooms(wide=4.0),
}


@pytest.mark.parametrize("name", CASES)
def test_the_tangent_is_the_force_s_derivative(name):
    model = CASES[name]()
    state, held = pressed_together(model)
    (term,) = model.contacts
    touching = term.gaps(state.x)[2] < 0
    assert touching.sum() > 5
    assert (
        len(term.facets) == len(touching) == len(term.facets.share) * (3 + 2 * (name == "farther"))
    )
    rows, columns, values = model.tangent(state).getValuesCSR()
    matrix = scipy.sparse.csr_matrix((values, columns, rows))
    assert abs(matrix - matrix.T).max() < 1e-12 * abs(matrix).max()
    way, step = np.random.default_rng(2).standard_normal(model.unknowns.local), 1e-6
    way[held.dofs] = 0.0
    way[model.repeat.follows] = 0.0

    def at(sign):
        return State(model.follow(state.x + sign * step * way), state.loads)

    def force(sign):
        found = model.force(at(sign))[0]
        found[held.dofs] = 0.0
        return found

    slope = (force(1) - force(-1)) / (2 * step)
    assert np.linalg.norm(matrix @ way - slope) < 1e-6 * np.linalg.norm(slope)
    pushed = np.zeros(model.unknowns.local)
    term.add_force(state, pushed)
    work = (term.energy(at(1)) - term.energy(at(-1))) / (2 * step)
    assert pushed @ way == pytest.approx(work, rel=1e-7)
    assert np.abs(pushed[model.repeat.dofs]).max() > 1e-3 * np.abs(pushed).max()


def test_one_more_module_of_a_chain_has_as_much_contact():
    """Energy, area and forces: what a chain of four has beyond one of three."""
    model = mushrooms()
    state, _ = pressed_together(model)
    (term,) = model.contacts
    found = []
    for modules in (3, 4):
        chain = mushrooms(modules, None)
        x = in_a_row(model, state.x, chain, modules)
        (whole,) = chain.contacts
        there = State(x, chain.initial_state().loads)
        found.append((whole.energy(there), whole.area(there), len(whole.facets)))
    wanted = np.subtract(*found[::-1])
    assert term.energy(state) == pytest.approx(wanted[0], rel=1e-10)
    assert term.area(state) == pytest.approx(wanted[1], rel=1e-10)
    assert term.energy(state) > 1e-6


def bent_shut(begins):
    """Moment, stiffness against bending at no force, energy and area in touch of a module whose
    caps a turn presses together; how many points face an image, and how many anything."""
    held = Repeats("x_min", "x_max", {"turn_y": -0.05})
    model = mushrooms(repeats=held, half=True, begins=begins)
    found = solve(model, LoadStep("bend"), [], 0.5, tolerance=1e-11)
    section, (term,) = CrossSection(model, found.state), model.contacts
    partner, _, gap = term.gaps(found.state.x)
    beyond = (gap < 0) & (partner >= len(term.facets.share))
    stiffness = 1 / np.linalg.inv(section.stiffness())[0, 0]
    values = section.load[1], stiffness, model.energy(found.state), term.area(found.state)
    return np.array(values), int(beyond.sum()), int((gap < 0).sum())


def test_where_a_chain_is_cut_does_not_matter():
    """In the gap, so that all contact is with images, or in a cap, so that none is."""
    (one, beyond, touching), (other, none, inside) = (bent_shut(part) for part in (0.0, 0.5))
    assert beyond == touching == inside > 5
    assert none == 0
    np.testing.assert_allclose(one, other, rtol=1e-8)
    assert other[-1] > 0.01
