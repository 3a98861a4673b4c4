"""Two faces that a rigid motion relates: derivatives, a bent block, a tube under pressure."""

import numpy as np
import pytest
import scipy.sparse
from scipy.integrate import quad
from scipy.optimize import brentq, fsolve
from scipy.spatial import cKDTree

from softact.bodies.layer import BondedLayer
from softact.bodies.plate import LayerBending
from softact.errors import SpecError
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.measures.cross_section import CrossSection
from softact.mesh.layout import COMPONENTS, Repeats
from softact.model import Support
from softact.system.rotation import RotationVector
from softact.system.term import EVERYTHING, State
from tests.analytic.meshes import block, disc
from tests.analytic.solving import build, solve

ALONG_X = Repeats("x_min", "x_max")
RUBBER = LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=10.0)
# As stiff against bending as the block: what is amiss at its border shows.
STIFF = LAWS["linear"].of(youngs_modulus=100.0, poissons_ratio=0.3)
PLATE = BondedLayer("z_min", STIFF, 0.5)
LOADS = {"pressure": {"cavity": 0.02}, "wrench": {EVERYTHING: np.array([1, 2, 3, 4, 5, 6]) / 500}}


def channel(element, half=False, repeats=ALONG_X, layers=(), modules=1, cells=2):
    """2 × 3 × 3 mm with a channel of 1 × 1 mm from face to face; a half has y >= 0. Or so many of
    them in a row, each of so many cells; without repeats there is no load."""
    middle, wide = (0.0, 1.2) if half else (1.5, 0.6)
    tets = block(
        (cells * modules, 3, 3),
        (2.0 * modules, 3.0, 3.0),
        keep=lambda c: ~((abs(c[:, 1] - middle) < wide) & (abs(c[:, 2] - 1.5) < 0.6)),
    )
    symmetry = {"y_min": 1} if half else {}
    walls = {"cavity": ("inside",)} if repeats else {}
    model = build(tets, RUBBER, element, layers, walls, symmetry, repeats=repeats)
    if repeats:
        model.make_room(LOADS)
    return model


def drawn_state(model):
    """A random state of which the right face follows, and what is held."""
    draw = np.random.default_rng(1).standard_normal
    state = State(0.03 * draw(model.unknowns.local), LOADS)
    held = model.set_supports([], model.initial_state())
    state.x[model.repeat.dofs] = 0.3 * draw(6)
    state.x[held.dofs] = held.end
    model.follow(state.x)
    return state, held


def unknown_direction(model, held):
    """A direction of what is unknown: not of what follows."""
    way = np.random.default_rng(2).standard_normal(model.unknowns.local)
    along = np.zeros_like(way)
    along[:] = way
    along[held.dofs] = 0.0
    along[model.repeat.follows] = 0.0
    return along


@pytest.mark.parametrize("half", [False, True])
@pytest.mark.parametrize(("element", "layers"), [("P2/P1", ()), ("P2", ()), ("P2", (PLATE,))])
@pytest.mark.parametrize("cells", [1, 2])
def test_the_tangent_is_the_force_s_derivative(cells, element, layers, half):
    model = channel(element, half, layers=layers, cells=cells)
    state, held = drawn_state(model)
    rows, columns, values = model.tangent(state).getValuesCSR()
    matrix = scipy.sparse.csr_matrix((values, columns, rows))
    assert abs(matrix - matrix.T).max() < 1e-12 * abs(matrix).max()
    way, step = unknown_direction(model, held), 1e-6

    def force(sign):
        moved = State(model.follow(state.x + sign * step * way), LOADS)
        found = model.force(moved)[0]
        found[held.dofs] = 0.0
        return found

    slope = (force(1) - force(-1)) / (2 * step)
    assert np.linalg.norm(matrix @ way - slope) < 1e-6 * np.linalg.norm(slope)


@pytest.mark.parametrize("layers", [(), (PLATE,)])
@pytest.mark.parametrize("half", [False, True])
def test_the_force_is_the_energy_s_derivative(half, layers):
    model = channel("P2", half, layers=layers)
    state, held = drawn_state(model)
    state.x[model.repeat.rows_of_multipliers] = 0.0  # their energy is none of the model's
    way, step = unknown_direction(model, held), 1e-6
    way[model.repeat.rows_of_multipliers] = 0.0

    def energy(sign):
        return model.energy(State(model.follow(state.x + sign * step * way), LOADS))

    work = model.force(state)[0] @ way
    assert work == pytest.approx((energy(1) - energy(-1)) / (2 * step), rel=1e-7)


