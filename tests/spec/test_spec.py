"""The spec: what a file means, its defaults, overrides, hash, and the way back to YAML."""

import copy
import json
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from softact import spec
from softact.errors import SpecError
from softact.geometries import GEOMETRIES
from softact.materials import CARDS, LAWS

CONFIGS = Path(__file__).resolve().parents[2] / "configs"

FINGER = """\
name: finger
geometry:
  type: pneunet
  chambers: 4
  outer_wall: 1.2 mm
materials:
  body: elastosil-m4601
layers:
  - {surface: strain_limiting_layer, thickness: 0.1 mm, material: paper}
steps:
  - {name: gravity, gravity: [0, 0, -1]}
  - {name: inflate, pressure: 50 kPa}
"""
DATA = yaml.safe_load(FINGER)


def load(**changes):
    return spec.loads(yaml.safe_dump({**copy.deepcopy(DATA), **changes}))


def faults(text, **keywords):
    with pytest.raises(SpecError) as caught:
        spec.loads(text, **keywords)
    assert caught.value.exit_code == 2
    return caught.value.lines


def test_values_are_floats_in_internal_units():
    finger = spec.loads(FINGER)
    assert finger.geometry.outer_wall == 1.2
    assert finger.layers[0].thickness == 0.1
    # Polygerinos 2013: Yeoh 0.11 and 0.02 MPa, 1130 kg/m^3; paper of 6.5 GPa.
    body = finger.materials["body"]
    assert (body.c10, body.c20, body.density) == (0.11, 0.02, 1.13e-9)
    assert finger.layers[0].material.youngs_modulus == 6500.0
    assert finger.steps[0].gravity == (0.0, 0.0, -9810.0)
    assert finger.steps[1].pressure == {"cavity": 0.05}


def test_defaults_are_filled_in():
    finger = spec.loads(FINGER)
    (clamp,) = finger.supports
    assert (clamp.surface, clamp.fix, clamp.move) == ("clamp", ("x", "y", "z"), {})
    assert finger.measures == "all"
    assert finger.solver.element == "P2/P1"
    assert finger.solver.tolerance == 1e-8


def test_a_spec_without_name_has_that_of_its_file(tmp_path):
    path = tmp_path / "My Finger (2).yaml"
    path.write_text(FINGER.replace("name: finger\n", "", 1))
    assert spec.load(path).name == "my_finger_2"


def test_a_step_without_name_is_numbered():
    finger = load(steps=[{"gravity": [0, 0, -1]}, {"name": "up", "pressure": "1 kPa"}])
    assert [step.name for step in finger.steps] == ["step_1", "up"]


