"""Dotted paths: every value of a spec is reached, set, swept, varied and listed by one path."""

import json
from pathlib import Path

import pytest

from softact import spec as specs
from softact.errors import SpecError
from softact.files import document
from softact.fit.knobs import read_knobs
from softact.report.compare import spec_differences
from softact.run.from_spec import parameters
from softact.spec import Spec
from softact.spec.path import assign, get, joined, leaves, locate, single
from softact.sweep.points import spec_at

CONFIGS = Path(__file__).parents[2] / "configs"
# Between them: plies, layers, steps of all kinds, supports, obstacles, contact, cards, half models.
WHOLE = ("pneunet_glove", "agarwal_sliding", "finger_woven_blocked", "pneunet_small_touching")
SHEETS = """\
geometry: {type: woven_contracting}
sheets:
  pouches: {plies: [{material: woven-tpu-nylon, thickness: 0.2 mm}]}
  tabs: {plies: [{material: {law: linear, youngs_modulus: 498 MPa, poissons_ratio: 0.35},
                  thickness: 0.2 mm}]}
obstacles: {ball: {type: sphere, center: [0 mm, 0 mm, 50 mm], radius: 5 mm},
            box: {type: block, center: [0 mm, 0 mm, 90 mm], size: [1 mm, 1 mm, 1 mm]}}
contact: [{self: pouches}]
steps:
  - {pressure: {air: 10 kPa}}
  - {name: push, obstacles: {ball: {move: [0 mm, 0 mm, -5 mm]}}}
"""


def sheets(*overrides):
    return specs.loads(SHEETS, "sheets", overrides)


def plain(spec):
    return spec.model_dump(mode="json", exclude_none=True)


@pytest.mark.parametrize("name", WHOLE)
def test_every_value_of_a_spec_is_found_and_set_by_its_path(name):
    """As --set, as an axis, as a change of a finished spec: each gives back the same spec."""
    spec = specs.load(CONFIGS / f"{name}.yaml")
    text = spec.to_yaml()
    base = document.parse(text, name)
    found = list(leaves(plain(spec)))
    assert len(found) > 60
    assert {str(place[0]) for place, _ in found} >= {"geometry", "materials", "steps", "supports"}
    for place, value in found:
        path = joined(place)
        assert locate(plain(spec), path) == place
        assert get(plain(spec), path) == value
        assert spec_at(base, ((path, value),)) == spec
    path_and_value = {joined(place): value for place, value in found}
    assert spec.with_(path_and_value) == spec
    written = [f"{path}={json.dumps(value)}" for path, value in path_and_value.items()]
    assert specs.loads(text, name, written) == spec


SET = {
    "sheets.pouches.plies.0.material.youngs_modulus": "1 GPa",
    "sheets.tabs.plies.0.material.youngs_modulus": "1 GPa",
    "sheets.tabs.plies.0.thickness": "1 mm",
    "sheets.tabs.wrinkling": "resolved",
    "sheets.tabs.axis.1": 2.0,
    "obstacles.ball.center.2": "40 mm",
    "obstacles.box.rotation.2": "40 deg",
    "contact.0.friction": 0.3,
    "contact.contact_1.friction": 0.3,
    "steps.0.pressure.air": "3 kPa",
    "steps.step_1.pressure.air": "3 kPa",
    "steps.push.obstacles.ball.move.2": "1 mm",
    "steps.1.obstacles.ball.active": True,
}


@pytest.mark.parametrize("path", SET)
def test_a_value_is_set_inside_of_every_part(path):
    """It is the only one that changes."""
    before = dict(leaves(plain(sheets())))
    spec = sheets(f"{path}={json.dumps(SET[path])}")
    place = locate(plain(spec), path)
    expected = {**before, place: SET[path]}
    assert dict(leaves(plain(spec))) == expected != before


def ply(spec, sheet="pouches"):
    return spec.sheets[sheet].plies[0]


def test_a_card_in_a_ply_keeps_what_is_not_set():
    before, after = (ply(s).material for s in (sheets(), sheets(f"{STIFFER}")))
    assert (before.youngs_modulus, after.youngs_modulus) == (498, 1000)
    assert before.model_copy(update={"youngs_modulus": 1000.0}) == after


STIFFER = "sheets.pouches.plies.0.material.youngs_modulus=1 GPa"
PATH, MODULUS = STIFFER.split("=")


def test_a_value_in_a_ply_is_varied_swept_and_a_column():
    spec = sheets()
    (knob,) = read_knobs([f"{PATH}=100 MPa..2 GPa"], spec)
    assert (knob.value, knob.unit, knob.low, knob.high) == (498, "MPa", 100, 2000)
    swept = spec_at(document.parse(SHEETS, "sheets"), ((PATH, MODULUS),))
    assert swept == sheets(STIFFER)
    assert (parameters(spec)[PATH], parameters(swept)[PATH]) == ("498 MPa", "1 GPa")


