"""Trials on a made-up solver with a known best design: resumed, constrained, failed as failed."""

import csv
import json
import re
import shutil
import sqlite3

import numpy as np
import pytest

from softact.cli import main as cli
from softact.errors import MeshError, SpecError
from softact.files.text import csv_text
from softact.optimise import optimise_page
from softact.optimise.spec import Optimisation, place_of
from softact.optimise.study import Trials, feasible
from softact.results.folder import read as read_results
from softact.results.own_folder import Output
from softact.run.start import SolverCrashError
from softact.sweep import compute as computing
from softact.sweep.axes import Axis
from softact.sweep.cache import Cache
from softact.sweep.record import refresh
from softact.sweep.spec import read
from tests import bent_beam

FILE = """
base:
  geometry: {type: block, length: 10 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
  materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
  steps: [{name: hang, gravity: [0, 0, -1]}]
parameters:
  - {path: geometry.length, from: 4 mm, to: 20 mm}
  - {path: geometry.width, values: [4 mm, 5 mm]}
objectives: [{measure: bending_angle_deg, goal: maximise}]
constraints: [{measure: bending_angle_deg, below: 120}]
trials: 12
reference: {geometry.length: 10 mm, geometry.width: 4 mm}
"""


@pytest.fixture
def made_up(monkeypatch):
    """10 degrees for each mm of length, one more for a width of 5 mm; beyond 18 mm it fails."""
    calls = []

    def run(spec, directory, **options):
        calls.append(spec)
        if spec.geometry.length > 18:
            raise MeshError("block: gmsh crashed")
        angle = 10 * spec.geometry.length + (spec.geometry.width == 5)
        bent_beam.write(directory, angle, 2, size={"nx": 6, "ny": 2, "nz": 7})

    monkeypatch.setattr(computing, "run", run)
    monkeypatch.setattr(
        optimise_page, "write_report", lambda folder: (folder / "report.html").touch()
    )
    return calls


def trials(tmp_path, text=FILE, **changes):
    (tmp_path / "opt.yaml").write_text(text)
    wanted, base = read(tmp_path / "opt.yaml", Optimisation)
    return Trials(wanted.model_copy(update=changes), base, Cache(tmp_path / "runs"), tmp_path)


def test_best_of_the_feasible_beats_the_reference(tmp_path, made_up):
    study = trials(tmp_path, trials=25)
    study.run(2, lambda trial, answer: None)
    (best,) = study.best()
    assert study.done[0].values == [100.0]  # the reference comes first
    assert 110 < best.values[0] <= 120
    assert all(t.values[0] > 120 for t in study.done if t.values and not feasible(t))
    path = optimise_page.write(study, Output(tmp_path, "optimize"))
    assert "reference" in path.read_text()
    with open(tmp_path / "trials.csv") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 25
    assert (tmp_path / "best/spec.yaml").is_file()


def test_failed_runs_are_failed_trials_with_their_cause(tmp_path, made_up):
    study = trials(tmp_path, FILE.replace("from: 4 mm", "from: 17 mm").replace(
        "length: 10 mm, geometry", "length: 19 mm, geometry"))  # fmt: skip
    study.run(2, lambda trial, answer: None)
    failed = [t for t in study.done if t.values is None]
    assert failed
    assert all(t.user_attrs["cause"] == "block: gmsh crashed" for t in failed)
    assert study.best() == []
    optimise_page.write(study, Output(tmp_path, "optimize"))


def test_a_second_call_goes_on(tmp_path, made_up):
    first = trials(tmp_path, trials=4)
    first.run(1, lambda trial, answer: None)
    first.study.ask()  # under way when the command is killed
    runs = len(made_up)
    again = trials(tmp_path, trials=4)
    again.run(1, lambda trial, answer: None)
    assert len(made_up) == runs
    assert [t.params for t in again.done] == [t.params for t in first.done]
    more = trials(tmp_path, trials=6)
    more.run(1, lambda trial, answer: None)
    assert len(more.done) == 6


def test_error_bars_carried_into_the_best_design_stay(tmp_path, made_up):
    """``softact converge --into best`` changes files there and their record; a second call leaves
    them alone, unless another design has become the best, or a file is damaged."""
    study = trials(tmp_path, trials=1)
    study.run(1, lambda trial, answer: None)
    best = tmp_path / "best"
    optimise_page.write(study, Output(tmp_path, "optimize"))
    (best / "mesh_error.json").write_text("{}")
    refresh(best)
    optimise_page.write(study, Output(tmp_path, "optimize"))
    assert (best / "mesh_error.json").read_text() == "{}"
    (best / "curve.csv").write_text("torn")
    optimise_page.write(study, Output(tmp_path, "optimize"))
    assert not (best / "mesh_error.json").exists() and len((best / "curve.csv").read_text()) > 99


