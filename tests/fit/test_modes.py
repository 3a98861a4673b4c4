"""Closed-form stresses: by hand, against the solver's stress of the same law, and invariances."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from softact.fit.modes import (
    MODES,
    first_invariant,
    nominal_stress,
    sheet_energy,
    sheet_stress,
    stretch_reaching,
)
from softact.materials import LAWS
from tests.materials.samples import SAMPLES

STRETCH = np.array([0.8, 1.0, 1.2, 1.5, 2.0, 2.5])
ISOTROPIC = [name for name, law in SAMPLES.items() if not law.anisotropic]


def by_hand(mode, w1, w2, s):
    """Rivlin's formulas for nominal stress with W1 and W2 at the mode's invariants."""
    if mode == "uniaxial":
        return 2 * (s - s**-2) * (w1 + w2 / s)
    if mode == "equibiaxial":
        return 2 * (s - s**-5) * (w1 + w2 * s**2)
    return 2 * (s - s**-3) * (w1 + w2)


@pytest.mark.parametrize("mode", MODES)
def test_invariant_laws_give_rivlins_formulas(mode):
    s = STRETCH
    i1 = first_invariant(mode, s)
    cases = {
        "neo_hookean": (0.14, 0.0),
        "mooney_rivlin_2": (0.11, 0.03),
        "yeoh": (0.11 + 2 * 0.02 * (i1 - 3) + 3 * 0.003 * (i1 - 3) ** 2, 0.0),
        "gent": (0.15 / (1 - (i1 - 3) / 60), 0.0),
        "fung": (0.15 * np.exp(0.4 * (i1 - 3)), 0.0),
    }
    for name, (w1, w2) in cases.items():
        law = SAMPLES[name]
        stress = nominal_stress(law, law, mode, s)
        assert np.allclose(stress, by_hand(mode, w1, w2, s), rtol=0, atol=1e-12)


# The table of REFERENCE (nominal stress in MPa to six digits), at stretches .8 1.2 1.5 2 2.5.
TABLE = {
    ("neo_hookean", "uniaxial"): [-0.2135, 0.141556, 0.295556, 0.49, 0.6552],
    ("neo_hookean", "equibiaxial"): [-0.630492, 0.223474, 0.383128, 0.55125, 0.697133],
    ("neo_hookean", "planar"): [-0.322875, 0.173963, 0.337037, 0.525, 0.68208],
    ("mooney_rivlin", "uniaxial"): [-0.224938, 0.1365, 0.274444, 0.4375, 0.57096],
    ("mooney_rivlin", "equibiaxial"): [-0.581854, 0.244545, 0.485751, 0.905625, 1.48141],
    ("yeoh", "uniaxial"): [-0.17629, 0.115536, 0.281481, 0.665, 1.27296],
    ("yeoh", "equibiaxial"): [-0.625341, 0.198717, 0.486849, 1.23047, 2.44506],
    ("yeoh", "planar"): [-0.272368, 0.143368, 0.331687, 0.75, 1.39534],
}
CONSTANTS = {
    "neo_hookean": {"c10": 0.14},
    "mooney_rivlin": {"c10": 0.11, "c01": 0.03},
    "yeoh": {"c10": 0.11, "c20": 0.02},
}


def test_fung_by_numbers():
    """Uniaxial, μ = 0.3, b = 0.4, λ = 2: Ī1 − 3 = 2, P = 0.3 e^0.8 (2 − 1/4) = 1.168409 MPa."""
    law = LAWS["fung"].of(mu=0.3, b=0.4)
    assert nominal_stress(law, law, "uniaxial", np.array([2.0]))[0] == pytest.approx(
        1.168409, abs=5e-7
    )
    # Equibiaxial, λ = 1.5: Ī1 − 3 = 4.5 + 1.5⁻⁴ − 3 = 1.697531, P = μ e^(0.4 · 1.697531) (λ − λ⁻⁵).
    expected = 0.3 * np.exp(0.4 * 1.697530864) * (1.5 - 1.5**-5)
    assert nominal_stress(law, law, "equibiaxial", np.array([1.5]))[0] == pytest.approx(expected)


@pytest.mark.parametrize(("name", "mode"), TABLE)
def test_reference_table(name, mode):
    law = LAWS[name].of(**CONSTANTS[name])
    stress = nominal_stress(law, law, mode, np.array([0.8, 1.2, 1.5, 2.0, 2.5]))
    for value, expected in zip(stress, TABLE[name, mode], strict=True):
        # The table's last digit is rounded.
        assert abs(value - expected) <= 0.5001 * 10 ** (np.floor(np.log10(abs(expected))) - 5)


@pytest.mark.parametrize("mode", MODES)
def test_ogden_gives_the_textbook_formula(mode):
    law = SAMPLES["ogden_3"]
    powers, pairs = MODES[mode].powers, MODES[mode].pairs
    expected = 0.0
    for mu, a in ((1.887e-3, -3.848), (2.225e-2, 0.6632), (3.574e-3, 4.225)):
        # d/dλ of 2μ/α² Σ λ^(p α), shared by the loaded directions.
        slope = sum(p * STRETCH ** (p * a - 1) for p in powers)
        expected = expected + 2 * mu / a * slope / pairs
    assert np.allclose(nominal_stress(law, law, mode, STRETCH), expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", ISOTROPIC)
def test_same_stress_as_the_solvers_tensors(name, mode):
    """P1 = λ1 (S1 − S3 λ3²/λ1²): the pressure makes direction 3 free of stress."""
    law = SAMPLES[name]
    s = STRETCH
    stretches = np.stack([s**p for p in MODES[mode].powers], axis=1)
    C = np.zeros((len(s), 3, 3))
    for i in range(3):
        C[:, i, i] = stretches[:, i] ** 2
    S, _ = law.material().stress_tangent(C)
    expected = (S[:, 0] * C[:, 0, 0] - S[:, 2] * C[:, 2, 2]) / s
    assert np.allclose(nominal_stress(law, law, mode, s), expected, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", ISOTROPIC)
def test_initial_slope_is_the_shear_modulus(name, mode):
    law = SAMPLES[name]
    h = 1e-5
    slope = np.diff(nominal_stress(law, law, mode, np.array([1 - h, 1 + h])))[0] / (2 * h)
    moduli = {"uniaxial": 3.0, "equibiaxial": 6.0, "planar": 4.0}[mode]
    # Van der Waals approaches its modulus like sqrt(Ī1 − 3).
    tolerance = 1e-4 if name == "van_der_waals" else 1e-7
    assert slope == pytest.approx(moduli * law.shear_modulus, rel=tolerance)


@given(st.floats(0.4, 3.0), st.floats(0.4, 3.0))
def test_sheet_energy_of_the_sheet_is_that_of_the_tensor(a, b):
    for name in ("yeoh", "ogden_3", "holzapfel"):
        law = SAMPLES[name]
        jet = sheet_energy(law, law, (np.log([a]), np.log([b])))
        C = np.diag([a * a, b * b, 1 / (a * b) ** 2])[None]
        fibres = None
        if law.anisotropic:
            fibres = law.fibre_directions(np.array([[1.0, 0, 0]]), np.array([[0, 0, 1.0]]))
        energy = law.material().energy(C, fibres)
        assert np.allclose(jet.value, energy, rtol=1e-9, atol=1e-12)


def test_sheet_without_fibres_is_the_isotropic_law():
    law = LAWS["holzapfel"].of(c10=0.14, k1=0.0)
    for mode in MODES:
        for direction in ("course", "wale"):
            stress = sheet_stress(law, law, mode, direction, STRETCH)
            expected = nominal_stress(LAWS["neo_hookean"], law, mode, STRETCH)
            assert np.allclose(stress, expected, rtol=0, atol=1e-12)


def test_uniaxial_sheet_with_fibres_across_the_load_is_a_planar_test_in_the_limit():
    # Very stiff fibres across the load let the sheet get no narrower, though in compression they
    # carry nothing: pull along wale with the fibre at 90° to it only in equibiaxial stays free.
    law = LAWS["holzapfel"].of(c10=0.14, k1=1e7, families=1)
    stress = sheet_stress(law, law, "planar", "wale", STRETCH)
    assert np.allclose(
        stress, nominal_stress(LAWS["neo_hookean"], law, "planar", STRETCH), atol=1e-12
    )


def test_fibres_along_the_load_by_hand():
    law = LAWS["holzapfel"].of(c10=0.14, k1=0.5, k2=0.3, families=1)
    s = np.array([1.1, 1.4])
    strain = s**2 - 1
    # The fibre does not press sideways, so the sheet narrows as without it; dE/dλ = 2λ.
    gain = 0.5 * strain * np.exp(0.3 * strain**2) * 2 * s
    stress = sheet_stress(law, law, "uniaxial", "course", s)
    assert np.allclose(stress, 2 * 0.14 * (s - s**-2) + gain, rtol=1e-10)
    wale = sheet_stress(law, law, "uniaxial", "wale", s)
    assert np.allclose(wale, 2 * 0.14 * (s - s**-2), rtol=1e-10)


def test_free_direction_has_no_stress():
    law = SAMPLES["holzapfel"]
    s = np.array([0.7, 0.85, 1.1, 1.3, 1.5, 1.8])
    stress = sheet_stress(law, law, "uniaxial", "course", s)
    # Energy along the path: with no stress across, dW/dλ along the path is the stress.
    from softact.fit.modes import _free_stretch

    def energy(across, log):
        return sheet_energy(law, law, (log, across))

    def path(x):
        log = np.log(x)
        return energy(_free_stretch(lambda e: energy(e, log), log, 1), log).value

    h = 1e-5
    assert np.allclose((path(s + h) - path(s - h)) / (2 * h), stress, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("mode", MODES)
def test_equivalent_stretch(mode):
    for side in (0.5, 2.0):
        found = stretch_reaching(mode, 5.0, side)
        assert (found > 1) == (side > 1)
        assert first_invariant(mode, found) == pytest.approx(5.0)


# REFERENCE: pressure in kPa in a thick sphere, radii 10 and 11 mm, at inner stretches below.
INNER = (1.05, 1.1, 1.2, 1.3, 1.4, 1.5, 2.0, 3.0)
SPHERE = {
    "neo_hookean": (11.573, 19.445, 28.273, 31.924, 33.006, 32.810, 27.252, 18.596),
    "yeoh": (9.165, 15.734, 24.599, 30.607, 35.297, 39.316, 56.006, 86.031),
}


@pytest.mark.parametrize("name", SPHERE)
def test_thick_sphere_by_quadrature_of_the_equibiaxial_stress(name):
    """P = ∫ Ŵ'(λ)/(λ³ − 1) dλ from λb to λa with Ŵ' twice the equibiaxial nominal stress."""
    law = LAWS[name].of(**CONSTANTS[name])

    def integrand(s):
        return 2 * nominal_stress(law, law, "equibiaxial", np.array([s]))[0] / (s**3 - 1)

    for inner, expected in zip(INNER, SPHERE[name], strict=True):
        outer = np.cbrt(1 + (inner**3 - 1) * (10 / 11) ** 3)
        pressure = quad(integrand, outer, inner, epsabs=1e-12)[0]
        assert 1e3 * pressure == pytest.approx(expected, abs=6e-4)
