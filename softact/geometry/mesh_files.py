"""Meshes out of files of many programs, with the names of their groups; surfaces alone are filled.

Read by meshio, as data: nothing in a file is run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from softact.errors import MeshError
from softact.geometry.curved import are_curved
from softact.mesh.cells import upright
from softact.mesh.components import Skin, connected, place
from softact.mesh.curves import VTK_EDGES, Curves, of_quadratic
from softact.mesh.file_mesh import FileMesh

SURFACES = (".stl", ".ply", ".off")
VOLUMES = (".msh", ".vtu", ".vtk", ".inp", ".med", ".bdf", ".xdmf")
#: Cells of a mesh of any order: dimension and number of corners, which come first.
_CORNERS = {"tetra": (3, 4), "tetra10": (3, 4), "triangle": (2, 3), "triangle6": (2, 3)}
_OTHERS = ("hexahedron", "wedge", "pyramid", "quad")
#: Two points of a surface are one within this part of its size.
_SAME = 1e-7
#: Degrees between facets beyond which an edge is kept sharp as a surface is meshed anew.
_SHARP = 35.0


def read(path: Path, scale: float) -> FileMesh:
    """The mesh in a file; regions and surfaces by the names of its groups, solids without one by
    ``solid_1``, ``solid_2``, ... scale: mm of the file's unit.

    Raises MeshError where the file cannot be read or has other cells than tetrahedra.
    """
    raw = _raw(path)
    others = sorted({b.type for b in raw.cells} & {*_OTHERS, *(f"{o}8" for o in _OTHERS)})
    if others:
        raise MeshError(f"{path.name} has cells of another kind ({others[0]}); write tetrahedra")
    points = np.asarray(raw.points, float)[:, :3] * scale
    groups: dict[tuple[int, str], list[np.ndarray]] = {}
    solids: list[np.ndarray] = []
    for number, block in enumerate(raw.cells):
        if block.type not in _CORNERS:
            continue
        dimension, corners = _CORNERS[block.type]
        cells = np.asarray(block.data, np.int64)[:, :corners]
        if dimension == 3:
            solids.append(cells)
        for name, members in _groups(raw, number, dimension):
            groups.setdefault((dimension, name), []).append(cells[members])
    regions = {n: upright(points, np.vstack(c)) for (d, n), c in groups.items() if d == 3}
    if not regions:
        regions = {f"solid_{k}": upright(points, c) for k, c in enumerate(_bodies(solids), start=1)}
    surfaces = {
        n: np.unique(np.sort(np.vstack(c), axis=1), axis=0)
        for (d, n), c in groups.items()
        if d == 2
    }
    curves, kinds = Curves(), ("tetra10",) if are_curved() else ()
    if curved := [np.asarray(b.data, np.int64) for b in raw.cells if b.type in kinds]:
        curves = of_quadratic(points, np.vstack(curved), VTK_EDGES)
    return FileMesh(points, regions, surfaces, curves)


def _raw(path: Path) -> Any:
    import meshio

    try:
        return meshio.read(path)
    except (Exception, SystemExit) as error:  # meshio leaves where it knows no reader
        reason = " ".join(str(error).split()) or type(error).__name__
        raise MeshError(f"{path.name} cannot be read as a mesh: {reason}") from None


def _groups(raw: Any, number: int, dimension: int) -> Iterator[tuple[str, np.ndarray]]:
    """Names and members of the groups of a block: its sets, else its whole numbers."""
    named = False
    for name, per_block in raw.cell_sets.items():
        members = per_block[number] if number < len(per_block) else None
        if members is not None and len(members) and not name.startswith("gmsh:"):
            named = True
            yield name, np.asarray(members, np.int64)
    if named:
        return
    titles = {(int(tag), int(d)): name for name, (tag, d) in raw.field_data.items()}
    for key, values in _whole_numbers(raw, number, dimension):
        flags = set(np.unique(values)) <= {0, 1} and dimension == 2
        for value in np.unique(values):
            members = np.flatnonzero(values == value)
            if flags and value:
                yield key, members
            elif not flags and value >= 0:
                yield titles.get((int(value), dimension), f"{key}_{value}"), members


def _whole_numbers(raw: Any, number: int, dimension: int) -> Iterator[tuple[str, np.ndarray]]:
    """Names and whole numbers of the cells of a block; of tetrahedra those that tell most apart,
    since each belongs to one region."""
    found = {key: np.asarray(per_block[number]) for key, per_block in raw.cell_data.items()}
    found = {
        key: values
        for key, values in found.items()
        if values.dtype.kind in "iu" and values.ndim == 1 and key != "gmsh:geometrical"
    }
    if dimension == 3 and found:
        best = max(found, key=lambda key: len(np.unique(found[key])))
        found = {best: found[best]}
    yield from found.items()


def _bodies(solids: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Tetrahedra by the bodies that hang together at nodes."""
    if not solids:
        return []
    cells = np.vstack(solids)
    one = np.repeat(cells[:, 0], 3)
    label = connected(one, cells[:, 1:].ravel(), int(cells.max()) + 1)[cells[:, 0]]
    return [cells[label == number] for number in np.unique(label)]


