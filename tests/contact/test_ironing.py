"""Ironing: a stiff die with a round underside is pressed into a slab and drawn along it."""

from dataclasses import replace

import numpy as np
import pytest
from mpi4py import MPI

from softact.contact.surfaces import Touching
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.curves import Curves
from softact.mesh.layout import Layout
from softact.mesh.msh_file import Tetrahedra
from softact.mesh.tetrahedra import distribute
from softact.model import Model, Support
from tests.analytic.meshes import block, together, with_image
from tests.analytic.solving import Solution, solve

LENGTH, HEIGHT, GAP = 12.0, 4.0, 0.2  # mm, of the slab; the die begins above it
WIDTH, RADIUS, TALL, CORNER = 1.2, 0.75, 1.2, 0.2  # mm, of the die
FRICTION = 0.3


def neo_hooke(modulus: float, poisson: float = 0.32):
    """Of Young's modulus (MPa) and Poisson's ratio."""
    bulk = modulus / 3 / (1 - 2 * poisson)
    return LAWS["neo_hookean"].of(c10=modulus / 4 / (1 + poisson), bulk_modulus=bulk).material()


MATERIALS = {"slab": neo_hooke(689.6), "die": neo_hooke(6896.0)}


def slab(size: float, start: float, end: float) -> Tetrahedra:
    """Elements of this size where the die is pressed, and larger ones away from it."""
    fine = np.linspace(start, end, 1 + round((end - start) / size))

    def outwards(room):
        lines, step = [], size
        while sum(lines) < room:
            step *= 1.6
            lines.append(step)
        return np.cumsum(lines) * room / sum(lines) if lines else np.empty(0)

    x = np.concatenate([start - outwards(start)[::-1], fine, end + outwards(LENGTH - end)])
    down = np.concatenate([[0, size], size + outwards(HEIGHT - size)])
    z = HEIGHT - down[::-1]

    def places(points):
        along = np.interp(points[:, 0], np.arange(len(x)), x)
        up = np.interp(points[:, 2], np.arange(len(z)), z)
        return np.column_stack([along, points[:, 1], up])

    cells = len(x) - 1, 1, len(z) - 1
    return block(cells, (cells[0], size, cells[2]), places)


def underside(along: np.ndarray, arc: int) -> np.ndarray:
    """Points (n, 2) of the left half of the die's underside, x and z from its lowest point: from
    the side (0) over the rounded corner to the arc (1), and along that (1 + arc)."""
    across = WIDTH / 2 - CORNER  # of the corner's centre; it touches the arc and the side
    turn = np.arcsin(across / (RADIUS - CORNER))
    middle = -across, RADIUS - (RADIUS - CORNER) * np.cos(turn)
    angle = np.interp(along, [0, 1, 1 + arc], [np.pi / 2, turn, 0.0])
    radius = np.where(along < 1, CORNER, RADIUS)
    x, z = (np.where(along < 1, one, rest) for one, rest in zip(middle, (0.0, RADIUS), strict=True))
    return np.column_stack([x - radius * np.sin(angle), z - radius * np.cos(angle)])


def die(arc: int, size: float) -> Tetrahedra:
    """With so many elements along each half of the arc, and one around each corner; thick as the
    slab's elements. It begins 0.2 mm from the slab's end."""

    def places(points):
        low = underside(points[:, 0], arc)
        top = np.column_stack(
            [np.interp(points[:, 0], [0, 1 + arc], [-WIDTH / 2, 0.0]), 0 * low[:, 0] + TALL]
        )
        x, z = ((1 - points[:, 2:]) * low + points[:, 2:] * top).T
        return np.column_stack([x, points[:, 1], z])

    cells = 1 + arc, 1, 1 + arc
    half = block(cells, (1.0 + arc, size, 1.0), places, curved=True)
    whole = with_image(half)
    place = np.array([0.2 + WIDTH / 2, 0.0, HEIGHT + GAP])
    curves = Curves(whole.curves.edges, whole.curves.places + place)
    return replace(whole, points=whole.points + place, curves=curves)


