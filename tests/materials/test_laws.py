"""Each law: stress and tangent are derivatives of its energy, and it behaves as a solid must."""

import numpy as np
import pytest

from softact.errors import SpecError
from softact.materials import LAWS, load_card
from tests.materials.samples import (
    SAMPLES,
    VOIGT,
    cauchy_green,
    deformations,
    fibres_of,
    rotations,
    tensor,
)

STEP = 4e-4
REPEATED = np.array(
    [
        np.eye(3),
        np.diag([1.44, 1.44, 0.7]),
        np.diag([0.8, 1.3, 1.3]),
        np.diag([1.2, 1.2, 1.2]),
        np.diag([1.3, 1.3 + 1e-9, 0.6]),
        np.diag([1.3, 1.3 + 1e-5, 0.6]),
    ]
)


def by_difference(function, C, step):
    """Twice the derivative of ``function`` in C, fourth order, per Voigt component."""
    columns = []
    for i, j in VOIGT:
        d = np.zeros((3, 3))
        d[i, j] += 0.5
        d[j, i] += 0.5
        near = function(C + step * d) - function(C - step * d)
        far = function(C + 2 * step * d) - function(C - 2 * step * d)
        columns.append(2.0 * (8.0 * near - far) / (12.0 * step))
    return np.stack(columns, axis=-1)


def fibre_strains(law, C, fibres):
    """Eα of each family, for choosing states away from where fibres begin to carry."""
    isochoric = C / np.cbrt(np.linalg.det(C))[:, None, None]
    trace = np.trace(isochoric, axis1=1, axis2=2)
    along = np.einsum("nfi,nij,nfj->nf", fibres, isochoric, fibres)
    return law.kappa * (trace - 3)[:, None] + (1 - 3 * law.kappa) * (along - 1)


def assert_derivatives(law, C, tolerance):
    if law.anisotropic:
        clear = np.abs(fibre_strains(law, C, fibres_of(law, len(C)))).min(axis=1) > 0.02
        C = C[clear]
    material, fibres = law.material(), fibres_of(law, len(C))
    S, D = material.stress_tangent(C, fibres)
    stress = by_difference(lambda c: material.energy(c, fibres), C, STEP)
    tangent = by_difference(lambda c: material.stress_tangent(c, fibres)[0], C, STEP)
    size = np.maximum(np.abs(S).max(axis=1), material.shear_modulus)
    assert np.max(np.abs(S - stress) / size[:, None]) < tolerance
    error = np.abs(D - tangent).max(axis=(1, 2)) / np.abs(D).max(axis=(1, 2))
    assert np.max(error) < tolerance
    assert np.array_equal(D, np.swapaxes(D, 1, 2))


@pytest.mark.parametrize("name", SAMPLES)
def test_stress_and_tangent_are_derivatives_of_the_energy(name):
    assert_derivatives(SAMPLES[name], cauchy_green(deformations(150)), 1e-6)


@pytest.mark.parametrize(
    "name", [n for n in SAMPLES if n != "van_der_waals" and not SAMPLES[n].anisotropic]
)
def test_repeated_stretches_are_exact(name):
    # Van der Waals has no second derivative at F = I, and fibres begin to carry there: see below.
    assert_derivatives(SAMPLES[name], REPEATED, 1e-6)
    turned = rotations(len(REPEATED))
    assert_derivatives(SAMPLES[name], turned @ REPEATED @ np.swapaxes(turned, 1, 2), 1e-6)


@pytest.mark.parametrize("name", ["van_der_waals", "holzapfel", "holzapfel_one"])
def test_repeated_stretches_away_from_the_undeformed_state(name):
    assert_derivatives(SAMPLES[name], REPEATED[[1, 2, 4, 5]], 1e-6)


@pytest.mark.parametrize("name", SAMPLES)
def test_undeformed_state_has_no_stress_and_the_shear_modulus_of_the_law(name):
    law = SAMPLES[name]
    C = np.eye(3)[None]
    S, D = law.material().stress_tangent(C, fibres_of(law, 1))
    # Van der Waals: the modulus is reached from above like sqrt(Ī1 − 3).
    tolerance = 1e-6 if name == "van_der_waals" else 1e-12
    assert np.max(np.abs(S)) < 1e-12 * law.shear_modulus
    if not law.anisotropic:
        # Isotropic and isochoric: D = 2μ (1/2 (δik δjl + δil δjk) − 1/3 δij δkl).
        expected = np.zeros((6, 6))
        expected[:3, :3] = 2 * law.shear_modulus * (np.eye(3) - 1 / 3)
        expected[3:, 3:] = law.shear_modulus * np.eye(3)
        assert np.max(np.abs(D[0] - expected)) < tolerance * law.shear_modulus
        assert law.material().energy(C)[0] == pytest.approx(0.0, abs=1e-11 * law.shear_modulus)


