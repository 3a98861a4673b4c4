"""A run goes on from where it was interrupted, to the numbers that it would have had."""

import csv
import json
import random
import subprocess
import sys

import pytest

from benchmarks import resume
from softact import spec as specs
from softact.errors import SoftactError
from softact.run import run

CUBE = """
name: cube
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps:
  - {name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}
  - {name: push, traction: {surface: x_max, value: [20 kPa, 5 kPa, 0 kPa]}}
solver: {initial_increment: 0.1, max_increment: 0.1}
"""


class Killed(BaseException):
    """Stands for a kill: nothing of the program runs afterwards."""


@pytest.fixture
def cube(tmp_path):
    file = tmp_path / "cube.yaml"
    file.write_text(CUBE)
    return lambda *changes: specs.load(str(file), changes)


def curve(directory):
    with (directory / "curve.csv").open() as file:
        return list(csv.DictReader(file))


def interrupt(spec, directory, after):
    """Solve and kill the command after so many increments; its solver ends with it."""
    count = 0

    def progress(event):
        nonlocal count
        count += event["stage"] == "increment"
        if count > after:
            raise Killed

    with pytest.raises(Killed):
        run(spec, directory, progress=progress, report=False)
    assert json.loads((directory / "run.json").read_text())["status"] == "incomplete"


@pytest.mark.parametrize("after", random.Random(4).sample(range(2, 18), 3))
def test_interrupted_run_goes_on(cube, tmp_path, after):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    run(cube(), whole, report=False)
    interrupt(cube(), cut, after)
    solved = []
    outcome = run(cube(), cut, progress=solved.append, report=False, resume=True)
    assert outcome.status == "complete"
    assert sum(event["stage"] == "increment" for event in solved) <= 20 - after + 1
    assert resume.difference(curve(whole), curve(cut)) < 1e-8
    fields = [specs_fields(folder) for folder in (whole, cut)]
    assert fields[0] == fields[1]


def specs_fields(folder):
    from softact.results import read

    results = read(folder)
    return len(results.increments), results.field(-1, "displacement").round(9).tolist()


def test_another_number_of_processes_goes_on(cube, tmp_path):
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    run(cube(), whole, report=False)
    interrupt(cube(), cut, 7)
    run(cube(), cut, processes=2, report=False, resume=True)
    for row, other in zip(curve(whole), curve(cut), strict=True):
        for name in ("tip_x_mm", "tip_y_mm", "strain_energy_mJ", "max_principal_stretch"):
            assert float(row[name]) == pytest.approx(float(other[name]), rel=1e-6, abs=1e-9)


def test_finished_run_is_extended(cube, tmp_path):
    """To a higher last load, and by a further step: as if it had been written so at once."""
    further, once = "steps.1.traction.value=[20 kPa, 10 kPa, 0 kPa]", tmp_path / "once"
    run(cube(further), once, report=False)
    run(cube(), tmp_path / "out", report=False)
    begun = len(curve(tmp_path / "out"))
    outcome = run(cube(further), tmp_path / "out", report=False, resume=True)
    assert outcome.status == "complete"
    found = curve(tmp_path / "out")
    assert len(found) > begun
    ends = curve(once)[-1], found[-1]
    assert float(ends[0]["strain_energy_mJ"]) == pytest.approx(float(ends[1]["strain_energy_mJ"]))


def test_nothing_is_left_to_do(cube, tmp_path):
    run(cube(), tmp_path / "out", report=False)
    before = (tmp_path / "out" / "curve.csv").stat().st_mtime_ns
    assert run(cube(), tmp_path / "out", report=False, resume=True).status == "complete"
    assert (tmp_path / "out" / "curve.csv").stat().st_mtime_ns == before


def test_fields_cut_off_in_a_write(cube, tmp_path):
    """fields.h5 cannot be read: all is solved anew."""
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    run(cube(), whole, report=False)
    interrupt(cube(), cut, 7)
    with (cut / "fields.h5").open("r+b") as file:
        file.truncate(100)
    assert run(cube(), cut, report=False, resume=True).status == "complete"
    assert resume.difference(curve(whole), curve(cut)) < 1e-8


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("materials.body.c10=0.2 MPa", "holds the run of another spec (materials differ)"),
        ("steps.0.traction.value=[1 kPa, 0 kPa, 0 kPa]", "only what comes after may change"),
        ("steps.1.traction.value=[1 kPa, 0 kPa, 0 kPa]", "is not finished; resume it as it was"),
    ],
)
def test_another_spec_is_refused(cube, tmp_path, change, words):
    interrupt(cube(), tmp_path / "cut", 13)
    kept = (tmp_path / "cut" / "curve.csv").read_bytes()
    with pytest.raises(SoftactError) as refused:
        run(cube(change), tmp_path / "cut", report=False, resume=True)
    assert refused.value.exit_code == 2
    assert words in str(refused.value.lines)
    assert (tmp_path / "cut" / "curve.csv").read_bytes() == kept


def test_command_line(cube, tmp_path):
    interrupt(cube(), tmp_path / "cut", 5)
    command = [sys.executable, "-m", "softact.cli.main", "run", "cube.yaml", "-o", "cut"]
    done = subprocess.run([*command, "--resume"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "cut/run.json").read_text())["status"] == "complete"
    assert (tmp_path / "cut/report.html").is_file()
