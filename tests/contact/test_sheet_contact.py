"""Contact of sheets with obstacles, with each other and with solids: exact solutions."""

import numpy as np
import pytest

from softact.bodies.sheet import Ply, Sheet
from softact.contact.obstacles.plane import Plane
from softact.contact.rigid import Obstacle
from softact.contact.surfaces import Touching
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.sheets import SheetMesh
from softact.model import Support
from tests.analytic.differences import (
    assert_contact_tangent,
    force,
)
from tests.analytic.sheet_meshes import build, edges_of, grid
from tests.analytic.solving import solve

E, NU, T = 498.0, 0.35, 0.2
NYLON = LAWS["linear"].of(youngs_modulus=E, poissons_ratio=NU)
FABRIC = Sheet([Ply(NYLON, T)], tension_field=True, bending=0.0)
LENGTH, WIDTH, HEIGHT, PRESSURE = 40.0, 2.5, 12.0, 0.05
UP, DOWN = (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)


def flat_width(height: float, pressure: float = PRESSURE) -> float:
    """Width along which a long pouch of two sheets of LENGTH lies on each of two plates that are
    ``height`` apart: between them it closes in half circles, so that 2 b + π h is its girth, longer
    by the strain under the tension p h/2 (plane strain)."""
    strain = pressure * height / 2 * (1 - NU**2) / (E * T)
    return (2 * LENGTH * (1 + strain) - np.pi * height) / 2


def pouches(heights, half=False, counts=(8, 1)) -> SheetMesh:
    """Long flat pouches over each other at the heights z, x from their middle to their seam; with
    ``half`` only the upper sheet of each. The names: top_0, bottom_0, top_1, ..."""
    points, triangles, parts, curves = [], [], {}, {}
    count = number = 0
    for k, z in enumerate(heights):
        names = [f"top_{k}"] if half else [f"top_{k}", f"bottom_{k}"]
        for name in names:

            def place(s, z=z):
                return np.column_stack([s * [LENGTH / 2, WIDTH], np.full(len(s), z)])

            own, elements, ends = grid(counts, place)
            if name.startswith("bottom"):
                elements = elements[:, [0, 2, 1]]
            parts[name] = number + np.arange(len(elements))
            for curve, row in zip(("middle", "seam", "y_0", "y_1"), ends, strict=True):
                curves.setdefault(curve, []).append(edges_of(row) + count)
            points.append(own)
            triangles.append(elements + count)
            count, number = count + len(own), number + len(elements)
    points, curves = np.vstack(points), {n: np.vstack(rows) for n, rows in curves.items()}
    # The seam joins the two sheets of a pouch, which lie on each other.
    at_seam = points[:, 0] > LENGTH / 2 - 1e-9
    key = np.where(at_seam, np.unique(points, axis=0, return_inverse=True)[1].ravel(), -1)
    same = np.arange(len(points))
    for value in np.unique(key[at_seam]):
        same[key == value] = np.flatnonzero(key == value)[0]
    used, renumbered = np.unique(same, return_inverse=True)
    curves = {name: renumbered[edges] for name, edges in curves.items()}
    return SheetMesh(points[used], renumbered[np.vstack(triangles)], parts, curves)


def between_plates(height=HEIGHT, friction=0.0):
    """A quarter of a long pouch below a plate at z = h/2."""
    plate = Obstacle("plate", Plane((0.0, 0.0, height / 2), DOWN), friction)
    return build(
        pouches([0.0], half=True),
        FABRIC,
        cavities={"air": ("top_0",)},
        symmetry={"middle": 0, "y_0": 1, "seam": 2},
        flux=(0.0, 0.0, 1.0),
        obstacles=[plate],
    )


SIDE = Support("y_1", {1: 0.0})


