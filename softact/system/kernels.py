"""FFCx's element kernels, run over cells or facets by the loops of ``_assembly.c``."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from softact.system.assembly import Assembler


def pointer(array: np.ndarray | None) -> ctypes.c_void_p:
    """Where an array begins, for C."""
    return ctypes.c_void_p(array.ctypes.data) if array is not None else ctypes.c_void_p()


class _Coefficient(ctypes.Structure):
    _fields_ = (
        ("data", ctypes.c_void_p),
        ("table", ctypes.c_void_p),
        ("width", ctypes.c_int32),
        ("stride", ctypes.c_int32),
    )


class Entities(ctypes.Structure):
    """What a loop of ``_assembly.c`` goes over."""

    _fields_ = (
        ("count", ctypes.c_int64),
        ("cells", ctypes.c_void_p),
        ("facets", ctypes.c_void_p),
        ("nodes", ctypes.c_void_p),
        ("points", ctypes.c_void_p),
        ("shape", ctypes.c_int32),
        ("constants", ctypes.c_void_p),
        ("coefficient_count", ctypes.c_int32),
        ("coefficients", ctypes.POINTER(_Coefficient)),
    )


@dataclass(frozen=True)
class Coefficient:
    """Values that a kernel reads: by dof table (columns 0 to ``width`` of ``table``) or, with
    ``table`` None, ``width`` values for each entity in order."""

    data: np.ndarray
    width: int
    table: np.ndarray | None = None


class Kernel:
    """One element kernel on a set of entities: (k,) cells, or (k, 2) cells and local facets."""

    def __init__(self, assembler: Assembler, address: ctypes.c_void_p, entities: np.ndarray):
        self.address = address
        self._assembler = assembler
        entities = np.asarray(entities, dtype=np.int32)
        on_facets = entities.ndim == 2
        self._cells = np.ascontiguousarray(entities[:, 0] if on_facets else entities)
        self._facets = np.ascontiguousarray(entities[:, 1]) if on_facets else None

    def _entities(
        self, coefficients: Sequence[Coefficient], constants: Sequence[float]
    ) -> tuple[Entities, tuple[object, ...]]:
        """What a loop goes over, and what has to live as long as it is used."""
        array = (_Coefficient * max(1, len(coefficients)))()
        for slot, c in zip(array, coefficients, strict=False):
            assert c.data.dtype == np.float64 and c.data.flags.c_contiguous
            slot.data, slot.table = c.data.ctypes.data, None
            slot.width = c.width
            if c.table is not None:
                slot.table, slot.stride = c.table.ctypes.data, c.table.shape[1]
        values = np.ascontiguousarray(constants, dtype=float)
        on = Entities(
            len(self._cells),
            pointer(self._cells),
            pointer(self._facets),
            pointer(self._assembler.geometry_nodes),
            pointer(self._assembler.points),
            self._assembler.geometry_nodes.shape[1],
            pointer(values),
            len(coefficients),
            array,
        )
        return on, (values, array)

    def scalar(
        self, coefficients: Sequence[Coefficient] = (), constants: Sequence[float] = ()
    ) -> float:
        """Sum of a functional over this process's entities."""
        on, _alive = self._entities(coefficients, constants)
        return self._assembler.library.assemble_scalar(self.address, ctypes.byref(on))

    def add_vector(
        self,
        out: np.ndarray,
        size: int,
        coefficients: Sequence[Coefficient] = (),
        constants: Sequence[float] = (),
    ) -> None:
        """Add a linear form over the first ``size`` dofs of each cell to ``out`` (local,)."""
        on, _alive = self._entities(coefficients, constants)
        dofs = self._assembler.unknowns.cell_dofs
        self._assembler.library.assemble_vector(
            self.address, ctypes.byref(on), pointer(dofs), dofs.shape[1], size, pointer(out)
        )

    def add_matrix(
        self, size: int, coefficients: Sequence[Coefficient] = (), constants: Sequence[float] = ()
    ) -> None:
        """Add a bilinear form over the first ``size`` dofs to the assembler's matrix values."""
        on, _alive = self._entities(coefficients, constants)
        self._assembler.add_matrix(self.address, on, size)
