"""Homogeneous modes of every isotropic law, in the solver, against the incompressible closed form.

A cube of six quadratic tetrahedra with prescribed stretch.

With principal stretches λi, product 1, and a traction-free third direction, the nominal stress
along 1 is (t1 − t3)/λ1, where t1 − t3 is 2 (λ1² − λ3²)(∂W/∂I1 + λ2² ∂W/∂I2) for a law of the
invariants (Rivlin 1948) and λ1 f'(λ1) − λ3 f'(λ3) for W = Σ f(λi) (Ogden 1972). The derivatives
here are written by hand.
"""

import numpy as np
import pytest
import scipy.optimize
from meshes import block
from solving import ROLLERS, build, solve

from softact.materials import LAWS
from softact.model import Support
from softact.stepping import LoadStep

BULK = 1e8  # MPa: J differs from 1 by less than 1e-7
LOW_BULK = 30.0  # MPa, for the test of the compressible answer
LOGARITHMIC = [n for n, law in LAWS.items() if law.logarithmic_volume and not law.anisotropic]
STRETCHES = (0.8, 1.2, 1.5, 2.0, 2.5)
MODES = {  # prescribed stretches of x and y; None: free
    "uniaxial": lambda s: (s, None),
    "equibiaxial": lambda s: (s, s),
    "pure shear": lambda s: (s, 1.0),
}
OGDEN_MU, OGDEN_ALPHA = (0.3, 0.02, 0.05), (1.3, 5.0, -2.0)


def _arruda_boyce(i1, i2):
    factors = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)
    terms = [c * n * i1 ** (n - 1) / 9.0 ** (n - 1) for n, c in enumerate(factors, start=1)]
    return 0.2 * sum(terms), 0.0


def _van_der_waals(i1, i2):
    share, locking = 0.1, 8.0**2 - 3
    mixed = (1 - share) * i1 + share * i2
    eta = np.sqrt((mixed - 3) / locking)
    # ∂/∂Ĩ of μ (−L (ln(1 − η) + η) − ⅔ a ((Ĩ − 3)/2)^(3/2)) with L η² = Ĩ − 3
    slope = 0.3 * (0.5 / (1 - eta) - 0.2 * 0.5 * np.sqrt((mixed - 3) / 2))
    return (1 - share) * slope, share * slope


# law, its constants in MPa, and (∂W/∂I1, ∂W/∂I2) at (I1, I2)
INVARIANT_LAWS = {
    "neo_hookean": (dict(c10=0.14), lambda i1, i2: (0.14, 0.0)),
    "mooney_rivlin": (dict(c10=0.11, c01=0.03), lambda i1, i2: (0.11, 0.03)),
    "yeoh": (dict(c10=0.11, c20=0.02), lambda i1, i2: (0.11 + 0.04 * (i1 - 3), 0.0)),
    "reduced_polynomial": (
        dict(c10=0.1, c20=0.01, c40=1e-4),
        lambda i1, i2: (0.1 + 0.02 * (i1 - 3) + 4e-4 * (i1 - 3) ** 3, 0.0),
    ),
    "arruda_boyce": (dict(mu=0.2, lambda_m=3.0), _arruda_boyce),
    "van_der_waals": (dict(mu=0.3, lambda_m=8.0, a=0.2, beta=0.1), _van_der_waals),
    "gent": (dict(mu=0.3, jm=60.0), lambda i1, i2: (0.15 / (1 - (i1 - 3) / 60), 0.0)),
}
# law, its constants, and λ f'(λ)
STRETCH_LAWS = {
    "ogden": (
        dict(mu=list(OGDEN_MU), alpha=list(OGDEN_ALPHA)),
        lambda s: sum(2 * m / a * s**a for m, a in zip(OGDEN_MU, OGDEN_ALPHA, strict=True)),
    ),
    "linear": (dict(youngs_modulus=0.9), lambda s: 0.6 * np.log(s)),  # 2 μ ln λ with μ = E/3
}
# REFERENCE, nominal stress in MPa at STRETCHES: other people's evaluation, six digits.
TABLE = {
    ("neo_hookean", "uniaxial"): (-0.2135, 0.141556, 0.295556, 0.49, 0.6552),
    ("neo_hookean", "equibiaxial"): (-0.630492, 0.223474, 0.383128, 0.55125, 0.697133),
    ("neo_hookean", "pure shear"): (-0.322875, 0.173963, 0.337037, 0.525, 0.68208),
    ("mooney_rivlin", "uniaxial"): (-0.224938, 0.1365, 0.274444, 0.4375, 0.57096),
    ("mooney_rivlin", "equibiaxial"): (-0.581854, 0.244545, 0.485751, 0.905625, 1.48141),
    ("yeoh", "uniaxial"): (-0.17629, 0.115536, 0.281481, 0.665, 1.27296),
    ("yeoh", "equibiaxial"): (-0.625341, 0.198717, 0.486849, 1.23047, 2.44506),
    ("yeoh", "pure shear"): (-0.272368, 0.143368, 0.331687, 0.75, 1.39534),
}


