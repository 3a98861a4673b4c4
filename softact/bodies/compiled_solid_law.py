"""Laws of solids, compiled: those of invariants and those of principal stretches.

The same as ``InvariantMaterial`` and ``StretchMaterial``, point by point in C. The formula is the
law's own, see ``softact.materials.traced``.
"""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from softact.materials import stretches
from softact.materials.base import Material
from softact.materials.invariants import InvariantMaterial
from softact.materials.stretches import StretchMaterial
from softact.materials.traced import formula_in_c, stretch_formula_in_c
from softact.system import jit
from softact.system.kernels import pointer

if TYPE_CHECKING:
    from mpi4py import MPI


class CompiledLaw:
    """Stress and tangent of a law. formula: of the law in C; constants: in it; source: name of the
    file with the rest."""

    def __init__(self, comm: MPI.Comm, formula: str, constants: np.ndarray, source: str):
        rest = Path(__file__).with_name(f"_{source}.c").read_text(encoding="utf-8")
        text = "\n".join(["#include <math.h>", "#include <stdint.h>", formula, rest])
        self._function = jit.load_text(source, text, comm).solid_response
        self._constants = constants

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


def compiled(comm: MPI.Comm, material: Material, fibres: np.ndarray | None) -> CompiledLaw | None:
    """The material's law, compiled; None: it is another. fibres: (n, families, 3). Collective."""
    material.check_fibres(fibres)
    if isinstance(material, InvariantMaterial):
        families = 0 if fibres is None else fibres.shape[1]
        return CompiledLaw(comm, *formula_in_c(material.law, families), "invariant_solid")
    if isinstance(material, StretchMaterial):
        formula, constants = stretch_formula_in_c(material.law)
        near = f"#define NEAR {stretches.NEAR!r}\n"
        return CompiledLaw(comm, near + formula, constants, "stretch_solid")
    return None
