"""The mesh in gmsh's current model as plain arrays, for geometries out of a user's file.

``of_model`` takes it, of whatever order, ``only_named`` keeps what the spec names,
``softact.mesh.joining.joined`` merges the nodes of solids that touch,
``softact.geometry.gmsh_groups.add_mesh`` puts it back.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from types import ModuleType

import numpy as np

from softact.errors import MeshError
from softact.mesh.boundary import face_keys
from softact.mesh.cells import MOST_TETRAHEDRA, upright
from softact.mesh.components import FACES, Skin, place
from softact.mesh.curves import GMSH_EDGES, Curves, of_quadratic
from softact.mesh.layout import Layout
from softact.nearest import likely
from softact.units import one_line, show

CORNERS = {2: ("Triangle", 3), 3: ("Tetrahedron", 4)}
CURVED = 1e-3  # part of a tetrahedron's size by which a node is off its straight edge
QUADRATIC = 10  # nodes of a tetrahedron of the second order
MOST_NAMES, MOST_LETTERS = 20, 40  # in one message


@dataclass(frozen=True)
class FileMesh:
    """points (n, 3) mm; regions: name -> tetrahedra (m, 4) of positive volume; surfaces: name ->
    triangles (k, 3), each once; curves: edges that are not straight."""

    points: np.ndarray
    regions: dict[str, np.ndarray]
    surfaces: dict[str, np.ndarray]
    curves: Curves

    @property
    def cells(self) -> np.ndarray:
        """All tetrahedra (m, 4)."""
        return np.vstack(list(self.regions.values()))

    @property
    def region(self) -> np.ndarray:
        """The number of the region of each tetrahedron (m,)."""
        return np.repeat(np.arange(len(self.regions)), [len(t) for t in self.regions.values()])

    def by_names(self) -> list[tuple[frozenset[str], np.ndarray]]:
        """The triangles in sets that have the same names; each triangle is in one of them."""
        if not self.surfaces:
            return []
        all_of_them = np.sort(np.vstack(list(self.surfaces.values())), axis=1)
        triangles = np.unique(all_of_them, axis=0)
        keys = face_keys(triangles, len(self.points))
        inside = np.array(
            [np.isin(keys, face_keys(t, len(self.points))) for t in self.surfaces.values()]
        )
        patterns, members = np.unique(inside.T, axis=0, return_inverse=True)
        names = np.array(list(self.surfaces), dtype=object)
        return [
            (frozenset(names[pattern]), triangles[members.ravel() == number])
            for number, pattern in enumerate(patterns)
        ]


def of_model(
    gmsh: ModuleType, scale: float, tell: Callable[[str], None], curved_edges: bool
) -> FileMesh:
    """The named groups of gmsh's current model, of elements of any order by their corners, and by
    the middles of their edges where edges may be curved and the order is the second.

    scale: mm of the model's unit. tell: receives a line where nodes on edges are left out that
    are not in their middle. Raises MeshError where elements are no tetrahedra or triangles.
    """
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    number = np.zeros(int(tags.max(initial=0)) + 1, dtype=np.int64)
    number[tags] = np.arange(len(tags))
    points = coordinates.reshape(-1, 3) * scale
    groups: dict[tuple[int, str], list[np.ndarray]] = {}
    curved, off = 0, 0.0
    quadratic = [np.empty((0, QUADRATIC), np.int64)]
    for dimension, name, members, local in _elements(gmsh):
        elements, corners = number[members], CORNERS[dimension][1]
        groups.setdefault((dimension, name), []).append(elements[:, :corners])
        if dimension == 3 and curved_edges and elements.shape[1] == QUADRATIC:
            quadratic.append(elements)
        elif dimension == 3 and elements.shape[1] > corners:
            count, distance = _bent(points, elements, local)
            curved, off = curved + count, max(off, distance)
    if curved:
        tell(
            f"{curved} tetrahedra have curved edges, whose nodes are up to {off:.2g} mm off the "
            "straight ones: softact takes the corners alone; a finer mesh follows curved walls "
            "better, or one of the second order with curved: true under solver"
        )
    named = {key: np.vstack(pieces) for key, pieces in groups.items()}
    return FileMesh(
        points,
        {name: upright(points, c) for (d, name), c in named.items() if d == 3},
        {name: np.unique(np.sort(c, axis=1), axis=0) for (d, name), c in named.items() if d == 2},
        of_quadratic(points, np.vstack(quadratic), GMSH_EDGES),
    )


def _elements(gmsh: ModuleType) -> Iterator[tuple[int, str, np.ndarray, np.ndarray]]:
    """Dimension, group, node tags (m, nodes) and local coordinates (nodes, dimension)."""
    for dimension, group in gmsh.model.getPhysicalGroups():
        if dimension not in CORNERS:
            continue
        name = gmsh.model.getPhysicalName(dimension, group)
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, group):
            for kind, _, nodes in zip(*gmsh.model.mesh.getElements(dimension, entity), strict=True):
                title, _, _, count, local, _ = gmsh.model.mesh.getElementProperties(kind)
                wanted = CORNERS[dimension][0]
                if not title.startswith(wanted):
                    raise MeshError(
                        f"the group {show(name)} has elements of another kind ({title.lower()}); "
                        f"write a mesh of {wanted.lower()}s"
                    )
                members = nodes.astype(np.int64).reshape(-1, count)
                yield dimension, name, members, np.reshape(local, (count, -1))


def _bent(points: np.ndarray, elements: np.ndarray, local: np.ndarray) -> tuple[int, float]:
    """How many elements have nodes off their straight edges, and the largest distance (mm)."""
    corners = points[elements[:, :4]]
    weights = np.column_stack([1 - local.sum(axis=1), local])
    off = np.linalg.norm(points[elements] - weights @ corners, axis=2).max(axis=1)
    bent = off > CURVED * np.linalg.norm(np.ptp(corners, axis=1), axis=1)
    return int(bent.sum()), float(off[bent].max(initial=0.0))


def only_named(found: FileMesh, layout: Layout, count: int) -> FileMesh:
    """What the layout names, of all that a file holds; the file's other names go no further.

    count: of all tetrahedra in the file. Raises MeshError where something is missing, left over, or
    there twice.
    """
    kinds = (
        ("volume", layout.regions, found.regions),
        ("surface", layout.surfaces, found.surfaces),
    )
    faults = [
        missing(kind, name, list(there))
        for kind, names, there in kinds
        for name in names
        if name not in there
    ]
    if faults:
        raise MeshError(*faults)
    mesh = FileMesh(
        found.points,
        {name: found.regions[name] for name in layout.regions},
        {name: found.surfaces[name] for name in layout.surfaces},
        found.curves,
    )
    if len(mesh.cells) > MOST_TETRAHEDRA:
        raise MeshError(
            f"{len(mesh.cells)} tetrahedra are more than the {MOST_TETRAHEDRA:.0e} that softact "
            "takes; write a coarser mesh"
        )
    _refuse_repeated(mesh)
    if count > len(mesh.cells):
        others = [name for name in found.regions if name and name not in layout.regions]
        raise MeshError(
            f"{count - len(mesh.cells)} tetrahedra are in no solid named under regions "
            f"({', '.join(layout.regions)}); name all solids"
            + (f": there are {listed(others)} too" if others else "")
        )
    return mesh


def missing(kind: str, name: str, there: list[str]) -> str:
    """A line about a name that is not in a file. kind: "surface" or "volume"; there: its names."""
    named = sorted(filter(None, there))
    known = f"there are {listed(named)}" if named else f"no {kind} has a name"
    return f"the mesh has nothing in the {kind} group {show(name)}; {known}{similar(name, named)}"


def similar(name: str, there: Iterable[str]) -> str:
    """The end of a line about a name that is not there: one that may be meant, "" for none."""
    meant = likely(name, map(one_line, there))
    return f"; {meant}" if meant else ""


def listed(names: list[str]) -> str:
    """Names of a file on one line, whatever they hold, and not more than a few."""
    shown = [one_line(name)[:MOST_LETTERS] for name in names[:MOST_NAMES]]
    return ", ".join(shown) + (", ..." if len(names) > MOST_NAMES else "")


def without_inner_walls(mesh: FileMesh, walls: set[str]) -> FileMesh:
    """The mesh without those triangles of some surfaces that lie inside the solid.

    Where two solids are joined, their faces are the wall of no cavity any more.
    """
    count = len(mesh.points)
    faces = face_keys(mesh.cells[:, FACES].reshape(-1, 3), count)
    inside = np.setdiff1d(faces, face_keys(Skin.of(mesh.cells).corners, count))
    surfaces = {
        name: triangles[~np.isin(face_keys(triangles, count), inside)]
        for name, triangles in mesh.surfaces.items()
        if name in walls
    }
    return replace(mesh, surfaces=mesh.surfaces | surfaces)


def _refuse_repeated(mesh: FileMesh) -> None:
    """Raises MeshError where a tetrahedron is there twice, in one region or in two."""
    cells = np.sort(mesh.cells, axis=1)
    _, first, counts = np.unique(cells, axis=0, return_index=True, return_counts=True)
    if (counts > 1).any():
        where = place(mesh.points[cells[first[counts > 1][0]]].mean(axis=0))
        raise MeshError(
            f"{int((counts > 1).sum())} tetrahedra are there more than once, one near {where}; "
            "each belongs to one group of volumes, once"
        )
