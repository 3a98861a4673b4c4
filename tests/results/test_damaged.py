"""Whatever happens to the files of a result folder, one line says which is damaged, or nothing of
what is shown comes from it."""

import json
import random
import shutil

import h5py
import numpy as np
import pytest

from benchmarks import damaging
from softact import spec as specs
from softact.cli import main as cli
from softact.converge import carry
from softact.errors import SpecError
from softact.report import frames
from softact.results import journal
from softact.results.fields_file import changed, opened, write_array
from softact.results.folder import read
from softact.results.writer import ResultsWriter
from softact.run.resuming import identity, to_resume
from softact.run.start import run
from tests import bent_beam

SPEC = """
name: cube
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 2 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
solver: {initial_increment: 0.2, max_increment: 0.2}
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole") / "cube"
    run(specs.loads(SPEC), folder, report=False)
    return folder


@pytest.fixture
def undrawn(monkeypatch):
    """Reports without pictures, which take most of the time; all else is as usual."""
    monkeypatch.setattr(
        frames, "command", lambda *of: ["/bin/sh", "-c", "echo not here >&2; exit 3"]
    )


def called(capsys, *arguments):
    """Exit code of the command line, and the lines that it has on standard error."""
    code = cli._run([str(argument) for argument in arguments], debug=False)
    lines = capsys.readouterr().err.splitlines()
    assert code in (0, 2) and not any("fault in softact" in line for line in lines), lines
    return code, [line for line in lines if "not here" not in line]


def named(lines, damaged):
    """Whether there is one line for each damaged file, or one at all, and it names one of them."""
    return 0 < len(lines) and all(any(name in line for name in damaged) for line in lines)


@pytest.mark.parametrize("seed", range(24))
def test_compare_and_converge(whole, tmp_path, capsys, seed):
    """Where no line says that a file is damaged, the figures are those of the undamaged folder."""
    folder, draw = tmp_path / "cube", random.Random(seed)
    shutil.copytree(whole, folder)
    names = {damaging.damage(folder, draw)[0] for _ in range(draw.choice((1, 1, 2)))}
    code, lines = called(capsys, "compare", whole, folder, "-o", tmp_path / "page")
    if code or lines:
        assert named(lines, names), (names, lines)
    if not lines:
        rows = (tmp_path / "page" / "measures.csv").read_text().splitlines()[1:]
        assert all(float(row.split(",")[-2]) == 0 for row in rows)  # the difference
    try:
        carry.check_folder(folder, [read(whole).run["spec_hash"]])
    except SpecError as error:
        assert named(error.lines, names), (names, error.lines)
    else:
        assert code == 0 and not lines


@pytest.mark.parametrize("seed", range(100, 112))
def test_report(whole, tmp_path, capsys, undrawn, seed):
    folder, draw = tmp_path / "cube", random.Random(seed)
    shutil.copytree(whole, folder)
    name, how = damaging.damage(folder, draw)
    code, lines = called(capsys, "report", folder)
    told = named(lines, {name})
    assert told if code else told or not lines, (name, how, lines)
    assert (folder / "report.html").exists() == (code == 0)


@pytest.mark.parametrize("seed", range(200, 216))
def test_resume(whole, tmp_path, seed):
    """From a damaged file a run does not go on; what else is damaged is written anew."""
    folder, draw, spec = tmp_path / "cube", random.Random(seed), specs.loads(SPEC)
    shutil.copytree(whole, folder)
    files = ("restart.npz",) if seed % 2 else ("run.json", "spec.yaml", "curve.csv")
    name, how = damaging.damage(folder, draw, files)
    try:
        old = to_resume(spec, folder)
    except SpecError as error:
        assert name == "restart.npz" and named(error.lines, {name})
    else:
        missing = name == "restart.npz"
        assert old is None if missing else old.steps == identity(spec)["steps"]
        assert not missing or how in ("missing", "a folder")


@pytest.mark.parametrize("how", ["a name that is none", "other numbers"])
def test_states_that_stay_are_looked_at(whole, tmp_path, how):
    """A run that goes on keeps the states before it: a damaged one is not handed on."""
    folder = tmp_path / "cube"
    shutil.copytree(whole, folder)
    with h5py.File(folder / "fields.h5", "r+") as file:
        group = file["increments"][next(iter(file["increments"]))]
        if how == "other numbers":
            group["displacement"][0] = 1.0
        else:
            group.move("displacement", b"displ\xe0cement")
    before = (folder / "fields.h5").read_bytes()
    curve = (folder / "curve.csv").read_text()
    with pytest.raises(SpecError) as found:
        ResultsWriter.reopen(folder, SPEC, None, curve)
    assert len(found.value.lines) == 1 and named(found.value.lines, {"fields.h5"})
    assert (folder / "fields.h5").read_bytes() == before
    assert json.loads((folder / "run.json").read_text())["status"] == "complete"


def test_any_column_missing(tmp_path, capsys):
    """Of a folder without checksums, as an earlier softact wrote it."""
    folder, whole = tmp_path / "lacking", tmp_path / "whole"
    bent_beam.write(whole, 90.0, 2)
    shutil.copytree(whole, folder)
    for path in (whole, folder):
        run = json.loads((path / "run.json").read_text())
        del run["files"], run["checksum"]
        (path / "run.json").write_text(json.dumps(run))
    heads, *rows = [line.split(",") for line in (whole / "curve.csv").read_text().splitlines()]
    for place in range(len(heads)):
        lines = [",".join(row[:place] + row[place + 1 :]) for row in (heads, *rows)]
        (folder / "curve.csv").write_text("\n".join(lines))
        command = ("compare", whole, folder, "-o", tmp_path / "page", "--targets", "glove")
        code, lines = called(capsys, *command)
        assert code == 0 or named(lines, {"curve.csv"}), (heads[place], lines)


def test_numbers_that_are_none(whole, tmp_path, capsys):
    folder = tmp_path / "cube"
    shutil.copytree(whole, folder)
    text = (folder / "curve.csv").read_text().splitlines()
    place = text[0].split(",").index("elongation_mm")
    cells = text[3].split(",")
    cells[place] = "12.#4"
    text[3] = ",".join(cells)
    (folder / "curve.csv").write_text("\n".join(text))
    _, lines = called(capsys, "report", folder)
    why = "line 4, column 'elongation_mm': '12.#4' is no number"
    assert lines == [f"{folder}/curve.csv: is damaged ({why}); solve the spec again"]


@pytest.mark.parametrize("moment", [*range(13), 1000])
def test_change_of_the_fields_that_is_killed(tmp_path, monkeypatch, moment):
    """At any of its writes: the file has none or all of the change, also when it is read then."""
    path = tmp_path / "fields.h5"
    with h5py.File(path, "w") as file:
        write_array(file.create_group("old"), "values", np.arange(1000.0))
    count = 0

    class KilledError(BaseException):
        pass

    def dying(function):
        def call(*arguments, **named):
            nonlocal count
            count += 1
            if count > moment:
                raise KilledError
            return function(*arguments, **named)

        return call

    monkeypatch.setattr(journal, "_write", dying(journal._write))
    monkeypatch.setattr(journal, "_sync", dying(journal._sync))
    monkeypatch.setattr(journal, "write_atomic", dying(journal.write_atomic))
    killed = False
    try:
        with changed(path) as file:
            write_array(file.create_group("new"), "values", np.arange(3000.0))
            file["old/values"][5] = -1.0
    except KilledError:
        killed = True
    monkeypatch.undo()

    def found():
        with opened(path) as file:
            values = file["old/values"][()]
            return "new" in file and len(file["new/values"]), values[5]

    before = found()
    assert before in ((False, 5.0), (3000, -1.0))
    journal.recover(path)
    assert found() == before and not journal.journal_of(path).exists()
    assert killed == (moment < 1000) and (killed or before == (3000, -1.0))


def test_fields_that_another_program_has_open(tmp_path):
    """HDF5 itself would refuse to change them, and the run would end."""
    path = tmp_path / "fields.h5"
    with h5py.File(path, "w") as file:
        file.create_group("old")
    with h5py.File(path, "r"), changed(path) as file:
        write_array(file, "new", np.arange(3.0))
    with opened(path) as file:
        assert list(file) == ["new", "old"]
