"""Forces and tangents of a model's terms, and their central differences.

A difference over a step h is wrong by h² times a third derivative.
"""

from __future__ import annotations

import numpy as np
import pytest
from petsc4py import PETSc

from softact.system.term import State

STEP = 1e-5


def moved(state, change):
    return State(**{**vars(state), "x": state.x + change})


def force(model, term, state):
    out = np.zeros(model.unknowns.local)
    term.add_force(state, out)
    return out


def tangent(model, terms, state):
    """The matrix of some terms, dense."""
    model.assembler.fixed[:] = 0
    model.assembler.clear()
    for term in terms:
        term.add_tangent(state, None)
    return dense(model.assembler.finish_matrix())


def dense(matrix: PETSc.Mat) -> np.ndarray:
    copy = PETSc.Mat()
    return matrix.convert("dense", copy).getDenseArray().copy()


def slope(function, state, direction, step=STEP):
    """Central difference of ``function(state)`` along ``direction``."""
    ahead, behind = (function(moved(state, s * step * direction)) for s in (1, -1))
    return (ahead - behind) / (2 * step)


def to_global(model, local):
    out = np.empty_like(local)
    out[model.unknowns.number] = local
    return out


def to_local(model, values):
    return values[model.unknowns.number]


def assert_contact_tangent(model, term, state, friction, least, off, step=STEP):
    """Force against energy, tangent against force, in a direction that is drawn.

    friction: coefficient; with it the tangent is not symmetric and there is no energy. least: what
    the largest entry exceeds, N/mm, or nothing touches. off: largest relative deviation of the
    tangent: a point that begins to touch, to slip or to face another facet within the step has no
    derivative there.
    """
    direction = np.random.default_rng(2).standard_normal(model.unknowns.local)
    matrix = tangent(model, [term], state)
    assert np.abs(matrix).max() > least
    found = to_local(model, matrix @ to_global(model, direction))
    expected = slope(lambda s: force(model, term, s), state, direction, step)
    assert np.linalg.norm(found - expected) <= off * np.linalg.norm(expected)
    if friction:
        assert np.abs(matrix - matrix.T).max() > 1e-3 * np.abs(matrix).max()
    else:
        np.testing.assert_allclose(matrix, matrix.T, atol=1e-12 * np.abs(matrix).max())
        work = slope(lambda s: term.energy(s), state, direction)
        assert force(model, term, state) @ direction == pytest.approx(work, rel=1e-5)
