"""Laws of solids are compiled; they are what numpy makes of the law's formula."""

from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI

from softact.bodies.compiled_solid_law import compiled
from softact.materials.base import FibreLaw, Law
from softact.materials.tensors import full, symmetric
from softact.system import assembly, jit
from softact.system.kernels import pointer
from tests.materials.samples import SAMPLES


def _strains(count: int) -> np.ndarray:
    """C (n, 6) with stretches between about a half and two."""
    random = np.random.default_rng(count)
    f = np.eye(3) + 0.2 * random.standard_normal((count, 3, 3))
    f = np.where((np.linalg.det(f) > 0.1)[:, None, None], f, np.eye(3))
    return symmetric(f.transpose(0, 2, 1) @ f)


def _fibres(law: Law, count: int) -> np.ndarray | None:
    if not isinstance(law, FibreLaw):
        return None
    random = np.random.default_rng(7)
    fibres = random.standard_normal((count, law.families, 3))
    return fibres / np.linalg.norm(fibres, axis=2, keepdims=True)


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("count", [1, 8, 203])  # some are no multiple of the vectors' length
def test_stress_and_moduli_are_those_of_the_formula(name, count):
    material, c, fibres = SAMPLES[name].material(), _strains(count), _fibres(SAMPLES[name], count)
    function = compiled(MPI.COMM_SELF, material, fibres)
    assert function is not None
    for found, expected in zip(
        function.stress_tangent(c, fibres), material.stress_tangent(full(c), fibres), strict=True
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-12 * abs(expected).max())


@pytest.mark.parametrize("name", ["ogden_3", "linear"])
def test_equal_stretches_are_no_special_case(name):
    """Undeformed, two stretches alike, and nearly alike."""
    one, near = np.eye(3), np.diag([1.3, 1.3 + 1e-9, 0.7])
    material = SAMPLES[name].material()
    c = symmetric(
        np.stack([one, np.diag([1.3, 1.3, 0.7]), near, np.diag([0.7, 1.3, 1.3]), 2 * one])
    )
    function = compiled(MPI.COMM_SELF, material, None)
    for found, expected in zip(
        function.stress_tangent(c, None), material.stress_tangent(full(c)), strict=True
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12 * abs(expected).max())


def test_the_carried_stress_is_linear_in_the_displacement():
    """S + D : sym(F0ᵀ (F − F0)), shear strains counted twice."""
    random = np.random.default_rng(4)
    before, now = random.standard_normal((2, 7, 3, 3))
    stress, moduli = random.standard_normal((7, 6)), random.standard_normal((7, 6, 6))
    loops = Path(assembly.__file__).with_name("_assembly.c")
    library, out = jit.load_library(MPI.COMM_SELF, loops), np.empty((7, 6))
    library.carried_stress(7, *map(pointer, (before, now, stress, moduli, out)))
    strain = before.transpose(0, 2, 1) @ (now - before)
    strain = symmetric(strain + strain.transpose(0, 2, 1)) * [0.5, 0.5, 0.5, 1, 1, 1]
    np.testing.assert_allclose(out, stress + np.einsum("nij,nj->ni", moduli, strain), rtol=1e-12)
