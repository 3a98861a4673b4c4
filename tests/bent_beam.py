"""A result folder whose every number has a closed form: Rivlin's flexure of a hollow block.

A block 0 <= X <= L, |Y| <= W/2, 0 <= Z <= H of incompressible neo-Hookean material is bent so
that its base Z = 0 keeps its length (Rivlin 1949; Ogden, Non-linear Elastic Deformations, 5.2):

    theta = k X,  r = sqrt(1/k^2 + 2 Z/k),  stretches  l = k r = sqrt(1 + 2 k Z),  1/l,  1
    sigma_rr = mu/2 (l^2 + l^-2) - the same at the roof,  sigma_theta = sigma_rr + mu (l^2 - l^-2)

The base curls down (towards -z), a turn about +y. The map conserves volume, so the air channel
in the block keeps its volume too. The half Y >= 0 is meshed with quadratic tets; the pressure
that names the states is made up, in proportion to the angle.
"""

from contextlib import nullcontext
from itertools import permutations, product
from pathlib import Path

import numpy as np

from softact.mesh.layout import Layout
from softact.report.pictures import Drawn
from softact.results.writer import ResultsWriter

LENGTH, HALF_WIDTH, HEIGHT = 120.0, 8.0, 14.0
WALL = 2.0
SHEAR_MODULUS = 0.22
PRESSURE = 50.0
ANGLE, INCREMENTS = 200.0, 8  # of the tests of the report
EDGES = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))

LAYOUT = Layout(
    regions=("body",),
    surfaces=("cavity_wall", "clamp", "tip", "symmetry", "strain_limiting_layer"),
    cavities={"cavity": ("cavity_wall",)},
    bending_axis=(0.0, 1.0, 0.0),
    symmetry={"symmetry": 1},
    layers=("strain_limiting_layer",),
    length=LENGTH,
)

SPEC = """\
name: bent_beam
description: Rivlin's flexure of a hollow block, a state with a closed form
source: Rivlin 1949
assumptions:
  - The wall thickness of <2 mm> is not in the paper; it is read off a figure.
  - Pressure is in proportion to the bending angle.
geometry:
  type: pneunet
  length: 120 mm
"""


def mesh(nx=60, ny=4, nz=7):
    """Points (n, 3), VTK quadratic tets (m, 10) and named surfaces of the half block."""
    x, y, z = (np.linspace(0, end, n + 1) for end, n in
               ((LENGTH, nx), (HALF_WIDTH, ny), (HEIGHT, nz)))  # fmt: skip
    corners = np.stack(np.meshgrid(x, y, z, indexing="ij"), -1).reshape(-1, 3)

    def node(i, j, k):
        return (i * (ny + 1) + j) * (nz + 1) + k

    tets = []
    for i, j, k in product(range(nx), range(ny), range(nz)):
        middle = corners[[node(i, j, k), node(i + 1, j + 1, k + 1)]].mean(axis=0)
        if _in_channel(middle):
            continue
        for order in permutations(range(3)):  # Kuhn: one tet per order of the three axes
            path = [np.array((i, j, k))]
            for axis in order:
                path.append(path[-1] + np.eye(3, dtype=int)[axis])
            tet = [node(*place) for place in path]
            if np.linalg.det(corners[tet[1:]] - corners[tet[0]]) < 0:
                tet[2:] = tet[:1:-1]
            tets.append(tet)
    points, cells = _quadratic(corners, np.array(tets))
    return points, cells, _surfaces(points, cells)


def _in_channel(point):
    x, y, z = point
    return WALL < x < LENGTH - WALL and y < HALF_WIDTH - WALL and WALL < z < HEIGHT - WALL


def _quadratic(corners, tets):
    edges = np.sort(tets[:, EDGES].reshape(-1, 2), axis=1)
    unique, where = np.unique(edges, axis=0, return_inverse=True)
    points = np.vstack([corners, corners[unique].mean(axis=1)])
    cells = np.hstack([tets, len(corners) + where.reshape(-1, 6)])
    used, cells = np.unique(cells, return_inverse=True)
    return points[used], cells.reshape(-1, 10)


def _surfaces(points, cells):
    faces = np.vstack([
        cells[:, face] for face in
        ((0, 2, 1, 6, 5, 4), (0, 1, 3, 4, 8, 7), (1, 2, 3, 5, 9, 8), (2, 0, 3, 6, 7, 9))
    ])  # fmt: skip
    _, first, count = np.unique(
        np.sort(faces[:, :3], axis=1), axis=0, return_index=True, return_counts=True
    )
    outside = faces[first[count == 1]]
    middle = points[outside[:, :3]].mean(axis=1)
    near = {
        "clamp": middle[:, 0] < 1e-9,
        "tip": middle[:, 0] > LENGTH - 1e-9,
        "symmetry": middle[:, 1] < 1e-9,
        "strain_limiting_layer": middle[:, 2] < 1e-9,
    }
    inside = (middle > 1e-9).all(axis=1) & (
        middle < np.array([LENGTH, HALF_WIDTH, HEIGHT]) - 1e-9
    ).all(axis=1)
    return {"cavity_wall": outside[inside], **{name: outside[on] for name, on in near.items()}}


