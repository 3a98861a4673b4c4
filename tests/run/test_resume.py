"""A run goes on from where it was interrupted, to the numbers that it would have had."""

import csv
import json
import random
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

from benchmarks import resume
from softact import spec as specs
from softact.errors import SoftactError
from softact.files.restart import RESTART, seal, unseal
from softact.run.start import run

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


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder of a run that nobody disturbs."""
    folder = tmp_path_factory.mktemp("whole") / "out"
    run(specs.loads(CUBE), folder, report=False)
    return folder


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory):
    """Function that makes a copy of the folder of a run that was killed after so many increments;
    each is solved once."""
    known = {}

    def copy(after, directory):
        if after not in known:
            known[after] = tmp_path_factory.mktemp("cut") / "out"
            interrupt(specs.loads(CUBE), known[after], after)
        shutil.copytree(known[after], directory)

    return copy


def curve(directory):
    with (directory / "curve.csv").open() as file:
        return list(csv.DictReader(file))


def interrupt(spec, directory, after, processes=1):
    """Solve and kill the command after so many increments; its solver ends with it.

    On a busy machine the solver may have come to its end before word of its increments arrives;
    then there was nothing to interrupt, and it is solved again."""
    for _ in range(5):
        count = 0

        def progress(event):
            nonlocal count
            count += event["stage"] == "increment"
            if count > after:
                raise Killed

        with pytest.raises(Killed):
            run(spec, directory, processes=processes, progress=progress, report=False)
        status = json.loads((directory / "run.json").read_text())["status"]
        if status == "incomplete":
            return
        assert status == "complete"
        shutil.rmtree(directory)
    pytest.fail("the solver was at its end before it could be killed, five times")


@pytest.mark.parametrize("after", random.Random(4).sample(range(2, 18), 3))
def test_interrupted_run_goes_on(cube, whole, tmp_path, after):
    cut = tmp_path / "cut"
    interrupt(cube(), cut, after)
    solved = []
    outcome = run(cube(), cut, progress=solved.append, report=False, resume=True)
    assert outcome.status == "complete"
    assert sum(event["stage"] == "increment" for event in solved) <= 20 - after + 1
    assert resume.difference(curve(whole), curve(cut)) < 1e-8
    fields = [specs_fields(folder) for folder in (whole, cut)]
    assert fields[0] == fields[1]


def specs_fields(folder):
    from softact.results.folder import read

    results = read(folder)
    return len(results.increments), results.field(-1, "displacement").round(9).tolist()


@pytest.mark.parametrize("name", ["jaws.partner", "plane.stiffness"])
def test_what_an_earlier_softact_remembered_of_contact_is_not_passed_over(
    cube, interrupted, tmp_path, name
):
    cut = tmp_path / "cut"
    interrupted(7, cut)
    known, file = unseal(cut / RESTART)
    arrays = {key: file[key] for key in file.files if key != "known"}
    (cut / RESTART).write_bytes(seal(known, {**arrays, f"memory/0/now/{name}": np.array(4.0)}))
    with pytest.raises(SoftactError, match="was written by another version"):
        run(cube(), cut, report=False, resume=True)


def test_another_number_of_processes_goes_on(cube, whole, interrupted, tmp_path):
    cut = tmp_path / "cut"
    interrupted(7, cut)
    run(cube(), cut, processes=2, report=False, resume=True)
    assert_alike(whole, cut)


def assert_alike(whole, other):
    """Figures of two runs on other numbers of processes."""
    for row, there in zip(curve(whole), curve(other), strict=True):
        for name in ("tip_x_mm", "tip_y_mm", "strain_energy_mJ", "max_principal_stretch"):
            assert float(row[name]) == pytest.approx(float(there[name]), rel=1e-6, abs=1e-9)


def test_several_processes_hold_what_they_held(cube, whole, tmp_path):
    """What each remembers is of its own part of the mesh. Of an earlier softact, it may be of
    another: then it is refused, but where nothing depends on it."""
    cut = tmp_path / "cut"
    interrupt(cube(), cut, 7, processes=2)
    known, file = unseal(cut / RESTART)
    arrays = {name: file[name] for name in file.files if name != "known"}
    assert len(arrays["memory/1/passed/branch"])
    (earlier := dict(known)).pop("parts")
    shutil.copytree(cut, tmp_path / "two")
    run(cube(), tmp_path / "two", processes=2, report=False, resume=True)
    assert_alike(whole, tmp_path / "two")
    shutil.copytree(cut, tmp_path / "earlier")
    (tmp_path / "earlier" / RESTART).write_bytes(seal(earlier, arrays))
    shutil.copytree(tmp_path / "earlier", tmp_path / "beyond")
    run(cube(), tmp_path / "earlier", processes=2, report=False, resume=True)
    assert_alike(whole, tmp_path / "earlier")
    arrays["memory/0/passed/left"] = np.array(1)
    (tmp_path / "beyond" / RESTART).write_bytes(seal(earlier, arrays))
    with pytest.raises(SoftactError, match="was begun by an earlier softact"):
        run(cube(), tmp_path / "beyond", processes=2, report=False, resume=True)


def test_finished_run_is_extended(cube, whole, tmp_path):
    """To a higher last load, and by a further step: as if it had been written so at once."""
    further, once = "steps.1.traction.value=[20 kPa, 10 kPa, 0 kPa]", tmp_path / "once"
    run(cube(further), once, report=False)
    shutil.copytree(whole, tmp_path / "out")
    begun = len(curve(tmp_path / "out"))
    outcome = run(cube(further), tmp_path / "out", report=False, resume=True)
    assert outcome.status == "complete"
    found = curve(tmp_path / "out")
    assert len(found) > begun
    ends = curve(once)[-1], found[-1]
    assert float(ends[0]["strain_energy_mJ"]) == pytest.approx(float(ends[1]["strain_energy_mJ"]))


def test_nothing_is_left_to_do(cube, whole, tmp_path):
    shutil.copytree(whole, tmp_path / "out")
    before = (tmp_path / "out" / "curve.csv").stat().st_mtime_ns
    assert run(cube(), tmp_path / "out", report=False, resume=True).status == "complete"
    assert (tmp_path / "out" / "curve.csv").stat().st_mtime_ns == before


def test_fields_that_cannot_be_read(cube, interrupted, tmp_path):
    """They are missed with a word, and nothing of what is there is lost; anew it is solved."""
    cut = tmp_path / "cut"
    interrupted(7, cut)
    (cut / "fields.h5").write_bytes((cut / "fields.h5").read_bytes()[:100])
    before = {path.name: path.read_bytes() for path in cut.iterdir()}
    with pytest.raises(SoftactError) as refused:
        run(cube(), cut, report=False, resume=True)
    (line,) = refused.value.lines
    assert line.startswith(f"{cut}/fields.h5: is damaged (") and line.endswith("solved anew")
    assert {path.name: path.read_bytes() for path in cut.iterdir()} == before
    assert run(cube(), cut, report=False).status == "complete"


def test_curve_and_run_that_cannot_be_read(cube, whole, interrupted, tmp_path):
    """The file from which a run goes on holds all that they held."""
    cut = tmp_path / "cut"
    interrupted(7, cut)
    for name in ("curve.csv", "run.json", "spec.yaml"):
        (cut / name).write_bytes(b"\xff\0" + (cut / name).read_bytes()[:50])
    assert run(cube(), cut, report=False, resume=True).status == "complete"
    assert resume.difference(curve(whole), curve(cut)) < 1e-8
    assert (cut / "spec.yaml").read_text() == (whole / "spec.yaml").read_text()


@pytest.mark.parametrize("damage", ["cut", "zeroed", "one bit"])
def test_restart_file_that_is_damaged(cube, interrupted, tmp_path, damage):
    interrupted(7, tmp_path / "cut")
    path = tmp_path / "cut" / "restart.npz"
    raw = bytearray(path.read_bytes())
    if damage == "cut":
        raw = raw[: len(raw) // 2]
    elif damage == "zeroed":
        raw = bytearray(len(raw))
    else:
        raw[len(raw) // 3] ^= 4
    path.write_bytes(raw)
    with pytest.raises(SoftactError) as refused:
        run(cube(), tmp_path / "cut", report=False, resume=True)
    assert refused.value.exit_code == 2
    assert refused.value.lines == [
        f"{path}: is damaged: it is not as it was written; the run cannot go on from it; without "
        "--resume it is solved anew"
    ]


def test_killed_while_its_report_is_made(cube, tmp_path):
    """The run is complete; resumed, it gets its report."""
    folder = tmp_path / "out"

    def progress(event):
        if event["stage"] == "report":
            raise Killed

    with pytest.raises(Killed):
        run(cube(), folder, progress=progress, threads=1)  # with more the report is made by then
    assert json.loads((folder / "run.json").read_text())["status"] == "complete"
    assert not (folder / "report.html").exists()
    before = (folder / "curve.csv").stat().st_mtime_ns
    assert run(cube(), folder, resume=True).status == "complete"
    assert (folder / "report.html").exists() and (folder / "states.png").exists()
    assert (folder / "curve.csv").stat().st_mtime_ns == before


def test_log_keeps_what_was_told_before(cube, interrupted, tmp_path):
    interrupted(7, tmp_path / "cut")
    first = (tmp_path / "cut" / "log.txt").read_text()
    assert first.count(" iterations") >= 7
    run(cube(), tmp_path / "cut", report=False, resume=True)
    log = (tmp_path / "cut" / "log.txt").read_text()
    assert log.startswith(f"{first}resumed\n")
    assert re.search(r" s  all steps solved\n +[\d.]+ s  solved and trusted\n$", log)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("materials.body.c10=0.2 MPa", "holds the run of another spec (materials differ)"),
        ("steps.0.traction.value=[1 kPa, 0 kPa, 0 kPa]", "only what comes after may change"),
        ("steps.1.traction.value=[1 kPa, 0 kPa, 0 kPa]", "is not finished; resume it as it was"),
    ],
)
def test_another_spec_is_refused(cube, interrupted, tmp_path, change, words):
    interrupted(13, tmp_path / "cut")
    kept = (tmp_path / "cut" / "curve.csv").read_bytes()
    with pytest.raises(SoftactError) as refused:
        run(cube(change), tmp_path / "cut", report=False, resume=True)
    assert refused.value.exit_code == 2
    assert words in str(refused.value.lines)
    assert (tmp_path / "cut" / "curve.csv").read_bytes() == kept


def test_command_line(cube, interrupted, tmp_path):
    interrupted(7, tmp_path / "cut")
    command = [sys.executable, "-m", "softact.cli.main", "run", "cube.yaml", "-o", "cut"]
    done = subprocess.run([*command, "--resume"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert json.loads((tmp_path / "cut/run.json").read_text())["status"] == "complete"
    assert (tmp_path / "cut/report.html").is_file()
