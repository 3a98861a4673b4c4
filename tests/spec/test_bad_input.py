"""Wrong specs: exit 2, one clear line per fault with its place, no traceback, nothing written."""

import os
from pathlib import Path

import pytest

from softact.cli.main import main
from tests.spec.wrong_specs import BASE, WRONG, step


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def everything(folder):
    """Every path under a folder with its content."""
    return {
        path: path.read_bytes() if path.is_file() else None for path in sorted(folder.rglob("*"))
    }


def leave(*arguments):
    with pytest.raises(SystemExit) as left:
        main(arguments)
    return left.value.code


def check(folder, capsys, arguments, faults):
    """Run softact, which must refuse: ``faults`` are the starts and words of its lines."""
    before = everything(folder)
    assert leave(*arguments) == 2
    assert everything(folder) == before
    out, err = capsys.readouterr()
    lines = err.splitlines()
    assert out == ""
    assert "Traceback" not in err
    assert len(lines) == len(faults), err
    for line, (start, words) in zip(lines, faults, strict=True):
        assert line.startswith(start), err
        assert words in line, err


def test_the_base_is_right(folder, capsys):
    Path("finger.yaml").write_text(BASE)
    assert leave("validate", "finger.yaml") == 0
    ok, *notes = capsys.readouterr().out.splitlines()
    assert ok == "finger.yaml: ok" and all("note: one element through" in note for note in notes)


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_spec_is_refused(folder, capsys, case):
    text, faults = WRONG[case]
    content = text if isinstance(text, bytes) else text.encode()
    Path("finger.yaml").write_bytes(content)
    expected = []
    for line, path, words in faults:
        start = "finger.yaml" + (f":{line}" if line else "") + ": "
        expected.append((start + (f"{path}: " if path else ""), words))
    check(folder, capsys, ["run", "finger.yaml", "-o", "out"], expected)


def test_a_vacuum_is_no_fault(folder):
    Path("finger.yaml").write_text(step("pressure: -50 kPa"))
    assert leave("validate", "finger.yaml") == 0


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("missing.yaml", "there is no such file"),
        ("name: finger", "there is no such file"),
        (".", "this is a folder"),
        ("", "word 2 of the call is empty"),
        ("x" * 5000, "File name too long"),
        ("a\nb.yaml", "a b.yaml: there is no such file"),
    ],
)
def test_what_is_no_file_is_refused(folder, capsys, name, words):
    check(folder, capsys, ["run", name], [("", words)])


@pytest.mark.parametrize(
    "arguments",
    [
        ["validate", "pipe"],
        ["run", "pipe"],
        ["run", "finger.yaml", "--set", "materials.body=pipe.yaml"],
        ["run", "finger.yaml", "--measured", "pipe"],
        ["sweep", "pipe"],
        ["optimize", "pipe"],
        ["converge", "pipe"],
        ["fit", "pipe"],
        ["fit", "pipe.yaml"],
        ["calibrate", "finger.yaml", "--data", "pipe", "--vary", "geometry.roof"],
    ],
    ids=" ".join,
)
def test_nothing_waits_for_a_pipe_that_nobody_writes_into(folder, capsys, arguments):
    Path("finger.yaml").write_text(BASE)
    os.mkfifo("pipe")
    os.mkfifo("pipe.yaml")
    assert leave(*arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "is a pipe or a device and no file" in line
    assert sorted(path.name for path in folder.iterdir()) == ["finger.yaml", "pipe", "pipe.yaml"]


@pytest.mark.parametrize("command", ["validate", "sweep", "fit"])
def test_an_endless_device_is_not_read(folder, capsys, command):
    check(folder, capsys, [command, "/dev/zero"], [("/dev/zero: ", "no file")])


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_may_not_be_read_is_refused(folder, capsys):
    Path("finger.yaml").write_text(BASE)
    Path("finger.yaml").chmod(0)
    check(folder, capsys, ["run", "finger.yaml"], [("", "Permission denied")])


@pytest.mark.parametrize(
    ("override", "words"),
    [
        ("geometry.roof", "write a dotted path"),
        ("geometry.roof=3", "geometry.roof: '3' has no unit"),
        ("steps.7.pressure=3 kPa", "'steps' has no entry '7'"),
        ("steps=[", "not valid YAML"),
    ],
)
def test_a_wrong_override_is_refused(folder, capsys, override, words):
    Path("finger.yaml").write_text(BASE)
    arguments = ["run", "finger.yaml", "--set", override]
    check(folder, capsys, arguments, [(f"--set {override}: ", words)])


def test_a_folder_with_other_files_is_not_written_into(folder, capsys):
    Path("finger.yaml").write_text(BASE)
    Path("home").mkdir()
    Path("home/thesis.tex").write_text("years of work")
    arguments = ["run", "finger.yaml", "-o", "home"]
    check(folder, capsys, arguments, [("home: ", "the folder holds other files than results")])


def test_a_run_json_of_another_program_does_not_make_a_result_folder(folder, capsys):
    Path("finger.yaml").write_text(BASE)
    Path("home").mkdir()
    Path("home/run.json").write_text('["not", "softact"]')
    arguments = ["run", "finger.yaml", "-o", "home"]
    check(folder, capsys, arguments, [("home: ", "the folder holds other files than results")])


@pytest.mark.parametrize("name", ["finger.yaml", "finger.yaml/results"])
def test_a_file_is_no_result_folder(folder, capsys, name):
    Path("finger.yaml").write_text(BASE)
    words = "is a file; name another folder with -o DIR"
    check(folder, capsys, ["run", "finger.yaml", "-o", name], [(f"{name}: ", words)])


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_may_not_be_written_is_refused(folder, capsys):
    Path("finger.yaml").write_text(BASE)
    Path("locked").mkdir(0o500)
    arguments = ["run", "finger.yaml", "-o", "locked/results"]
    check(folder, capsys, arguments, [("locked/results: ", "locked may not be written")])


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["mesh", "finger.yaml", "-o", "finger.doc"], "no format for '.doc'"),
        (["mesh", "finger.yaml", "-o", "nowhere/finger.msh"], "there is no folder"),
        (["report", "nowhere"], "not a result folder"),
        (["list", "laws", "yeo"], "there is no 'yeo'; did you mean 'yeoh'?"),
        (["schema", "-o", "nowhere/schema.json"], "there is no folder 'nowhere'"),
    ],
)
def test_wrong_arguments_of_other_commands_are_refused(folder, capsys, arguments, words):
    Path("finger.yaml").write_text(BASE)
    check(folder, capsys, arguments, [("", words)])
