"""The differences between dolfinx 0.5.2 (Debian 12), 0.9 (Debian 13), 0.10 and 0.11 (Debian sid),
and nothing else.

No other module asks for a version. What differs: how elements are written (UFL's own classes
before 2023, Basix's later), the names of FFCx's arguments, what FFCx returns and what its kernels
take, and the argument order of mesh creation.
"""

from __future__ import annotations

import functools
import re
from typing import TYPE_CHECKING, Any

import basix
import dolfinx
import numpy as np
import ufl

if TYPE_CHECKING:
    from mpi4py import MPI

_OLD = not hasattr(basix, "ufl") and hasattr(ufl, "FiniteElement")
if not _OLD:
    import basix.ufl

CELL = "tetrahedron"


def lagrange(degree: int, shape: tuple[int, ...] = (), discontinuous: bool = False) -> Any:
    """Lagrange element on tetrahedra, scalar or with values of ``shape``."""
    family = "DG" if discontinuous else "Lagrange"
    if _OLD:
        if shape:
            return ufl.VectorElement(family, CELL, degree, dim=shape[0])
        return ufl.FiniteElement(family, CELL, degree)
    return basix.ufl.element(
        "Lagrange", CELL, degree, shape=shape or None, discontinuous=discontinuous
    )


def quadrature_element(degree: int, size: int) -> Any:
    """Element whose ``size`` values live at the points of the cell rule of ``degree``."""
    if _OLD:
        return ufl.VectorElement("Quadrature", CELL, degree, dim=size, quad_scheme="default")
    return basix.ufl.quadrature_element(CELL, value_shape=(size,), degree=degree)


def mixed(*elements: Any) -> Any:
    """Mixed element of the given ones (the one itself where there is only one)."""
    if len(elements) == 1:
        return elements[0]
    return ufl.MixedElement(*elements) if _OLD else basix.ufl.mixed_element(list(elements))


@functools.cache
def ufl_mesh(degree: int = 1) -> ufl.Mesh:
    """The one abstract mesh of tetrahedra of ``degree`` (1 straight, 2 curved), for forms that
    belong to no particular mesh."""
    return ufl.Mesh(lagrange(degree, (3,)))


@functools.cache
def quadrature_rule(degree: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) and weights (n,) of FFCx's default rule on the reference tetrahedron."""
    cell = basix.CellType.tetrahedron
    if _OLD:
        return basix.make_quadrature(cell, degree)
    return basix.make_quadrature(cell, degree, rule=basix.QuadratureType.default)


def tabulate_gradients(degree: int, points: np.ndarray) -> np.ndarray:
    """Reference gradients of the Lagrange functions at ``points`` (n, 3): (n, functions, 3)."""
    return np.ascontiguousarray(_tabulate(degree, points, 1)[1:4].transpose(1, 2, 0))


def tabulate_values(degree: int, points: np.ndarray) -> np.ndarray:
    """Values of the Lagrange functions of ``degree`` at ``points`` (n, 3): (n, functions)."""
    if degree == 0:
        return np.ones((len(points), 1))
    return _tabulate(degree, points, 0)[0]


def _tabulate(degree: int, points: np.ndarray, derivatives: int) -> np.ndarray:
    table = np.asarray(_reference_element(degree).tabulate(derivatives, points))
    return table.reshape(*table.shape[:3])


def reference_nodes(degree: int) -> np.ndarray:
    """Reference coordinates of the nodes of the Lagrange element, in dof order: (n, 3)."""
    return np.asarray(_reference_element(degree).points)


@functools.cache
def _reference_element(degree: int) -> Any:
    return basix.create_element(basix.ElementFamily.P, basix.CellType.tetrahedron, degree)


def create_mesh(
    comm: MPI.Comm, cells: np.ndarray, points: np.ndarray, part: np.ndarray
) -> dolfinx.mesh.Mesh:
    """Distributed dolfinx mesh of affine tets; rank 0 passes all, the others empty arrays.

    part: process (n,) that each cell goes to. No cells are shared.
    """
    ranks, begins = part.astype(np.int32), np.arange(len(part) + 1, dtype=np.int32)
    if _OLD:  # finds shared nodes by the neighbours that other processes have, and drops these
        ranks, begins = _with_neighbours(cells, ranks)

    def partitioner(*call: Any) -> Any:
        return dolfinx.cpp.graph.AdjacencyList_int32(ranks, begins)

    if _OLD:
        none = dolfinx.mesh.GhostMode.none
        return dolfinx.mesh.create_mesh(
            comm, cells, points, ufl_mesh(), ghost_mode=none, partitioner=partitioner
        )
    # By name: 0.10 has changed the places of the element and the points.
    rest: dict[str, Any] = {"e": ufl_mesh(), "x": points, "partitioner": partitioner}
    return dolfinx.mesh.create_mesh(comm, cells, **rest)


