"""Laws of invariants in solids, compiled.

The same as ``InvariantMaterial``, point by point in C. The formula is the law's own, see
``softact.materials.traced``.
"""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.materials.base import Material
from softact.materials.invariants import InvariantMaterial
from softact.materials.traced import formula_in_c
from softact.system import jit
from softact.system.kernels import pointer

if TYPE_CHECKING:
    from mpi4py import MPI


class InvariantSolid:
    """Stress and tangent of a law; families: of fibres."""

    def __init__(self, comm: MPI.Comm, material: InvariantMaterial, families: int):
        formula, self._constants = formula_in_c(material.law, families)
        source = Path(__file__).with_name("_invariant_solid.c").read_text(encoding="utf-8")
        text = "\n".join(["#include <math.h>", "#include <stdint.h>", formula, source])
        self._function = jit.load_text("invariant_solid", text, comm).solid_response

    def stress_tangent(
        self, strains: np.ndarray, fibres: np.ndarray | None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Stress (n, 6) and moduli (n, 6, 6), MPa, at C (n, 6), det C > 0. fibres: (n, families, 3)
        unit vectors, None: none."""
        count = len(strains)
        along = np.zeros(0) if fibres is None else fibres
        given = [np.ascontiguousarray(a, float) for a in (strains, along)]
        stress, moduli = np.empty((count, 6)), np.empty((count, 6, 6))
        arrays = (*given, self._constants, stress, moduli)
        self._function(ctypes.c_int64(count), *map(pointer, arrays))
        return stress, moduli


def compiled(
    comm: MPI.Comm, material: Material, fibres: np.ndarray | None
) -> InvariantSolid | None:
    """The material's law, compiled; None: it is another. fibres: (n, families, 3). Collective."""
    if not isinstance(material, InvariantMaterial):
        return None
    material.check_fibres(fibres)
    return InvariantSolid(comm, material, 0 if fibres is None else fibres.shape[1])
