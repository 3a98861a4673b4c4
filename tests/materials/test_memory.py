"""Prony series and Mullins' softening as formulas, against quadrature and by hand."""

import numpy as np
import pytest
import scipy.integrate
from pydantic import ValidationError

from softact.materials.mullins import Mullins
from softact.materials.viscoelastic import Shift, Viscoelastic


def series(constants="long_time", g=(0.2, 0.1), tau=("0.5 s", "4 s"), **more):
    return Viscoelastic(g=list(g), tau=list(tau), constants=constants, **more)


def test_moduli_of_both_kinds_of_constants():
    """G∞/G₀ = 1 − Σ g: of long-time constants G∞ is 1, of instantaneous ones G₀ is."""
    slow, fast = series().prony, series("instantaneous").prony
    assert slow.elastic == pytest.approx(1.0)
    assert slow.over(0.0).total == pytest.approx(1 / 0.7)
    assert fast.elastic == pytest.approx(0.7)
    assert fast.over(0.0).total == pytest.approx(1.0)
    assert fast.over(np.inf).total == fast.elastic


@pytest.mark.parametrize("elapsed", [1e-9, 1e-3, 0.3, 5.0, 1e3])
def test_step_is_exact_for_a_constant_rate(elapsed):
    """h₁ = exp(−Δt/τ) h₀ + ∫ exp(−(Δt − s)/τ) ds Ṡ, by quadrature."""
    prony = series().prony
    step = prony.over(elapsed)
    for tau, decay, growth in zip(prony.times, step.decay, step.growth, strict=True):
        grid = np.linspace(0.0, 1.0, 20001)
        kernel = np.exp(-elapsed * (1 - grid) / tau)
        if elapsed < 100:
            assert growth == pytest.approx(scipy.integrate.simpson(kernel, x=grid), rel=1e-9)
        assert decay == pytest.approx(np.exp(-elapsed / tau))


@pytest.mark.parametrize("elapsed", [1e-3, 0.04, 0.3, 5.0])
def test_error_estimates(elapsed):
    """S = t²/2 has a second rate of 1; S = 1 − exp(−t/τ) goes to rest as fast as the element."""
    for tau in (0.5, 4.0):
        prony = series(g=(0.5,), tau=(f"{tau} s",)).prony
        step, (share,) = prony.over(elapsed), prony.shares

        def exact(rate, tau=tau):
            kernel = lambda s: np.exp(-(elapsed - s) / tau) * rate(s)  # noqa: E731
            return scipy.integrate.quad(kernel, 0.0, elapsed, epsabs=0.0, epsrel=1e-13)[0]

        one = abs(step.growth[0] * elapsed**2 / 2 - exact(lambda s: s))
        parabola = one / (1 - step.decay[0])  # one after the other, each decaying
        assert prony.curved(elapsed) == pytest.approx(share * parabola, rel=1e-2)
        change = 1 - np.exp(-elapsed / tau)
        rest = abs(step.growth[0] * change - exact(lambda s, tau=tau: np.exp(-s / tau) / tau))
        assert prony.sudden(elapsed) * change == pytest.approx(share * rest, rel=1e-2)


def test_wlf_shift():
    """By hand: −17.44 · 30/(51.6 + 30) = −6.41: times fall by that many decades."""
    shift = Shift(c1=17.44, c2=51.6, reference=-50.0, temperature=-20.0)
    assert np.log10(shift.factor) == pytest.approx(-17.44 * 30 / 81.6)
    moved = series(wlf=shift).prony
    np.testing.assert_allclose(moved.times, shift.factor * series().prony.times)
    with pytest.raises(ValidationError, match=r"no value at or below -101\.6 °C"):
        Shift(c1=17.44, c2=51.6, reference=-50.0, temperature=-110.0)


def test_mullins_energies_by_quadrature():
    """What comes back is ∫ η dW; work of a loop is what is lost; η is 1 on the first way."""
    law = Mullins(r=1.7, m="20 kPa", beta=0.1)
    peak = 0.3
    for energy in (0.01, 0.1, 0.25, 0.3):
        back = scipy.integrate.quad(lambda w: law.softening(np.array(w), peak)[0], 0.0, energy)[0]
        assert law.recoverable(np.array(energy), peak) == pytest.approx(back, rel=1e-9)
    assert law.lost(np.array(peak)) == pytest.approx(peak - back, rel=1e-9)
    assert law.softening(np.array([peak]), np.array([peak]))[0] == 1.0
    one, slope = law.softening(np.array([0.27]), np.array([peak]))
    there = [law.softening(np.array([0.27 + h]), np.array([peak]))[0] for h in (1e-6, -1e-6)]
    assert slope == pytest.approx((there[0] - there[1]) / 2e-6, rel=1e-6)
    assert 1 - 1 / 1.7 < one < 1