def test_trials_of_another_file_are_not_mixed(tmp_path, made_up):
    trials(tmp_path)
    with pytest.raises(SpecError, match="another optimisation"):
        trials(tmp_path, FILE.replace("to: 20 mm", "to: 15 mm"))


def test_two_objectives_have_a_front(tmp_path, made_up):
    two = "objectives: [{measure: bending_angle_deg, goal: maximise}, "
    two += "{measure: pressure_kPa, goal: minimise}]"
    text = FILE.replace("objectives: [{measure: bending_angle_deg, goal: maximise}]", two)
    study = trials(tmp_path, text, trials=6)
    study.run(2, lambda trial, answer: None)
    # The made-up pressure is the same for all, so that the largest feasible angle beats all.
    (best,) = study.best()
    assert best.values[0] == max(t.values[0] for t in study.done if feasible(t))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("below: 120", "beneath: 120", "constraints.0.beneath: unknown key"),
        (", below: 120", "", "needs 'above', 'below' or both"),
        ("path: geometry.length", "path: geometry.mesh_size", "says how fine the mesh is"),
        ("goal: maximise", "goal: more", "'more' is not one of: maximise, minimise"),
        ("geometry.width: 4 mm}", "width: 4 mm}", "give a value for each of: geometry.length"),
    ],
)
def test_wrong_files(old, new, said, tmp_path):
    with pytest.raises(SpecError) as found:
        trials(tmp_path, FILE.replace(old, new))
    assert any(said in line for line in found.value.lines), found.value.lines


def test_plots_are_in_the_units_that_their_axes_name(tmp_path, made_up):
    """The cavity of tests/bent_beam.py has 116 · 12 · 10 mm³ = 13.92 mL."""
    text = FILE.replace(
        "objectives: [{measure: bending_angle_deg, goal: maximise}]",
        "objectives: [{measure: cavity_volume_mm3, goal: minimise}]",
    )
    study = trials(tmp_path, text, trials=2)
    study.run(1, lambda trial, answer: None)
    text = optimise_page.write(study, Output(tmp_path, "optimize")).read_text()
    found = re.findall(r"<script type='application/json'>(.*?)</script>", text, re.S)
    history, front = map(json.loads, found)
    assert history["y"] == front["y"] == "Cavity volume (mL)"
    assert history["traces"][0]["y"][0] == history["traces"][2]["y"][0] == pytest.approx(13.92)
    assert front["x"] == "Bending angle (°)"
    point = next(trace for trace in front["traces"] if trace["name"] == "reference")
    assert (point["x"], point["y"]) == ([pytest.approx(100)], [pytest.approx(13.92)])


def params(study):
    return [trial.params for trial in study.done]


@pytest.mark.parametrize("objectives", [1, 2])
def test_a_call_that_goes_on_proposes_what_one_call_would_have(tmp_path, made_up, objectives):
    text = FILE
    if objectives == 2:
        two = "goal: maximise}, {measure: tip_x_mm, goal: minimise}]"
        text = FILE.replace("goal: maximise}]", two)
    once, often = tmp_path / "once", tmp_path / "often"
    for folder in (once, often):
        folder.mkdir()
    whole = trials(once, text, trials=16)
    whole.run(1, lambda trial, answer: None)
    for count in (3, 4, 9, 16):
        parts = trials(often, text, trials=count)
        parts.run(1, lambda trial, answer: None)
    assert params(parts) == params(whole)
    lengths = [p["geometry.length"] for p in params(parts)]
    assert len(set(lengths)) == 16


@pytest.mark.parametrize(
    "change",
    [
        ("c10: 0.1 MPa", "c10: 0.5 MPa"),
        ("height: 4 mm", "height: 5 mm"),
        ("gravity: [0, 0, -1]", "gravity: [0, 0, 1]"),
    ],
)
def test_trials_of_another_base_are_not_mixed(tmp_path, made_up, change):
    """Also where the base is a file of the same name with another content."""
    base = tmp_path / "base.yaml"
    inline = FILE[FILE.index("  geometry:") : FILE.index("parameters:")]
    base.write_text(inline.replace("\n  ", "\n").removeprefix("  "))
    text = FILE.replace("base:\n" + inline, "base: base.yaml\n")
    trials(tmp_path, text, trials=2).run(1, lambda trial, answer: None)
    base.write_text(base.read_text().replace(*change))
    with pytest.raises(SpecError, match=r"trials\.db: holds trials of another base spec"):
        trials(tmp_path, text)
    base.write_text("description: a text\n" + base.read_text().replace(*reversed(change)))
    assert len(trials(tmp_path, text).done) == 2  # texts change no run


