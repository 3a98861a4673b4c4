"""Trials on a made-up solver with a known best design: resumed, constrained, failed as failed."""

import csv
import json
import re

import bent_beam
import pytest

from softact.errors import MeshError, SpecError
from softact.optimise import page
from softact.optimise.spec import Optimisation
from softact.optimise.study import Trials, feasible
from softact.sweep import compute as computing
from softact.sweep.cache import Cache
from softact.sweep.record import refresh
from softact.sweep.spec import read

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
    monkeypatch.setattr(page, "write_report", lambda directory: None)
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
    path = page.write(study, tmp_path)
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
    page.write(study, tmp_path)


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
    page.write(study, tmp_path)
    (best / "mesh_error.json").write_text("{}")
    refresh(best)
    page.write(study, tmp_path)
    assert (best / "mesh_error.json").read_text() == "{}"
    (best / "curve.csv").write_text("torn")
    page.write(study, tmp_path)
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
    text = page.write(study, tmp_path).read_text()
    found = re.findall(r"<script type='application/json'>(.*?)</script>", text, re.S)
    history, front = map(json.loads, found)
    assert history["y"] == front["y"] == "Cavity volume (mL)"
    assert history["traces"][0]["y"][0] == history["traces"][2]["y"][0] == pytest.approx(13.92)
    assert front["x"] == "Bending angle (°)"
    point = next(trace for trace in front["traces"] if trace["name"] == "reference")
    assert (point["x"], point["y"]) == ([pytest.approx(100)], [pytest.approx(13.92)])
