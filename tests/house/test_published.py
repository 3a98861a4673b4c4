"""Published figures: what is read off a run, and that no figure is left out of the page."""

import sys
from pathlib import Path

import numpy as np
import pytest

from softact.measured.curve import run_columns
from softact.sweep.cache import Cache
from softact.sweep.points import spec_at

sys.path.append(str(Path(__file__).resolve().parents[2] / "docs"))
from published import compute, figures, page, results

COLUMNS = ("pressure_kPa", "angle_deg")
# Two states without pressure, then up: at 15 kPa halfway between 20 and 40 degrees.
CURVE = np.array([[0, 0], [0, 5.0], [10, 20.0], [20, 40.0]])


@pytest.fixture(scope="module")
def sources():
    return figures.read()


def reading(**keys):
    return figures.Reading(column="angle_deg", **keys).of(COLUMNS, CURVE)


def figure(**keys):
    usual = {"id": "f", "what": "bending", "where": "Fig. 1", "kind": "measured", "unit": "°"}
    read = {"column": "elongation_mm", "at": {}}
    return figures.Figure(**(usual | {"runs": ["r"], "read": read} | keys))


def source(run, *shown):
    return figures.Source(name="S", source="paper", runs={"r": run}, figures=shown)


def rows(made):
    return [line.split(" | ") for line in made if line.startswith("| bending")]


def test_a_reading_is_linear_between_equilibria():
    assert reading(at={"pressure_kPa": 15}) == {"value": 30.0}
    assert reading(at={"pressure_kPa": 20}, scale=0.5) == {"value": 20.0}
    assert reading() == {"value": 40.0}
    both = figures.Reading(column="angle_deg + pressure_kPa", at={"pressure_kPa": 15}, scale=2.0)
    assert both.of(COLUMNS, CURVE) == {"value": 90.0}
    vacuum = figures.Reading(column="angle_deg", at={"pressure_kPa": -15})
    assert vacuum.of(COLUMNS, CURVE * [-1, 1]) == {"value": 30.0}


def test_a_run_that_ended_before_tells_where():
    assert reading(at={"pressure_kPa": 43}) == {"value": None, "last": [20.0, 40.0]}
    with pytest.raises(KeyError, match="no column pressure_MPa"):
        reading(at={"pressure_MPa": 1})


def test_every_run_has_a_right_spec_and_all_columns_that_are_read(sources):
    for paper in sources:
        for name, run in paper.runs.items():
            used = [entry for entry in paper.figures if name in entry.runs]
            assert used, f"{name} gives no figure"
            columns = {*run_columns(spec_at(run.base(), run.changes)), "unstable_modes"}
            for entry in used:
                assert {*entry.read.summands, *entry.read.at} <= columns, entry.id


def test_no_figure_is_left_out_whatever_became_of_its_run(sources):
    made = list(page.lines(sources, {}))
    runs = {name for paper in sources for name in paper.runs}
    shown = [line for line in made if " | not computed" in line and "softact run" not in line]
    shown += [line for line in made if "× not computed" in line]
    assert len(set(shown)) == sum(len(paper.groups) for paper in sources)
    assert all(sum(f"`{name}`" in line for line in shown) for name in runs)
    for figure in (figure for paper in sources for figure in paper.figures if figure.variant_of):
        assert any(f"({figure.differs})" in line for line in shown), figure.id
    xavier = next(line for line in made if line.startswith("| blocked force, NinjaFlex, two of f"))
    assert "1.1524 N (computed there; Table 3)" in xavier


def test_four_kinds_of_rows_are_never_mixed(sources):
    made = list(page.lines(sources, {}))
    starts = {f"**{title}**": kind for kind, title in page.KINDS.items()}
    kind, found = "", {}
    for line in made:
        kind = starts.get(line, "" if line.startswith("### ") else kind)
        found.setdefault(kind, []).append(line)
    for paper in sources:
        for first, *variants in paper.groups:
            assert {figure.row for figure in variants} <= {first.row}
            assert any(line.startswith(f"| {first.what} |") for line in found[first.row])
    of_tests = [line for line in found["test"] if "not computed" in line]
    assert all("(measured; " in line for line in of_tests if "softact run" not in line)
    assert not any("(measured; " in line for line in found["model"])


def test_what_is_off_says_why(sources):
    known = results.read()
    lacking = {paper.name: page.causes_lacking(paper, known) for paper in sources}
    assert not any(lacking.values()), lacking


