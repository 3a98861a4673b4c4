"""Sheets and layers that creep and soften: closed forms, and differential equations that are solved
without increments, see ``maxwell``."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.integrate
from scipy.special import erf

from softact.bodies.layer import BondedLayer
from softact.bodies.sheet import Ply, Sheet
from softact.errors import SpecError
from softact.loads.load_step import LoadStep
from softact.loads.timing import Hold, Timing
from softact.materials import LAWS
from softact.materials.viscoelastic import Viscoelastic
from softact.model import Support
from softact.system.term import Clock
from tests.analytic import maxwell
from tests.analytic.differences import dense, slope, to_global, to_local
from tests.analytic.meshes import block
from tests.analytic.sheet_meshes import build, rectangle
from tests.analytic.solving import build as build_solid
from tests.analytic.solving import solve
from tests.analytic.test_mullins import BETA, C10, M, R

T = 0.2
SERIES = {"g": [0.25, 0.15], "tau": ["0.3 s", "4 s"], "constants": "long_time"}
SOFTENING = {"r": R, "m": f"{M} MPa", "beta": BETA}
HELD = LoadStep("hold", timing=Timing(5.0, Hold()))


def rubber(c10=maxwell.C10, **memory):
    law = LAWS["neo_hookean"].of(c10=c10, bulk_modulus=100.0, **memory)
    return Sheet([Ply(law, T, incompressible=True)], bending=0.0)


def strip(sheet):
    """A square of 1 mm that can be drawn along x, free across."""
    return build(rectangle((1, 1), (1.0, 1.0)), sheet)


FLAT = [Support("x_min", {0: 0.0}), Support("y_min", {1: 0.0}), Support("sheet", {2: 0.0})]


def drawn(stretch, duration=None):
    timing = None if duration is None else Timing(duration)
    return LoadStep("pull", [*FLAT, Support("x_max", {0: stretch - 1})], timing=timing)


def nominal(solution):
    """Stress (n,) MPa at the states after the first."""
    return np.array([solution.reaction("x_max", s)[0] / T for s in solution.path[1:]])


def test_relaxation_of_a_sheet():
    """Stretched to 1.6 in 0.2 s and held, as a bar of that silicone: 0.1 % at each increment."""
    solution = solve(strip(rubber(viscoelastic=SERIES)), [drawn(1.6, 0.2), HELD], FLAT, 0.1)
    times = np.array([state.clock.now for state in solution.path[1:]])
    prony = Viscoelastic.model_validate(SERIES).prony
    expected = maxwell.force_of_stretch(prony, lambda t: 1 + 0.6 * min(t / 0.2, 1.0), times)
    np.testing.assert_allclose(nominal(solution), expected, rtol=1e-3)
    assert expected[-1] < 0.8 * max(expected)


def test_softening_of_a_sheet():
    """Drawn to 1.6, let go to 1.25, drawn to 1.8: η times the law's stress (Ogden, Roxburgh)."""
    model = strip(rubber(C10, mullins=SOFTENING))
    steps = [drawn(stretch) for stretch in (1.6, 1.25, 1.8)]
    solution = solve(model, steps, FLAT, 0.25)
    dofs = model.displacement_dofs[model.surfaces.nodes("x_max"), 0]
    stretch = np.array([1 + s.x[dofs].mean() for s in solution.path[1:]])
    law = 2 * C10 * (stretch - stretch**-2)
    energy = C10 * (stretch**2 + 2 / stretch - 3)
    peak = np.maximum.accumulate(energy)
    eta = 1 - erf((peak - energy) / (M + BETA * peak)) / R
    np.testing.assert_allclose(nominal(solution), eta * law, rtol=1e-6)
    assert eta.min() < 0.95
    (part,) = model.remembering
    never = M + BETA * peak[-1]  # at the largest peak: W less what comes back of it
    gone = peak[-1] / never
    back = peak[-1] - never * (gone * erf(gone) + (np.exp(-(gone**2)) - 1) / np.sqrt(np.pi)) / R
    assert part.softened_away(solution.state) == pytest.approx(T * (peak[-1] - back), rel=1e-6)