@pytest.mark.parametrize("name", SAMPLES)
def test_a_rotation_turns_the_stress_and_changes_no_energy(name):
    law = SAMPLES[name]
    material = law.material()
    F, Q = deformations(60), rotations(60)
    fibres = fibres_of(law, 60)
    energy = material.energy(cauchy_green(F), fibres)
    S = tensor(material.stress_tangent(cauchy_green(F), fibres)[0])
    # A rotation after the deformation: nothing changes for an observer of the material.
    assert np.allclose(material.energy(cauchy_green(Q @ F), fibres), energy, rtol=1e-12, atol=0)
    # A rotation of the material with its fibres before the deformation turns the stress along.
    turned = None if fibres is None else np.einsum("nij,nfj->nfi", Q, fibres)
    C = Q @ cauchy_green(F) @ np.swapaxes(Q, 1, 2)
    assert np.allclose(material.energy(C, turned), energy, rtol=1e-10, atol=0)
    T = tensor(material.stress_tangent(C, turned)[0])
    assert np.allclose(T, Q @ S @ np.swapaxes(Q, 1, 2), rtol=0, atol=1e-10 * np.abs(S).max())


@pytest.mark.parametrize("name", SAMPLES)
def test_a_volume_change_alone_costs_no_isochoric_energy(name):
    law = SAMPLES[name]
    F = deformations(20)
    C = cauchy_green(F)
    material, fibres = law.material(), fibres_of(law, 20)
    assert np.allclose(material.energy(1.7 * C, fibres), material.energy(C, fibres), rtol=1e-10)
    S, _ = material.stress_tangent(C, fibres)
    work = np.einsum("nij,nij->n", tensor(S), C)
    assert np.max(np.abs(work)) < 1e-12 * np.abs(S).max()


@pytest.mark.parametrize("name", [n for n in SAMPLES if n not in ("gent", "van_der_waals")])
def test_energy_grows_without_bound(name):
    law = SAMPLES[name]
    stretch = np.array([1.0, 1.5, 3.0, 10.0, 30.0])
    C = np.zeros((len(stretch), 3, 3))
    C[:, 0, 0], C[:, 1, 1], C[:, 2, 2] = stretch**2, 1 / stretch, 1 / stretch
    energy = law.material().energy(C, fibres_of(law, len(C)))
    finite = np.isfinite(energy)
    assert np.all(np.diff(energy[finite]) > 0)
    # The linear law grows like the square of the logarithm, the others as fast as a power.
    assert not finite[-1] or energy[-1] > 10 * energy[1]


@pytest.mark.parametrize(("name", "locking"), [("gent", 63.0), ("van_der_waals", 64.0)])
def test_locking_laws_rise_to_their_limit_and_have_no_value_beyond(name, locking):
    # Gent: Ī1 = 3 + Jm; van der Waals: Ĩ = λm², with β = 0 that is Ī1.
    law = SAMPLES[name] if name == "gent" else LAWS[name].of(mu=0.3, lambda_m=8.0, a=0.2)
    root = np.max(np.roots([1.0, 0.0, -locking, 2.0]).real)  # λ² + 2/λ = Ī1
    stretch = root * np.array([0.9, 0.99, 0.999, 0.9999, 1.001])
    C = np.zeros((5, 3, 3))
    C[:, 0, 0], C[:, 1, 1], C[:, 2, 2] = stretch**2, 1 / stretch, 1 / stretch
    S, _ = law.material().stress_tangent(C)
    assert np.all(np.diff(S[:4, 0]) > 0)
    assert S[3, 0] > 50 * S[0, 0]
    assert not np.isfinite(law.material().energy(C)[4])


def test_linear_law_is_hooke_for_small_strains_and_stiffens_not_in_rotation():
    law = load_card("pet")
    strain = 1e-7 * np.array([1.0, -0.4, 0.3, 0.2, -0.5, 0.6])
    S, _ = law.material().stress_tangent(np.eye(3)[None] + 2 * tensor(strain[None]))
    deviator = strain - np.mean(strain[:3]) * np.array([1, 1, 1, 0, 0, 0])
    shear = 2000 / (2 * 1.35)
    assert np.allclose(S[0], 2 * shear * deviator, rtol=1e-6)
    assert law.material().bulk_modulus == pytest.approx(2000 / (3 * (1 - 0.7)))
    # Logarithmic strain: squeezing by half costs what stretching to twice does.
    C = np.stack([np.diag([4.0, 0.5, 0.5]), np.diag([0.25, 2.0, 2.0])])
    energy = law.material().energy(C)
    assert energy[0] == pytest.approx(energy[1])
    assert energy[0] == pytest.approx(shear * np.log(2) ** 2 * (1 + 0.25 + 0.25))


def test_both_ogden_conventions_mean_the_same():
    classic = SAMPLES["ogden_classic"]
    mu, alpha = np.array([0.63, 0.0012, -0.01]), np.array([1.3, 5.0, -2.0])
    abaqus = LAWS["ogden"].of(mu=list(mu * alpha / 2), alpha=list(alpha))
    C = cauchy_green(deformations(20))
    assert np.allclose(classic.material().energy(C), abaqus.material().energy(C), rtol=1e-12)
    assert classic.shear_modulus == pytest.approx(0.5 * np.sum(mu * alpha))
    assert abaqus.shear_modulus == pytest.approx(np.sum(mu * alpha / 2))


