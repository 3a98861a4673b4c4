"""Forces and tangents of a model's terms, and their central differences.

A difference over a step h is wrong by h² times a third derivative.
"""

from __future__ import annotations

import numpy as np
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
