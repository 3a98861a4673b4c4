"""Friction of sheets with obstacles, with each other and with solids: exact solutions."""

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI

from softact.bodies.sheet import Ply, Sheet
from softact.contact.obstacles.cylinder import Cylinder
from softact.contact.obstacles.plane import Plane
from softact.contact.rigid import Obstacle
from softact.contact.surfaces import Touching
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.sheets import SheetMesh
from softact.mesh.tetrahedra import distribute
from softact.model import Model, Support
from tests.analytic.meshes import block
from tests.analytic.sheet_meshes import build, edges_of, grid, rectangle
from tests.analytic.solving import build as build_solid
from tests.analytic.solving import solve

NYLON = LAWS["linear"].of(youngs_modulus=498.0, poissons_ratio=0.35)
SOFT = LAWS["neo_hookean"].of(c10=0.05, bulk_modulus=50.0)
FABRIC = Sheet([Ply(NYLON, 0.2)], bending=0.0)
SIZE = (12.0, 2.0)
BESIDE = np.array([1.3, 0.9, 0.002])  # where a strip lies over a larger body


@pytest.mark.parametrize("coefficient", [0.2, 0.6])
def test_strip_dragged_over_a_plane(coefficient):
    """Under a dead load q it resists with μ q A; it begins pressed in a little, as nothing else
    holds it across."""
    load, start = 0.01, 1e-4
    floor = Obstacle("floor", Plane((0.0, 0.0, start), (0.0, 0.0, 1.0)), coefficient)
    model = build(rectangle((6, 1), SIZE), FABRIC, obstacles=[floor])
    still = Support("x_max", {0: 0.0, 1: 0.0})
    press = LoadStep("press", traction={"sheet": (0.0, 0.0, -load)})
    drag = LoadStep("drag", supports=[Support("x_max", {0: 1.0, 1: 0.0})])
    solution = solve(model, [press, drag], [still], 0.25)
    (contact,) = model.contacts
    push = model.contacts.force(contact, solution.state)
    area = SIZE[0] * SIZE[1]
    np.testing.assert_allclose(push, [-coefficient * load * area, 0, load * area], atol=1e-5)
    assert solution.reaction("x_max")[0] == pytest.approx(coefficient * load * area, rel=1e-5)
    assert 0 < -model.contacts.smallest_gap(contact, solution.state)[1] < 0.02


def belt(radius, straight, cells):
    """A strip over a quarter of a cylinder about y, with straight ends along its tangents; its
    nodes are 0.01 mm above it, and the middles of its sides a little below."""
    arc = radius * np.pi / 2
    total = arc + 2 * straight
    share = np.concatenate([[0], straight + arc * np.arange(cells + 1) / cells, [total]]) / total

    def place(s):
        along = share[np.rint(s[:, 0] * (len(share) - 1)).astype(int)] * total - straight
        angle = np.clip(along, 0, arc) / radius
        x = (radius + 0.01) * np.cos(angle) - np.maximum(along - arc, 0)
        z = (radius + 0.01) * np.sin(angle) + np.minimum(along, 0)
        return np.column_stack([x, s[:, 1], z])

    points, triangles, ends = grid((len(share) - 1, 1), place)
    curves = {"pulled": edges_of(ends[0]), "held": edges_of(ends[1])}
    return SheetMesh(points, triangles, {"sheet": np.arange(len(triangles))}, curves)