def shells(paths: Sequence[Path], scale: float) -> tuple[np.ndarray, list[np.ndarray]]:
    """Points (n, 3) mm and the closed shells, (k, 3) triangles each, of files of surfaces.

    Raises MeshError where there is none, or one is not closed.
    """
    points, found = np.zeros((0, 3)), []
    for path in paths:
        more, closed = _shells(path, scale)
        found += [shell + len(points) for shell in closed]
        points = np.vstack([points, more])
    return points, found


def _shells(path: Path, scale: float) -> tuple[np.ndarray, list[np.ndarray]]:
    raw = _raw(path)
    triangles = [b.data for b in raw.cells if b.type == "triangle"]
    if not triangles:
        raise MeshError(f"{path.name} holds no triangles")
    points = np.asarray(raw.points, float) * scale
    size = float(np.ptp(points, axis=0).max())
    _, first, where = np.unique(
        np.round(points / (_SAME * size)).astype(np.int64), axis=0, return_index=True,
        return_inverse=True,
    )  # fmt: skip
    points = points[first]
    corners = where.ravel()[np.vstack(triangles).astype(np.int64)]
    flat = (corners == np.roll(corners, 1, axis=1)).any(axis=1)
    corners = corners[~flat]
    _, once = np.unique(np.sort(corners, axis=1), axis=0, return_index=True)
    corners = corners[np.sort(once)]  # turned as they were: gmsh looks at angles between them
    _refuse_open(path, points, corners)
    label = connected(
        np.repeat(corners[:, 0], 2), corners[:, 1:].ravel(), len(points)
    )[corners[:, 0]]  # fmt: skip
    return points, [corners[label == number] for number in np.unique(label)]


def _refuse_open(path: Path, points: np.ndarray, corners: np.ndarray) -> None:
    sides = np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, count = np.unique(sides, axis=0, return_counts=True)
    wrong = count != 2
    if wrong.any():
        where = place(points[edges[wrong][0]].mean(axis=0))
        raise MeshError(
            f"{path.name} is not watertight: {int(wrong.sum())} edges have one side or more than "
            f"two, one near {where}; close it in the program that made it"
        )


def fill_shells(
    gmsh: ModuleType, points: np.ndarray, found: Sequence[np.ndarray], anew: bool
) -> None:
    """Make gmsh's current model hold volumes between closed shells: each that lies in no other is
    the outside of a body, those in it are rooms.

    anew: whether the surfaces get a new mesh, of faces that gmsh finds between sharp edges; else
    their triangles stay.
    """
    model = gmsh.model
    used = np.unique(np.concatenate([shell.ravel() for shell in found]))
    entities = [model.addDiscreteEntity(2) for _ in found]
    model.mesh.addNodes(2, entities[0], used + 1, points[used].ravel())
    for entity, shell in zip(entities, found, strict=True):
        model.mesh.addElementsByType(entity, 2, [], (shell + 1).ravel())
    faces: dict[int, list[int]] = {k: [entity] for k, entity in enumerate(entities)}
    if anew:
        model.mesh.reclassifyNodes()
        model.mesh.classifySurfaces(math.radians(_SHARP), True, True, math.pi)
        model.mesh.createGeometry()
        faces = _by_shell(gmsh, points, found)
    loops = {k: model.geo.addSurfaceLoop(tags) for k, tags in faces.items()}
    for outside, rooms in _nested(points, found).items():
        model.geo.addVolume([loops[outside], *(loops[room] for room in rooms)])
    model.geo.synchronize()


def _by_shell(
    gmsh: ModuleType, points: np.ndarray, found: Sequence[np.ndarray]
) -> dict[int, list[int]]:
    """Faces of gmsh's model by the number of the shell whose points they have."""
    owner = {
        tuple(np.round(point, 6)): number
        for number, shell in enumerate(found)
        for point in points[np.unique(shell)]
    }
    faces: dict[int, list[int]] = {}
    for _, tag in gmsh.model.getEntities(2):
        nodes = gmsh.model.mesh.getNodes(2, tag, includeBoundary=True)[1].reshape(-1, 3)
        faces.setdefault(owner[tuple(np.round(nodes[0], 6))], []).append(tag)
    return faces


def _nested(points: np.ndarray, found: Sequence[np.ndarray]) -> Mapping[int, list[int]]:
    """Shell outside -> the shells in it, by their boxes."""
    boxes = [(points[s].min(axis=(0, 1)), points[s].max(axis=(0, 1))) for s in found]
    order = sorted(range(len(found)), key=lambda k: -float(np.prod(boxes[k][1] - boxes[k][0])))
    nested: dict[int, list[int]] = {}
    for shell in order:
        low, high = boxes[shell]
        outside = next(
            (o for o in nested if (boxes[o][0] < low).all() and (high < boxes[o][1]).all()), None
        )
        if outside is None:
            nested[shell] = []
        else:
            nested[outside].append(shell)
    return nested


def skin_shells(cells: np.ndarray) -> list[np.ndarray]:
    """The closed shells (k, 3) of the skin of tetrahedra."""
    skin = Skin.of(cells).corners
    label = connected(
        np.repeat(skin[:, 0], 2), skin[:, 1:].ravel(), int(skin.max()) + 1
    )[skin[:, 0]]  # fmt: skip
    return [skin[label == number] for number in np.unique(label)]