def test_variants_share_a_row_with_the_spread(run):
    first = figure(value=4.0, cause="a guess")
    other = figure(id="g", value=4.0, variant_of="f", differs="twice as long", runs=["s"])
    both = figures.Source(
        name="S", source="paper", runs={"r": run, "s": run}, figures=(first, other)
    )
    outcomes = {
        name: results.Outcome(
            input=run.fingerprint(),
            status="complete",
            commit="x",
            readings={f.id: {"read": results.asked(f), "value": value}},
        )
        for name, f, value in (("r", first, 3.0), ("s", other, 5.0))
    }
    (row,) = rows(page.lines([both], outcomes))
    assert row[2:5] == ["3° (as assumed); 5° (twice as long)", "−25 to +25 %", "a guess"]
    assert page.causes_lacking(both, outcomes) == []


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        ({"variant_of": "x", "differs": "longer"}, "g: there is no figure x"),
        ({"variant_of": "f", "differs": "longer", "value": 5.0}, "g: f is published otherwise"),
        ({"variant_of": "f"}, "g: say in what it differs from f"),
    ],
)
def test_wrong_variants_are_refused(keys, line, run):
    other = figure(**({"id": "g", "value": 4.0} | keys))
    shown = figures.Source(
        name="S", source="paper", runs={"r": run}, figures=(figure(value=4.0), other)
    )
    with pytest.raises(ValueError, match=line):
        figures.check_variants(shown)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A block, pulled by 5 mm in two increments."""
    file = tmp_path_factory.mktemp("published") / "block.yaml"
    file.write_text(
        "geometry: {type: block, mesh_size: 10 mm}\n"
        "materials: {body: {law: neo_hookean, c10: 0.1 MPa}}\n"
        "steps:\n"
        "  - supports: [{surface: x_min, fix: [x, y, z]}, {surface: x_max, move: {x: 5 mm}}]\n"
        "measures: [elongation]\n"
        "solver: {initial_increment: 0.5, max_increment: 0.5}\n"
    )
    return figures.Run(spec=str(file))


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    return Cache(tmp_path_factory.mktemp("runs"))


def test_a_run_is_computed_once_and_stands_beside_the_published_figure(run, kept, tmp_path):
    shown = [figure(value=4.0), figure(id="g", above=0), figure(id="h", below=5)]
    found = compute.outcome_of(run, shown, kept, 60.0)
    assert found.status == "complete"
    assert found.readings["f"]["value"] == pytest.approx(5.0)
    results.store("r", found, tmp_path / "results.json")
    again = compute.outcome_of(run, shown, kept, 60.0)
    assert again == results.read(tmp_path / "results.json")["r"] == found
    assert len((kept.directory / "journal.csv").read_text().splitlines()) == 1
    assert page.is_current(found, run, shown)
    first, second, third = rows(page.lines([source(run, *shown)], {"r": found}))
    assert first[1:4] == ["4° (measured; Fig. 1)", "5°", "+25 %"]
    assert second[3] == "holds"
    assert third[3] == "**does not hold**"


def test_a_run_that_was_written_anew_is_said_to_be_old(run, kept):
    found = compute.outcome_of(run, [figure(value=4.0)], kept, 60.0)
    changed = figures.Run(spec=run.spec, set={"materials.body.c10": "0.2 MPa"})
    assert not page.is_current(found, changed, [figure(value=4.0)])
    (row,) = rows(page.lines([source(changed, figure(value=4.0))], {"r": found}))
    assert row[2] == "5° (of an older spec)"
    other = figure(value=4.0, read={"column": "elongation_mm", "scale": 2.0})
    assert not page.is_current(found, run, [other]), "another reading is another figure"


def test_a_run_that_takes_too_long_is_stopped_and_said_to_be(run, tmp_path):
    longer = figures.Run(spec=run.spec, set={"solver.initial_increment": 0.25})
    found = compute.outcome_of(longer, [figure(at_least=5)], Cache(tmp_path), 0.3)
    assert (found.status, found.cause) == ("stopped", "by us after 0.3 s")
    assert not list((tmp_path / "tmp").iterdir())


def test_a_claim_about_the_end_of_a_stopped_run_is_left_open(run):
    stable = figure(at_least=5)
    found = results.Outcome(
        input=run.fingerprint(),
        status="stopped",
        commit="x",
        readings={"f": {"read": results.asked(stable), "value": 2.0}},
    )
    (row,) = rows(page.lines([source(run, stable)], {"r": found}))
    assert row[2:4] == ["stopped at 2°", "not reached"]
    nowhere = found.model_copy(update={"readings": {"f": {"read": results.asked(stable)}}})
    nowhere.readings["f"]["value"] = None  # an empty column, as a failure pressure before failure
    (row,) = rows(page.lines([source(run, stable)], {"r": nowhere}))
    assert row[2:4] == ["not reached", "not reached"]


def test_trends_hold_or_do_not():
    three = ("a", "b", "c")
    assert figure(trend="rises", runs=three).holds([1, 2, 3])
    assert not figure(trend="rises", runs=three).holds([1, 3, 2])
    assert figure(trend="falls", runs=three).holds([3, 2, 1])
    assert figure(trend="peak", runs=three).holds([1, 3, 2])
    assert not figure(trend="peak", runs=three).holds([3, 2, 1])
    with pytest.raises(ValueError, match="one of value"):
        figure(value=1.0, trend="rises")