def test_belt_around_a_post():
    """Euler and Eytelwein: pulled over a quarter of a post, T₂ = T₁ e^(μ π/2)."""
    coefficient, tension, radius = 0.3, 0.5, 10.0
    post = Obstacle("post", Cylinder((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), radius), coefficient)
    model = build(belt(radius, 3.0, 12), FABRIC, obstacles=[post])
    across = Support("sheet", {1: 0.0})
    tight = LoadStep("tighten", traction={"held": (-tension, 0.0, 0.0)})
    pull = LoadStep("pull", supports=[across, Support("pulled", {0: 0.0, 2: -0.5})])
    still = [across, Support("pulled", {0: 0.0, 2: 0.0})]
    solution = solve(model, [tight, pull], still, 0.25)
    loose, pulled = (-solution.reaction("pulled", state)[2] for state in solution.ends)
    assert pulled == pytest.approx(tension * np.exp(coefficient * np.pi / 2), rel=0.01)
    # While it is tightened it slides the other way.
    assert loose == pytest.approx(tension * np.exp(-coefficient * np.pi / 2), rel=0.01)


def strip_over_sheet(coefficient):
    """A short strip, its outer side down, 0.002 mm over a longer sheet that looks up."""
    lower, upper = rectangle((7, 2), (16.0, 4.0)), rectangle((4, 1), (8.0, 2.0))
    count = len(lower.points)
    points = np.vstack([lower.points, upper.points + BESIDE])
    triangles = np.vstack([lower.triangles, upper.triangles[:, [0, 2, 1]] + count])
    first = len(lower.triangles)
    parts = {"lower": np.arange(first), "upper": np.arange(first, len(triangles))}
    mesh = SheetMesh(points, triangles, parts, {})
    touching = Touching("pair", (("lower",), ("upper",)), coefficient)
    return build(mesh, FABRIC, touching=[touching]), Support("lower", dict.fromkeys(range(3), 0.0))


def strip_over_block(coefficient):
    """The same strip over a block of rubber."""
    tets = block((4, 1, 1), (12.0, 4.0, 2.0))
    whole = build_solid(tets, SOFT).mesh.layout
    upper = rectangle((4, 1), (8.0, 2.0))
    sheet = SheetMesh(
        upper.points + BESIDE + np.array([0.0, 0.0, 2.0]),
        upper.triangles[:, [0, 2, 1]],
        {"upper": upper.parts["sheet"]},
        {},
    )
    mesh = replace(distribute(MPI.COMM_SELF, lambda: tets, whole), sheets=sheet)
    touching = Touching("pair", (("z_max",), ("upper",)), coefficient)
    model = Model(mesh, {"body": SOFT.material()}, sheets={"upper": FABRIC}, touching=[touching])
    return model, Support("z_min", dict.fromkeys(range(3), 0.0))


@pytest.mark.parametrize("over", [strip_over_sheet, strip_over_block])
def test_strip_dragged_over_a_body(over):
    """Pressed down by 0.01 mm (by 0.1 mm into rubber) and dragged by more than an element, it
    resists with μ times the pressing force (rubber rises before it); both forces come back from the
    body below. The last bit is short: what the strip newly covers has no friction yet."""
    model, hold = over(0.3)
    down, exact = (-0.01, 2e-3) if over is strip_over_sheet else (-0.1, 0.03)

    def at(x, z):
        return [hold, Support("upper", {1: 0.0, 2: z}), Support("end", {0: x})]

    model.surfaces.curves["end"] = ends_of(model)
    ends = {"press": 0.0, "drag": 2.5, "on": 2.52}
    steps = [LoadStep(name, supports=at(x, down)) for name, x in ends.items()]
    solution = solve(model, steps, at(0.0, 0.0), 0.25)
    across, along = solution.reaction("upper")[2], solution.reaction("end")[0]
    assert -across > 0.05
    assert along == pytest.approx(0.3 * -across, rel=exact)
    (pair,) = model.contacts
    below = solution.reaction(hold.surface)
    np.testing.assert_allclose(below[[0, 2]], [-along, -across], rtol=1e-3)
    assert 0 < -model.contacts.smallest_gap(pair, solution.state)[1] < 0.02


def ends_of(model) -> np.ndarray:
    """Nodes (k, 1) of the strip's end of the largest x."""
    nodes = np.unique(model.sheets["upper"].triangles.nodes)
    x = model.nodes.places[nodes, 0]
    return nodes[x > x.max() - 1e-9][:, None]