def state(points, angle_deg):
    """Nodal fields of the block bent by ``angle_deg``, as the solver would give them."""
    if angle_deg == 0:
        zero = np.zeros(len(points))
        return {
            "displacement": np.zeros_like(points),
            "von_mises": zero,
            "max_principal_stress": zero,
            "max_principal_stretch": zero + 1,
        }
    k = np.radians(angle_deg) / LENGTH
    X, Y, Z = points.T
    r, stretch = np.sqrt(1 / k**2 + 2 * Z / k), np.sqrt(1 + 2 * k * Z)
    place = np.column_stack([r * np.sin(k * X), Y, r * np.cos(k * X) - 1 / k])
    roof = 1 + 2 * k * HEIGHT
    radial = SHEAR_MODULUS / 2 * (stretch**2 + stretch**-2 - roof - 1 / roof)
    hoop = radial + SHEAR_MODULUS * (stretch**2 - stretch**-2)
    lateral = radial + SHEAR_MODULUS * (1 - stretch**-2)
    differences = (hoop - radial) ** 2 + (hoop - lateral) ** 2 + (lateral - radial) ** 2
    return {
        "displacement": place - points,
        "von_mises": np.sqrt(differences / 2),
        "max_principal_stress": np.maximum(hoop, np.maximum(lateral, radial)),
        "max_principal_stretch": stretch,
    }


def row(points, fields, fraction, angle_deg):
    """The row of curve.csv that belongs to a state; the tip is the middle of the end face."""
    tip = np.flatnonzero((points[:, 0] > LENGTH - 1e-9) & (points[:, 1] < 1e-9))
    base = tip[np.argmin(points[tip, 2])]
    x, y, z = points[base] + fields["displacement"][base]
    cavity = (LENGTH - 2 * WALL) * 2 * (HALF_WIDTH - WALL) * (HEIGHT - 2 * WALL)
    return {
        "step": "inflate",
        "step_fraction": fraction,
        "pressure_kPa": PRESSURE * fraction,
        "bending_angle_deg": angle_deg,
        "tip_x_mm": x,
        "tip_y_mm": y,
        "tip_z_mm": z,
        "cavity_volume_mm3": cavity,
        "max_von_mises_MPa": fields["von_mises"].max(),
        "max_principal_stress_MPa": fields["max_principal_stress"].max(),
        "max_principal_stretch": fields["max_principal_stretch"].max(),
        "newton_iterations": 4,
        "residual": 1e-9,
    }


def undrawn(results, parts, spots=(), renderer=None):
    """In place of ``softact.report.pictures.drawing``: no pictures, which take seconds."""
    return nullcontext(lambda *marks: Drawn("left out"))


def provenance(increments):
    """What ``run`` would store in run.json."""
    return {
        "softact": "0.1.0",
        "spec_hash": "0f3a",
        "versions": {"dolfinx": "0.5.2", "numpy": np.__version__},
        "platform": "Linux x86_64",
        "processes": 2,
        "times_s": {"mesh": 1.5, "solve": 20.25, "measures": 0.5},
        "counts": {"increments": increments, "cutbacks": 1, "newton_iterations": 4 * increments},
        "history": [
            {"step": "inflate", "fraction": 0.5, "iterations": 7, "converged": False,
             "residuals": [1.0, 0.5, 0.4, 0.4, 0.4, 0.4, 0.4]},
            *({"step": "inflate", "fraction": (n + 1) / increments, "iterations": 4,
               "converged": True, "residuals": [1.0, 1e-2, 1e-4, 1e-9]}
              for n in range(increments)),
        ],
    }  # fmt: skip


def write(directory: Path, angle_deg=200.0, increments=8, status="complete", size=None, **more):
    """Write the folder; ``status`` None leaves it incomplete. Returns the rows of the curve."""
    points, cells, surfaces = mesh(**(size or {}))
    writer = ResultsWriter(directory, SPEC, provenance(increments))
    writer.mesh(points, cells, np.zeros(len(cells)), ["body"], surfaces, LAYOUT)
    rows = []
    for number in range(increments + 1):
        fraction = number / increments
        fields = state(points, angle_deg * fraction)
        rows.append(row(points, fields, fraction, angle_deg * fraction))
        writer.increment(rows[-1], fields)
    if status:
        mesh_size = {"cells": len(cells), "unknowns": 4 * len(points)}
        writer.finish(status, rows[-1], {"mesh": mesh_size, **more})
    return rows
