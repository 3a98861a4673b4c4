"""Sheets of simple shapes, and models of them."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI

from softact.mesh.layout import Layout
from softact.mesh.sheets import SheetMesh
from softact.mesh.tetrahedra import of_sheets
from softact.model import Model


def grid(counts, place, wrap=False, crossed=True):
    """Triangles of a grid of counts[0] × counts[1] quadrilaterals.

    place: (n, 2) parameters in [0, 1]² -> (n, 3) mm. wrap: the second parameter closes in itself.
    crossed: diagonals alternate. Returns points, triangles and ends: the nodes (rows) at the first
    parameter's two ends and the second's.
    """
    n, m = counts
    columns = m if wrap else m + 1
    i, j = np.meshgrid(np.arange(n + 1), np.arange(columns), indexing="ij")
    points = place(np.column_stack([i.ravel() / n, j.ravel() / m]))
    number = np.arange((n + 1) * columns).reshape(n + 1, columns)
    triangles = []
    for a in range(n):
        for b in range(m):
            c = (b + 1) % columns
            p, q, r, s = number[a, b], number[a + 1, b], number[a + 1, c], number[a, c]
            if crossed and (a + b) % 2:
                triangles += [(p, q, s), (q, r, s)]
            else:
                triangles += [(p, q, r), (p, r, s)]
    return points, np.array(triangles), (number[0], number[-1], number[:, 0], number[:, -1])


def edges_of(row, closed=False):
    """Edges between the nodes of a row."""
    following = np.roll(row, -1) if closed else row[1:]
    return np.column_stack([row if closed else row[:-1], following])


def rectangle(counts, size, crossed=True) -> SheetMesh:
    """A sheet in the plane z = 0 with the curves x_min, x_max, y_min and y_max."""

    def place(s):
        return np.column_stack([s * np.asarray(size), np.zeros(len(s))])

    points, triangles, ends = grid(counts, place, crossed=crossed)
    names = ("x_min", "x_max", "y_min", "y_max")
    curves = {name: edges_of(row) for name, row in zip(names, ends, strict=True)}
    return SheetMesh(points, triangles, {"sheet": np.arange(len(triangles))}, curves)


def quarter_disc(n, radius, parts=("sheet",), z=0.0) -> SheetMesh:
    """A quarter of a disc, x and y ≥ 0, with the curves x_0, y_0 (straight) and rim."""

    def place(s):  # the unit square onto the quarter disc, without a collapsed side
        u = s * 2 - 1
        square = np.column_stack([u[:, 0], u[:, 1]])
        x = square[:, 0] * np.sqrt(1 - square[:, 1] ** 2 / 2)
        y = square[:, 1] * np.sqrt(1 - square[:, 0] ** 2 / 2)
        return radius * np.column_stack([x, y, np.zeros(len(s))])

    points, triangles, _ = grid((2 * n, 2 * n), place)
    keep = (points[triangles].mean(axis=1)[:, :2] > 0).all(axis=1)
    used, triangles = np.unique(triangles[keep], return_inverse=True)
    points, triangles = points[used], triangles.reshape(-1, 3)
    points[np.abs(points) < 1e-12 * radius] = 0.0
    a, b, c = (points[triangles[:, i]] for i in range(3))
    turned = np.cross(b - a, c - a)[:, 2] < 0
    triangles[turned] = triangles[turned][:, [0, 2, 1]]
    sides = np.unique(np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0)
    at = np.linalg.norm(points, axis=1) > radius * (1 - 1e-9)
    curves = {
        "x_0": sides[(points[sides][:, :, 0] == 0).all(axis=1)],
        "y_0": sides[(points[sides][:, :, 1] == 0).all(axis=1)],
        "rim": sides[at[sides].all(axis=1)],
    }
    return SheetMesh(points, triangles, {"sheet": np.arange(len(triangles))}, curves)


def build(
    mesh: SheetMesh,
    sheets,
    cavities=None,
    symmetry=None,
    element="P2",
    obstacles=(),
    touching=(),
    **layout,
) -> Model:
    """A model of sheets alone. sheets: one for all parts, or part -> Sheet."""
    if not isinstance(sheets, dict):
        sheets = dict.fromkeys(mesh.parts, sheets)
    names = {"clamp": "", "tip": ""} | layout
    whole = Layout(
        regions=(), surfaces=(), cavities=cavities or {}, symmetry=symmetry or {}, **names
    )
    mesh = of_sheets(MPI.COMM_SELF, mesh, whole)
    contacts = {"obstacles": obstacles, "touching": touching}
    return Model(mesh, {}, element=element, sheets=sheets, **contacts)
