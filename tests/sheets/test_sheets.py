"""Sheets against exact solutions: plates, tension fields, tubes of fibres, bonded layers."""

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI

from softact.bodies.layer import BondedLayer
from softact.bodies.sheet import Ply, Sheet
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.sheets import SheetMesh
from softact.mesh.tetrahedra import distribute
from softact.model import Model, Support
from softact.solve.newton import Newton
from tests.analytic.meshes import block
from tests.analytic.sheet_meshes import build, edges_of, grid, quarter_disc, rectangle
from tests.analytic.solving import build as build_solid
from tests.analytic.solving import solve

E, NU, T = 498.0, 0.35, 0.2
NYLON = LAWS["linear"].of(youngs_modulus=E, poissons_ratio=NU)
D = E * T**3 / (12 * (1 - NU**2))


def test_square_plate_under_its_weight():
    """Simply supported: w = 0.00406235 q a⁴/D (Timoshenko and Woinowsky-Krieger, art. 30)."""
    a, g = 40.0, 1e3
    mesh = rectangle((8, 8), (a / 2, a / 2))
    model = build(mesh, Sheet([Ply(NYLON, T)]), symmetry={"x_min": 0, "y_min": 1})
    edges = [Support(name, {2: 0.0}) for name in ("x_max", "y_max")]
    solution = solve(model, LoadStep("weight", gravity=(0, 0, -g)), edges)
    q = NYLON.density * T * g
    assert -solution.displacement((0, 0, 0))[2] == pytest.approx(
        0.00406235 * q * a**4 / D, rel=0.02
    )


def test_elastica():
    """A cantilever under the tip load P = 2 EI/L²: the tip falls by 0.4935 L and comes back by
    0.1606 L (Mattiasson, IJNME 17 (1981) 145)."""
    length, width = 20.0, 2.0
    law = LAWS["linear"].of(youngs_modulus=E, poissons_ratio=0.0)
    model = build(rectangle((10, 1), (length, width)), Sheet([Ply(law, T)]), symmetry={"x_min": 0})
    load = 2 * E * T**3 / 12 / length**2  # per width
    step = LoadStep("tip", traction={"x_max": (0.0, 0.0, load)})
    solution = solve(model, step, [Support("x_min", {1: 0.0, 2: 0.0})], increment=0.2)
    u = solution.displacement((length, 0, 0))
    assert u[2] / length == pytest.approx(0.4935, rel=0.01)
    assert -u[0] / length == pytest.approx(0.1606, rel=0.02)


def test_wrinkled_strip_in_shear():
    """Wagner's tension field: uniaxial tension at 45°, and the shear stress E γ/4 in place of
    G γ, where G/(E/4) = 2/(1 + ν)."""
    length, height, gamma = 60.0, 6.0, 0.002
    stresses = {}
    for relaxed in (True, False):
        sheet = Sheet([Ply(NYLON, T)], tension_field=relaxed, bending=0.0)
        model = build(rectangle((30, 6), (length, height)), sheet)
        supports = [
            Support("y_min", {0: 0.0, 1: 0.0, 2: 0.0}),
            Support("y_max", {0: gamma * height, 1: 0.0, 2: 0.0}),
            Support("sheet", {2: 0.0}),
        ]
        state = model.initial_state()
        newton = Newton(model, 1e-8, 30)
        newton.set_supports(supports, state)
        places = model.nodes.places
        state.x[model.nodes.dofs[:, 0]] = gamma * places[:, 1]
        assert newton.solve(state, newton.held(state).end).converged
        part = model.sheets["sheet"]
        x = part.triangles.places.mean(axis=1)[:, 0]
        middle = np.abs(x - length / 2) < 5.0
        stresses[relaxed] = part.membrane.cauchy(state.x)[middle].mean(axis=(0, 1))
    sigma = stresses[True]
    values, vectors = np.linalg.eigh(sigma[:2, :2])
    angle = np.degrees(np.arctan2(*np.abs(vectors[::-1, 1])))
    assert angle == pytest.approx(45.0, abs=0.5)
    assert abs(values[0]) < 1e-3 * values[1]
    assert sigma[0, 1] == pytest.approx(E * gamma / 4, rel=0.01)
    shear = E / (2 * (1 + NU))
    assert stresses[False][0, 1] == pytest.approx(shear * gamma, rel=0.01)