def law_of(name, bulk=BULK):
    if name in INVARIANT_LAWS:
        return LAWS[name].of(**INVARIANT_LAWS[name][0], bulk_modulus=bulk)
    if name == "linear":  # K = E/(3 (1 − 2ν))
        return LAWS[name].of(**STRETCH_LAWS[name][0], poissons_ratio=0.5 - 0.9 / (6 * BULK))
    return LAWS[name].of(**STRETCH_LAWS[name][0], bulk_modulus=BULK)


def closed_form(name, mode, stretch):
    """Nominal stress along x in MPa."""
    across = {"uniaxial": stretch**-0.5, "equibiaxial": stretch, "pure shear": 1.0}[mode]
    l1, l2, l3 = stretch, across, 1 / (stretch * across)
    if name in STRETCH_LAWS:
        f = STRETCH_LAWS[name][1]
        return (f(l1) - f(l3)) / l1
    i1, i2 = l1**2 + l2**2 + l3**2, l1**-2 + l2**-2 + l3**-2
    w1, w2 = INVARIANT_LAWS[name][1](i1, i2)
    return 2 * (l1**2 - l3**2) * (w1 + l2**2 * w2) / l1


def compressible(name, mode, stretch):
    """Nominal stress along x in MPa at LOW_BULK, the free stretches sought.

    Cauchy stress σi = dev(ti)/J + K/2 (J − 1/J) with ti = 2 (λ̄i² ∂W/∂I1 − λ̄i⁻² ∂W/∂I2).
    """
    prescribed = MODES[mode](stretch)

    def cauchy(free):
        l1, l2 = stretch, free[0] if prescribed[1] is None else prescribed[1]
        l3 = free[-1]
        jacobian = l1 * l2 * l3
        squares = np.array([l1, l2, l3]) ** 2 * jacobian ** (-2 / 3)
        w1, w2 = INVARIANT_LAWS[name][1](squares.sum(), (1 / squares).sum())
        t = 2 * (squares * w1 - w2 / squares)
        slope = LOW_BULK / 2 * (jacobian - 1 / jacobian)
        return (t - t.mean()) / jacobian + slope, jacobian

    guess = [stretch**-0.5] * 2 if prescribed[1] is None else [1 / (stretch * prescribed[1])]
    count = len(guess)
    found = scipy.optimize.root(lambda free: cauchy(free)[0][3 - count :], guess, tol=1e-13).x
    stress, jacobian = cauchy(found)
    return stress[0] * jacobian / stretch


def nominal_stresses(law, mode, stretches):
    """Reaction over undeformed area (1 mm²) of a stretched cube, solved one after the other."""
    model = build(block((1, 1, 1)), law)
    found, steps = [], []
    for stretch in stretches:
        along, across = MODES[mode](stretch)
        held = [*ROLLERS, Support("x_max", {0: along - 1})]
        if across is not None:
            held.append(Support("y_max", {1: across - 1}))
        steps.append(LoadStep(f"{stretch}", supports=held))
    for part in (steps[:1], steps[1:]):  # compression and tension both start from rest
        solution = solve(model, part, ROLLERS, 0.25)
        found += [solution.reaction("x_max", state)[0] for state in solution.ends]
    return found


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", [*INVARIANT_LAWS, *STRETCH_LAWS])
def test_mode_of_law(name, mode):
    found = nominal_stresses(law_of(name), mode, STRETCHES)
    expected = [closed_form(name, mode, s) for s in STRETCHES]
    np.testing.assert_allclose(found, expected, rtol=1e-6)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", LOGARITHMIC)
def test_logarithmic_volumetric_energy(name, mode):
    """U = K/2 ((J² − 1)/2 − ln J) is held by the pressure unknown: the compressible answer."""
    found = nominal_stresses(law_of(name, LOW_BULK), mode, STRETCHES)
    expected = [compressible(name, mode, s) for s in STRETCHES]
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    incompressible = [closed_form(name, mode, s) for s in STRETCHES]
    assert np.abs(np.divide(found, incompressible) - 1).min() > 1e-5


def test_every_isotropic_law_is_here():
    tested = set(INVARIANT_LAWS) | set(STRETCH_LAWS)
    assert tested == {name for name, law in LAWS.items() if not law.anisotropic}


@pytest.mark.parametrize("name,mode", TABLE)
def test_closed_form_gives_the_table(name, mode):
    """The formulas above against REFERENCE's table, to the digits that it prints."""
    expected = [closed_form(name, mode, s) for s in STRETCHES]
    np.testing.assert_allclose(TABLE[name, mode], expected, rtol=5e-6)
