"""A mesh made by softact itself, put into gmsh with its named groups."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from types import ModuleType

import numpy as np

from softact.mesh.cells import upright

#: Points (n, 3) mm and tetrahedra (m, 4) of a mesh.
Cells = tuple[np.ndarray, np.ndarray]
_TAKEN: ContextVar[list[Cells] | None] = ContextVar("taken", default=None)


@contextmanager
def meshes_taken() -> Iterator[list[Cells]]:
    """A list of the meshes that ``add_mesh`` is given meanwhile, which do not get into gmsh."""
    taken: list[Cells] = []
    token = _TAKEN.set(taken)
    try:
        yield taken
    finally:
        _TAKEN.reset(token)


def add_mesh(
    gmsh: ModuleType,
    points: np.ndarray,
    regions: dict[str, np.ndarray],
    surfaces: list[tuple[frozenset[str], np.ndarray]],
) -> None:
    """Makes a new gmsh model of discrete entities.

    points: (n, 3) mm; those that no cell uses are left out. regions: name -> tetrahedra (m, 4),
    turned so that their volume is positive. surfaces: triangles (k, 3) with the names of all
    surface groups that they are in; each triangle occurs once.
    """
    taken = _TAKEN.get()
    if taken is not None:
        taken.append((points, np.concatenate(list(regions.values()))))
        return
    model = gmsh.model
    model.add("discrete")
    used = np.unique(np.concatenate([tets.ravel() for tets in regions.values()]))
    tag = np.zeros(len(points), dtype=np.int64)
    tag[used] = np.arange(1, len(used) + 1)
    volumes = [model.addDiscreteEntity(3) for _ in regions]
    model.mesh.addNodes(3, volumes[0], tag[used], points[used].ravel())
    for volume, (name, tets) in zip(volumes, regions.items(), strict=True):
        turned = upright(points, tets)
        model.mesh.addElementsByType(volume, 4, [], tag[turned].ravel())
        model.setPhysicalName(3, model.addPhysicalGroup(3, [volume]), name)
    groups: dict[str, list[int]] = {}
    for names, triangles in surfaces:
        entity = model.addDiscreteEntity(2)
        model.mesh.addElementsByType(entity, 2, [], tag[triangles].ravel())
        for name in names:
            groups.setdefault(name, []).append(entity)
    for name in sorted(groups):
        model.setPhysicalName(2, model.addPhysicalGroup(2, groups[name]), name)


def prism_tetrahedra(triangles: np.ndarray, layers: int, count: int) -> np.ndarray:
    """Tetrahedra (m, 4) of layers of prisms over triangles (k, 3) of ``count`` points; point p of
    level l has the number l * count + p.

    Each side of a prism is cut from its lower-numbered point below to the other one above, which
    neighbours do alike.
    """
    a, b, c = np.sort(triangles, axis=1).T
    above = count
    pieces = [
        np.column_stack([a, b, c, c + above]),
        np.column_stack([a, b, b + above, c + above]),
        np.column_stack([a, a + above, b + above, c + above]),
    ]
    tets = np.vstack(pieces)
    return np.vstack([tets + level * count for level in range(layers)])


def prism_sides(edges: np.ndarray, layers: int, count: int) -> np.ndarray:
    """Triangles (k, 3) on the sides over edges (k, 2), cut as ``prism_tetrahedra`` cuts them."""
    a, b = np.sort(edges, axis=1).T
    above = count
    sides = np.vstack(
        [np.column_stack([a, b, b + above]), np.column_stack([a, a + above, b + above])]
    )
    return np.vstack([sides + level * count for level in range(layers)])
