"""The sparsity pattern of a model's matrix, and fast assembly of element matrices into it.

Unknowns come in blocks (the three displacements of a node, the pressure of a vertex). Each
process numbers its own blocks first, then those that it shares with others (ghosts). Matrix
values are summed into local CSR storage by the loops of ``_assembly.c`` and given to PETSc at
once (MatSetValuesCOO), which also sends the rows of other processes to them.
"""

from __future__ import annotations

import ctypes
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse
from mpi4py import MPI
from petsc4py import PETSc

from softact import compat
from softact.system import forms, jit
from softact.system.kernels import Entities, pointer
from softact.system.unknowns import Unknowns

if TYPE_CHECKING:
    from softact.mesh.tetrahedra import Mesh

_INT = PETSc.IntType
_petsc = ctypes.CDLL(PETSc.__file__)  # symbols of libpetsc; petsc4py 3.18 does not wrap COO


class LooseEntries:
    """Matrix entries (global numbers, any process's) that may be replaced at any time."""

    def __init__(self) -> None:
        self.entries = np.empty(0, _INT), np.empty(0, _INT)
        self.values = np.empty(0)
        self.changed = False

    def set(self, rows: np.ndarray, columns: np.ndarray) -> None:
        """Replace them by others, with values of zero."""
        self.entries = rows.astype(_INT), columns.astype(_INT)
        self.values = np.zeros(len(rows))
        self.changed = True


class BlockTable:
    """Places in the matrix of elements beside the cells, each of n nodes with three unknowns.

    blocks: (k, n) blocks of ``Unknowns``. It joins the pattern when the assembler is made.
    """

    def __init__(self, blocks: np.ndarray):
        self.blocks = np.ascontiguousarray(blocks, dtype=np.int32)

    def place_in(self, assembler: Assembler, place: np.ndarray, row_length: np.ndarray) -> None:
        """Learn where the values of each pair of nodes begin."""
        self._assembler = assembler
        dofs = assembler.unknowns.first[self.blocks][..., None] + np.arange(3)
        tables = dofs, place[assembler.find_pairs(self.blocks)], row_length[self.blocks]
        self._tables = tuple(np.ascontiguousarray(table, dtype=np.int32) for table in tables)

    def add(self, matrices: np.ndarray, on: np.ndarray | None = None) -> None:
        """Add matrices (k, n, 3, n, 3) of all elements, or of those ``on``; supported unknowns are
        left out."""
        self._add(matrices, on, False, 1.0)

    def add_scalar(self, matrices: np.ndarray, factor: float) -> None:
        """Add ``factor`` times matrices (k, n, n) of all elements, to each of the nodes' three
        unknowns alike."""
        self._add(matrices, None, True, factor)

    def _add(
        self, matrices: np.ndarray, on: np.ndarray | None, scalar: bool, factor: float
    ) -> None:
        assembler, matrices = self._assembler, np.ascontiguousarray(matrices, dtype=float)
        on = None if on is None else np.ascontiguousarray(on, dtype=np.int64)
        assembler.library.add_blocks(
            ctypes.c_int64(len(matrices)),
            self.blocks.shape[1],
            pointer(matrices),
            scalar,
            ctypes.c_double(factor),
            *map(pointer, (on, *self._tables, assembler.fixed, assembler.values)),
        )