def bending_energy(model, x):
    return sum(t.energy(State(x, LOADS)) for t in model.elastic if isinstance(t, LayerBending))


@pytest.mark.parametrize(("half", "cells"), [(False, 2), (True, 2), (True, 1)])
def test_a_plate_bends_across_the_border_of_modules(half, cells):
    """In a chain of modules that are bent at random, one more has that much more energy."""
    model = channel("P2", half, layers=[PLATE], cells=cells)
    state, _ = drawn_state(model)
    energies = []
    for modules in (2, 3):
        chain = channel("P2", half, None, [PLATE], modules, cells)
        x = in_a_row(model, state.x, chain, modules)
        energies.append(bending_energy(chain, x))
    wanted = energies[1] - energies[0]
    assert bending_energy(model, state.x) == pytest.approx(wanted, rel=1e-10)
    assert wanted > 1.1 * (2 * energies[0] - energies[1])  # that of a module without its border


def next_module(repeat, x, places):
    turn, shift = repeat.motion(x)
    return repeat.centre + (places - repeat.centre) @ RotationVector(turn).matrix.T + shift


def in_a_row(model, x, chain, modules):
    """Unknowns (local,) of a chain of so many modules, each as one with the unknowns x."""
    found, tree = chain.initial_state().x, cKDTree(chain.nodes.places)
    rest, moved = model.nodes.places, model.nodes.places + x[model.displacement_dofs]
    for _ in range(modules):
        gaps, nodes = tree.query(rest)
        assert gaps.max() < 1e-12
        found[chain.displacement_dofs[nodes]] = moved - rest
        rest, moved = rest + model.repeat.pitch, next_module(model.repeat, x, moved)
    return found


def test_the_air_of_a_module_is_that_between_its_openings():
    """1 × 1 × 2 mm at rest; turned and moved as a whole, as much; a longer module has more."""
    model = channel("P2")
    rest = model.initial_state()
    assert model.cavity_volume(rest, "cavity") == pytest.approx(2.0, rel=1e-12)
    turn = RotationVector(np.array([0.3, -0.5, 0.8])).matrix
    places = model.nodes.places
    rest.x[model.displacement_dofs] = places @ turn.T + [3.0, 4.0, 5.0] - places
    centre, pitch = model.repeat.centre, model.repeat.pitch
    # Seen from the turned left face the neighbour has not turned; its place has.
    rest.x[model.repeat.dofs[3:]] = turn @ pitch - pitch
    moved = model.repeat.follow(rest.x.copy())
    np.testing.assert_allclose(moved, rest.x, atol=1e-12)
    assert model.cavity_volume(rest, "cavity") == pytest.approx(2.0, rel=1e-12)
    longer = model.initial_state()
    longer.x[model.displacement_dofs[:, 0]] = 0.25 * (places[:, 0] - centre[0])
    longer.x[model.repeat.dofs[3]] = 0.5
    assert model.cavity_volume(longer, "cavity") == pytest.approx(2.5, rel=1e-12)


def rivlin_walls(curvature, half_height):
    """Radii of a bent block whose outsides are free; see ``rivlin``."""
    bend = 2 * curvature * half_height  # λ₂² − λ₁² = 2 κ times the height, which keeps the volume
    outer = np.sqrt(bend + np.sqrt(1 + bend**2))
    return 1 / (curvature * outer), outer / curvature


def rivlin(curvature, half_height, modulus):
    """Moment per width of a bent block in plane strain, N.

    Rivlin 1949, Proc. R. Soc. A 195:463: planes x = const. turn, z = const. become cylinders. With
    the stretch λ = κ r, both outsides free, λ₁ λ₂ = 1, and M = −∫ r (W − W(λ₂)) dr.
    """

    def energy(radius):
        square = (curvature * radius) ** 2
        return modulus / 2 * (square + 1 / square - 2)

    ends = rivlin_walls(curvature, half_height)
    return -quad(lambda r: r * (energy(r) - energy(ends[1])), *ends)[0]