def closed_tube(radius, length, n=2, m=4) -> SheetMesh:
    """An eighth of a tube along x with a flat end: x, y and z ≥ 0."""

    cap = quarter_disc(n, radius)
    rim = cap.points[np.unique(cap.curves["rim"])]
    angles = np.sort(np.arctan2(rim[:, 1], rim[:, 0]))

    def place(s):
        angle = angles[np.rint(s[:, 1] * 2 * n).astype(int)]
        return np.column_stack([s[:, 0] * length, radius * np.cos(angle), radius * np.sin(angle)])

    wall, triangles, ends = grid((m, 2 * n), place)
    lid = np.column_stack([np.full(len(cap.points), length), cap.points[:, :2]])
    points = np.vstack([wall, lid])
    merged = np.unique(np.round(points, 8) + 0.0, axis=0, return_index=True, return_inverse=True)
    first, inverse = merged[1], merged[2].ravel()
    both = inverse[np.vstack([triangles[:, [0, 2, 1]], cap.triangles + len(wall)])]
    parts = {"wall": np.arange(len(triangles)), "cap": np.arange(len(triangles), len(both))}
    curves = {
        "x_0": inverse[edges_of(ends[0])],
        "z_0": np.vstack([inverse[edges_of(ends[2])], inverse[cap.curves["y_0"] + len(wall)]]),
        "y_0": np.vstack([inverse[edges_of(ends[3])], inverse[cap.curves["x_0"] + len(wall)]]),
    }
    return SheetMesh(points[first], both, parts, curves)


def stretches(angle, pressure) -> tuple[float, float]:
    """Axial and circumferential stretch of a closed tube of two stiff fibre families."""
    radius, length = 10.0, 40.0
    knit = LAWS["holzapfel"].of(c10=0.5, k1=100.0, angle=angle, bulk_modulus=50.0)
    sheets = {
        "wall": Sheet([Ply(knit, T)], bending=0.0),
        "cap": Sheet([Ply(LAWS["linear"].of(youngs_modulus=2e4, poissons_ratio=0.3), T)]),
    }
    mesh = closed_tube(radius, length)
    symmetry = {"x_0": 0, "y_0": 1, "z_0": 2}
    model = build(mesh, sheets, cavities={"air": ("wall", "cap")}, symmetry=symmetry)
    solution = solve(model, LoadStep("inflate", pressure={"air": pressure}), [], increment=0.5)
    wall = model.sheets["wall"]
    c = wall.membrane.metric(solution.state.x).reshape(*wall.membrane.weights.shape, 2, 2)
    x = wall.triangles.places.mean(axis=1)[:, 0]
    squares = np.diagonal(c, axis1=2, axis2=3)
    lengths = np.sqrt(squares)[x < length / 4].mean(axis=(0, 1))
    return lengths[0], lengths[1]


def test_fibres_at_the_neutral_angle():
    """tan² = 2, 54.7°: a closed tube of inextensible fibres neither lengthens nor shortens. At
    45° it shortens and widens, and the fibres keep their length."""
    neutral = np.degrees(np.arctan(np.sqrt(2)))
    # The fibres themselves give by p r/t over their modulus of about 4 k1: 0.4 %.
    assert stretches(neutral, 0.02) == pytest.approx((1.0, 1.0), abs=8e-3)
    axial, around = stretches(45.0, 0.02)
    assert axial < 0.95 and around > 1.05
    assert (axial**2 + around**2) / 2 == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("relaxed", [False, True])
def test_bonded_sheet_and_facet_layer(relaxed):
    """Paper on the base of a block that is bent: as a sheet or as a facet layer, the same."""
    law = LAWS["yeoh"].of(c10=0.11, c20=0.02, bulk_modulus=10.0)
    paper = LAWS["linear"].of(youngs_modulus=65.0, poissons_ratio=0.2)
    tets = block((4, 1, 1), (8.0, 2.0, 2.0))
    supports = [
        Support("x_min", {0: 0.0, 1: 0.0, 2: 0.0}),
        Support("x_max", {2: -1.0 + 2 * relaxed}),
    ]
    step = LoadStep("bend", supports=supports)
    start = [Support("x_min", {0: 0.0, 1: 0.0, 2: 0.0})]
    layered = build_solid(tets, law, layers=[BondedLayer("z_min", paper, 0.1)])
    mesh = distribute(MPI.COMM_SELF, lambda: tets, layered.mesh.layout)
    triangles = tets.surfaces["z_min"]
    used, triangles = np.unique(triangles, return_inverse=True)
    sheet = SheetMesh(
        tets.points[used],
        triangles.reshape(-1, 3),
        {"paper": np.arange(len(tets.surfaces["z_min"]))},
        {},
        bonded=("paper",),
    )
    bonded = Model(
        replace(mesh, sheets=sheet),
        {"body": law.material()},
        sheets={"paper": Sheet([Ply(paper, 0.1)])},
    )
    assert bonded.unknowns.local == layered.unknowns.local
    one = solve(layered, step, start, increment=0.5)
    two = solve(bonded, step, start, increment=0.5)
    np.testing.assert_allclose(
        two.displacement((8, 0, 2)), one.displacement((8, 0, 2)), rtol=1e-6, atol=1e-8
    )
    np.testing.assert_allclose(two.reaction("x_max"), one.reaction("x_max"), rtol=1e-4, atol=1e-8)
    bare = solve(build_solid(tets, law), step, start, increment=0.5)
    assert abs(bare.reaction("x_max")[2]) < 0.9 * abs(one.reaction("x_max")[2])
