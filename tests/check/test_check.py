"""`softact check`: what deviates is named, in words; planted errors are caught by their cases."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner

from softact.check import compare
from softact.check.cases import find, read
from softact.cli.check import check as command
from softact.errors import SpecError
from tests import bent_beam

ROOT = Path(__file__).parents[2]
CASE = """\
description: a made-up run
spec:
  geometry: {type: block, length: 4 mm}
  materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
  steps: [{name: hang, gravity: [0, 0, -1]}]
values:
  - {measure: bending_angle_deg, value: 40.0, tolerance: 0.1, kind: exact, source: "by hand"}
  - measure: bending_angle_deg
    value: 15.0  # half of that, and a half more
    tolerance: 0.1
    kind: computed
    source: "softact"
    at: {column: pressure_kPa, value: 18.75}
"""
OLD = CASE.replace("value: 15.0", "value: 16.5")


@pytest.fixture
def case(tmp_path, monkeypatch):
    """A case whose run is made up: 40 degrees at 50 kPa, in proportion to the pressure."""

    def run(spec, directory, **options):
        bent_beam.write(directory, 40.0, 4, size={"nx": 6, "ny": 2, "nz": 7})
        return compare_outcome(directory)

    def compare_outcome(directory):
        from softact.run.start import Outcome

        return Outcome("complete", directory, None)

    monkeypatch.setattr(compare, "run", run)
    path = tmp_path / "beam.yaml"
    path.write_text(CASE)
    return path


def call(*arguments):
    result = CliRunner().invoke(command, [str(a) for a in arguments], catch_exceptions=False)
    return result.exit_code, result.output


def test_values_as_stored_pass(case, tmp_path):
    """At 18.75 kPa, between two states, 40/50 · 18.75 = 15 degrees."""
    code, said = call(case, "--junit", tmp_path / "check.xml")
    assert (code, "1 of 1 cases are as stored" in said) == (0, True)
    suite = ElementTree.parse(tmp_path / "check.xml").getroot()
    assert (suite.get("tests"), suite.get("failures"), suite.get("errors")) == ("1", "0", "0")


def test_a_deviation_is_told_in_words(case, tmp_path):
    case.write_text(CASE.replace("value: 40.0", "value: 43.0"))
    code, said = call(case, "--junit", tmp_path / "check.xml")
    assert code == 1
    assert (
        "beam: bending_angle_deg 40, stored 43 ± 0.1, off by 30 tolerances [exact: by hand]" in said
    )
    failure = ElementTree.parse(tmp_path / "check.xml").getroot().find("testcase/failure")
    assert "stored 43 ± 0.1" in failure.get("message")


def test_update_stores_computed_values_with_the_reason(case):
    case.write_text(OLD)
    code, said = call(case, "--update", "--reason", "another mesh")
    assert code == 0
    assert "stored  beam: bending_angle_deg at pressure_kPa 18.75: 16.5 -> 15" in said
    text = case.read_text()
    assert "value: 15.0  # half of that, and a half more" in text
    again = read(case)
    assert again.content.history[0].reason == "another mesh"
    assert call(case)[0] == 0


@pytest.mark.parametrize("kind", ["edited", "edited elsewhere"])
def test_an_edit_while_the_case_runs_is_not_written_over(case, monkeypatch, kind):
    """The numbers of lines are those of the file as it was read."""
    made_up, edited = compare.run, OLD.replace("made-up", "my own")
    if kind == "edited elsewhere":
        edited = "# a line more\n" + OLD
    case.write_text(OLD)

    def run(spec, directory, **options):
        case.write_text(edited)
        return made_up(spec, directory, **options)

    monkeypatch.setattr(compare, "run", run)
    with pytest.raises(SpecError, match="was edited while the case ran; nothing is stored"):
        call(case, "--update", "--reason", "a test")
    assert case.read_text() == edited


def test_update_writes_through_a_link_and_keeps_line_ends_and_permissions(case, tmp_path):
    case.write_bytes(OLD.replace("\n", "\r\n").encode())
    case.chmod(0o600)
    (tmp_path / "link.yaml").symlink_to(case)
    call(tmp_path / "link.yaml", "--update", "--reason", "a test")
    assert (tmp_path / "link.yaml").is_symlink()
    raw = case.read_bytes()
    assert raw.count(b"\r\n") == raw.count(b"\n") and b"a test" in raw
    assert case.stat().st_mode & 0o777 == 0o600
    assert call(case)[0] == 0


def test_a_text_that_would_be_no_case_is_not_written(case, monkeypatch):
    case.write_text(OLD)
    monkeypatch.setattr("softact.check.update.to_text", lambda entry: "- {date: 5}")
    with pytest.raises(SpecError, match="history"):
        call(case, "--update", "--reason", "a test")
    assert case.read_text() == OLD


def test_update_leaves_exact_values(case):
    case.write_text(CASE.replace("value: 40.0", "value: 43.0"))
    before = case.read_text()
    assert call(case, "--update", "--reason", "it says so")[0] == 1
    assert case.read_text() == before


def test_update_asks_for_a_reason(case):
    with pytest.raises(SpecError, match="say why"):
        call(case, "--update")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("kind: exact", "kind: sure", "beam.yaml:7: values.0.kind: 'sure' is not one of: exact"),
        ("tolerance: 0.1,", "tolerance: 0,", "values.0.tolerance: '0' must be greater than 0"),
        ("c10: 0.1 MPa", "c10: 0.1", "beam.yaml:4: materials.body.c10"),
        ("type: block", "type: blok", "there is no geometry 'blok'"),
    ],
)
def test_wrong_cases_are_one_line(case, old, new, said):
    case.write_text(CASE.replace(old, new))
    with pytest.raises(SpecError) as found:
        call(case)
    assert any(said in line for line in found.value.lines), found.value.lines


def test_a_column_that_is_not_there_is_a_deviation(case):
    case.write_text(CASE.replace("bending_angle_deg, value", "twist_deg, value"))
    code, said = call(case)
    assert code == 1
    assert "twist_deg is not there (the run has no such column)" in said


def test_stored_cases_cover_what_they_should(monkeypatch):
    monkeypatch.chdir(ROOT)
    cases = [read(path) for path in find(())]
    assert len(cases) >= 8
    text = "\n".join(case.path.read_text() for case in cases)
    for wanted in ("neo_hookean", "yeoh", "ecoflex-00-30", "pressure:", "surface_pressure",
                   "layers:", "gravity:", "traction:", "move:"):  # fmt: skip
        assert wanted in text, wanted
    exact = [case for case in cases if any(v.kind == "exact" for v in case.content.values)]
    assert len(exact) >= 8


# What is changed in the sources, and the case that has to fail for it.
PLANTED = {
    "wrong constant": ("softact/cards/ecoflex-00-30.yaml", "2.225e-2", "2.252e-2",
                       "equibiaxial_ogden"),
    "wrong size of pressure": ("softact/loads/cavity_pressure.py", "self._u(state.x), [pressure])",
                               "self._u(state.x), [pressure / 2])", "thick_sphere_yeoh"),
    "lost layer": ("softact/bodies/layer.py", "Layer(model, layer) for layer in parts]",
                   "Layer(model, layer) for layer in parts[:0]]", "layer_in_tension"),
}  # fmt: skip


@pytest.mark.parametrize("error", PLANTED)
def test_planted_errors_are_named_by_a_failing_case(error, tmp_path):
    file, right, wrong, case = PLANTED[error]
    # The layout that setuptools gives the installed package.
    ignore = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "softact", tmp_path / "softact", ignore=ignore)
    for part in ("cli", "geometries"):
        shutil.copytree(ROOT / part, tmp_path / "softact" / part, ignore=ignore)
    shutil.copytree(ROOT / "configs" / "reference", tmp_path / "configs" / "reference")
    text = (tmp_path / file).read_text()
    assert right in text
    (tmp_path / file).write_text(text.replace(right, wrong))
    done = subprocess.run(
        [sys.executable, "-m", "softact.cli.main", "check", case, "-j", "1"],
        cwd=tmp_path,  # where python -m looks first
        env=os.environ | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 1, done.stdout + done.stderr
    assert f"FAIL  {case}" in done.stdout
    assert f"{case}: " in done.stdout and "stored" in done.stdout