def test_gravity_may_have_units_and_vacuum_is_a_pressure():
    finger = load(
        steps=[
            {"gravity": ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"]},
            {"pressure": {"cavity": "-30 kPa"}},
        ]
    )
    assert finger.steps[0].gravity == (0.0, 0.0, -9810.0)
    assert finger.steps[1].pressure == {"cavity": -0.03}


def test_gravity_in_metres_per_second_squared_without_unit_is_refused():
    (line,) = faults(FINGER.replace("[0, 0, -1]", "[0, 0, -9.81]"))
    assert line.startswith("spec:11: steps.0.gravity: ") and "-9.81 m/s^2" in line


def test_supports_and_tractions_are_read():
    finger = load(
        supports=[
            {"surface": "clamp", "fix": ["x", "y", "z"]},
            {"surface": "tip", "move": {"x": "2 mm"}},
        ],
        steps=[{"traction": {"surface": "tip", "value": ["0 kPa", "0 kPa", "-1 kPa"]}}],
    )
    assert finger.supports[1].values == {0: 2.0}
    assert finger.steps[0].traction.value == (0.0, 0.0, -0.001)


@pytest.mark.parametrize("card", CARDS)
def test_every_card_can_be_the_material_of_a_region(card):
    finger = load(materials={"body": card})
    assert finger.materials["body"].name == card
    assert spec.loads(finger.to_yaml()) == finger


KNIT = {"card": "knit-fabric-coated-biaxial"}
DIRECTIONS = {
    "the axis is normal to the plane": (
        {"normal": [-2, 0, 0]},
        "materials.body.normal: the actuator's axis, from which the fibre angle counts, is normal",
    ),
    "oblique to the symmetry plane": (
        {"normal": [0, 1, 1]},
        "materials.body.normal: the plane is oblique to the symmetry plane 'symmetry'",
    ),
    "one oblique family in a half": (
        {"families": 1, "angle": "30 deg"},
        "materials.body.families: one family at 30 deg is not symmetric to symmetry; take families",
    ),
    "two components": (
        {"normal": [0, 1]},
        "materials.body.normal: write a list of three for x, y, z, for example [0, 0, 1]",
    ),
    "no direction": (
        {"normal": [0, 0, 0]},
        "materials.body.normal: [0, 0, 0] has no direction; write for example [0, 0, 1]",
    ),
}


@pytest.mark.parametrize("case", DIRECTIONS)
def test_directions_of_fibres_that_cannot_be(case):
    changes, told = DIRECTIONS[case]
    with pytest.raises(SpecError) as raised:
        load(materials={"body": KNIT | changes})
    assert any(told in line for line in raised.value.lines)


@pytest.mark.parametrize(
    "changes", [{"normal": [0, 1, 0]}, {"families": 1, "angle": "90 deg"}, {"angle": "30 deg"}]
)
def test_directions_of_fibres_that_are_symmetric(changes):
    body = load(materials={"body": KNIT | changes})
    assert spec.loads(body.to_yaml()) == body


def test_constants_of_a_card_can_be_replaced():
    finger = load(materials={"body": {"card": "elastosil-m4601", "c10": "0.2 MPa"}})
    assert (finger.materials["body"].c10, finger.materials["body"].c20) == (0.2, 0.02)


def test_an_inline_law():
    constants = {"law": "neo_hookean", "c10": "0.14 MPa", "bulk_modulus": "100 MPa"}
    body = load(materials={"body": constants}).materials["body"]
    assert (body.c10, body.bulk_modulus, body.poissons_ratio) == (0.14, 100.0, None)


@pytest.mark.parametrize("path", sorted(CONFIGS.glob("*.yaml")), ids=lambda path: path.stem)
def test_a_config_comes_back_from_its_own_yaml(path):
    first = spec.load(path)
    again = spec.loads(first.to_yaml())
    assert again == first
    assert again.hash == first.hash
    assert again.to_yaml() == first.to_yaml()


def test_the_resolved_yaml_reads_the_same_in_any_yaml_reader():
    text = spec.loads(FINGER).to_yaml()
    assert spec.Spec.model_validate(yaml.safe_load(text)) == spec.loads(FINGER)


lengths = st.floats(0.3, 5.0).map(lambda value: f"{value!r} mm")
pressures = st.floats(-1e3, 1e3, allow_subnormal=False).map(lambda value: f"{value!r} kPa")
words = st.text(max_size=40)


@settings(max_examples=50, deadline=None)
@given(
    lengths,
    lengths,
    st.lists(pressures, min_size=1, max_size=4),
    st.lists(words, max_size=3),
    words,
    st.floats(1e-12, 1e-2),
)
def test_any_spec_comes_back_from_its_yaml(wall, roof, loads, assumptions, text, tolerance):
    geometry = {"type": "pneunet", "outer_wall": wall, "roof": roof}
    first = spec.Spec.model_validate(
        {
            **DATA,
            "description": text,
            "assumptions": assumptions,
            "geometry": geometry,
            "steps": [{"pressure": value} for value in loads],
            "solver": {"tolerance": tolerance},
        }
    )
    again = spec.loads(first.to_yaml())
    assert again == first
    assert again.hash == first.hash


atoms = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8), st.just("3 mm")
)
anything = st.recursive(
    atoms,
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(
            st.sampled_from([*spec.Step.model_fields, "type", "card", "law", "surface", "x", ""]),
            inner,
            max_size=3,
        ),
    ),
    max_leaves=8,
)


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_whatever_stands_at_any_place_gives_a_spec_or_plain_faults(data):
    broken = copy.deepcopy(DATA)
    for _ in range(data.draw(st.integers(1, 3))):
        target = broken
        while True:
            keys = list(target) if isinstance(target, dict) else list(range(len(target)))
            key = data.draw(st.sampled_from(keys))
            if isinstance(target[key], dict | list) and target[key] and data.draw(st.booleans()):
                target = target[key]
                continue
            target[key] = data.draw(anything)
            break
    try:
        spec.loads(yaml.safe_dump(broken), name="broken.yaml")
    except SpecError as error:
        assert error.lines
        for line in error.lines:
            assert "\n" not in line
            assert line.startswith("broken.yaml")


def test_all_faults_are_told_at_once_with_their_lines():
    text = FINGER.replace("1.2 mm", "1.2").replace("0.1 mm", "0.1 kPa").replace("50 kPa", "50 mm")
    assert [line.split(": ")[:2] for line in faults(text)] == [
        ["spec:5", "geometry.outer_wall"],
        ["spec:9", "layers.0.thickness"],
        ["spec:12", "steps.1.pressure"],
    ]


def test_a_fault_between_the_parts_is_told_beside_a_fault_in_one():
    text = FINGER.replace("0.1 mm", "-0.1 mm").replace("surface: strain_limit", "surface: strain-l")
    lines = faults(text)
    assert any("layers.0.thickness: '-0.1 mm' must be greater than 0" in line for line in lines)
    assert any("did you mean 'strain_limiting_layer'?" in line for line in lines)


def test_aliases_are_allowed_where_they_stay_small():
    text = FINGER.replace("1.2 mm", "&wall 1.2 mm") + "description: done\n"
    text = text.replace("  chambers: 4\n", "  chambers: 4\n  roof: *wall\n")
    with pytest.raises(SpecError, match="undefined alias"):
        spec.loads(text)
    text = text.replace("  roof: *wall\n", "").replace("materials:", "  roof: *wall\nmaterials:")
    assert spec.loads(text).geometry.roof == 1.2