@pytest.mark.parametrize("turn", [0.2, 0.6])
def test_a_bent_block_has_rivlin_s_moment(turn):
    """2 × 1 × 4 mm, sides held: 0.2 and 0.6 rad by module, of curvatures 0.1 and 0.3 per mm."""
    law = LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=1e4)
    repeats = Repeats("x_min", "x_max", {"turn_y": turn})
    symmetry = {"y_min": 1}
    model = build(block((2, 1, 6), (2.0, 1.0, 4.0)), law, symmetry=symmetry, repeats=repeats)
    found = solve(model, LoadStep("bend"), [Support("y_max", {1: 0.0})], 0.5, tolerance=1e-10)
    section = CrossSection(model, found.state)
    curvature = turn / 2.0
    exact = 2 * rivlin(curvature, 2.0, 0.2)  # with the mirror image, 2 mm wide
    assert section.strain[1] == pytest.approx(curvature, rel=1e-12)
    assert section.load[1] == pytest.approx(exact, rel=2e-4)
    assert np.abs(section.load[[3, 5]]).max() < 1e-8 * exact
    step = 1e-4 * curvature
    slope = 2 * (rivlin(curvature + step, 2.0, 0.2) - rivlin(curvature - step, 2.0, 0.2))
    free_of_force = np.linalg.inv(np.linalg.inv(section.stiffness())[:1, :1])
    assert free_of_force[0, 0] == pytest.approx(slope / (2 * step), rel=2e-3)


@pytest.mark.parametrize(("turn", "pressure"), [(0.3, 0.02), (0.3, 0.05), (0.4, 0.02)])
def test_an_arch_of_a_pressurised_cylinder(turn, pressure):
    """The same block, bent to a part of a ring with air in it, about the axis of this ring: the
    radii of its walls, with no force needed to keep it there.

    With λ = κ r and λ₁ λ₂ no longer 1, dσ_r/dr = μ (κ² r² − 1/(κ² r²)) / r gives the pressure by
    r₂² − r₁² = 2 H / κ (Rivlin 1949); p r₁ pulls at the faces.
    """
    curvature, height = turn / 2.0, 4.0
    thicker = 2 * height / curvature

    def lacking(inner):
        low, high = (curvature**2 * square for square in (inner**2, inner**2 + thicker))
        return 0.1 * (high + 1 / high - low - 1 / low) - pressure

    free = rivlin_walls(curvature, height / 2)[0]
    inner = brentq(lacking, 0.9 * free, 3 * free)
    outer = np.sqrt(inner**2 + thicker)
    assert inner > 1.01 * free
    # The left face stays where it is in the mean.
    axis = np.array([0.0, 0.0, -curvature * (outer**3 - inner**3) / (3 * height)])
    way = axis - RotationVector(np.array([0.0, turn, 0.0])).matrix @ axis
    motion = {"turn_y": turn, "shift_x": way[0], "shift_z": way[2]}
    model = build(
        block((2, 1, 6), (2.0, 1.0, height)),
        LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=1e4),
        symmetry={"y_min": 1},
        repeats=Repeats("x_min", "x_max", motion),
    )
    step = LoadStep("press", surface_pressure={"z_min": pressure})
    found = solve(model, step, [Support("y_max", {1: 0.0})], 0.25, tolerance=1e-10)
    places, left = model.nodes.places, model.repeat.left_nodes
    for z, radius in ((0.0, inner), (height, outer)):
        at = left[places[left, 2] == z]
        here = places[at] + found.state.x[model.nodes.dofs[at]]
        apart = np.linalg.norm(next_module(model.repeat, found.state.x, here) - here, axis=1)
        assert apart / (2 * np.sin(turn / 2)) == pytest.approx(radius, rel=1e-3)
    assert np.abs(found.state.x[model.repeat.rows_of_multipliers[:3]]).max() < 1e-4


INNER, OUTER, SIDES = 2.0, 4.0, 32  # of the tube, mm; its outside is a polygon of so many sides


def tube_loads(inner, stretch, twist, modulus):
    """Pressure MPa, force N of closed ends and torque N·mm of a tube whose bore becomes ``inner``.

    Rivlin 1949, Phil. Trans. A 242:173, incompressible neo-Hookean: r² = a² + (R² − A²)/λ, and with
    b = F Fᵀ, dσ_r/dr = μ (b_θ − b_r)/r; twist: rad by undeformed length.
    """

    def left(radius):
        before = np.sqrt(INNER**2 + stretch * (radius**2 - inner**2))
        return (before / (radius * stretch)) ** 2, (radius / before) ** 2 + (radius * twist) ** 2

    def rise(radius):
        along, around = left(radius)
        return modulus * (around - along) / radius

    end = np.sqrt(inner**2 + (OUTER**2 - INNER**2) / stretch)
    pressure = quad(rise, inner, end)[0]

    def axial(radius):
        radial = quad(rise, inner, radius)[0] - pressure
        return (radial + modulus * (stretch**2 - left(radius)[0])) * 2 * np.pi * radius

    force = quad(axial, inner, end)[0] - pressure * np.pi * inner**2
    torque = 2 * np.pi * modulus * twist * stretch * (end**4 - inner**4) / 4
    return pressure, force, torque