def test_relaxation_of_a_layer_on_a_block():
    """A stiff layer, plane stress without lateral contraction, on an elastic block in plane strain:
    P = 2 C10 (λ − λ⁻³) + t λ S(t), S that of its Maxwell elements."""
    young, thickness, c10 = 20.0, 0.1, 0.05
    film = LAWS["linear"].of(youngs_modulus=young, poissons_ratio=0.0, viscoelastic=SERIES)
    layer = BondedLayer("z_min", film, thickness, bending=0.0, relaxed=False)
    soft = LAWS["neo_hookean"].of(c10=c10, bulk_modulus=5e4)
    model = build_solid(block((2, 1, 1)), soft, layers=[layer])
    sides = [Support(f"{a}_{end}", {n: 0.0}) for n, a in enumerate("xy") for end in ("min",)]
    sides += [Support("y_max", {1: 0.0}), Support("z_min", {2: 0.0})]
    pull = LoadStep("pull", [*sides, Support("x_max", {0: 0.5})], timing=Timing(0.2))
    solution = solve(model, [pull, HELD], sides, 0.1)
    times = np.array([state.clock.now for state in solution.path[1:]])
    length = np.ptp(model.nodes.places[:, 0])
    width, height = np.ptp(model.nodes.places[:, 1]), np.ptp(model.nodes.places[:, 2])

    def stretch(t):
        return 1 + 0.5 / length * min(t / 0.2, 1.0)

    prony = Viscoelastic.model_validate(SERIES).prony

    def rate(t, alpha):
        return (young * (stretch(t) ** 2 - 1) / 2 - alpha) / prony.times

    alpha = scipy.integrate.solve_ivp(
        rate, (0, times[-1]), np.zeros(2), "LSODA", times, rtol=1e-9, atol=1e-12, max_step=0.05
    ).y
    lam = np.array([stretch(t) for t in times])
    s = young * (lam**2 - 1) / 2
    film_stress = prony.elastic * s + prony.shares @ (s - alpha)
    expected = width * (height * 2 * c10 * (lam - lam**-3) + thickness * lam * film_stress)
    found = [solution.reaction("x_max", state)[0] for state in solution.path[1:]]
    np.testing.assert_allclose(found, expected, rtol=2e-3)


@pytest.mark.parametrize("softens", [False, True])
@pytest.mark.parametrize("creeps", [False, True])
def test_tangent_is_slope_of_force(creeps, softens):
    """Of a state in the middle of a time step, points on their way up and down."""
    memory = {"viscoelastic": SERIES} if creeps else {}
    memory |= {"mullins": SOFTENING} if softens else {}
    model = build(rectangle((2, 2), (1.0, 1.0)), rubber(C10, **memory))
    rng = np.random.default_rng(5)
    place = model.nodes.places

    def somewhere(stretch):
        state = model.initial_state()
        state.x[model.nodes.dofs] = (stretch - 1) * place + 0.05 * rng.standard_normal(place.shape)
        return state

    before = somewhere(1.5)
    before.clock = Clock(0.3, 0.0, True)
    model.remember(before)
    state = somewhere(1.45)
    follows = replace(state, memory={}, clock=Clock(0.7, 0.3, True))
    state.memory, state.clock = before.memory, Clock(0.7, 0.3, True)
    direction = rng.standard_normal(model.unknowns.local)
    found = to_local(model, dense(model.tangent(state)) @ to_global(model, direction))
    expected = slope(lambda s: model.force(s)[0], state, direction)
    assert np.linalg.norm(found - expected) <= 1e-6 * np.linalg.norm(expected)
    changed = np.linalg.norm(model.force(state)[0] - model.force(follows)[0])
    assert (changed > 1e-4) == (creeps or softens)


def test_wrinkles_on_a_curved_layer_remember_nothing():
    film = LAWS["linear"].of(youngs_modulus=20.0, poissons_ratio=0.3, viscoelastic=SERIES)
    with pytest.raises(SpecError, match=r"layer on 'z_min': without bending .*: resolved"):
        build_solid(block((1, 1, 1)), LAWS["neo_hookean"].of(c10=0.1, bulk_modulus=50.0),
                    layers=[BondedLayer("z_min", film, 0.1, bending=0.0)])  # fmt: skip