def iron(size: float, arc: int, way: int, increment: float = 0.05, **settings) -> Solution:
    """The die is pressed down by 1 mm and drawn by ``way`` mm. size, arc: see ``slab``, ``die``."""
    tets = together(slab=slab(size, 0.0, 2.2 + way), die=die(arc, size))
    names = tuple(tets.surfaces)
    layout = Layout(("slab", "die"), names, {}, clamp="slab_z_min", tip="die_z_max")
    mesh = distribute(MPI.COMM_SELF, lambda: tets, layout)
    groups = ("die_z_min", "die_x_min", "die_x_max"), ("slab_z_max",)
    model = Model(mesh, MATERIALS, (), "P2", touching=[Touching("iron", groups, FRICTION)])
    plane = [Support(name, {1: 0.0}) for name in names if "_y_" in name]
    held = [*plane, Support("slab_z_min", {0: 0.0, 2: 0.0})]

    def top(x, z):
        return [*held, Support("die_z_max", {0: x, 2: z})]

    steps = [LoadStep("press", supports=top(0.0, -1.0))]
    steps += [LoadStep(f"to {x} mm", supports=top(float(x), -1.0)) for x in range(1, 1 + way)]
    return solve(model, steps, top(0.0, 0.0), increment, **settings)


# Vertical and horizontal force (N per mm of width) at the end of the press, and when the die was
# drawn by 0.5 and by 1 mm: curves of Fischer and Wriggers, Comput. Methods Appl. Mech. Eng. 195
# (2006) 5020; Hartmann et al., 198 (2009) 2607; Yastrebov, thesis, Mines ParisTech, 2011; Poulios
# and Renard, Comput. Struct. 153 (2015) 75; Code_Aster, V6.03.153 (SSNP153), 2020. The authors of
# the case shallowIroning of solids4foam/solid-benchmarks (732f74c) read them off the printed
# figures, all but Yastrebov's, who gave his numbers. The last is a mean over 0.4 mm.
PRESSED, HALF, DRAWN = range(3)
PUBLISHED = {
    "Fischer and Wriggers": ((297.9, 62.1), (342.4, 143.3), (363.1, 173.7)),
    "Hartmann": ((319.5, 67.2), (372.1, 143.4), (394.0, 147.7)),
    "Yastrebov": ((289.7, 58.5), (326.6, 143.5), (351.8, 168.2)),
    "Poulios and Renard": ((267.9, 55.3), (307.9, 102.4), (323.2, 99.4)),
    "Code_Aster": ((332.0, 71.0), (384.3, 139.3), (404.1, 137.5)),
}


@pytest.fixture(scope="module")
def curve():
    """Way down, way along (mm), vertical and horizontal force (N/mm) of all states (n, 4)."""
    size = 0.2
    solution = iron(size, 4, 1)
    dofs = solution.model.displacement_dofs[solution.model.surfaces.nodes("die_z_max")[0]]
    rows = []
    for state in solution.path:
        x, _, z = state.x[dofs]
        along, _, up = solution.reaction("die_z_max", state) / size
        rows.append((-z, x, -up, along))
    return np.array(rows)


def at(curve, along):
    """Vertical and horizontal force where the die was drawn by so much."""
    drawn = curve[curve[:, 0] > 1 - 1e-9]
    return np.array([np.interp(along, drawn[:, 1], force) for force in drawn[:, 2:].T])


def test_shallow_ironing_against_published_curves(curve):
    """Plane strain, a die ten times as stiff as the slab, μ = 0.3. Published curves are up to a
    fifth apart: forces are among them, and the vertical one within 5 % of Hartmann's all along."""
    published = np.array(list(PUBLISHED.values()))
    for when, along in ((PRESSED, 0.0), (HALF, 0.5), (DRAWN, 1.0)):
        vertical, horizontal = at(curve, along)
        assert vertical == pytest.approx(PUBLISHED["Hartmann"][when][0], rel=0.05)
        for force, column in ((vertical, 0), (horizontal, 1)):
            assert published[:, when, column].min() < force < published[:, when, column].max()
    # Their ratio while it is pressed, which all publish alike: 0.202 to 0.214.
    vertical, horizontal = at(curve, 0.0)
    assert horizontal / vertical == pytest.approx(0.208, rel=0.05)


def test_ironing_is_smooth(curve):
    """From one state to the next, 0.05 mm at most or a quarter of an element."""
    drawn = curve[curve[:, 1] > 0.0]
    assert len(drawn) > 19
    assert np.abs(np.diff(drawn[:, 2])).max() < 0.02 * drawn[:, 2].mean()
