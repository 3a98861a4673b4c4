"""Solids of a mesh that touch: the nodes where their faces lie on each other become one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from softact.errors import MeshError
from softact.mesh.boundary import face_keys
from softact.mesh.components import Skin, components, part_names, place
from softact.mesh.file_mesh import FileMesh
from softact.mesh.nearest_triangle import nearest_triangle

SAME_PLACE = 1e-3  # part of an edge: what is nearer to each other lies at one place


def joined(mesh: FileMesh) -> tuple[FileMesh, float]:
    """The mesh with the nodes of parts merged where their faces lie on each other, and the area
    (mm^2) where they do.

    Raises MeshError where parts touch and their triangles there differ.
    """
    cells = mesh.cells
    labels = components(mesh.points, cells)
    if labels.max(initial=0) == 0:
        return mesh, 0.0
    skin = Skin.of(cells)
    part = labels[skin.cell]
    twin = _coincident(mesh.points, skin.corners, part)
    meet, area = _common_faces(mesh.points, skin.corners, twin)
    _refuse_other_triangles(mesh, labels, skin, ~meet)
    renumber = np.arange(len(mesh.points))
    nodes = np.unique(skin.corners[meet])
    renumber[nodes] = twin[nodes]
    return (
        replace(
            mesh,
            regions={name: renumber[tets] for name, tets in mesh.regions.items()},
            surfaces={
                name: np.unique(np.sort(renumber[t], axis=1), axis=0)
                for name, t in mesh.surfaces.items()
            },
            curves=mesh.curves.renumbered(renumber),
        ),
        area,
    )


def _coincident(points: np.ndarray, triangles: np.ndarray, part: np.ndarray) -> np.ndarray:
    """For each point the first one at its place on the skin (k, 3) of another part, or itself."""
    # Imported here: reading a spec shall not wait for it.
    from scipy.spatial import cKDTree

    sides = points[triangles] - points[np.roll(triangles, 1, axis=1)]
    tolerance = SAME_PLACE * float(np.median(np.linalg.norm(sides, axis=2)))
    part_of = np.zeros(len(points), dtype=np.int64)
    part_of[triangles] = part[:, None]
    nodes = np.unique(triangles)
    pairs = nodes[cKDTree(points[nodes]).query_pairs(tolerance, output_type="ndarray")]
    pairs = np.sort(pairs[part_of[pairs[:, 0]] != part_of[pairs[:, 1]]], axis=1)
    twin = np.arange(len(points))
    for a, b in pairs[np.argsort(pairs[:, 0], kind="stable")].tolist():
        twin[b] = min(twin[b], twin[a])
    return twin


def _common_faces(
    points: np.ndarray, triangles: np.ndarray, twin: np.ndarray
) -> tuple[np.ndarray, float]:
    """Whether each triangle (k, 3) lies on another one with the same corners, and their area."""
    keys = face_keys(twin[triangles], len(points))
    _, inverse, counts = np.unique(keys, return_inverse=True, return_counts=True)
    meet = counts[inverse.ravel()] > 1
    return meet, float(np.linalg.norm(_vectors(points, triangles[meet]), axis=1).sum() / 2)


def _vectors(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    x = points[triangles]
    return np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]) / 2


def _refuse_other_triangles(
    mesh: FileMesh, labels: np.ndarray, skin: Skin, free: np.ndarray
) -> None:
    """Raises MeshError where free triangles of one part lie on those of another."""
    part, triangles = labels[skin.cell], skin.corners
    for label in range(int(labels.max()) + 1):
        own = np.flatnonzero(free & (part == label))
        others = np.flatnonzero(free & (part != label))
        middles = mesh.points[triangles[own]].mean(axis=1)
        on = lying_on(mesh.points, middles, triangles[others])
        hit = np.flatnonzero(on >= 0)
        if not len(hit):
            continue
        names = part_names(mesh.points, mesh.cells, mesh.region, list(mesh.regions), labels)
        other = names[part[others[on[hit[0]]]]]
        raise MeshError(
            f"{names[label]} and {other} touch near {place(middles[hit[0]])}, and their triangles "
            "there differ, so they cannot be joined; mesh them as one (in gmsh: fragment, or "
            "Coherence), or write separate: true, and a contact that holds them together"
        )


def lying_on(points: np.ndarray, places: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """For each of some places (n, 3) a triangle (k, 3) on which it lies, -1 where there is none."""
    distance, nearest = nearest_triangle(places, points[triangles])
    if not len(triangles):
        return nearest
    size = np.sqrt(np.linalg.norm(_vectors(points, triangles), axis=1))
    return np.where(distance < SAME_PLACE * size[nearest], nearest, -1)