@pytest.mark.parametrize("text", ["a\x85b", "\u2028", "1e5", "yes", "null", "- a: b", "#", " x "])
def test_a_text_that_yaml_could_misread_comes_back(text):
    first = spec.loads(f"{FINGER}description: {json.dumps(text)}\n")
    assert first.description == text
    assert spec.loads(first.to_yaml()) == first


@pytest.mark.parametrize(
    ("override", "read", "value"),
    [
        ("steps.1.pressure=30 kPa", lambda s: s.steps[1].pressure, {"cavity": 0.03}),
        ("steps.inflate.pressure=30 kPa", lambda s: s.steps[1].pressure, {"cavity": 0.03}),
        ("geometry.roof=0.8 mm", lambda s: s.geometry.roof, 0.8),
        ("solver.tolerance=1e-6", lambda s: s.solver.tolerance, 1e-6),
        ("materials.body=ecoflex-00-30", lambda s: s.materials["body"].law, "ogden"),
        ("materials.body.c10=0.2 MPa", lambda s: s.materials["body"].c10, 0.2),
        ("layers.0.material.density=1 g/cm^3", lambda s: s.layers[0].material.density, 1e-9),
        ("measures=[bending, tip]", lambda s: s.measures, ("bending", "tip")),
        ("description=a = b", lambda s: s.description, "a = b"),
        ("layers=[]", lambda s: s.layers, ()),
    ],
)  # fmt: skip
def test_an_override_replaces_a_value(override, read, value):
    assert read(spec.loads(FINGER)) != value
    assert read(spec.loads(FINGER, overrides=[override])) == value


def test_the_last_override_wins():
    finger = spec.loads(FINGER, overrides=["geometry.roof=2 mm", "geometry.roof=3 mm"])
    assert finger.geometry.roof == 3.0


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("roof", "write a dotted path, '=' and a value"),
        ("=3", "write a dotted path"),
        ("geometry..roof=3 mm", "write a dotted path"),
        ("geometry.roof=3", "geometry.roof: '3' has no unit"),
        ("geometry.rof=3 mm", "geometry.rof: unknown key; did you mean 'roof'?"),
        ("geometry.wall.thickness=3 mm", "geometry.wall: unknown key"),
        ("steps.9.pressure=3 kPa", "'steps' has no entry '9' (it has 2 entries, counted from 0)"),
        ("steps.inflat.pressure=3 kPa", "did you mean 'inflate'?"),
        ("geometry.roof.x=3 mm", "geometry.roof: "),
        ("name.first=x", "'name' is a single value and has no 'first'"),
        ("steps=[", "not valid YAML"),
        ("steps=[]", "steps: no step is given"),
        ("geometry.roof={a: 1, a: 2}", "a: given twice"),
        ("geometry.roof=!!python/name:os.system x", "tag"),
    ],
)
def test_a_wrong_override_is_told_as_such(override, words):
    (line,) = faults(FINGER, overrides=[override])
    assert line.startswith(f"--set {override.split('=')[0]}")
    assert words in line


def test_the_hash_follows_what_changes_a_result_and_nothing_else():
    first = spec.loads(FINGER)
    assert first.hash == spec.loads("# a comment\n" + FINGER).hash
    assert first.hash == spec.loads(FINGER, overrides=["description=text", "name=other"]).hash
    assert first.hash == spec.loads(FINGER.replace("50 kPa", "0.5 bar")).hash
    assert first.hash == spec.loads(FINGER, overrides=["tiles=[pull_N]"]).hash
    different = ["geometry.roof=1.1 mm", "materials.body.c10=0.2 MPa", "steps.1.pressure=51 kPa"]
    hashes = {spec.loads(FINGER, overrides=[change]).hash for change in different}
    assert len(hashes | {first.hash}) == 4


def test_a_spec_cannot_be_changed():
    finger = spec.loads(FINGER)
    with pytest.raises(ValueError, match="frozen"):
        finger.name = "other"


def test_the_json_schema_knows_every_geometry_law_and_card():
    schema = spec.json_schema()
    text = json.dumps(schema)
    models = [*GEOMETRIES.values(), *LAWS.values()]
    assert {model.__name__ for model in models} <= set(schema["$defs"])
    for card in CARDS:
        assert f'"{card}"' in text
    pneunet = schema["$defs"]["Pneunet"]
    assert pneunet["required"] == ["type"]
    assert pneunet["properties"]["roof"]["default"] == "1 mm"
    assert "x-dimension" not in text
    assert schema["additionalProperties"] is False
    assert schema["required"] == ["geometry", "steps"]


def test_titles_in_the_json_schema_are_words_of_a_spec():
    titles = {part["title"] for part in spec.json_schema()["$defs"].values() if "title" in part}
    assert {"Layer", "Ply", "Support", "Turn", "SurfaceContact"} <= titles
    assert not [title for title in titles if title.endswith("Spec")]


def test_the_json_schema_allows_one_pressure_and_one_for_each_cavity():
    pressure = spec.json_schema()["$defs"]["Step"]["properties"]["pressure"]
    one, each = (part for part in pressure["anyOf"] if part["type"] != "null")
    assert one["type"] == "string"
    assert (each["type"], each["additionalProperties"]) == ("object", one)
