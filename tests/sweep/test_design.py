"""Axes and designs: which values, which points, and what is said of wrong ones."""

import numpy as np
import pytest
import yaml
from pydantic import ValidationError
from scipy.stats import qmc

from softact.errors import SpecError
from softact.sweep.axes import Axis
from softact.sweep.design import Design
from softact.sweep.points import Plan, spec_at
from softact.sweep.spec import Sweep, read
from tests.sweep.folders import CUBE

LENGTH = Axis(path="geometry.length", **{"from": "4 mm", "to": "8 mm", "count": 3})
LAW = Axis(path="materials.body", name="law", values=("ecoflex-00-30", "elastosil-m4601"))
WHOLE = Axis(path="geometry.chambers", **{"from": 2, "to": 5, "count": 4})
LOG = Axis(
    path="materials.body.c10", **{"from": "0.01 MPa", "to": "1 MPa", "count": 3}, scale="log"
)


def test_values_of_ranges():
    assert LENGTH.steps() == ["4 mm", "6 mm", "8 mm"]
    assert WHOLE.steps() == [2, 3, 4, 5]
    assert LOG.steps() == ["0.01 MPa", "0.1 MPa", "1 MPa"]


def test_columns_carry_the_unit():
    assert LENGTH.column == "geometry.length_mm"
    assert LENGTH.cell("6 mm") == 6.0
    assert LENGTH.number("0.6 cm") == pytest.approx(6.0)
    assert (LAW.column, LAW.is_number, LAW.cell("ecoflex-00-30")) == ("law", False, "ecoflex-00-30")
    density = Axis(path="materials.body.density", values=("1000 kg/m^3",))
    assert density.column == "materials.body.density_kg_m3"


def test_grid_is_every_combination():
    points = Design().points([LENGTH, LAW])
    assert len(points) == 6
    assert points[1] == {"geometry.length": "4 mm", "law": "elastosil-m4601"}


def test_one_at_a_time_is_the_base_and_each_value():
    points = Design(kind="one_at_a_time").points([LENGTH, LAW])
    assert points[0] == {}
    assert [len(point) for point in points[1:]] == [1] * 5


def test_latin_hypercube_has_one_point_in_each_of_n_slices():
    points = Design(kind="latin_hypercube", samples=10, seed=3).points([LENGTH, LOG])
    lengths = np.array([float(p["geometry.length"].split()[0]) for p in points])
    assert sorted(np.floor((lengths - 4) / 0.4).astype(int)) == list(range(10))
    c10 = np.log10([float(p["materials.body.c10"].split()[0]) for p in points])
    assert sorted(np.floor((c10 + 2) / 0.2).astype(int)) == list(range(10))


def test_sobol_fills_evenly_and_again_the_same():
    design = Design(kind="sobol", samples=64)
    points = design.points([LENGTH, LOG])
    assert points == design.points([LENGTH, LOG])
    unit = np.array([[(float(p["geometry.length"].split()[0]) - 4) / 4,
                      (np.log10(float(p["materials.body.c10"].split()[0])) + 2) / 2]
                     for p in points])  # fmt: skip
    random = np.random.default_rng(0).random((64, 2))
    assert qmc.discrepancy(unit) < 0.5 * qmc.discrepancy(random)


def test_whole_numbers_and_lists_are_sampled_as_they_are():
    points = Design(kind="sobol", samples=16).points([WHOLE, LAW])
    assert {p["geometry.chambers"] for p in points} == {2, 3, 4, 5}
    assert {p["law"] for p in points} == set(LAW.values)


def sweep(tmp_path, text):
    (tmp_path / "sweep.yaml").write_text(CUBE + text)
    return read(tmp_path / "sweep.yaml", Sweep)


def test_several_paths_with_one_value(tmp_path):
    study, base = sweep(
        tmp_path,
        "axes: [{name: side, path: [geometry.width, geometry.height], values: [5 mm, 6 mm]}]",
    )
    points = Plan(base).points(study.axes, study.design.points(study.axes))
    spec = spec_at(base, points[1].changes)
    assert (spec.geometry.width, spec.geometry.height, spec.geometry.length) == (6.0, 6.0, 4.0)
    assert base.data["geometry"]["width"] == "4 mm"


def test_keys_differ_with_every_value_and_not_with_texts(tmp_path):
    study, base = sweep(tmp_path, "axes: [{path: geometry.length, values: [4 mm, 5 mm, 0.4 cm]}]")
    keys = [p.key for p in Plan(base).points(study.axes, study.design.points(study.axes))]
    assert keys[0] == keys[2] != keys[1]
    base.data["description"] = "another text"
    assert Plan(base).points(study.axes, study.design.points(study.axes))[0].key == keys[0]


def test_changed_sources_change_every_key(tmp_path, monkeypatch):
    study, base = sweep(tmp_path, "axes: [{path: geometry.length, values: [4 mm]}]")
    plan_file = tmp_path / "plan.json"
    design = study.design.points(study.axes)
    before = Plan(base, plan_file).points(study.axes, design)[0].key
    assert Plan(base, plan_file).points(study.axes, design)[0].key == before
    monkeypatch.setattr("softact.sweep.version.code", lambda: "0" * 16)
    assert Plan(base, plan_file).points(study.axes, design)[0].key != before