def test_trials_of_another_version_are_not_mixed(tmp_path, made_up, monkeypatch):
    trials(tmp_path, trials=1).run(1, lambda trial, answer: None)
    monkeypatch.setattr("softact.optimise.store.version", lambda: "softact 2")
    with pytest.raises(SpecError, match="another version of softact"):
        trials(tmp_path)


@pytest.mark.parametrize("cut", ["before it is asked", "before it is told", "before it ends"])
def test_a_trial_that_a_kill_cut_off_is_neither_lost_nor_false(tmp_path, made_up, cut):
    """The reference, wherever the kill came: with its own values afterwards, and once."""
    study = trials(tmp_path, trials=3)
    asked = study.study.ask()
    if cut != "before it is asked":
        study._suggest(asked)
    if cut == "before it ends":
        for name, value in (("cause", ""), ("run", "0" * 32), ("status", "complete")):
            asked.set_user_attr(name, value)
    study.study.ask()  # one more that was under way, without its values
    again = trials(tmp_path, trials=3)
    again.run(1, lambda trial, answer: None)
    assert len(again.done) == 3
    assert [t.values for t in again.done if t.params == again.reference.params] == [[100.0]]
    assert all((t.values is None) == (t.user_attrs["status"] != "complete") for t in again.done)


DAMAGE = {
    "cut": lambda raw: raw[: len(raw) // 2],
    "empty": lambda raw: b"",
    "zeros": lambda raw: raw[:4096] + bytes(len(raw) - 4096),
    "text": lambda raw: b"mine\n" * 100,
    "another name": lambda raw: raw.replace(b"softact", b"another"),
    "a state that is none": lambda raw: raw.replace(b"COMPLETE", b"COMPLETT"),
    "a parameter elsewhere": lambda raw: raw.replace(b'"log": false', b'"log": falsy'),
}


@pytest.mark.parametrize("how", DAMAGE)
def test_a_damaged_file_is_one_line_and_its_trials_come_again_from_the_cache(
    tmp_path, made_up, how
):
    text = FILE.replace("to: 20 mm", "to: 17 mm")  # no run fails: such are not kept
    first = trials(tmp_path, text, trials=3)
    first.run(1, lambda trial, answer: None)
    file, before = tmp_path / "trials.db", params(first)
    raw = file.read_bytes()
    assert DAMAGE[how](raw) != raw
    file.write_bytes(DAMAGE[how](raw))
    try:
        trials(tmp_path, text, trials=3)
    except SpecError as error:
        (line,) = error.lines
        assert line.startswith(f"{file}: ") and "move" in line
    else:
        pytest.fail("a damaged file was taken")
    file.rename(tmp_path / "trials.db.damaged")
    runs = len(made_up)
    again = trials(tmp_path, text, trials=3)
    again.run(1, lambda trial, answer: None)
    assert (params(again), len(made_up)) == (before, runs)


@pytest.mark.parametrize(
    "change",
    [
        "UPDATE trial_values SET value = value + 1",
        "UPDATE trial_user_attributes SET value_json = '[-2.0]' WHERE key = 'violations'",
    ],
)
def test_a_changed_value_in_the_file_is_noticed(tmp_path, made_up, change):
    study = trials(tmp_path, trials=2)
    study.run(1, lambda trial, answer: None)
    with sqlite3.connect(tmp_path / "trials.db") as connection:
        connection.execute(change)
    with pytest.raises(SpecError, match="the values of trial 0 are not those of its run"):
        trials(tmp_path)


def test_a_database_of_another_program_is_left_alone(tmp_path, made_up):
    with sqlite3.connect(tmp_path / "trials.db") as connection:
        connection.execute("CREATE TABLE mine (a)")
    before = (tmp_path / "trials.db").read_bytes()
    with pytest.raises(SpecError, match="cannot be read"):
        trials(tmp_path)
    assert (tmp_path / "trials.db").read_bytes() == before


ODD = [
    "[{law: neo_hookean, c10: 0.1 MPa}, {law: neo_hookean, c10: 0.2 MPa}]",
    "[elastosil-m4601, {law: neo_hookean, c10: 0.2 MPa}]",
    "[ecoflex-00-30, null]",
    "[ecoflex-00-30, 0, 2.5, true, [1, 2]]",
]


@pytest.mark.parametrize("values", ODD)
def test_choices_of_any_type(tmp_path, made_up, values):
    text = FILE.replace("{path: geometry.width, values: [4 mm, 5 mm]}",
                        f"{{path: materials.body, values: {values}}}")  # fmt: skip
    text = text[: text.index("reference")]
    study = trials(tmp_path, text, trials=6)
    study.run(1, lambda trial, answer: None)
    assert (
        len(study.done) == 6 and optimise_page.write(study, Output(tmp_path, "optimize")).is_file()
    )
    assert {str(study.coordinates(t)["materials.body"]) for t in study.done} <= {
        str(value) for value in study.wanted.parameters[1].values
    }


def test_a_measure_without_a_number_is_a_failed_trial(tmp_path, made_up):
    """As a failure pressure that is not reached: no trial with NaN, which Optuna takes for none."""
    text = FILE.replace("{measure: bending_angle_deg, below: 120}", "{measure: void, above: 0}")
    study = trials(tmp_path, text, trials=2)

    def with_void(spec, directory, **options):
        made = bent_beam.write(directory, 50.0, 2, size={"nx": 6, "ny": 2, "nz": 7})
        (directory / "curve.csv").write_text(csv_text([row | {"void": np.nan} for row in made]))

    computing.run = with_void  # taken back by made_up
    study.run(1, lambda trial, answer: None)
    assert [t.values for t in study.done] == [None, None]
    assert study.done[0].user_attrs["cause"] == "the run has no value of void"


def test_the_best_run_is_computed_again_where_the_cache_has_gone(tmp_path, made_up):
    trials(tmp_path, trials=2).run(1, lambda trial, answer: None)
    shutil.rmtree(tmp_path / "runs")
    optimise_page.write(trials(tmp_path, trials=2), Output(tmp_path, "optimize"))
    assert read_results(tmp_path / "best").status == "complete"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("length: 10 mm, geometry", "length: 30 mm, geometry", "'30 mm' is outside of its range"),
        ("length: 10 mm, geometry", "length: 3 kPa, geometry", "'3 kPa' is no number in mm"),
        ("geometry.width: 4 mm}", "geometry.width: 6 mm}", "'6 mm' is none of its values: '4 mm'"),
    ],
)
def test_a_reference_that_no_trial_could_be_is_refused(old, new, said, tmp_path):
    with pytest.raises(SpecError) as found:
        trials(tmp_path, FILE.replace(old, new))
    (line,) = found.value.lines
    assert line.startswith(f"{tmp_path / 'opt.yaml'}:12: reference.geometry.") and said in line


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("objectives: [{measure: bending_", "objectives: [{measure: bendin_",
         "opt.yaml:9: objectives.0.measure: 'bendin_angle_deg': the run has no such column; did "
         "you mean 'bending_angle_deg'?"),
        ("constraints: [{measure: bending_angle_deg", "constraints: [{measure: bending",
         "opt.yaml:10: constraints.0.measure: 'bending': is a group of columns; name one of: "),
        ("c10: 0.1 MPa", "c10: 0.1 mm", "materials.body.c10: '0.1 mm'"),
        ("geometry.width: 4 mm}", "geometry.width: 5 mm}\nset: {geometry.height: 0 mm}",
         "the height would vanish"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_told_before_the_first_run(
    old, new, said, tmp_path, made_up, capsys, monkeypatch
):
    """With exit code 2, and nothing is written."""
    monkeypatch.chdir(tmp_path)
    for text in (FILE, FILE[: FILE.index("reference")]):
        if old not in text:
            continue
        (tmp_path / "opt.yaml").write_text(text.replace(old, new))
        with pytest.raises(SystemExit) as stop:
            cli.main(["optimize", "opt.yaml"])
        assert stop.value.code == 2 and said in capsys.readouterr().err
        assert (made_up, [path.name for path in tmp_path.iterdir()]) == ([], ["opt.yaml"])


def test_a_trial_whose_solver_was_killed_is_tried_again_by_the_next_call(
    tmp_path, made_up, monkeypatch
):
    whole = trials(tmp_path, trials=4)
    solve, killed = computing.run, []

    def once_killed(spec, directory, **options):
        if len(made_up) == 2 and not killed:
            killed.append(spec)
            raise SolverCrashError("the solver was killed by signal 9")
        solve(spec, directory, **options)

    monkeypatch.setattr(computing, "run", once_killed)
    whole.run(1, lambda trial, answer: None)
    assert [t.user_attrs["status"] for t in whole.done][2] == "failed"
    for _ in range(2):
        again = trials(tmp_path, trials=4)
        again.run(1, lambda trial, answer: None)
        assert len(again.done) == 4
        assert again.done[-1].params == whole.done[2].params
        assert all(t.user_attrs["cause"] in ("", "block: gmsh crashed") for t in again.done)


def test_true_and_one_are_two_choices():
    axis = Axis.model_validate({"path": "a", "values": [1, "1", [1]]})
    assert [place_of(axis, value) for value in (1, "1", [1], True, 1.0)] == [0, 1, 2, None, None]
