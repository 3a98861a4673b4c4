"""Rows of the tangent are scaled where MUMPS has to delay pivots, and only there."""

import numpy as np

from softact.solve.mumps_factor import DELAYED, SCALED, SCALING, UNSCALED
from tests.solve.test_pardiso import apart, newton_of

ALMOST_ONE = 1 + 1e-12


def factorised_again(newton):
    newton.factor.follow_layout()
    newton.factor.again()
    newton.factor.fresh = True
    return newton.factor


def answer(newton):
    """Of the tangent to a right-hand side (owned,)."""
    return newton.factor.solve_all(np.sin(np.arange(newton.model.unknowns.owned))[None])


def test_a_usual_tangent_delays_no_pivot_and_is_not_scaled():
    newton = newton_of("mumps")
    assert factorised_again(newton)._scaling == UNSCALED


def test_a_tangent_that_delays_pivots_is_scaled_from_then_on():
    """An unstable block's, with a threshold that few pivots pass. Answer and inertia stay."""
    newton = newton_of("mumps", cells=(8, 8, 8), shortened=0.7)
    factor = newton.factor
    before, modes = answer(newton), factor.unstable_modes()
    factor._matrix.setMumpsCntl(1, 0.5)
    newton.model.assembler.matrix.scale(ALMOST_ONE)  # PETSc factorises again only what has changed
    assert factorised_again(newton)._matrix.getMumpsInfog(DELAYED) > 500
    newton.model.assembler.matrix.scale(ALMOST_ONE)
    again = factorised_again(newton)
    assert again._scaling == SCALED and again._matrix.getMumpsIcntl(SCALING) == SCALED
    assert again.unstable_modes() == modes > 0
    assert apart(answer(newton), before) < 1e-9
    again.set_up()
    assert factorised_again(newton)._matrix.getMumpsIcntl(SCALING) == SCALED