def _with_neighbours(cells: np.ndarray, part: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Processes of each cell, its own first, then those of cells beyond its facets; and where each
    cell's begin, one more than there are cells."""
    facets = np.sort(cells[:, [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]]], axis=-1).reshape(-1, 3)
    order = np.lexsort(facets.T)
    ordered = facets[order]
    first = np.flatnonzero((ordered[1:] == ordered[:-1]).all(axis=1))
    one, other = order[first] // 4, order[first + 1] // 4
    apart = part[one] != part[other]
    one, other = one[apart], other[apart]
    across = np.concatenate(
        [np.column_stack([one, part[other]]), np.column_stack([other, part[one]])]
    )
    across = np.unique(across.astype(np.int64), axis=0)
    cell = np.concatenate([np.arange(len(part)), across[:, 0]])
    rank = np.concatenate([part, across[:, 1]])
    begins = np.concatenate([[0], np.cumsum(np.bincount(cell, minlength=len(part)))])
    return rank[np.argsort(cell, kind="stable")].astype(np.int32), begins.astype(np.int32)


def function_space(
    mesh: dolfinx.mesh.Mesh, degree: int, size: int = 1, discontinuous: bool = False
) -> dolfinx.fem.FunctionSpace:
    """Lagrange space of ``degree`` with ``size`` components per node on ``mesh``."""
    element = lagrange(degree, (size,) if size > 1 else (), discontinuous)
    create = getattr(dolfinx.fem, "FunctionSpace" if _OLD else "functionspace")
    return create(mesh, element)


def cell_dofs(space: dolfinx.fem.FunctionSpace) -> np.ndarray:
    """Node numbers (blocks) of each local cell: (cells, functions)."""
    table = space.dofmap.list
    if hasattr(table, "array"):
        cells = space.mesh.topology.index_map(3)
        return table.array.reshape(cells.size_local + cells.num_ghosts, -1)
    return np.asarray(table)


def geometry_dofs(mesh: dolfinx.mesh.Mesh) -> np.ndarray:
    """Geometry nodes of each local cell: (cells, 4)."""
    tables = getattr(mesh.geometry, "dofmaps", None)
    if tables is not None and not callable(tables):
        return np.asarray(tables[0])
    table = mesh.geometry.dofmap
    return table.array.reshape(-1, 4) if hasattr(table, "array") else np.asarray(table)


def diverged_to_nan() -> int:
    """SNES's reason where the residual is not a number; PETSc 3.24 has renamed it."""
    from petsc4py import PETSc

    reasons = PETSc.SNES.ConvergedReason
    new = getattr(reasons, "DIVERGED_FUNCTION_NANORINF", None)
    return reasons.DIVERGED_FNORM_NAN if new is None else new


def generate_code(form: ufl.Form, name: str) -> str:
    """C source of FFCx's kernels for ``form``; it includes ufcx.h.

    Their arguments are those of ufcx_tabulate_tensor_float64 before 0.10, which has one more: data
    of a kernel's own, which FFCx's kernels do not read.
    """
    import ffcx.compiler

    # FFCx's defaults themselves: get_options would read a file in the current folder or the home,
    # which changes the kernels (or leaves them empty), and the cache would keep these for all.
    if _OLD:
        import ffcx.parameters

        known = ffcx.parameters.FFCX_DEFAULT_PARAMETERS
        parameters = {key: value for key, (value, *_) in known.items()}
        return ffcx.compiler.compile_ufl_objects([form], prefix=name, parameters=parameters)[1]
    import ffcx.options

    known = ffcx.options.FFCX_DEFAULT_OPTIONS
    options = {key: value for key, (_, value, *_) in known.items()}
    # By place: the last argument is called prefix before 0.11, and namespace since.
    made = ffcx.compiler.compile_ufl_objects([form], options, None, name)
    parts, suffixes = made if isinstance(made[0], list) else (made, (".h", ".c"))
    source = parts[suffixes.index(".c")]
    return re.sub(r",\s*void\s*\*\s*custom_data\s*\)", ")", source)