def test_columns_of_parameters_are_single_values_with_their_paths():
    columns = parameters(sheets())
    assert columns["obstacles.ball.center.2"] == "50 mm"
    assert columns["steps.1.obstacles.ball.move.2"] == "-5 mm"
    assert columns["steps.0.pressure.air"] == "10 kPa"
    assert columns["contact.0.self.0"] == "pouches"
    assert columns["name"] == "sheets"
    assert not any(isinstance(value, dict | list) for value in columns.values())
    assert not {"description", "source", "measures"} & set(columns)


def test_runs_are_compared_by_the_same_paths():
    class Run:
        def __init__(self, spec):
            self.spec_yaml = spec.to_yaml()
            self.spec = plain(spec)

    rows = spec_differences([Run(sheets()), Run(sheets(STIFFER))])
    assert rows == [(PATH, ["498 MPa", "1 GPa"])]


LOST = {
    "geometri.n_a": "the spec has no value 'geometri'; did you mean 'geometry'?",
    "geometry.wall": "geometry has no value 'wall'; known: type, n_a, l_i, w_a, h_a, passage, seam",
    "steps.2": "'steps' has no entry '2' (it has 2 entries, counted from 0); known: step_1, push",
    "steps.pus": "'steps' has no entry 'pus' (it has 2 entries, counted from 0); did you mean",
    "steps.-1": "'steps' has no entry '-1'",
    f"steps.{'9' * 5000}": "'steps' has no entry '9999",
    "geometry.n_a.x": "'geometry.n_a' is a single value and has no 'x'",
    "sheets.pouches.plies.1": "'sheets.pouches.plies' has no entry '1' (it has 1 entries",
    "sheets.poches.plies": "sheets has no value 'poches'; did you mean 'pouches'?",
    "layers.0": "'layers' has no entry '0' (it has no entries)",
    "geometry..n_a": "'geometry..n_a' is no path; write for example steps.0.pressure",
}


@pytest.mark.parametrize("path", LOST)
def test_it_is_said_where_a_path_leaves_the_spec_and_what_is_there(path):
    with pytest.raises(SpecError) as caught:
        get(plain(sheets()), path)
    (line,) = caught.value.lines
    assert line.startswith(LOST[path]), line


def test_a_mapping_of_one_entry_stands_for_it():
    data = plain(sheets())
    place = ("steps", 0, "pressure", "air")
    assert single(data, "steps.0.pressure") == single(data, "steps.0.pressure.air")
    assert single(data, "steps.0.pressure") == (place, "10 kPa")
    with pytest.raises(SpecError, match="several values; name one of pouches, tabs"):
        single(data, "sheets")


def test_names_out_of_a_cad_program_may_hold_dots():
    data = {"materials": {"Body.1": {"c10": "1 MPa"}, "Body": "paper"}}
    assert get(data, "materials.Body.1.c10") == "1 MPa"
    assert get(data, "materials.Body") == "paper"
    long = {"materials": {"Body.1" * 20: {"c10": "1 MPa"}}}
    ((place, value),) = leaves(long)
    assert get(long, joined(place)) == value


def test_nothing_is_set_where_a_path_leads_nowhere():
    source = document.parse(SHEETS, "sheets")
    before = source.copy()
    for path in ("steps.7.pressure", "geometry.type.first", "supports.0.fix"):
        with pytest.raises(SpecError):
            assign(source, path, "1 kPa", "", Spec)
    assert source == before


@pytest.mark.parametrize("path", ["supports.0.fix", "layers.0.thickness", "steps.0.gravity"])
def test_a_list_that_the_file_lacks_is_set_whole(path):
    text = SHEETS[: SHEETS.index("steps:")]
    with pytest.raises(SpecError) as caught:
        specs.loads(text, "sheets", [f"{path}=[x]"])
    part = path.partition(".")[0]
    assert f"'{part}' is not in the file; set the whole list" in caught.value.lines[0]


def test_a_changed_copy_is_checked_anew():
    spec = sheets()
    copy = spec.with_({"geometry.n_a": 3, PATH: "600 MPa"})
    assert isinstance(copy, Spec)
    assert (copy.geometry.n_a, ply(copy).material.youngs_modulus) == (3, 600.0)
    assert spec == sheets()
    with pytest.raises(SpecError) as caught:
        spec.with_({"geometry.n_a": 0})
    assert caught.value.lines[0].startswith("--set geometry.n_a=0: geometry.n_a: '0' must be")
