"""Numbering of the unknowns of a model."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from petsc4py import PETSc

from softact import compat

if TYPE_CHECKING:
    import dolfinx
    from mpi4py import MPI


class Unknowns:
    """Numbering of the unknowns of several Lagrange spaces on one mesh, and of loose nodes.

    spaces: dolfinx function spaces (each of blocks of equal size).
    loose: number of further nodes with three unknowns each, for one process only; they come last,
    with the dofs ``loose_dofs`` and the blocks ``loose_blocks``. apart: number of further threes of
    unknowns that are no node's, after them: ``apart_dofs``; the first process owns them, and all
    others hold them last of all. far: whether these couple with unknowns all over the model.
    cell_dofs: (cells, dofs) local numbers of each cell's unknowns, space after space.
    cell_blocks: (cells, blocks) the same for blocks.
    owned, local: number of unknowns that this process owns, and holds.
    number: (local,) global number of each.
    """

    def __init__(
        self,
        comm: MPI.Comm,
        spaces: Sequence[dolfinx.fem.FunctionSpace],
        loose: int = 0,
        apart: int = 0,
        far: bool = False,
    ):
        self.comm, self.far = comm, far
        self.spaces = list(spaces)
        sizes = [s.dofmap.index_map_bs for s in self.spaces]
        maps = [s.dofmap.index_map for s in self.spaces]
        owned = [m.size_local for m in maps]
        ghosts = [m.num_ghosts for m in maps]
        first_owned = np.concatenate([[0], np.cumsum(np.multiply(owned, sizes))])
        of_spaces, here = int(first_owned[-1]), comm.rank == 0
        self.owned = of_spaces + 3 * (loose + apart * here)
        first_ghost = self.owned + np.concatenate([[0], np.cumsum(np.multiply(ghosts, sizes))])
        self.local = int(first_ghost[-1]) + 3 * apart * (not here)
        ends = of_spaces + 3 * loose, self.owned if here else self.local
        self.loose_dofs, self.apart_dofs = (
            np.arange(end - 3 * count, end, dtype=np.int32).reshape(-1, 3)
            for end, count in zip(ends, (loose, apart), strict=True)
        )
        last = np.vstack([self.loose_dofs, self.apart_dofs])
        self._block_offsets = np.concatenate([[0], np.cumsum(np.add(owned, ghosts))])
        # Per space: (blocks, size) local numbers, in the space's own order.
        self.space_dofs: list[np.ndarray] = []
        for k, size in enumerate(sizes):
            starts = np.concatenate(
                [
                    first_owned[k] + size * np.arange(owned[k]),
                    first_ghost[k] + size * np.arange(ghosts[k]),
                ]
            )
            self.space_dofs.append((starts[:, None] + np.arange(size)).astype(np.int32))
        every = [*self.space_dofs, last]
        self.first = np.concatenate([d[:, 0] for d in every]).astype(np.int32)
        self.width = np.concatenate([np.full(len(d), d.shape[1]) for d in every]).astype(np.int32)
        self.loose_blocks = int(self._block_offsets[-1]) + np.arange(loose)
        self.apart_blocks = int(self._block_offsets[-1]) + loose + np.arange(apart)
        if not self.spaces:
            self._have_no_cells()
            return
        tables = [compat.cell_dofs(s) for s in self.spaces]
        self.cell_blocks = np.ascontiguousarray(
            np.hstack([t + o for t, o in zip(tables, self._block_offsets, strict=False)]),
            dtype=np.int32,
        )
        self.cell_dofs = np.ascontiguousarray(
            np.hstack(
                [d[t].reshape(len(t), -1) for d, t in zip(self.space_dofs, tables, strict=True)]
            ),
            dtype=np.int32,
        )
        functions = [t.shape[1] for t in tables]
        self.dof_block = np.repeat(np.arange(sum(functions)), np.repeat(sizes, functions)).astype(
            np.int32
        )
        self.dof_component = np.concatenate(
            [np.tile(np.arange(s), f) for s, f in zip(sizes, functions, strict=True)]
        ).astype(np.int32)
        self.number = self._global_numbers(maps, sizes, first_owned)

    def _have_no_cells(self) -> None:
        self.cell_blocks = np.empty((0, 0), np.int32)
        self.cell_dofs = np.empty((0, 0), np.int32)
        self.dof_block = self.dof_component = np.empty(0, np.int32)
        self.number = np.arange(self.local, dtype=PETSc.IntType)

    def _global_numbers(
        self,
        maps: Sequence[dolfinx.common.IndexMap],
        sizes: Sequence[int],
        first_owned: np.ndarray,
    ) -> np.ndarray:
        """Global number of each local unknown, from the ranges that all processes own."""
        starts = np.array(self.comm.allgather([m.local_range[0] for m in maps]))
        offsets = np.array(self.comm.allgather(list(first_owned)))
        process_start = np.concatenate([[0], np.cumsum(self.comm.allgather(self.owned))])
        number = np.empty(self.local, dtype=PETSc.IntType)
        for k, (index_map, size) in enumerate(zip(maps, sizes, strict=True)):
            blocks = index_map.local_to_global(
                np.arange(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
            )
            owner = np.searchsorted(starts[:, k], blocks, side="right") - 1
            first = process_start[owner] + offsets[owner, k] + size * (blocks - starts[owner, k])
            number[self.space_dofs[k]] = first[:, None] + np.arange(size)
        number[self.loose_dofs] = self.loose_dofs
        last = process_start[1]  # of those of the first process
        number[self.apart_dofs] = (
            last - self.apart_dofs.size + np.arange(self.apart_dofs.size).reshape(-1, 3)
        )
        return number

    def create_vector(self) -> PETSc.Vec:
        """Ghosted PETSc vector of all unknowns."""
        return PETSc.Vec().createGhost(
            self.number[self.owned :], size=(self.owned, None), comm=self.comm
        )

    @functools.cached_property
    def _ghosted(self) -> PETSc.Vec:
        return self.create_vector()

    def to_local(self, vector: PETSc.Vec) -> np.ndarray:
        """Values of a PETSc vector of all unknowns, ghosts included, as a new array (local,)."""
        vector.copy(self._ghosted)
        self._ghosted.ghostUpdate(PETSc.InsertMode.INSERT, PETSc.ScatterMode.FORWARD)
        with self._ghosted.localForm() as local:
            return local.getArray(readonly=True).copy()

    def sum_shared(self, local: np.ndarray) -> np.ndarray:
        """Add up what all processes hold of each unknown; returns the sums, ghosts included."""
        with self._ghosted.localForm() as form:
            form.setArray(local)
        self._ghosted.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        self._ghosted.ghostUpdate(PETSc.InsertMode.INSERT, PETSc.ScatterMode.FORWARD)
        with self._ghosted.localForm() as form:
            return form.getArray(readonly=True).copy()
