"""Working space of the factorisation: a sheet that carries nothing delays many pivots."""

import numpy as np
import pytest

from softact.bodies.sheet import Ply, Sheet
from softact.loads.support import Support
from softact.materials import LAWS
from softact.mesh.sheets import SheetMesh
from softact.solve import mumps_factor
from softact.solve.newton import Newton
from softact.system.rotation import rotation_about
from softact.system.term import EVERYTHING, TimeStep
from tests.analytic.sheet_meshes import build, edges_of, grid

NYLON = LAWS["linear"].of(youngs_modulus=498.0, poissons_ratio=0.35)
SIZE, TIME_STEP, GRAVITY = 40.0, 1e-2, 1.0
TURN = rotation_about(np.array([0.3, 1.0, 0.2]), 40.0)


def fallen(slack: int, monkeypatch):
    """A square sheet without stress that leans, held along one side, after a time step of its fall
    from rest: displacements (n, 3) and the space that the factors had (percent)."""
    monkeypatch.setattr(mumps_factor, "SPACE", mumps_factor.WorkingSpace(of_sheets=slack))

    def place(s):
        return SIZE * np.column_stack([s, np.zeros(len(s))]) @ TURN.T

    points, triangles, ends = grid((12, 12), place)
    mesh = SheetMesh(
        points, triangles, {"sheet": np.arange(len(triangles))}, {"held": edges_of(ends[0])}
    )
    model = build(mesh, Sheet([Ply(NYLON, 0.2)], bending=0.0))
    model.add_inertia()
    state = model.initial_state()
    rest = np.zeros_like(state.x)
    state.motion = TimeStep(1 / TIME_STEP**2, rest, rest)
    state.put("gravity", {EVERYTHING: np.array([0.0, 0.0, -GRAVITY])})
    solver = Newton(model, 1e-8, 15)
    solver.set_supports([Support("held", {0: 0.0, 1: 0.0, 2: 0.0})], state)
    assert solver.solve(state, solver.held(state).end).converged
    return state.x[model.nodes.dofs], solver.factor._space


def test_too_little_space_is_made_more(monkeypatch):
    """With a tenth of what MUMPS estimates the factors do not fit at first; then the answer is that
    of ample space: across its plane the sheet has no stiffness, and far from the held side it
    falls freely, by g·n Δt² in a step of backward Euler."""
    little, space = fallen(-90, monkeypatch)
    ample, kept = fallen(400, monkeypatch)
    assert space >= mumps_factor.WorkingSpace().usual and kept == 400
    np.testing.assert_allclose(little, ample, atol=1e-9 * GRAVITY * TIME_STEP**2)
    normal = TURN[:, 2]
    free = -GRAVITY * normal[2] * TIME_STEP**2
    assert np.median(ample @ normal) == pytest.approx(free, rel=1e-3)
