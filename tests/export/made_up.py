"""Result folders of an actuator that is made up: constant curvature, by closed forms.

Stiffness K(p), curvature without a load k0(p) and volume V(p, k) are given; what holds the tip
applies a pure moment M, so that k = k0 + M/K all along. The mesh is a box without mass elsewhere.
"""

import numpy as np

from softact.mesh.layout import Layout
from softact.results.writer import ResultsWriter

START, ACTIVE, END = 4.0, 40.0, 6.0
LENGTH = START + ACTIVE + END
HEIGHT, WIDTH = 10.0, 8.0
NEUTRAL = -3.0  # below the centre of the tip
FREE = (0.0, 5.0, 10.0, 15.0, 20.0)  # kPa
MOST = 20.0

LAYOUT = Layout(
    regions=("body",),
    surfaces=("clamp", "tip", "cavity", "outer"),
    cavities={"cavity": ("cavity",)},
    bending_axis=(0.0, 1.0, 0.0),
    length=LENGTH,
)
SPEC = """\
name: made_up
geometry: {type: block, length: 50 mm, width: 8 mm, height: 10 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa, density: 1 g/cm^3}}
steps:
  - {name: inflate, traction: {surface: x_max, value: [0 kPa, 0 kPa, 0 kPa]}}
"""


def stiffness(p):
    """N·mm² at p kPa."""
    return 500.0 + 4.0 * np.asarray(p)


def curvature(p):
    """1/mm without a load."""
    p = np.asarray(p)
    return 8e-4 * p + 1e-5 * p**2


def volume(p, k):
    """mm³ at a curvature k: the volume at rest, and what Maxwell's relation adds."""
    rest = 2000.0 + 30.0 * p + 0.5 * p**2
    slope = (8e-4 + 2e-5 * p) * 1e3  # per MPa
    change = k - curvature(p)
    return rest + ACTIVE * (stiffness(p) * slope * change - 0.5 * 4.0 * 1e3 * change**2)


def row(p, moment, number):
    """A row of curve.csv."""
    k = curvature(p) + moment / stiffness(p)
    angle = k * ACTIVE
    # From the clamp's centre: the neutral line, its arc, the way on to the tip's centre.
    chord = ACTIVE * np.sinc(angle / 2 / np.pi)
    x = START + chord * np.cos(angle / 2) + END * np.cos(angle) - NEUTRAL * np.sin(angle)
    z = NEUTRAL - chord * np.sin(angle / 2) - END * np.sin(angle) - NEUTRAL * np.cos(angle)
    held = {} if moment == 0 else {f"tip_force_{c}_N": 0.0 for c in "xz"} | {
        "tip_force_y_N": 0.0, "tip_moment_x_Nmm": 0.0, "tip_moment_y_Nmm": -moment,
        "tip_moment_z_Nmm": 0.0,
    }  # fmt: skip
    return {
        "step": "inflate", "increment": number, "step_fraction": p / MOST, "pressure_kPa": p,
        "bending_angle_deg": np.degrees(angle), "twist_angle_deg": 0.0,
        "tip_x_mm": x, "tip_y_mm": 0.0, "tip_z_mm": z + HEIGHT / 2,
        "cavity_volume_mm3": volume(p, k), **{f"reaction_{c}_N": 0.0 for c in "xyz"}, **held,
    }  # fmt: skip


def mesh():
    """A box of six tets, its ends, and a cavity's wall from START to START + ACTIVE."""
    corners = np.array([(x, y, z) for x in (0.0, LENGTH) for y in (-WIDTH / 2, WIDTH / 2)
                        for z in (0.0, HEIGHT)])  # fmt: skip
    tets = np.array([(0, a, b, 7) for a, b in
                     ((1, 3), (3, 2), (2, 6), (6, 4), (4, 5), (5, 1))])  # fmt: skip
    wall = np.array([(x, y, z) for x in (START, START + ACTIVE) for y, z in ((0, 4), (1, 6))])
    points = np.vstack([corners, wall])
    surfaces = {
        "clamp": [(0, 1, 3), (0, 3, 2)],
        "tip": [(4, 5, 7), (4, 7, 6)],
        "cavity": [(8, 9, 10), (9, 10, 11)],
        "outer": [(0, 1, 4)],
    }
    return points, tets, {name: np.array(rows) for name, rows in surfaces.items()}


def write(directory, moments=(0.0, -2.0, 2.0), spec=SPEC, finished=True):
    """Write a result folder for each moment that holds the tip; returns them."""
    folders = []
    for number, moment in enumerate(moments):
        folder = directory / f"moment_{number}"
        writer = ResultsWriter(folder, spec, {})
        points, cells, surfaces = mesh()
        writer.mesh(points, cells, np.zeros(len(cells), int), ("body",), surfaces, LAYOUT)
        for count, p in enumerate(np.linspace(0.0, MOST, 11)):
            writer.increment(row(p, moment, count), {"displacement": np.zeros_like(points)})
        if finished:
            writer.finish("complete")
        folders.append(folder)
    return folders
