"""A ball that slides and rolls over a dome: forces go on evenly over the edges of facets."""

import numpy as np
import pytest
from mpi4py import MPI

from softact.contact.obstacles.sphere import Sphere
from softact.contact.rigid import Obstacle
from softact.contact.surfaces import Touching
from softact.loads.load_step import LoadStep
from softact.loads.support import Turn
from softact.materials import LAWS
from softact.mesh.layout import Layout
from softact.mesh.tetrahedra import distribute
from softact.model import Model, Support
from tests.analytic.meshes import block, together
from tests.analytic.solving import build, solve

SOFT = LAWS["neo_hookean"].of(c10=0.05, bulk_modulus=5.0)
DOME, BALL, LAYER, COAT = 20.0, 10.0, 4.0, 3.0  # mm: radii, rubber on the dome and on the ball
DEPTH, WAY, STEPS, FRICTION = 0.4, 3.0, 60, 0.3
SETTLED = 16  # steps after which all points slip


def cap(cells, length, inner, outer, middle=0.0, up=True):
    """Half of a layer between two spheres about (0, 0, middle), of this length and 4 mm wide on
    the outer one: on the upper or the lower side of the spheres, outer side up or down."""
    sign = 1.0 if up else -1.0

    def places(points):
        along, across, through = (points / cells).T
        angle, beside = length * (along - 0.5) / outer, 4.0 * across / outer
        radius = inner + (outer - inner) * (through if up else 1 - through)
        z = sign * np.cos(angle) * np.cos(beside)
        arms = np.column_stack([np.sin(angle) * np.cos(beside), np.sin(beside), z])
        return radius[:, None] * arms + [0.0, 0.0, middle]

    return block(cells, tuple(map(float, cells)), places, curved=True)


def changes(forces):
    """Largest change from one step to the next of the normal force and of the tangential one, by
    their means, once all slips. forces: (n, 2)."""
    settled = forces[SETTLED:]
    return np.abs(np.diff(settled, axis=0)).max(axis=0) / np.abs(settled.mean(axis=0))


def over_the_dome(turns):
    """Normal and tangential force (n, 2) N on a rigid ball and the share of the friction that is
    used (n,), at each of the steps; turns: whether it rolls."""

    def centre(way, lower):
        arm = np.array([np.sin(way / DOME), 0.0, np.cos(way / DOME)])
        return (DOME + BALL - lower) * arm

    start = centre(-WAY / 2, 0.0)
    ball = Obstacle("ball", Sphere(tuple(start), BALL), FRICTION, surfaces=("z_max",), turns=turns)
    tets = cap((7, 2, 2), 14.0, DOME - LAYER, DOME)
    model = build(tets, SOFT, symmetry={"y_min": 1}, obstacles=[ball])

    def at(way):
        loads = {"shift": {"ball": centre(way, DEPTH) - start}}
        if turns:
            angle = np.degrees((way + WAY / 2) / DOME * (DOME + BALL) / BALL)
            loads["turn"] = {"ball": np.array([0.0, angle, 0.0, *start])}
        return loads

    ways = np.linspace(-WAY / 2, WAY / 2, 1 + STEPS)
    steps = [LoadStep("press", max_increment=0.25, **at(ways[0]))]
    steps += [LoadStep(f"to {way:g}", **at(way)) for way in ways[1:]]
    solution = solve(model, steps, [Support("z_min", dict.fromkeys(range(3), 0.0))])
    (term,) = model.contacts
    forces, used = [], []
    for way, state in zip(ways, solution.ends, strict=True):
        sine, cosine = np.sin(way / DOME), np.cos(way / DOME)
        axes = np.array([[sine, 0.0, cosine], [-cosine, 0.0, sine]])
        forces.append(-2 * axes @ model.contacts.force(term, state))
        _, rubs, might = term.rubbing(state)
        used.append(rubs / might)
    return np.array(forces), np.array(used)


def test_a_rigid_ball_slides():
    """From one step of a fortieth of an element to the next the normal force changes by less than
    1 %, and so does the friction, which all of the ball feels."""
    forces, used = over_the_dome(turns=False)
    assert forces[:, 0].min() > 0.4
    assert used[SETTLED:] == pytest.approx(1.0, abs=1e-3)
    assert forces[SETTLED:, 1] == pytest.approx(FRICTION * forces[SETTLED:, 0], rel=0.06)
    assert (changes(forces) < 0.01).all()


def test_a_rigid_ball_rolls():
    """Rolling, it feels less than half of the friction there might be, and that is as even."""
    forces, _ = over_the_dome(turns=True)
    assert changes(forces)[0] < 0.01
    assert np.abs(np.diff(forces[SETTLED:, 1])).max() < 0.01 * FRICTION * forces[:, 0].mean()
    assert (np.abs(forces[SETTLED:, 1]) < 0.5 * FRICTION * forces[SETTLED:, 0]).all()


def rubber_on_rubber():
    """Normal and tangential force (n, 2) N on a rubber-coated ball under which a rubber-coated dome
    turns; a facet of the one goes over edges of the other all the time."""
    tets = together(
        dome=cap((7, 2, 2), 14.0, DOME - LAYER, DOME),
        ball=cap((6, 2, 2), 10.0, BALL - COAT, BALL, DOME + BALL + 0.02, up=False),
    )
    names = tuple(tets.surfaces)
    sides = {"dome_y_min": 1, "ball_y_min": 1}
    ends = {"clamp": "dome_z_min", "tip": "ball_z_max"}
    layout = Layout(("dome", "ball"), names, {}, symmetry=sides, **ends)
    mesh = distribute(MPI.COMM_SELF, lambda: tets, layout)
    touching = [Touching("both", (("ball_z_min",), ("dome_z_max",)), FRICTION)]
    materials = dict.fromkeys(("dome", "ball"), SOFT.material())
    model = Model(mesh, materials, touching=touching)

    def held(way, lower):
        turn = Turn((0.0, 1.0, 0.0), np.degrees(way / DOME), (0.0, 0.0, 0.0))
        core = Support("ball_z_max", {0: 0.0, 1: 0.0, 2: -lower})
        return [Support("dome_z_min", turn=turn), core]

    ways = np.linspace(-WAY / 2, WAY / 2, 1 + STEPS)
    steps = [LoadStep("turn", supports=held(ways[0], 0.0), max_increment=0.25)]
    steps += [LoadStep("press", supports=held(ways[0], DEPTH + 0.02), max_increment=0.1)]
    steps += [LoadStep(f"to {way:g}", supports=held(way, DEPTH + 0.02)) for way in ways[1:]]
    still = [Support(n, dict.fromkeys(range(3), 0.0)) for n in ("dome_z_min", "ball_z_max")]
    solution = solve(model, steps, still)
    pushes = np.array([2 * solution.reaction("ball_z_max", state) for state in solution.ends[1:]])
    return pushes[:, [2, 0]]


def test_a_rubber_ball_slides():
    """Two curved surfaces that deform: the same."""
    forces = rubber_on_rubber()
    assert forces[:, 0].max() < -0.2
    assert forces[SETTLED:, 1] == pytest.approx(FRICTION * forces[SETTLED:, 0], rel=0.03)
    assert (changes(forces) < 0.01).all()
