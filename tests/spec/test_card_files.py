"""A spec that names a card file of the user's own."""

import pytest

from softact import spec
from softact.errors import SpecError

CARD = """\
law: yeoh
c10: 0.2 MPa
c20: 0.01 MPa
poissons_ratio: 0.48
density: 1100 kg/m^3
"""
SPEC = """\
geometry: {type: pneunet}
materials:
  body:
    card: cards/my_silicone.yaml
    c20: 0.05 MPa
layers:
  - {surface: strain_limiting_layer, thickness: 0.1 mm, material: cards/felt.yaml}
steps:
  - {pressure: 20 kPa}
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "cards").mkdir()
    (tmp_path / "cards" / "my_silicone.yaml").write_text(CARD)
    felt = "{law: linear, youngs_modulus: 20 MPa, poissons_ratio: 0.3, name: wool}"
    (tmp_path / "cards" / "felt.yaml").write_text(felt)
    (tmp_path / "finger.yaml").write_text(SPEC)
    return tmp_path


def load(folder, *overrides):
    return spec.load(folder / "finger.yaml", overrides)


def faults(folder, *overrides):
    with pytest.raises(SpecError) as raised:
        load(folder, *overrides)
    return raised.value.lines


def test_a_card_is_found_beside_the_spec_and_its_constants_are_replaced(folder, monkeypatch):
    monkeypatch.chdir("/")  # the working folder does not matter
    loaded = load(folder)
    body = loaded.materials["body"]
    assert (body.law, body.c10, body.c20, body.c30) == ("yeoh", 0.2, 0.05, 0.0)
    assert (body.density, body.poissons_ratio, body.name) == (1.1e-9, 0.48, "my_silicone")
    assert (loaded.layers[0].material.youngs_modulus, loaded.layers[0].material.name) == (
        20,
        "wool",
    )
    assert spec.loads(loaded.to_yaml()) == loaded


def test_a_new_compressibility_replaces_that_of_the_card(folder):
    body = load(folder, "materials.body.bulk_modulus=30 MPa").materials["body"]
    assert (body.bulk_modulus, body.poissons_ratio) == (30.0, None)


def test_a_card_may_be_named_without_a_mapping_and_by_its_whole_path(folder):
    for name in ("cards/my_silicone.yaml", folder / "cards" / "my_silicone.yaml"):
        assert load(folder, f"materials.body={name}").materials["body"].c20 == 0.01
    body = load(folder, "materials.body=./cards/my_silicone.yaml", "materials.body.c10=0.3 MPa")
    assert (body.materials["body"].c10, body.materials["body"].c20) == (0.3, 0.01)


WRONG = {
    "missing": (None, "{spec}:4: materials.body.card: {card}: there is no such file"),
    "empty": ("", "{spec}:4: materials.body.card: {card}: the file is empty"),
    "no law": ("c10: 1 MPa\n", "{spec}:4: materials.body.card: {card}: 'law' is missing; one of"),
    "unknown law": (
        CARD.replace("yeoh", "yoeh"),
        "{spec}:4: materials.body.card: {card}:1: law: there is no law 'yoeh'; did you mean",
    ),
    "no unit": (
        CARD.replace("0.2 MPa", "0.2"),
        "{spec}:4: materials.body.card: {card}:2: c10: '0.2' has no unit; write a pressure",
    ),
    "unknown constant": (
        CARD.replace("c20", "c2o"),
        "{spec}:4: materials.body.card: {card}:3: c2o: unknown key; did you mean 'c20'?",
    ),
    "unstable": (
        CARD.replace("0.2 MPa", "-0.2 MPa"),
        "{spec}:4: materials.body.card: {card}:1: the initial shear modulus is -0.4 MPa",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_card_is_told_with_the_lines_of_both_files(case, folder):
    text, told = WRONG[case]
    card = folder / "cards" / "my_silicone.yaml"
    card.unlink()
    if text is not None:
        card.write_text(text)
    (line,) = faults(folder)
    assert line.startswith(told.format(spec=folder / "finger.yaml", card=card))


def test_a_wrong_change_is_told_with_the_line_of_the_spec(folder):
    (folder / "finger.yaml").write_text(SPEC.replace("c20: 0.05 MPa", "c20: 0.05"))
    (line,) = faults(folder)
    assert line.startswith(f"{folder / 'finger.yaml'}:5: materials.body.c20: '0.05' has no unit")
    (line,) = faults(folder, "materials.body.c20=1 MPa", "materials.body.law=ogden")
    assert line.endswith("materials.body.card: the card is of law yeoh, not ogden")


def test_a_layer_takes_a_linear_card_only(folder):
    (line,) = faults(folder, "layers.0.material=cards/my_silicone.yaml")
    assert "layers.0.material.law: there is no law 'yeoh' here; known: linear" in line


def test_the_json_schema_knows_files():
    region = spec.json_schema()["properties"]["materials"]["additionalProperties"]
    assert any(option.get("pattern") == r"\.ya?ml$" for option in region["anyOf"])