def test_a_pouch_between_plates():
    """Inflated from flat: it presses on each plate with p b. Then the plates come nearer and go
    back, and give back the work that went into strain, contact and the air at constant pressure."""
    model = between_plates()
    steps = [
        LoadStep("inflate", pressure={"air": PRESSURE}),
        LoadStep("press", shift={"plate": (0.0, 0.0, -2.0)}),
        LoadStep("release", shift={"plate": (0.0, 0.0, 0.0)}),
    ]
    solution = solve(model, steps, [SIDE], 0.25)
    (plate,) = model.contacts
    for state, height in zip(solution.ends, (HEIGHT, HEIGHT - 4, HEIGHT), strict=True):
        found = -2 * model.contacts.force(plate, state)[2] / WIDTH
        assert found == pytest.approx(PRESSURE * flat_width(height), rel=0.01)
        assert 0 < -model.contacts.smallest_gap(plate, state)[1] < 0.02
        x = model.nodes.places + state.x[model.nodes.dofs]
        assert x[:, 2].max() == pytest.approx(height / 2, rel=0.01)
    inflated, pressed, released = map(model.energy, solution.ends)
    assert released == pytest.approx(inflated, rel=1e-6)
    work = np.trapezoid if hasattr(np, "trapezoid") else np.trapz
    way = [s for s in solution.path if s["pressure"].get("air") == PRESSURE]
    place = [s["shift"]["plate"][2] for s in way]
    push = [model.contacts.force(plate, s)[2] for s in way]
    lowest = int(np.argmin(place)) + 1
    done = float(work(push[:lowest], place[:lowest]))
    assert done == pytest.approx(pressed - inflated, rel=0.01)


def test_two_pouches():
    """Two flat pouches over each other between plates: both press with p b on the plates and on
    each other, and each is the other's mirror image. The sheets of one do not feel each other."""
    middle = 0.25
    floor = Obstacle("floor", Plane((0.0, 0.0, middle - HEIGHT), UP))
    roof = Obstacle("roof", Plane((0.0, 0.0, middle + HEIGHT), DOWN))
    mesh = pouches([0.0, 2 * middle], counts=(6, 1))
    model = build(
        mesh,
        Sheet([Ply(NYLON, T)], bending=0.0),  # all taut
        cavities={f"air_{k}": (f"top_{k}", f"bottom_{k}") for k in (0, 1)},
        symmetry={"middle": 0, "y_0": 1},
        flux=(0.0, 0.0, 1.0),
        obstacles=[floor, roof],
        touching=[Touching("pouches", (tuple(mesh.parts),))],
    )
    step = LoadStep("inflate", pressure={"air_0": PRESSURE, "air_1": PRESSURE})
    solution = solve(model, step, [SIDE], 0.25)
    state, (below, above, pair) = solution.state, model.contacts
    expected = PRESSURE * flat_width(HEIGHT)
    for contact, sign in ((below, 1), (above, -1)):
        found = sign * 2 * model.contacts.force(contact, state)[2] / WIDTH
        assert found == pytest.approx(expected, rel=0.01)
    forces = force(model, pair, state)[model.displacement_dofs]
    lower = model.nodes.places[:, 2] < middle
    push = 2 * forces[lower].sum(axis=0) / WIDTH
    np.testing.assert_allclose(forces.sum(axis=0), 0, atol=1e-12)
    assert push[2] == pytest.approx(expected, rel=0.01)
    for contact in model.contacts:
        assert 0 < -model.contacts.smallest_gap(contact, state)[1] < 0.02
    x = model.nodes.places + state.x[model.nodes.dofs]
    mirrored = x[lower] * [1, 1, -1] + [0, 0, 2 * middle]
    apart = np.linalg.norm(mirrored[:, None] - x[~lower], axis=2).min(axis=1)
    assert apart.max() < 1e-3 * HEIGHT


def crushed(friction, element="P2"):
    """Two pouches in a random state that presses them into a plate and each other, and what they
    remember of an earlier one."""
    gap = 0.05
    mesh = pouches([0.0, gap], counts=(6, 1))
    plate = Obstacle("plate", Plane((10.0, 1.0, 0.03), (0.002, 0.003, -1.0)), friction)
    model = build(
        mesh,
        FABRIC,
        symmetry={"middle": 0},
        element=element,
        obstacles=[plate],
        touching=[Touching("pouches", (tuple(mesh.parts),), friction)],
    )
    rng = np.random.default_rng(4)
    state = model.initial_state()
    places = model.nodes.places
    model.contacts.remember(state)
    state.x = 0.01 * rng.standard_normal(model.unknowns.local)
    state.x[model.nodes.dofs[:, 2]] += np.where(places[:, 2] < gap / 2, 0.04, -0.04)
    model.contacts.remember(state)
    state.x = state.x + 0.004 * rng.standard_normal(model.unknowns.local)
    return model, state


@pytest.mark.parametrize("element", ["P2", "P1"])
@pytest.mark.parametrize("friction", [0.0, 0.4])
@pytest.mark.parametrize("number", [0, 1])
def test_tangent(number, friction, element):
    """Force against energy, tangent against force, by central differences."""
    model, state = crushed(friction, element)
    term = list(model.contacts)[number]
    assert_contact_tangent(model, term, state, friction, least=1.0, off=1e-3)
