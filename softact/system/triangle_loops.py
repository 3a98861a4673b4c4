"""Loops over the triangles of sheets and layers, compiled; see ``_triangles.c``."""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path

import numpy as np

from softact.mesh.triangles import MEMBRANE_RULE, VOLUME_RULE, Triangles, shape_gradients
from softact.system import jit
from softact.system.kernels import pointer


@functools.cache
def library() -> ctypes.CDLL:
    """The compiled loops. Each process asks for them by itself: not all have triangles."""
    source = Path(__file__).with_name("_triangles.c")
    return jit.load_text("triangles", source.read_text(encoding="utf-8"))


class _Triangles(ctypes.Structure):
    _fields_ = (
        ("count", ctypes.c_int64),
        ("nodes", ctypes.c_int32),
        ("slopes", ctypes.c_void_p),
        ("weights", ctypes.c_void_p),
        ("places", ctypes.c_void_p),
        ("frames", ctypes.c_void_p),
        ("dofs", ctypes.c_void_p),
    )


class TriangleLoops:
    """What the loops have to know of triangles.

    slopes: (k, q, 2, n) derivatives of the shape functions along the frames at the points of the
    membrane's rule, 1/mm; weights: (k, q) areas of the points, mm². frames: (k, q, 3, 2) of the
    triangles as they were made, where the deformation gradient is to come from displacements and
    not from places. The volume needs none of them.
    """

    def __init__(
        self,
        triangles: Triangles,
        slopes: np.ndarray | None = None,
        weights: np.ndarray | None = None,
        frames: np.ndarray | None = None,
    ):
        given = (slopes, weights, triangles.places, frames)
        doubles = [None if a is None else np.ascontiguousarray(a, dtype=float) for a in given]
        dofs = np.ascontiguousarray(triangles.dofs, dtype=np.int32)
        self._alive = doubles, dofs
        arrays = map(pointer, (*doubles, dofs))
        self.shape = triangles.nodes.shape
        self._on = _Triangles(*self.shape, *arrays)
        self._matrices: np.ndarray | None = None

    def __len__(self) -> int:
        return self.shape[0]

    def strain(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """F (k, q, 3, 2) and C (k q, 2, 2) at the unknowns (local,)."""
        points = len(MEMBRANE_RULE[1])
        f, c = np.empty((len(self), points, 3, 2)), np.empty((len(self) * points, 2, 2))
        x = np.ascontiguousarray(x, dtype=float)
        library().membrane_strain(ctypes.byref(self._on), *map(pointer, (x, f, c)))
        return f, c

    def add_force(self, f: np.ndarray, stress: np.ndarray, out: np.ndarray) -> None:
        """Add the nodal forces of the stress (k q, 3), N/mm, to ``out`` (local,)."""
        stress = np.ascontiguousarray(stress)
        library().membrane_force(ctypes.byref(self._on), *map(pointer, (f, stress, out)))

    def tangent(self, f: np.ndarray, moduli: np.ndarray, carried: np.ndarray) -> np.ndarray:
        """Matrices (k, n, 3, n, 3) of moduli (k q, 3, 3), N/mm, with the stress (k q, 3) of the
        geometric stiffness; until the next ones are asked for."""
        moduli, carried = np.ascontiguousarray(moduli), np.ascontiguousarray(carried)
        arrays = f, moduli, carried, self._room()
        library().membrane_tangent(ctypes.byref(self._on), *map(pointer, arrays))
        return arrays[-1]

    def _room(self) -> np.ndarray:
        """Element matrices, in the same place each time: a new one would have to be mapped."""
        if self._matrices is None:
            k, n = self.shape
            self._matrices = np.empty((k, n, 3, n, 3))
        return self._matrices


class _Volume(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_void_p) for name in ("table", "first", "flux"))


class VolumeLoops(TriangleLoops):
    """V = ∫ (W x) · (∂x/∂r × ∂x/∂s) dr ds of triangles, a polynomial in the places of their nodes,
    as Σ_a Σ_(b < c) T_abc (W x_a) · (x_b × x_c). flux: (3,) the diagonal of W."""

    def __init__(self, triangles: Triangles, flux: np.ndarray):
        super().__init__(triangles)
        points, weights = VOLUME_RULE
        r, s = np.moveaxis(shape_gradients(points, self.shape[1]), -1, 0)
        values = triangles.values(points) * (weights / 2)[:, None]  # of the reference triangle
        other, one = np.tril_indices(self.shape[1], -1)  # of the nodes, in the order of the loops
        table = values.T @ (r[:, one] * s[:, other] - r[:, other] * s[:, one])
        self._tables = table, table.sum(axis=0), np.ascontiguousarray(flux, dtype=float)
        self._of = _Volume(*map(pointer, self._tables))

    def volume(self, x: np.ndarray) -> float:
        """mm³."""
        found, x = np.zeros(1), np.ascontiguousarray(x, dtype=float)
        library().cavity_volume(*self._both(), pointer(x), pointer(found))
        return float(found[0])

    def add_gradient(self, x: np.ndarray, factor: float, out: np.ndarray) -> None:
        """Add ``factor`` times the derivative by the unknowns to ``out`` (local,)."""
        x = np.ascontiguousarray(x, dtype=float)
        library().cavity_gradient(*self._both(), pointer(x), ctypes.c_double(factor), pointer(out))

    def second(self, x: np.ndarray, factor: float) -> np.ndarray:
        """Matrices (k, n, 3, n, 3), ``factor`` times the second derivative; until the next ones are
        asked for."""
        x, found = np.ascontiguousarray(x, dtype=float), self._room()
        library().cavity_second(*self._both(), pointer(x), ctypes.c_double(factor), pointer(found))
        return found

    def _both(self) -> tuple[object, object]:
        return ctypes.byref(self._on), ctypes.byref(self._of)


def linearised_stress(
    f: np.ndarray, now: np.ndarray, stress: np.ndarray, moduli: np.ndarray
) -> np.ndarray:
    """Stress (m, 3) at the deformation gradients ``now`` (k, q, 3, 2), linearised at f, where it is
    ``stress`` (m, 3) with ``moduli`` (m, 3, 3)."""
    out = np.empty(stress.shape)
    arrays = f, now, np.ascontiguousarray(stress), np.ascontiguousarray(moduli), out
    library().membrane_linearised(ctypes.c_int64(len(stress)), *map(pointer, arrays))
    return out
