"""Cards, overrides, and the volumetric part."""

import numpy as np
import pytest
from pydantic import ValidationError

from softact.errors import SpecError
from softact.materials import CARDS, LAWS, load_card, parse_material
from softact.materials.cards import card_data

REFERENCE = {
    "ecoflex-00-30", "elastosil-m4601", "elastic-50a-v2", "elastic-resin-uncured",
    "elastic-resin-cured", "ninjaflex", "knit-fabric-uncoated-uniaxial",
    "knit-fabric-coated-uniaxial", "knit-fabric-uncoated-biaxial", "knit-fabric-coated-biaxial",
    "woven-tpu-nylon", "pet", "paper", "silk-film", "dragon-skin-10", "dragon-skin-30",
    "ecoflex-00-10", "ecoflex-00-50", "rtv615",
}  # fmt: skip


def test_the_cards_of_the_reference_are_there():
    assert set(CARDS) >= REFERENCE


@pytest.mark.parametrize("name", CARDS)
def test_every_card_loads_with_source_and_plausible_values(name):
    law = load_card(name)
    assert law.name == name and law.source
    assert 1e-3 < law.shear_modulus < 1e4
    assert 0.7e-9 <= law.density < 2e-9
    assert law.material().bulk_modulus > law.shear_modulus


def test_ecoflex_constants_give_the_published_poissons_ratio():
    # REFERENCE: with Σμi as shear modulus D1 = 2.9259 gives ν = 0.48 exactly.
    law = load_card("ecoflex-00-30")
    ratio = law.material().bulk_modulus / law.shear_modulus
    assert (3 * ratio - 2) / (6 * ratio + 2) == pytest.approx(0.48, abs=5e-6)


def test_palacios_card_has_the_published_strength_and_range():
    card = load_card("elastic-50a-v2").material().card
    assert (card.strength, card.stretch_range) == (3.4, (1.0, 2.6))


@pytest.mark.parametrize("name", CARDS)
def test_every_strength_says_what_it_is_and_where_it_comes_from(name):
    data = card_data(name)
    if data.get("strength") or data.get("elongation"):
        assert data.get("strength_source")
    if data.get("strength"):
        assert data["strength_is"] in ("nominal", "true") and data["elongation"]


def test_override_replaces_a_constant_and_keeps_the_rest():
    law = load_card("elastosil-m4601", c10="0.12 MPa")
    assert (law.c10, law.c20) == (0.12, 0.02)


def test_an_overridden_bulk_modulus_replaces_the_cards_d1():
    law = load_card("ecoflex-00-30", bulk_modulus="3 MPa")
    assert law.d1 is None and law.material().bulk_modulus == 3.0


def test_default_compressibility_is_stated_in_the_law():
    law = parse_material({"law": "yeoh", "c10": "0.11 MPa"})
    assert law.poissons_ratio == 0.499
    expected = law.shear_modulus * 2 * 1.499 / (3 * 0.002)
    assert law.material().bulk_modulus == pytest.approx(expected)
    assert '"poissons_ratio":0.499' in law.model_dump_json()