class Assembler:
    """Sparsity pattern and matrix of a set of unknowns.

    mesh: of the cells; without a ``domain`` there are none. tables: further elements. like: one of
    the same unknowns and elements, with which it shares the pattern and the room of the values.
    curved: places (n, 3) mm of the displacement's nodes where the cells are curved.
    """

    def __init__(
        self,
        mesh: Mesh,
        unknowns: Unknowns,
        tables: Sequence[BlockTable] = (),
        like: Assembler | None = None,
        curved: np.ndarray | None = None,
    ):
        self.unknowns = unknowns
        self.library = jit.load_library(unknowns.comm, Path(__file__).with_name("_assembly.c"))
        self.library.assemble_scalar.restype = ctypes.c_double
        self.library.force_beside.restype = ctypes.c_double
        self.geometry_nodes: np.ndarray = np.empty((0, 4), np.int32)
        self.points: np.ndarray = np.empty((0, 3))
        if curved is not None:
            self.geometry_nodes = np.ascontiguousarray(
                compat.cell_dofs(unknowns.spaces[0]), dtype=np.int32
            )
            self.points = np.ascontiguousarray(curved)
        elif mesh.domain is not None:
            self.geometry_nodes = np.ascontiguousarray(
                compat.geometry_dofs(mesh.domain), dtype=np.int32
            )
            self.points = np.ascontiguousarray(mesh.points)
        self.fixed = np.zeros(unknowns.local, dtype=np.uint8)
        self.symmetric = True
        if like is None:
            self._build_pattern([table.blocks for table in tables])
        else:
            self._share_pattern(like)
        for table in tables:
            table.place_in(self, self._place, self._block_row_length)
        self._extra: list[tuple[np.ndarray, np.ndarray]] = []
        self.extra_values = np.empty(0)
        self._loose: list[LooseEntries] = []
        self.layouts = 0  # how often the matrix was laid out

    def _build_pattern(self, tables: list[np.ndarray]) -> None:
        u = self.unknowns
        incidence = scipy.sparse.vstack(
            [_incidence(blocks, len(u.first)) for blocks in (u.cell_blocks, *tables) if len(blocks)]
        ).tocsr()
        graph = (incidence.T @ incidence).tocsr()
        graph.sort_indices()
        indptr, indices = graph.indptr.astype(np.int32), graph.indices.astype(np.int32)
        widths = u.width[indices]
        total = np.concatenate([[0], np.cumsum(widths, dtype=np.int64)])
        row_length = total[indptr[1:]] - total[indptr[:-1]]
        row_start = np.concatenate([[0], np.cumsum(row_length * u.width)])
        if row_start[-1] > np.iinfo(np.int32).max:
            raise MemoryError("the matrix has more than 2^31 entries per process")
        place = (
            np.repeat(row_start[:-1] - total[indptr[:-1]], np.diff(indptr)) + total[:-1]
        ).astype(np.int32)
        self._graph = indptr, indices
        self._place, self._block_row_length = place, row_length.astype(np.int32)
        self._base = place[self.find_pairs(u.cell_blocks)]
        self._row_length = np.ascontiguousarray(self._block_row_length[u.cell_blocks])
        self.values = np.zeros(int(row_start[-1]))
        diagonal = place[indptr[:-1] + _diagonal_offset(indptr, indices)]
        self._diagonal = np.empty(u.local, dtype=np.int64)
        for c in range(int(u.width.max())):
            has = u.width > c
            self._diagonal[u.first[has] + c] = diagonal[has] + c * row_length[has] + c

    def _share_pattern(self, like: Assembler) -> None:
        for name in (
            "_graph", "_place", "_block_row_length", "_base", "_row_length", "values", "_diagonal",
        ):  # fmt: skip
            setattr(self, name, getattr(like, name))

    def find_pairs(self, blocks: np.ndarray) -> np.ndarray:
        """Numbers (k, n, n) of the graph's entries between the blocks (k, n) of each element."""
        indptr, indices = self._graph
        pairs = np.empty((*blocks.shape, blocks.shape[1]), dtype=np.int32)
        self.library.find_pairs(
            ctypes.c_int64(len(blocks)),
            blocks.shape[1],
            pointer(blocks),
            pointer(indptr),
            pointer(indices),
            pointer(pairs),
        )
        return pairs

    def add_table(self, blocks: np.ndarray) -> BlockTable:
        """Places of further elements (k, n) whose pairs of nodes those of the pattern have."""
        table = BlockTable(blocks)
        table.place_in(self, self._place, self._block_row_length)
        return table

    def couple(self, rows: np.ndarray, columns: np.ndarray) -> slice:
        """Make room for entries beyond those of the elements (global numbers, any process's).

        Returns their place in ``extra_values``. To be called before ``matrix`` is used.
        """
        if "matrix" in self.__dict__:
            raise RuntimeError("the matrix has its pattern already; couple unknowns before")
        start = len(self.extra_values)
        self._extra.append((rows, columns))
        self.extra_values = np.zeros(start + len(rows))
        return slice(start, len(self.extra_values))

    def couple_loosely(self) -> LooseEntries:
        """Room for entries that change while the matrix is in use; all processes ask for it."""
        self._loose.append(LooseEntries())
        return self._loose[-1]

    @functools.cached_property
    def matrix(self) -> PETSc.Mat:
        """The PETSc matrix of all unknowns."""
        u = self.unknowns
        matrix = PETSc.Mat().create(u.comm)
        matrix.setSizes(((u.owned, None), (u.owned, None)))
        matrix.setType(PETSc.Mat.Type.AIJ)
        self._lay_out(matrix)
        if self.symmetric:
            matrix.setOption(PETSc.Mat.Option.SYMMETRIC, True)
            matrix.setOption(PETSc.Mat.Option.SYMMETRY_ETERNAL, True)
        return matrix

    @functools.cached_property
    def pattern(self) -> tuple[np.ndarray, np.ndarray]:
        """Global row and column of each entry of ``values``."""
        u = self.unknowns
        indptr, indices = self._graph
        rows = np.empty(len(self.values), dtype=np.int32)
        columns = np.empty_like(rows)
        number = u.number.astype(np.int32)  # a name of its own: the C code reads it in place
        self.library.expand_pattern(
            len(u.first),
            pointer(indptr),
            pointer(indices),
            pointer(u.first),
            pointer(u.width),
            pointer(number),
            pointer(rows),
            pointer(columns),
        )
        return rows, columns

    @property
    def beyond(self) -> tuple[np.ndarray, np.ndarray]:
        """Global row and column of each entry of ``extra_values`` that there is by now."""
        return tuple(
            np.concatenate([np.empty(0, _INT), *(extra[k] for extra in self._extra)])
            for k in range(2)
        )

    @property
    def coupled(self) -> np.ndarray:
        """(2, m) global numbers of unknowns that share an entry of the matrix as it is laid out: of
        two blocks the first of each, and each pair that is coupled beyond. This process's share."""
        u = self.unknowns
        indptr, indices = self._graph
        first = u.number[u.first]
        blocks = first[np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))], first[indices]
        beyond = [*self._extra, *(loose.entries for loose in self._loose)]
        return np.array([np.concatenate([p[k] for p in (blocks, *beyond)]) for k in range(2)])

    @property
    def entries(self) -> tuple[np.ndarray, np.ndarray]:
        """Global row and column of each entry of ``values`` and ``extra_values``, in this order."""
        return self._element_entries

    @functools.cached_property
    def _element_entries(self) -> tuple[np.ndarray, np.ndarray]:
        """Global row and column of each entry of ``values`` and ``extra_values``."""
        rows, columns = (
            np.concatenate([part, *(extra[k] for extra in self._extra)]) if self._extra else part
            for k, part in enumerate(self.pattern)
        )
        return rows.astype(_INT, copy=False), columns.astype(_INT, copy=False)

    def _lay_out(self, matrix: PETSc.Mat) -> None:
        """Give the matrix its pattern: the elements' and what is coupled beyond."""
        rows, columns = (
            np.concatenate([part, *(loose.entries[k] for loose in self._loose)])
            for k, part in enumerate(self._element_entries)
        )
        _check(
            _petsc.MatSetPreallocationCOO(
                ctypes.c_void_p(matrix.handle),
                ctypes.c_ssize_t(len(rows)),
                pointer(rows),
                pointer(columns),
            )
        )
        self.layouts += 1
        for loose in self._loose:
            loose.changed = False

    def _any_changed(self) -> bool:
        """Whether entries were replaced on any process; each may have others. Collective."""
        mine = any(loose.changed for loose in self._loose)
        return bool(self._loose) and bool(self.unknowns.comm.allreduce(mine, op=MPI.LOR))

    def kernels(self, name: str, *arguments: int | None) -> tuple[ctypes.c_void_p, ...]:
        """Compiled kernels of the forms that ``softact.system.forms.name`` writes for the degree of
        the cells' shape and ``arguments``."""
        return jit.load_kernels(self.unknowns.comm, forms, name, self.shape_degree, *arguments)

    @property
    def shape_degree(self) -> int:
        """1 where the cells are straight, 2 where they are curved."""
        return 2 if self.geometry_nodes.shape[1] == 10 else 1

    def add_matrix(self, address: ctypes.c_void_p, on: Entities, size: int) -> None:
        """Run the matrix loop of one kernel."""
        u = self.unknowns
        self.library.assemble_matrix(
            address,
            ctypes.byref(on),
            pointer(u.cell_dofs),
            u.cell_dofs.shape[1],
            size,
            u.cell_blocks.shape[1],
            pointer(u.dof_block),
            pointer(u.dof_component),
            pointer(self._base),
            pointer(self._row_length),
            pointer(self.fixed),
            pointer(self.values),
        )

    def add_solid(
        self,
        loop: Sequence[object],
        weights: np.ndarray,
        moduli: np.ndarray,
        stress: np.ndarray,
        shares: np.ndarray | None,
        constants: Sequence[float],
    ) -> None:
        """Add the tangents of a solid's cells. loop: see ``Solid.loop``; weights (points,) of the
        rule; moduli (cells, points, 36) and stress (cells, points, 6), MPa; shares (points,
        pressures) of the pressure's functions and the constants of ``forms.solid``."""
        moduli, stress = (np.ascontiguousarray(a, dtype=float) for a in (moduli, stress))
        compliance, logarithmic = constants or (0.0, 0.0)
        self.library.solid_tangent(
            *loop,
            *map(pointer, (weights, moduli, stress)),
            0 if shares is None else shares.shape[1],
            pointer(shares),
            ctypes.c_double(compliance),
            ctypes.c_double(logarithmic),
            self.unknowns.cell_blocks.shape[1],
            *map(pointer, (self._base, self._row_length, self.fixed, self.values)),
        )

    def clear(self) -> None:
        """Start a new matrix."""
        self.values[:] = 0.0
        self.extra_values[:] = 0.0
        for loose in self._loose:
            loose.values[:] = 0.0

    def finish_matrix(self) -> PETSc.Mat:
        """Put 1 on the diagonal of fixed unknowns and hand the values to PETSc."""
        owned_fixed = np.flatnonzero(self.fixed[: self.unknowns.owned])
        self.values[self._diagonal[owned_fixed]] = 1.0
        if self._any_changed():
            self._lay_out(self.matrix)
        beyond = [self.extra_values, *(loose.values for loose in self._loose)]
        # Where there is nothing beyond the elements' values, they are handed over as they lie.
        values = np.concatenate([self.values, *beyond]) if any(map(len, beyond)) else self.values
        _check(
            _petsc.MatSetValuesCOO(
                ctypes.c_void_p(self.matrix.handle),
                pointer(values),
                ctypes.c_int(int(PETSc.InsertMode.INSERT)),
            )
        )
        return self.matrix


def _incidence(blocks: np.ndarray, total: int) -> scipy.sparse.csr_matrix:
    """Which blocks (k, n) each element has: (k, total)."""
    count, width = blocks.shape
    starts = np.arange(0, count * width + 1, width)
    ones = np.ones(count * width, dtype=np.int32)
    return scipy.sparse.csr_matrix((ones, blocks.ravel(), starts), shape=(count, total))


def _diagonal_offset(indptr: np.ndarray, indices: np.ndarray) -> np.ndarray:
    rows = np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))
    return np.flatnonzero(indices == rows) - indptr[:-1]


def _check(code: int) -> None:
    if code:
        raise PETSc.Error(code)
