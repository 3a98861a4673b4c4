"""A mesh made by softact itself, put into gmsh with its named groups."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from types import ModuleType

import numpy as np

from softact.geometry.curved import are_curved
from softact.geometry.saying import tell
from softact.mesh.cells import upright
from softact.mesh.curves import EDGES, GMSH_EDGES, SIDES, Curves, EdgeNumbers

# gmsh's numbers of straight and of quadratic elements.
TRIANGLES, TETRAHEDRA = (2, 9), (4, 11)


class _Middles:
    """Nodes in the middles of all edges of a mesh; their tags count from ``first``."""

    def __init__(self, curves: Curves, cells: np.ndarray, points: np.ndarray, first: int):
        self._edges = EdgeNumbers(cells[:, EDGES])
        ends = self._edges.ends
        self.places = curves.middles_of(ends, points[ends])
        self.tags = first + np.arange(len(ends))

    def of(self, ends: np.ndarray) -> np.ndarray:
        """Tags (..., ) of the middles of edges (..., 2)."""
        return self.tags[self._edges.of(ends)]


def _sound(curves: Curves, cells: np.ndarray, points: np.ndarray) -> Curves:
    kept, folded = curves.sound(cells, points)
    if folded:
        tell(
            f"{folded} of {len(cells)} tetrahedra keep straight edges along the curved walls, "
            "which would fold them; a smaller mesh_size follows the walls better"
        )
    return kept


#: Points (n, 3) mm and tetrahedra (m, 4) of a mesh, and its edges that are not straight.
Cells = tuple[np.ndarray, np.ndarray, Curves]
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
    curves: Curves | None = None,
) -> None:
    """Makes a new gmsh model of discrete entities, of quadratic elements where edges are curved.

    points: (n, 3) mm; those that no cell uses are left out. regions: name -> tetrahedra (m, 4),
    turned so that their volume is positive. surfaces: triangles (k, 3) with the names of all
    surface groups that they are in; each triangle occurs once. curves: edges that are not straight;
    those that would fold a tetrahedron are made straight, and that is said.
    """
    curves = curves if curves is not None and are_curved() else Curves()
    taken = _TAKEN.get()
    if taken is not None:
        taken.append((points, np.concatenate(list(regions.values())), curves))
        return
    model = gmsh.model
    model.add("discrete")
    cells = np.vstack(list(regions.values()))
    used = np.unique(cells)
    tag = np.zeros(len(points), dtype=np.int64)
    tag[used] = np.arange(1, len(used) + 1)
    kept = _sound(curves, upright(points, cells), points)
    middles = _Middles(kept, cells, points, len(used) + 1) if len(kept) else None
    volumes = [model.addDiscreteEntity(3) for _ in regions]
    model.mesh.addNodes(3, volumes[0], tag[used], points[used].ravel())
    if middles:
        model.mesh.addNodes(3, volumes[0], middles.tags, middles.places.ravel())

    def add(entity: int, kind: tuple[int, int], corners: np.ndarray, edges: np.ndarray) -> None:
        nodes = tag[corners]
        if middles:
            nodes = np.hstack([nodes, middles.of(corners[:, edges])])
        model.mesh.addElementsByType(entity, kind[bool(middles)], [], nodes.ravel())

    for volume, (name, tets) in zip(volumes, regions.items(), strict=True):
        add(volume, TETRAHEDRA, upright(points, tets), GMSH_EDGES)
        model.setPhysicalName(3, model.addPhysicalGroup(3, [volume]), name)
    groups: dict[str, list[int]] = {}
    for names, triangles in surfaces:
        entity = model.addDiscreteEntity(2)
        add(entity, TRIANGLES, triangles, SIDES)
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