def test_a_law_survives_its_own_json():
    for name in CARDS:
        law = load_card(name)
        again = LAWS[law.law].model_validate_json(law.model_dump_json(exclude_none=True))
        assert again == law


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("elastosil", "elastosil-m4601"),
        ({"card": "nothing-like-it-at-all"}, "no material card"),
        ({"law": "yoeh", "c10": "1 MPa"}, "did you mean 'yeoh'"),
        ({"c10": "1 MPa"}, "needs 'card' or 'law'"),
        ({"card": "pet", "law": "yeoh"}, "of law linear"),
        (3, "mapping"),
    ],
)
def test_unknown_card_or_law(value, said):
    with pytest.raises(SpecError, match=said):
        parse_material(value)


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ({"law": "yeoh", "c10": 0.11}, "no unit"),
        ({"law": "yeoh", "c10": "0.11 mm"}, "pressure"),
        ({"law": "yeoh", "c10": "-0.11 MPa"}, "shear modulus"),
        ({"law": "yeoh"}, "c10"),
        ({"law": "yeoh", "c10": "1 MPa", "c11": "1 MPa"}, "c11"),
        ({"law": "yeoh", "c10": "1 MPa", "bulk_modulus": "9 MPa", "d1": "1 1/MPa"}, "give one"),
        ({"law": "yeoh", "c10": "1 MPa", "poissons_ratio": 0.5}, "less than 0.5"),
        ({"law": "ogden", "mu": ["1 MPa", "2 MPa"], "alpha": [2]}, "mu2"),
        ({"law": "ogden", "mu": ["1 MPa"], "alpha": [0]}, "alpha1"),
        ({"law": "ogden", "mu": ["1 MPa"], "mu1": "2 MPa", "alpha": [2]}, "twice"),
        ({"law": "ogden", "mu": ["1 MPa"] * 7, "alpha": [2] * 7}, "1 to 6"),
        ({"law": "linear", "youngs_modulus": "1 GPa"}, "poissons_ratio"),
        ({"law": "holzapfel", "c10": "1 MPa", "k1": "1 MPa", "kappa": 0.4}, "kappa"),
        ({"law": "holzapfel", "c10": "1 MPa", "k1": "1 MPa", "families": 3}, "families"),
        ({"law": "yeoh", "c10": "1 MPa", "stretch_range": [1.2, 2]}, "enclose 1"),
    ],
)
def test_wrong_constants_are_refused_with_the_reason(value, said):
    with pytest.raises(ValidationError, match=said):
        parse_material(value)


@pytest.mark.parametrize("name", ["yeoh", "arruda_boyce"])
def test_extra_volumetric_energy_and_its_derivatives(name):
    constants = {"c10": 0.1} if name == "yeoh" else {"mu": 0.2, "lambda_m": 3.0}
    law = LAWS[name].of(**constants, d1=0.5, d2=0.02, d3=0.001)
    material = law.material()
    assert material.bulk_modulus == 4.0
    J = np.array([0.8, 0.95, 1.0, 1.1, 1.4])
    energy, first, second = material.extra_volumetric(J)
    x = J - 1
    expected = x**4 / 0.02 + x**6 / 0.001
    if name == "arruda_boyce":
        # The source's form is 1/D1 ((J² − 1)/2 − ln J) in place of (J − 1)²/D1.
        expected = expected + ((J**2 - 1) / 2 - np.log(J)) / 0.5 - x**2 / 0.5
    assert np.allclose(energy, expected, rtol=1e-12, atol=1e-15)
    h = 1e-5
    up, down = material.extra_volumetric(J + h), material.extra_volumetric(J - h)
    assert np.allclose(first, (up[0] - down[0]) / (2 * h), rtol=1e-7, atol=1e-8)
    assert np.allclose(second, (up[1] - down[1]) / (2 * h), rtol=1e-7, atol=1e-7)


def test_no_extra_volumetric_energy_without_d2():
    for part in load_card("elastosil-m4601").material().extra_volumetric(np.array([0.9, 1.2])):
        assert np.array_equal(part, [0.0, 0.0])


# Nominal stress (MPa) at stretches 1.5, 2, 3 and 3.9, read off the tables of the Soft Robotics
# Materials Database (doi 10.1089/soro.2019.0115), and how far the cards say they are off at 1.5.
MEASURED = {
    "dragon-skin-20": ([0.1511, 0.3184, 0.7223, 1.145], 0.10),
    "mold-star-16": ([0.0947, 0.1855, 0.4330, 0.7267], 0.02),
    "platsil-gel-10": ([0.0674, 0.1470, 0.3196, 0.4997], 0.14),
}


@pytest.mark.parametrize("name", MEASURED)
def test_fitted_cards_follow_the_measured_curves(name):
    law, (stress, off) = load_card(name), MEASURED[name]
    assert law.stretch_range == (1.0, 4.0)
    for stretch, measured in zip((1.5, 2.0, 3.0, 3.9), stress, strict=True):
        # Ogden, one term, incompressible: P = 2 mu / alpha (l^(alpha - 1) - l^(-alpha/2 - 1)).
        mu, alpha = law.mu1, law.alpha1
        nominal = 2 * mu / alpha * (stretch ** (alpha - 1) - stretch ** (-alpha / 2 - 1))
        assert nominal == pytest.approx(measured, rel=off if stretch == 1.5 else 0.02)
