"""What a geometry is made of: the first fault of a spec names it, with lines that can be pasted."""

import pytest

from softact import catalogue
from softact import spec as specs
from softact.errors import SpecError
from softact.geometries import GEOMETRIES
from softact.geometry.imported import Imported
from softact.spec import Step

OWN = [name for name, kind in GEOMETRIES.items() if not issubclass(kind, Imported)]
BARE = "geometry: {{type: {}}}\nsteps: [{{gravity: [0, 0, -1]}}]\n"


def lines(text, *overrides):
    with pytest.raises(SpecError) as caught:
        specs.loads(text, "bare.yaml", overrides)
    return caught.value.lines


@pytest.mark.parametrize("name", OWN)
def test_what_a_bare_geometry_lacks_can_be_pasted_from_its_faults(name):
    text = BARE.format(name)
    for line in lines(text):
        part = line.split(": ")[1]
        assert line.startswith(f"bare.yaml:1: {part}: missing; this geometry has the ")
        text += line.partition("; write: ")[2] + "\n"
    spec = specs.loads(text)
    layout = spec.geometry.layout()
    assert set(spec.materials) == set(layout.regions)
    assert set(spec.sheets) == set(layout.sheets)


def test_both_parts_of_a_shell_on_a_core_are_told():
    text = BARE.format("shell_reinforced, shell: sliding")
    materials, sheets, contact = lines(text)
    assert "materials: missing; this geometry has the region body; write: materials: {" in materials
    assert "sheets: missing; this geometry has the sheets shell, glued; write: sheets: {" in sheets
    assert "contact: missing" in contact


def test_a_sheet_that_is_left_out_is_told_where_the_others_are():
    text = BARE.format("woven_contracting") + "sheets:\n  tabs: {plies: []}\n"
    lacking, empty = sorted(lines(text), key=lambda line: "plies" in line.split(": ")[1])
    pasted = "pouches: {plies: [{material: woven-tpu-nylon, thickness: 0.2 mm}]}"
    assert lacking == (
        f"bare.yaml:3: sheets.pouches: missing; write what this sheet is made of: {pasted}"
    )
    assert empty == "bare.yaml:4: sheets.tabs.plies: empty; 1 or more are wanted (its layers)"
    tabs = pasted.replace("pouches", "tabs")
    assert specs.loads(text.replace("tabs: {plies: []}", f"{pasted}\n  {tabs}")).sheets


def test_a_fault_in_a_ply_does_not_make_the_list_too_short():
    text = BARE.format("woven_contracting") + (
        "sheets: {pouches: &cloth {plies: [{material: paper, thickness: 1 kPa}]}, tabs: *cloth}\n"
    )
    assert [line.split(": ")[1] for line in lines(text)] == [
        "sheets.pouches.plies.0.thickness",
        "sheets.tabs.plies.0.thickness",
    ]


def test_an_unknown_key_of_a_step_is_answered_with_what_a_step_may_have():
    text = BARE.format("block") + "materials: {body: paper}\n"
    (line,) = lines(text, "steps.0.length=2 s")
    known = ", ".join(Step.model_fields)
    assert line == f"--set steps.0.length=2 s: steps.0.length: unknown key; known: {known}"
    (line,) = lines(text, "duration=2 s")
    assert "duration: unknown key; known: name, description, source, assumptions, geo" in line


@pytest.mark.parametrize("record", catalogue.geometries(), ids=lambda record: record["name"])
def test_the_catalogue_names_every_part_of_a_geometry(record):
    layout = GEOMETRIES[record["name"]].model_construct().layout()
    for key in catalogue.NAMES:
        assert record[key] == list(getattr(layout, key))
    assert bool(record["example"]) == bool(layout.sheets)


def test_the_catalogue_tells_what_another_choice_brings():
    (shell,) = [r for r in catalogue.geometries() if r["name"] == "shell_reinforced"]
    sheets, surfaces = ["shell", "glued"], ["under_shell", "under_glued"]
    assert shell["others"] == [{"with": "shell: sliding", "surfaces": surfaces, "sheets": sheets}]


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("strain_energy", "measure energy has strain_energy_mJ"),
        ("contact_area", "measure contact has contact_area_<contact>_mm2"),
        ("benging", "did you mean 'bending'?"),
    ],
)
def test_a_column_is_answered_with_its_measure(name, said):
    text = "geometry: {type: block}\nmaterials: {body: ecoflex-00-30}\nsupports: "
    text += "[{surface: x_min, fix: [x, y, z]}]\nsteps: [{gravity: [0, 0, -1]}]\n"
    (line,) = lines(f"{text}measures: [{name}]\n")
    assert line == f"bare.yaml:5: measures.0: there is no measure '{name}'; {said}"