def test_a_tube_under_pressure_and_torque():
    """Bore, stretch and twist beside quadrature: 40 kPa in 0.2 MPa, and 8 N·mm, closed ends."""

    def rings(points):
        """To polygons of the areas of the circles."""
        found = disc(points, OUTER)
        angle = 2 * np.pi / SIDES * OUTER / np.linalg.norm(found[:, :2], axis=1)
        found[:, :2] *= np.sqrt(angle / np.sin(angle))[:, None]
        return found

    tets = block(
        (8, 8, 2),
        (1.0, 1.0, 2.0),
        rings,
        keep=lambda c: (abs(c[:, :2] - 0.5) > 0.25).any(axis=1),
    )
    law = LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=1e3)
    repeats, walls = Repeats("z_min", "z_max"), {"cavity": ("inside",)}
    model = build(tets, law, cavities=walls, repeats=repeats)
    wrench = {EVERYTHING: np.array([0.0, 0.0, 8.0, 0.0, 0.0, 0.0])}
    step = LoadStep("press", pressure={"cavity": 0.04}, wrench=wrench)
    found = solve(model, step, [], 0.5)
    wanted = np.array([0.04, 0.0, 8.0])
    bore, stretch, twist = fsolve(lambda v: tube_loads(*v, 0.2) - wanted, (2.3, 1.02, 0.05))
    section = CrossSection(model, found.state)
    assert section.strain[2] == pytest.approx(twist, rel=5e-3)
    assert section.strain[5] - 1 == pytest.approx(stretch - 1, rel=5e-3)
    volume = model.cavity_volume(found.state, "cavity")
    assert volume == pytest.approx(np.pi * bore**2 * stretch * 2.0, rel=2e-3)
    assert section.load[2] == pytest.approx(8.0, rel=1e-12)
    assert np.abs(section.strain[[0, 1, 3, 4]]).max() < 1e-6


def test_faces_that_do_not_match_are_refused():
    tets = block((2, 2, 2), mapping=lambda x: x + 0.1 * x[:, :1] * (x[:, 1:2] > 0.4) * [0, 1, 0])
    with pytest.raises(SpecError, match=r"'x_min' and 'x_max' do not match: .* have no partner"):
        build(tets, RUBBER, repeats=ALONG_X)


def test_injected_air_takes_the_pressure_that_gives_its_volume():
    """With the volume prescribed instead, the tangent of the air's opening is part of a border."""
    model = channel("P2/P1", half=True)
    steps = {"pressure": {"cavity": 0.01}, "wrench": {EVERYTHING: np.zeros(6)}}
    pressed = solve(model, LoadStep("press", **steps), [], 0.5, tolerance=1e-10)
    volume = model.cavity_volume(pressed.state, "cavity")
    more = volume - model.cavity_volume(model.initial_state(), "cavity")
    assert more > 0.05
    other = channel("P2/P1", half=True)
    filled = solve(other, LoadStep("fill", inject={"cavity": more}), [], 0.5, tolerance=1e-10)
    assert filled.state["pressure"]["cavity"] == pytest.approx(0.01, rel=1e-7)
    strains = (CrossSection(m, s.state).strain for m, s in ((model, pressed), (other, filled)))
    np.testing.assert_allclose(*strains, atol=1e-8)


def held_section(strain):
    """The cross-section of a channel under 10 kPa whose curvatures and stretches are all given."""
    turn, length = 2.0 * strain[:3], 2.0
    shift = length * RotationVector(turn, integral=True).matrix @ strain[3:]
    held = dict(zip(COMPONENTS, [*turn, *shift], strict=True))
    model = channel("P2/P1", repeats=Repeats("x_min", "x_max", held))
    step = LoadStep("hold", pressure={"cavity": 0.01})
    found = solve(model, step, [], 0.5, tolerance=1e-11)
    return CrossSection(model, found.state)


def test_the_stiffness_is_the_slope_of_moment_and_force():
    """In a state that is bent, twisted, sheared and stretched, by twist, by bending, by stretch."""
    here = np.array([0.05, 0.08, -0.03, 1.1, 0.03, -0.02])
    section = held_section(here)
    np.testing.assert_allclose(section.strain, here, atol=1e-12)
    stiffness, step = section.stiffness(), 1e-4
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-9 * np.abs(stiffness).max())
    for number in (0, 1, 3):
        way = step * np.eye(6)[number]
        slope = (held_section(here + way).load - held_section(here - way).load) / (2 * step)
        np.testing.assert_allclose(stiffness[number], slope, atol=1e-5 * np.abs(slope).max())
