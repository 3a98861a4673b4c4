"""Mullins' softening in the solver against the closed form of Ogden and Roxburgh (1999)."""

import numpy as np
import pytest
from scipy.special import erf

from softact.loads.load_step import LoadStep
from softact.materials import LAWS
from softact.model import Support
from tests.analytic.meshes import block
from tests.analytic.solving import ROLLERS, build, solve

C10, R, M, BETA = 0.1, 1.6, 0.02, 0.15
WAY = (1.5, 1.2, 1.0, 1.3, 1.5, 1.8, 1.1)  # loading, unloading, reloading, beyond, back
MODES = {"uniaxial": lambda s: s**-0.5, "biaxial": lambda s: s}


def material():
    return LAWS["neo_hookean"].of(
        c10=C10, bulk_modulus=1e8, mullins={"r": R, "m": f"{M} MPa", "beta": BETA}
    )


def invariant(mode, s):
    across = MODES[mode](s)
    return s**2 + across**2 + (s * across) ** -2 - 3


def closed_form(mode, s, furthest):
    """Nominal stress along x in MPa where the stretch has been ``furthest``."""
    energy, peak = (C10 * invariant(mode, x) for x in (s, furthest))
    eta = 1 - erf((peak - energy) / (M + BETA * peak)) / R
    across = MODES[mode](s)
    return eta * 2 * C10 * (s**2 - (s * across) ** -2) / s


def way(mode, model):
    steps = []
    for number, s in enumerate(WAY):
        held = [*ROLLERS, Support("x_max", {0: s - 1})]
        if mode == "biaxial":
            held.append(Support("y_max", {1: s - 1}))
        steps.append(LoadStep(f"{number}", held))
    return solve(model, steps, ROLLERS, 0.25)


@pytest.mark.parametrize("mode", MODES)
def test_closed_form(mode):
    model = build(block((1, 1, 1)), material())
    solution = way(mode, model)
    found = [solution.reaction("x_max", state)[0] for state in solution.ends]
    furthest = np.maximum.accumulate(WAY)
    expected = [closed_form(mode, s, f) for s, f in zip(WAY, furthest, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-9)
    virgin = closed_form(mode, 1.2, 1.2)
    assert found[1] < 0.9 * virgin


def test_work_is_stored_or_lost():
    """Work of the support on the way = what comes back + what does not, to the trapezoidal rule."""
    model = build(block((1, 1, 1)), material())
    step = [
        LoadStep(str(i), [*ROLLERS, Support("x_max", {0: s - 1})])
        for i, s in enumerate((1.6, 1.25))
    ]
    solution = solve(model, step, ROLLERS, 0.02)
    body = model.solids["body"]
    where = [1 + solution_displacement(model, state) for state in solution.path]
    force = [solution.reaction("x_max", state)[0] for state in solution.path]
    work = np.trapezoid(force, where) if hasattr(np, "trapezoid") else np.trapz(force, where)
    stored, lost = model.strain_energy(solution.state), body.softened_away(solution.state)
    assert stored + lost == pytest.approx(work, rel=1e-3)
    assert lost > 0.1 * work


def solution_displacement(model, state):
    return float(state.x[model.displacement_dofs[model.surfaces.nodes("x_max"), 0]].mean())


def test_a_way_that_was_given_up_is_not_remembered():
    """What the solid remembers goes back; what contacts keep stays."""
    model = build(block((1, 1, 1)), material())
    solution = way("uniaxial", model)
    early, late = solution.ends[0], solution.state
    assert (late.memory["solid body.peak"] > early.memory["solid body.peak"]).all()
    late.memory["touch.slip"] = 3.0
    model.recall(late, early.memory)
    assert late.memory == {**early.memory, "touch.slip": 3.0}
