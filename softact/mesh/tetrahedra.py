"""A gmsh file as a distributed dolfinx mesh with named regions and surfaces."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from softact import compat
from softact.errors import MeshError, SoftactError
from softact.mesh import leaks
from softact.mesh.curves import Curves
from softact.mesh.layout import Layout
from softact.mesh.msh_file import Tetrahedra
from softact.mesh.partition import parts
from softact.mesh.sheets import SheetMesh, on_facets

if TYPE_CHECKING:
    from mpi4py import MPI

# Local facet f of a tetrahedron is the one opposite to its vertex f (UFC numbering).
FACET_VERTICES = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])


@dataclass(frozen=True)
class Mesh:
    """The part of a mesh that this process holds. Lengths in mm.

    domain: dolfinx mesh of affine tetrahedra without ghost cells; None where all is sheets.
    layout: names and what they mean.
    region: (cells,) number of the region of each local cell, into ``layout.regions``.
    facets: surface name -> (k, 2) local cell and local facet. Each facet belongs to exactly one
        process and one cell, also where it lies between two cells.
    cell_count: cells of the whole mesh.
    sheets: triangles in space, None where there are none; for one process only.
    comm: the MPI communicator.
    middles: (cells, 6, 3) places of the middles of each local cell's edges, in the order of
        quadratic elements; None where all edges are straight.
    moved: (n, 3) places of the domain's points, mm, where they are others than the domain's own.
    """

    domain: Any
    layout: Layout
    region: np.ndarray
    facets: dict[str, np.ndarray]
    cell_count: int
    comm: MPI.Comm
    sheets: SheetMesh | None = None
    middles: np.ndarray | None = None
    moved: np.ndarray | None = None

    @property
    def points(self) -> np.ndarray:
        """Places (n, 3) of the domain's points, mm."""
        return self.domain.geometry.x if self.moved is None else self.moved

    @property
    def original_points(self) -> np.ndarray:
        """Numbers (n,) of the domain's points in the mesh that was spread over the processes."""
        return np.asarray(self.domain.geometry.input_global_indices)


def _facet_keys(triangles: np.ndarray, points: int) -> np.ndarray:
    corners = np.sort(triangles, axis=-1).astype(np.int64)
    return (corners[..., 0] * points + corners[..., 1]) * points + corners[..., 2]


def _locate_facets(tets: Tetrahedra) -> dict[str, np.ndarray]:
    """Surface name -> (k, 4): a cell of each triangle and the triangle's three points."""
    count = len(tets.points)
    keys = _facet_keys(tets.cells[:, FACET_VERTICES], count)
    order = np.argsort(keys.ravel(), kind="stable")
    ordered = keys.ravel()[order]
    located = {}
    for name, triangles in tets.surfaces.items():
        wanted = _facet_keys(triangles, count)
        place = np.minimum(np.searchsorted(ordered, wanted), len(ordered) - 1)
        if not np.array_equal(ordered[place], wanted):
            lost = int(np.sum(ordered[place] != wanted))
            raise MeshError(f"surface '{name}': {lost} triangles are not faces of the tetrahedra")
        located[name] = np.column_stack([order[place] // 4, triangles])
    return located


def check_closed(tets: Tetrahedra, layout: Layout) -> None:
    """Raise MeshError where the walls of a cavity leave a hole that no symmetry plane closes.

    The enclosed volume, and with it the pressure, has a meaning for closed cavities only.
    """
    planes = list(layout.symmetry.values())
    for cavity, walls in layout.cavities.items():
        triangles = np.vstack([tets.surfaces[name] for name in walls])
        edges = leaks.open_edges(tets.points, triangles, planes)
        edges = edges[~leaks.within_repeats(layout, tets.surfaces, edges)]
        if len(edges):
            line = leaks.line(cavity, tets.points, edges)
            raise MeshError(f"{line}; close it, or use surface_pressure")


def distribute(comm: MPI.Comm, load: Callable[[], Tetrahedra], layout: Layout) -> Mesh:
    """Spread a mesh over all processes of ``comm``; ``load`` is called on rank 0 only."""
    tets, region, located, curves = _on_root(comm, lambda: _prepare(load(), layout))
    if comm.rank == 0:
        part = parts(tets.points[tets.cells].mean(axis=1), comm.size)
        domain = compat.create_mesh(comm, tets.cells, tets.points, part)
    else:
        nothing = np.empty((0, 4), np.int64), np.empty((0, 3)), np.empty(0, np.int32)
        domain = compat.create_mesh(comm, *nothing)
    original = np.asarray(domain.topology.original_cell_index, dtype=np.int64)
    local_cells = domain.topology.index_map(3).size_local
    original = original[:local_cells]
    nodes = np.asarray(domain.geometry.input_global_indices)[compat.geometry_dofs(domain)]
    local_of = np.full(len(region), -1, dtype=np.int64)
    local_of[original] = np.arange(local_cells)
    facets = {name: _local_facets(rows, local_of, nodes) for name, rows in located.items()}
    sheets = _covering(comm, tets, located, layout) if layout.covers else None
    middles = curves.middles(nodes, domain.geometry.x[compat.geometry_dofs(domain)])
    return Mesh(domain, layout, region[original], facets, len(region), comm, sheets, middles)


def of_sheets(comm: MPI.Comm, sheets: SheetMesh, layout: Layout) -> Mesh:
    """A mesh without a solid, for one process."""
    none = np.empty(0, np.int32)
    return Mesh(None, layout, none, {}, len(sheets.triangles), comm, sheets)


def _covering(
    comm: MPI.Comm, tets: Tetrahedra, located: dict[str, np.ndarray], layout: Layout
) -> SheetMesh:
    """The sheets that lie on a solid."""
    if comm.size > 1:
        raise MeshError("sheets on a solid: for one process only")
    triangles = {}
    for sheet, surface in layout.covers.items():
        cells, corners = tets.cells[located[surface][:, 0]], located[surface][:, 1:]
        opposite = cells[~(cells[:, :, None] == corners[:, None]).any(axis=2)]
        triangles[sheet] = on_facets(tets.points, corners, opposite)
    return SheetMesh.of_parts(tets.points, triangles, layout.bonded, tets.curves)


def _prepare(
    tets: Tetrahedra, layout: Layout
) -> tuple[Tetrahedra, np.ndarray, dict[str, np.ndarray], Curves]:
    check_closed(tets, layout)
    return tets, tets.region, _locate_facets(tets), tets.curves


def _on_root(comm: MPI.Comm, work: Callable[[], tuple]) -> tuple:
    """What ``work`` returns on rank 0 (its first part stays there), on all processes.

    Its error is raised on all as well.
    """
    result, error = (None,), None
    if comm.rank == 0:
        try:
            result = work()
        except SoftactError as found:
            error = found
    shared, error = comm.bcast((result[1:], error))
    if error is not None:
        raise error
    return result[0], *shared


def _local_facets(rows: np.ndarray, local_of: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    cells = local_of[rows[:, 0]]
    here = cells >= 0
    cells, corners = cells[here], rows[here, 1:]
    on_facet = (nodes[cells][:, :, None] == corners[:, None, :]).any(axis=2)
    return np.column_stack([cells, np.argmin(on_facet, axis=1)]).astype(np.int32)
