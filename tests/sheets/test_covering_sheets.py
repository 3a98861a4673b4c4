"""Sheets that lie on a solid with its triangles: bonded, pressed by it, sliding on it."""

import numpy as np
import pytest
import scipy.integrate
from mpi4py import MPI

from softact.bodies.sheet import Ply, Sheet
from softact.contact.surfaces import Touching
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.layout import Layout
from softact.mesh.tetrahedra import distribute
from softact.model import Model, Support
from tests.analytic.differences import force, slope, tangent, to_global, to_local
from tests.analytic.meshes import block
from tests.analytic.solving import solve

C10 = 0.05
RUBBER = LAWS["neo_hookean"].of(c10=C10, bulk_modulus=50.0)


def covered(tets, covers, sheet, touching=(), bonded=(), **layout) -> Model:
    """A block of rubber with sheets on it: ``covers`` as in ``Layout``."""
    names = {"clamp": "x_min", "tip": "x_max", "cavities": {}} | layout
    whole = Layout(
        regions=("body",),
        surfaces=tuple(tets.surfaces),
        sheets=tuple(covers),
        covers=covers,
        bonded=bonded,
        **names,
    )
    mesh = distribute(MPI.COMM_SELF, lambda: tets, whole)
    sheets = dict.fromkeys(covers, sheet)
    return Model(mesh, {"body": RUBBER.material()}, sheets=sheets, touching=touching)


A, B, FILM = 4.0, 6.0, 0.1  # mm


def around(points):
    """The unit square of x and y to a quarter of a ring about z."""
    r, angle = A + (B - A) * points[:, 0], np.pi / 2 * points[:, 1]
    return np.column_stack([r * np.cos(angle), r * np.sin(angle), points[:, 2]])


def test_tube_in_a_sleeve():
    """Plane strain: p = ∫ (σθ − σr)/r dr of the core plus what the sleeve, E t ε, holds back. The
    sleeve is held in the planes of symmetry by the core's surfaces there."""
    sleeve = LAWS["linear"].of(youngs_modulus=150.0 * C10, poissons_ratio=0.0)
    film = Sheet([Ply(sleeve, FILM)], bending=0.0)
    pressure = 0.03
    model = covered(
        block((3, 16, 1), (1.0, 1.0, 1.0), around),
        {"film": "x_max"},
        film,
        [Touching("pair", (("x_max",), ("film",)))],
        symmetry={"y_min": 1, "y_max": 0, "z_min": 2},
    )
    step = LoadStep("press", surface_pressure={"x_min": pressure})
    solution = solve(model, step, [Support("z_max", {2: 0.0})], increment=0.1)
    places = model.nodes.places + solution.state.x[model.displacement_dofs]

    def radius(name):
        """Of the corners: the middles of flat sides are nearer to the axis."""
        nodes = model.surfaces.nodes(name)
        before = np.linalg.norm(model.nodes.places[nodes, :2], axis=1)
        return np.linalg.norm(places[nodes, :2], axis=1)[np.abs(before - B) < 1e-9].mean()

    outer, ring = radius("x_max"), radius("film")

    def stress_difference(now):
        before = np.sqrt(now**2 - outer**2 + B**2)
        return 2 * C10 * ((now / before) ** 2 - (before / now) ** 2) / now

    inner = np.sqrt(outer**2 - B**2 + A**2)
    of_core = scipy.integrate.quad(stress_difference, inner, outer)[0]
    stretch = ring / B
    tension = sleeve.youngs_modulus * FILM * stretch * (stretch**2 - 1) / 2
    assert of_core + tension / outer == pytest.approx(pressure, rel=0.01)
    assert 0.2 < tension / outer / pressure < 0.8
    assert stretch > 1.01


@pytest.mark.parametrize("coefficient", [0.1, 0.6])
def test_film_dragged_over_its_block(coefficient):
    """Under a dead load q it resists with μ q A, and with what the rubber does that rises before
    its edge; pressed on by 0.002 mm, as nothing else holds it across. Partners are looked up anew
    after the last increment: forces then change by a percent or two."""
    load, size = 2e-3, (8.0, 3.0, 2.0)
    nylon = LAWS["linear"].of(youngs_modulus=498.0, poissons_ratio=0.35)
    model = covered(
        block((5, 2, 1), size),
        {"film": "z_max"},
        Sheet([Ply(nylon, 0.2)]),
        [Touching("pair", (("z_max",), ("film",)), coefficient, distance=0.002)],
    )
    end = model.surfaces.nodes("film")
    end = end[model.nodes.places[end, 0] > size[0] - 1e-9]
    model.surfaces.curves["end"] = end[:, None]
    hold = Support("z_min", dict.fromkeys(range(3), 0.0))
    press = LoadStep("press", traction={"film": (0.0, 0.0, -load)})
    drag = LoadStep("drag", supports=[hold, Support("end", {0: 0.3, 1: 0.0})])
    solution = solve(model, [press, drag], [hold, Support("end", {0: 0.0, 1: 0.0})], 0.2)
    pushed = load * size[0] * size[1]
    held, below = solution.reaction("end")[0], solution.reaction("z_min")
    assert held == pytest.approx(coefficient * pushed, rel=0.03)
    np.testing.assert_allclose(below[[0, 2]], [-held, pushed], rtol=0.03)
    (pair,) = model.contacts
    normal, along = pair.pressed(solution.state)
    sizes = np.linalg.norm(along, axis=1)
    np.testing.assert_allclose(sizes, coefficient * normal, rtol=1e-4)
    assert normal.sum() == pytest.approx(pushed, rel=0.03)
    assert 0 < -model.contacts.smallest_gap(pair, solution.state)[0] < 0.02


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_tangent(friction):
    """Force against energy, tangent against force, by central differences: a film with a hole on a
    block, of which only the film's points look for the other."""
    tets = block((3, 2, 1), (3.0, 2.0, 1.0))
    lid = tets.surfaces["z_max"]
    tets.surfaces["under"] = lid[tets.points[lid][:, :, 0].max(axis=1) < 2.5]
    film = Sheet([Ply(RUBBER, 0.1)], bending=0.0)
    touching = [Touching("pair", (("z_max",), ("film",)), friction, distance=0.01)]
    model = covered(tets, {"film": "under"}, film, touching)
    (pair,) = model.contacts
    rng = np.random.default_rng(7)
    state = model.initial_state()
    model.contacts.remember(state)
    for size in (2e-3, 1e-3):
        state.x = state.x + size * rng.standard_normal(model.unknowns.local)
        model.contacts.remember(state)
    state.x = state.x + 5e-4 * rng.standard_normal(model.unknowns.local)
    looks = pair.gaps(state.x)[0] >= 0
    assert looks[pair.facets.of_sheet].all() and not looks[~pair.facets.of_sheet].any()
    direction = rng.standard_normal(model.unknowns.local)
    matrix = tangent(model, [pair], state)
    found = to_local(model, matrix @ to_global(model, direction))
    expected = slope(lambda s: force(model, pair, s), state, direction)
    assert np.linalg.norm(found - expected) <= 1e-6 * np.linalg.norm(expected)
    forces = force(model, pair, state)[model.displacement_dofs]
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-12 * np.abs(forces).max())
    if not friction:
        work = slope(lambda s: pair.energy(s), state, direction)
        assert force(model, pair, state) @ direction == pytest.approx(work, rel=1e-5)
