"""An inflated cantilever of fabric that wrinkles and collapses: Comer and Levy, AIAA J. 1 (1963)
1652, after Stein and Hedgepeth, NASA TN D-813 (1961)."""

import numpy as np
import pytest
from scipy.optimize import brentq

from softact.bodies.sheet import Ply, Sheet
from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.mesh.sheets import SheetMesh
from softact.model import Support
from tests.analytic.sheet_meshes import build, edges_of, grid, quarter_disc
from tests.analytic.solving import solve

E, T, R, LENGTH, PRESSURE = 498.0, 0.2, 10.0, 80.0, 0.05
FABRIC = LAWS["linear"].of(youngs_modulus=E, poissons_ratio=0.0)
PLATE = LAWS["linear"].of(youngs_modulus=1e4, poissons_ratio=0.3)
COLLAPSE = np.pi * PRESSURE * R**3


def half_tube(n=3, m=8) -> SheetMesh:
    """The half y ≥ 0 of a tube along x with a plate at x = LENGTH; rows closer towards x = 0."""
    quarter = quarter_disc(n, R)
    points, upper = quarter.points, quarter.triangles  # x of the disc is z here, y is y
    rim = points[np.unique(quarter.curves["rim"])]
    angles = np.sort(np.arctan2(rim[:, 1], rim[:, 0]))
    angles = np.append(angles, np.pi - angles[-2::-1])  # from the top to the bottom

    def place(s):
        angle = angles[np.rint(s[:, 1] * (len(angles) - 1)).astype(int)]
        x = LENGTH * s[:, 0] ** 1.5
        return np.column_stack([x, R * np.sin(angle), R * np.cos(angle)])

    wall, triangles, ends = grid((m, len(angles) - 1), place)
    plates, numbers, count = [], [], len(wall)
    for sign in (1, -1):
        plates.append(
            np.column_stack([np.full(len(points), LENGTH), points[:, 1], sign * points[:, 0]])
        )
        numbers.append((upper[:, [0, 2, 1]] if sign == 1 else upper) + count)
        count += len(points)
    everything = np.vstack([wall, *plates])
    _, first, inverse = np.unique(
        np.round(everything, 8) + 0.0, axis=0, return_index=True, return_inverse=True
    )
    inverse = inverse.ravel()
    both = inverse[np.vstack([triangles, *numbers])]
    z_0 = inverse[quarter.curves["x_0"] + len(wall)]  # of the plate, where z = 0
    sides = np.vstack([edges_of(ends[2]), edges_of(ends[3])])
    flat = [quarter.curves["y_0"] + len(wall) + k * len(points) for k in (0, 1)]
    parts = {"wall": np.arange(len(triangles)), "cap": np.arange(len(triangles), len(both))}
    curves = {
        "root": inverse[edges_of(ends[0])],
        "middle": inverse[np.vstack([sides, *flat])],
        "tip": z_0,
    }
    return SheetMesh(everything[first], both, parts, curves)


def curvature(moment: float) -> float:
    """Of a section under a moment by the collapse moment, 1/mm. Where it is wrinkled over the angle
    2 θ on the side of the compression, the rest carries π p r² at the tube's axis."""
    if moment <= 0.5:
        return moment * COLLAPSE / (np.pi * E * T * R**3)

    def taut(theta):
        return np.sin(theta) + (np.pi - theta) * np.cos(theta)

    def miss(theta):
        return (2 * np.pi - 2 * theta + np.sin(2 * theta)) / (4 * taut(theta)) - moment

    return PRESSURE / (2 * E * T) * np.pi / taut(brentq(miss, 0.0, 0.97 * np.pi))


def deflection(moment: float) -> float:
    """Of the tip, mm, under the moment at the root by the collapse moment: bending and shear."""
    share = np.linspace(0.0, 1.0, 2001)
    bent = LENGTH**2 * np.mean([curvature(moment * s) * s for s in share])
    return bent + moment * COLLAPSE / (E / 2 * np.pi * R * T)


def test_wrinkling_and_collapse():
    """Closed, so that it is pulled by π p r². The tip sinks as a beam's that wrinkles from half
    the collapse moment π p r³ at its root on, and it carries no more than that."""
    sheets = {
        "wall": Sheet([Ply(FABRIC, T)], tension_field=True, bending=0.0),
        "cap": Sheet([Ply(PLATE, 4.0)]),
    }
    model = build(
        half_tube(),
        sheets,
        cavities={"air": ("wall", "cap")},
        symmetry={"middle": 1},
        flux=(0.0, 0.5, 0.5),  # the root's plane is open
    )
    root = Support("root", {0: 0.0, 1: 0.0, 2: 0.0})
    steps = [LoadStep("inflate", pressure={"air": PRESSURE})]
    moments = [0.4, 0.7, 0.9, 0.99]
    for i, moment in enumerate(moments):
        down = Support("tip", {2: -deflection(moment)})
        steps.append(LoadStep(f"bend {i}", supports=[root, down]))
    solution = solve(model, steps, [root, Support("tip", {2: 0.0})], increment=0.5)
    tip, wall = np.unique(model.surfaces.curves["tip"]), model.sheets["wall"]
    # The root keeps its width and its corners.
    free = wall.triangles.places.mean(axis=1)[:, 0] > R / 2
    for moment, state in zip(moments, solution.ends[1:], strict=True):
        arm = LENGTH + state.x[model.nodes.dofs[tip, 0]].mean()
        carried = -2 * solution.reaction("tip", state)[2] * arm
        assert carried == pytest.approx(moment * COLLAPSE, rel=0.05)
        wrinkled = (wall.membrane.wrinkling(state.x) == 1).any(axis=1) & free
        assert wrinkled.any() == (moment > 0.5)
