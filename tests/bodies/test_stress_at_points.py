"""Loops over points beside numpy and scipy."""

import ctypes
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from mpi4py import MPI

import softact.system
from softact.materials.tensors import symmetric
from softact.system import jit
from softact.system.assembly import pointer

RANDOM = np.random.default_rng(3)
POINTS = 40
F = np.eye(3) + 0.3 * RANDOM.standard_normal((POINTS, 3, 3))
F[0] = np.diag([20.0, 0.2, 0.3]) @ scipy.linalg.expm([[0, 1, 2], [-1, 0, 1], [-2, -1, 0]])
F = F[np.linalg.det(F) > 0.05]
S = RANDOM.standard_normal((len(F), 3, 3))
S = S + S.swapaxes(1, 2)


def at_points(loop, *known, entries=6):
    library = jit.load_library(
        MPI.COMM_SELF, Path(softact.system.__file__).with_name("_assembly.c")
    )
    out = np.empty((len(F), entries))
    arrays = [np.ascontiguousarray(a) for a in known]
    getattr(library, loop)(ctypes.c_int64(len(F)), *map(pointer, arrays), pointer(out))
    return out


def test_strains():
    assert at_points("jacobians", F, entries=1)[:, 0] == pytest.approx(np.linalg.det(F), rel=1e-12)
    exact = symmetric(F.swapaxes(1, 2) @ F)
    assert at_points("right_cauchy_green", F) == pytest.approx(exact, rel=1e-12, abs=1e-13)


def test_cauchy_stress_is_the_second_piola_stress_pushed_forward():
    p = RANDOM.standard_normal(len(F))
    jacobian = np.linalg.det(F)[:, None, None]
    exact = F @ S @ F.swapaxes(1, 2) / jacobian + p[:, None, None] * np.eye(3)
    found = at_points("cauchy_stress", F, symmetric(S), p, entries=9).reshape(F.shape)
    assert found == pytest.approx(exact, rel=1e-11, abs=1e-11)


def test_nominal_stress_is_that_of_the_polar_decomposition():
    found = at_points("nominal_stress", F, S)
    for f, sigma, stress in zip(F, S, found, strict=True):
        _, left = scipy.linalg.polar(f, side="left")
        product = np.linalg.det(f) * sigma @ np.linalg.inv(left)
        exact = symmetric((product + product.T)[None] / 2)[0]
        assert stress == pytest.approx(exact, rel=1e-9, abs=1e-9 * np.abs(exact).max())


def test_principal_nominal_stresses_are_forces_per_undeformed_area():
    """J σᵢ/λᵢ where the stress has the axes of the stretch, whatever rotates."""
    turn = scipy.linalg.expm([[0, 1, 2], [-1, 0, 1], [-2, -1, 0]])
    stretches, stresses = np.array([2.0, 0.8, 0.7]), np.array([3.0, 1.0, -0.5])
    f = np.broadcast_to(np.diag(stretches) @ turn, F.shape)
    found = at_points("nominal_stress", f, np.broadcast_to(np.diag(stresses), F.shape))
    exact = np.prod(stretches) * stresses / stretches
    assert found[0] == pytest.approx([*exact, 0, 0, 0], abs=1e-12)
