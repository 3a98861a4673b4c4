"""The bending stiffness of thin layers: its matrix against plate theory, its symmetry planes."""

import numpy as np
import pytest
import scipy.sparse.linalg

from softact.bodies.layer import BondedLayer
from softact.bodies.plate import bending_matrices
from softact.materials import LAWS
from softact.system.rotation import rotation_about
from softact.system.term import State
from tests.analytic.meshes import block
from tests.analytic.solving import build

RIGIDITY = 3.0  # N·mm


def sheet(cells, size, low=(0.0, 0.0)):
    """Quadratic triangles on a rectangle: nodes (n, 3), triangles (k, 6), middles 01, 12, 20."""
    tets = block((*cells, 1), (*size, 1.0))
    triangles = tets.surfaces["z_min"]
    points = tets.points + np.array([*low, 0.0])
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=-1).reshape(-1, 2)
    edges, place = np.unique(sides, axis=0, return_inverse=True)
    points = np.vstack([points, points[edges].mean(axis=1)])
    triangles = np.hstack([triangles, len(tets.points) + place.reshape(-1, 3)])
    return compact(points, triangles)


def compact(points, triangles):
    used, triangles = np.unique(triangles, return_inverse=True)
    return points[used], triangles.reshape(-1, 6)


def with_mirror_image(points, triangles):
    """The sheet and its image across y = 0, joined there."""
    image = points * [1.0, -1.0, 1.0]
    number = np.where(
        points[:, 1] == 0, np.arange(len(points)), len(points) + np.arange(len(points))
    )
    both = np.vstack([triangles, number[triangles]])
    return compact(np.vstack([points, image]), both)


def matrices(points, triangles, poisson, symmetry=()):
    return bending_matrices(points[triangles], triangles, len(points), RIGIDITY, poisson, symmetry)


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.49])
def test_only_affine_fields_cost_nothing(poisson):
    """Positive semidefinite with a kernel of three: 1, x and y. A fourth would wrinkle freely."""
    points, triangles = sheet((4, 3), (5.0, 2.0))
    matrix = matrices(points, triangles, poisson)[1].toarray()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())
    values = np.linalg.eigvalsh(matrix)
    assert np.abs(values[:3]).max() < 1e-12 * values[-1]
    assert values[3] > 1e-6 * values[-1]
    affine = np.column_stack([np.ones(len(points)), points[:, :2]])
    assert np.abs(matrix @ affine).max() < 1e-11 * np.abs(matrix).max()


@pytest.mark.parametrize("poisson", [0.0, 0.3])
@pytest.mark.parametrize("xx,xy,yy", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.3, -0.5, 0.8)])
def test_constant_curvature(poisson, xx, xy, yy):
    """Energy ½ D A (κxx² + κyy² + 2 ν κxx κyy + 2 (1 − ν) κxy²), exact for quadratic elements."""
    points, triangles = sheet((3, 4), (5.0, 2.0))
    x, y = points[:, :2].T
    w = xx * x**2 / 2 + xy * x * y + yy * y**2 / 2
    energy = w @ (matrices(points, triangles, poisson)[1] @ w) / 2
    bent = xx**2 + yy**2 + 2 * poisson * xx * yy + 2 * (1 - poisson) * xy**2
    assert energy == pytest.approx(RIGIDITY * 10 * bent / 2, rel=1e-9)


def deflection(points, triangles, poisson, length, symmetry, force):
    """Tip of a sheet that is clamped at x = 0, with the same force on each node of its end.

    The slope is held to zero at the clamp as in a plane of symmetry.
    """
    even, _ = matrices(points, triangles, poisson, symmetry)
    end = points[:, 0] > length - 1e-9
    free = np.flatnonzero(points[:, 0] > 1e-9)
    load = np.where(end, 1.0, 0.0)
    load *= force / load.sum()
    w = np.zeros(len(points))
    w[free] = scipy.sparse.linalg.spsolve(even[free][:, free].tocsc(), load[free])
    return w[end].mean(), w


@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_cantilever_strip(poisson):
    """w = P L³/(3 E I) with E I = D (1 − ν²) b for a narrow strip: plate theory, within 2 %."""
    length, width = 20.0, 1.0
    points, triangles = sheet((40, 2), (length, width))
    found, _ = deflection(points, triangles, poisson, length, (0,), 0.01)
    exact = 0.01 * length**3 / (3 * RIGIDITY * (1 - poisson**2) * width)
    assert found == pytest.approx(exact, rel=0.02)


@pytest.mark.parametrize("ratio", [10.0, 1000.0])
def test_a_stepped_strip(ratio):
    """Stiffness D₁ up to the middle, D₂ from there on: by the force method the tip goes down by
    P/b (7 L³/(24 D₁) + L³/(24 D₂)), within 2 % whichever is the stiffer."""
    length, force = 20.0, 0.01
    points, triangles = sheet((40, 2), (length, 1.0))
    outer = points[triangles, 0].mean(axis=1) > length / 2
    for d1, d2 in ((RIGIDITY, ratio * RIGIDITY), (ratio * RIGIDITY, RIGIDITY)):
        rigidity = np.where(outer, d2, d1)
        even, _ = bending_matrices(points[triangles], triangles, len(points), rigidity, 0.0, (0,))
        end, free = points[:, 0] > length - 1e-9, np.flatnonzero(points[:, 0] > 1e-9)
        load = np.where(end, force / end.sum(), 0.0)
        w = scipy.sparse.linalg.spsolve(even[free][:, free].tocsc(), load[free])
        exact = force * length**3 / 24 * (7 / d1 + 1 / d2)
        assert w[end[free]].mean() == pytest.approx(exact, rel=0.02)