def test_point_that_cannot_be_built_has_its_fault(tmp_path):
    study, base = sweep(tmp_path, "axes: [{path: geometry.length, values: [4 mm, 0 mm]}]")
    points = Plan(base).points(study.axes, study.design.points(study.axes))
    assert points[0].key and points[1].key is None
    assert "the length would vanish" in points[1].faults[0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("axes: []", "sweep.yaml:7: axes: empty; write for example"),
        ("axis: []\naxes: [{path: a, values: [1]}]", "did you mean 'axes'?"),
        ("axes: [{path: geometry.length}]", "write either 'values', or 'from', 'to' and 'count'"),
        (
            "axes: [{path: geometry.length, from: 4 mm, to: 8 kPa}]",
            "sweep.yaml:7: axes.0.to: '8 kPa' has another unit than 'from': 'mm'",
        ),
        (
            "axes: [{path: geometry.length, from: 0 mm, to: 1 mm, scale: log}]",
            "a logarithmic range has to be above 0",
        ),
        ("axes: [{path: a, values: [1]}, {path: a, values: [2]}]", "two axes have the name 'a'"),
        ("axes: [{path: a, values: [1, 1]}]", "axes.0.values.1: '1' is given twice"),
        ("design: random\naxes: [{path: a, values: [1]}]", "'random' is not one of: grid"),
        (
            "set: {steps.9.pressure: 1 kPa}\naxes: [{path: geometry.length, values: [4 mm]}]",
            "sweep.yaml:7: set.steps.9.pressure: 'steps' has no entry '9'",
        ),
        (
            "set: {geometry.lenght: 1 mm}\naxes: [{path: geometry.length, values: [4 mm]}]",
            "sweep.yaml:7: set.geometry.lenght: geometry has no 'lenght'; did you mean 'length'?",
        ),
        (
            "axes: [{path: geometry.lenght, values: [4 mm, 5 mm]}]",
            "sweep.yaml:7: axes.0.path: 'geometry.lenght': geometry has no 'lenght'; did you mean",
        ),
        (
            "axes: [{path: a, values: [1]}]\ntrends: [{measure: x, axis: b, does: rise}]",
            "trends.0.axis: no axis 'b'; known: a",
        ),
    ],
)
def test_wrong_sweep_files(text, said, tmp_path):
    with pytest.raises(SpecError) as found:
        sweep(tmp_path, text)
    assert len(found.value.lines) == 1
    assert said in found.value.lines[0]


def refused(text, **more):
    axes, design = yaml.safe_load(text), more.pop("design", {"kind": "grid"})
    with pytest.raises(ValidationError) as caught:
        Sweep.model_validate({"base": "cube.yaml", "axes": axes, "design": design, **more})
    (fault,) = caught.value.errors()
    return fault["loc"], fault["msg"]


GRID = """
- {path: geometry.length, from: 1 mm, to: 9 mm, count: 100000}
- {path: geometry.width, from: 1 mm, to: 9 mm, count: 100000}
"""


def test_a_grid_of_ten_billion_points_is_refused_and_not_listed():
    assert refused(GRID) == (
        ("axes",), "10000000000 points; a study has at most 100000, so take fewer"
    )  # fmt: skip
    alone = {"kind": "one_at_a_time"}
    assert refused(GRID, design=alone)[1].startswith("200001 points; a study has at most")


def test_whole_numbers_are_drawn_and_not_listed():
    """As a list, a billion of them would take 32 GB."""
    axis = Axis.model_validate({"path": "n", "from": 0, "to": 10**9})
    assert axis.at([0.0, 0.5, 0.999999]) == [0, 500000000, 999999000]
    assert len(Design(kind="sobol", samples=8).points([axis])) == 8
    place, words = refused("- {path: n, from: 2, to: 10000000000}")
    assert place == ("axes", 0, "to")
    assert words == "'10000000000': whole numbers go to 1000000000 here"


def test_many_values_are_compared_with_each_other_in_one_go():
    values = [f"{n} mm" for n in range(50_000)]
    assert Axis.model_validate({"path": "a", "values": values}).size == 50_000
    with pytest.raises(ValidationError, match="'7 mm' is given twice"):
        Axis.model_validate({"path": "a", "values": [*values, "7 mm"]})
    lists = [[1, 2], [2, 1], {"a": 1}, 1, True, "1"]
    assert Axis.model_validate({"path": "a", "values": lists}).size == 6


@pytest.mark.parametrize("name", ["a\nb", "\x1b[2J", " ", "a\u2028b"])
def test_a_heading_is_words_on_one_line(name):
    with pytest.raises(ValidationError, match="is no heading: write words on one line"):
        Axis.model_validate({"path": "a", "values": [1, 2], "name": name})


def test_a_seed_is_one_that_every_sampler_takes():
    sample = {"kind": "sobol", "samples": 2, "seed": 2**32}
    assert refused("- {path: a, values: [1, 2]}", design=sample)[0] == ("design", "seed")
    Design(kind="sobol", samples=2, seed=2**32 - 1).points([LENGTH])


@pytest.mark.parametrize("text", ["1,1" + " " * 10**6 + "1", "1" * 10**6 + " a\nb", "1 mm" * 10**6])
def test_a_long_end_of_a_range_is_not_searched_for_ever(text):
    with pytest.raises(ValidationError, match=r"another unit than 'from'|is no number with its"):
        Axis.model_validate({"path": "a", "from": "1 mm", "to": text})


def test_an_end_of_a_range_is_finite():
    with pytest.raises(ValidationError, match="is no number with its unit"):
        Axis.model_validate({"path": "a", "from": "1 mm", "to": "1e999 mm"})


@pytest.mark.parametrize("unit", ["kg/cm^2", "m^9^9^9", "degC", "(", "shore", "a\nb"])
def test_a_value_in_a_unit_that_does_not_fit_stays_text(unit):
    axis = Axis.model_validate({"path": "a", "from": "1 mm", "to": "2 mm"})
    assert axis.number(f"3 {unit}") == f"3 {unit}"
    assert axis.number("3 cm") == 30.0