def test_ogden_with_two_terms_of_2_and_minus_2_is_mooney_rivlin():
    ogden = LAWS["ogden"].of(mu=[0.22, 0.06], alpha=[2.0, -2.0])
    C = cauchy_green(deformations(50))
    for mine, other in zip(
        ogden.material().stress_tangent(C),
        SAMPLES["mooney_rivlin_2"].material().stress_tangent(C),
        strict=True,
    ):
        assert np.max(np.abs(mine - other)) < 1e-13 * np.max(np.abs(other))


def test_laws_that_contain_one_another_agree():
    C = cauchy_green(deformations(30))
    neo = SAMPLES["neo_hookean"].material().stress_tangent(C)
    same = [
        LAWS["reduced_polynomial"].of(c10=0.14),
        LAWS["ogden"].of(mu=[0.28], alpha=[2.0]),
        LAWS["gent"].of(mu=0.28, jm=1e9),
        LAWS["fung"].of(mu=0.28, b=1e-9),
        LAWS["arruda_boyce"].of(mu=0.28, lambda_m=1e5),
        LAWS["van_der_waals"].of(mu=0.28, lambda_m=1e6),
    ]
    for law in same:
        stress, tangent = law.material().stress_tangent(C)
        assert np.max(np.abs(stress - neo[0])) < 1e-5 * np.max(np.abs(neo[0]))
        assert np.max(np.abs(tangent - neo[1])) < 1e-5 * np.max(np.abs(neo[1]))


def test_holzapfel_carries_no_fibre_in_compression():
    law = LAWS["holzapfel"].of(c10=0.3, k1=5.0, k2=1.0, families=1)
    matrix = LAWS["neo_hookean"].of(c10=0.3)
    stretch = 0.8
    C = np.diag([stretch**2, 1 / stretch, 1 / stretch])[None]
    fibres = np.array([[[1.0, 0.0, 0.0]]])
    for mine, other in zip(
        law.material().stress_tangent(C, fibres), matrix.material().stress_tangent(C), strict=True
    ):
        assert np.allclose(mine, other, rtol=0, atol=1e-14)
    across = np.array([[[0.0, 1.0, 0.0]]])
    stiff, _ = law.material().stress_tangent(C, across)
    # Fibre along y, stretched by λ^(−1/2): S22 gains 2 k1 E exp(k2 E²) with E = 1/λ − 1.
    strain = 1 / stretch - 1
    gain = 2 * 5.0 * strain * np.exp(strain**2)
    base, _ = matrix.material().stress_tangent(C)
    deviator = np.array([-(1 / stretch) / (3 * stretch**2), 2 / 3, -1 / 3])
    assert np.allclose(stiff[0, :3] - base[0, :3], gain * deviator, rtol=1e-12)


def test_holzapfel_limits():
    C = cauchy_green(deformations(40))
    values = {"c10": 0.3, "k1": 0.6, "angle": 30.0}
    none, small = LAWS["holzapfel"].of(**values, k2=0.0), LAWS["holzapfel"].of(**values, k2=1e-9)
    fibres = fibres_of(none, 40)
    for a, b in zip(
        none.material().stress_tangent(C, fibres),
        small.material().stress_tangent(C, fibres),
        strict=True,
    ):
        assert np.allclose(a, b, rtol=1e-7)
    # κ = 1/3: each family is the isotropic k1/2 ((Ī1 − 3)/3)².
    spread = LAWS["holzapfel"].of(**values, k2=0.0, kappa=1 / 3)
    even = LAWS["yeoh"].of(c10=0.3, c20=2 * 0.5 * 0.6 / 9)
    for a, b in zip(
        spread.material().stress_tangent(C, fibres), even.material().stress_tangent(C), strict=True
    ):
        assert np.allclose(a, b, rtol=0, atol=1e-12)


def test_fibre_directions_lie_in_the_wall_at_the_angle():
    law = LAWS["holzapfel"].of(c10=0.3, k1=0.6, angle=30.0)
    axis, normal = np.array([[2.0, 0, 0]]), np.array([[0.4, 0, 1.0]])
    fibres = law.fibre_directions(axis, normal)
    along = np.cos(np.pi / 6) * np.array([1.0, 0.0, -0.4]) / np.sqrt(1.16)  # the axis in the wall
    across = np.array([0.0, 0.5, 0.0])
    assert np.allclose(fibres[0], [along + across, along - across])
    with pytest.raises(ValueError, match="parallel"):
        law.fibre_directions(axis, axis)


def test_a_fibre_law_without_fibres_is_refused_and_not_run_as_its_matrix():
    C = np.eye(3)[None]
    material = SAMPLES["holzapfel"].material()
    with pytest.raises(SpecError, match="wants 2 fibre directions per point, not none"):
        material.stress_tangent(C)
    with pytest.raises(SpecError, match="not 1"):
        material.energy(C, np.array([[[1.0, 0, 0]]]))
    for name in ("yeoh", "ogden_3"):
        with pytest.raises(SpecError, match="wants no fibre"):
            SAMPLES[name].material().energy(C, np.array([[[1.0, 0, 0]]]))