def test_strip_in_cylindrical_bending():
    """Between two planes of symmetry a strip cannot curve across: w = P L³/(3 D b), no 1 − ν²."""
    length, poisson = 20.0, 0.3
    points, triangles = sheet((40, 2), (length, 1.0))
    far = points - [0.0, 1.0, 0.0]  # the far side becomes a plane of symmetry in a second matrix
    one, _ = matrices(points, triangles, poisson, (0, 1))
    two, odd = matrices(far, triangles, poisson, (1,))
    both = one + two - odd
    end, free = points[:, 0] > length - 1e-9, np.flatnonzero(points[:, 0] > 1e-9)
    load = np.where(end, 0.01 / end.sum(), 0.0)
    w = scipy.sparse.linalg.spsolve(both[free][:, free].tocsc(), load[free])
    found = w[end[free]].mean()
    assert found == pytest.approx(0.01 * length**3 / (3 * RIGIDITY), rel=0.02)


def test_half_with_symmetry_plane_is_the_whole():
    """Half the sheet under half the load bends as the whole does; without the mirror terms not."""
    half = sheet((8, 3), (4.0, 1.5))
    whole = with_mirror_image(*half)
    force = np.array([0.01, 0.02])
    in_half, fields = {}, {}
    for symmetry in ((0, 1), (0,)):
        in_half[symmetry], fields[symmetry] = bent_by_edge_load(*half, symmetry, force[0])
    in_whole, field = bent_by_edge_load(*whole, (0,), force[1])
    assert in_half[0, 1] == pytest.approx(in_whole, rel=1e-9)
    assert abs(in_half[(0,)] / in_whole - 1) > 1e-3
    assert np.ptp(field) > 0


def bent_by_edge_load(points, triangles, symmetry, force):
    """Clamped sheet with the same force on the nodes of its outer long edges: mean deflection."""
    even, _ = matrices(points, triangles, 0.3, symmetry)
    edge = np.abs(np.abs(points[:, 1]) - 1.5) < 1e-9
    free = np.flatnonzero(points[:, 0] > 1e-9)
    load = np.where(edge, force / edge.sum(), 0.0)
    w = np.zeros(len(points))
    w[free] = scipy.sparse.linalg.spsolve(even[free][:, free].tocsc(), load[free])
    return w[edge].mean(), w


def test_not_flat():
    points, triangles = sheet((3, 3), (1.0, 1.0))
    points[:, 2] = 0.01 * points[:, 0] ** 2
    with pytest.raises(ValueError, match="not flat"):
        matrices(points, triangles, 0.3)


PAPER = LAWS["linear"].of(youngs_modulus=6500.0, poissons_ratio=0.2, density=1e-20)
AXIS = np.array([1.0, 2.0, -0.5]) / np.linalg.norm([1.0, 2.0, -0.5])


def layered_block(mapping=None):
    tets = block((4, 2, 1), (4.0, 2.0, 1.0), mapping)
    law = LAWS["neo_hookean"].of(c10=0.14, bulk_modulus=10.0)
    return build(tets, law, layers=[BondedLayer("z_min", PAPER, 0.1)])


@pytest.mark.parametrize("degrees", [10.0, 90.0, 180.0])
def test_rigid_rotation_costs_nothing(degrees):
    """u = (R − I) X + c: no energy and no force, of the layer and of the whole model."""
    model = layered_block()
    state = model.initial_state()
    places = model.unknowns.spaces[0].tabulate_dof_coordinates()
    turn = rotation_about(AXIS, degrees)
    state.x[model.displacement_dofs] = places @ (turn - np.eye(3)).T + [1.0, 2.0, 3.0]
    assert model.layers[0].bending is not None
    assert abs(model.energy(state)) < 1e-11
    assert np.abs(model.force(state)[0]).max() < 1e-9


def test_energy_of_a_rolled_layer():
    """A layer rolled to a radius R has ½ D A/R² whatever way it lies: D = E t³/12 (1 − ν²)."""
    radius = 40.0
    model = layered_block()
    places = model.unknowns.spaces[0].tabulate_dof_coordinates()
    angle = places[:, 0] / radius
    rolled = places.copy()
    rolled[:, 0] = (radius - places[:, 2]) * np.sin(angle)
    rolled[:, 2] = radius - (radius - places[:, 2]) * np.cos(angle)
    turn = rotation_about(AXIS, 70.0)
    rigidity = 6500.0 * 0.1**3 / (12 * (1 - 0.2**2))
    for way in (np.eye(3), turn):
        state = State(np.zeros(model.unknowns.local))
        state.x[model.displacement_dofs] = rolled @ way.T - places
        energy = model.energy(state, [model.layers[0].bending])
        assert energy == pytest.approx(rigidity * 8.0 / radius**2 / 2, rel=0.001)


def test_curved_layer_has_no_bending_term():
    """Documented: only flat layers bend; a curved one is a membrane."""

    def bulge(points):
        return points + np.column_stack([*np.zeros((2, len(points))), 0.1 * points[:, 0] ** 2])

    assert layered_block(bulge).layers[0].bending is None
