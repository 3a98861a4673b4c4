"""A hundred inputs of the fuzzer (``benchmarks.fuzz``), and what it has found by now."""

import dataclasses
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from benchmarks.fuzz import fuzz, make_template, solved
from benchmarks.fuzz_inputs import CUBE, MEASURED, TENSION, commands
from benchmarks.fuzz_judge import Ended, faults, in_process, listing
from softact.fit.candidates import CANDIDATES
from softact.fit.card import numbers
from softact.fit.data import Test
from softact.fit.fit import Options, fit
from softact.report import frames


@pytest.fixture(scope="module")
def cube(tmp_path_factory):
    """A result folder of the cube, without a report."""
    folder = tmp_path_factory.mktemp("solved") / "cube"
    solved(folder)
    return folder


def test_a_hundred_inputs_end_as_they_should(cube, tmp_path):
    """Ten of them again, since the same seed gives the same inputs."""
    template = tmp_path / "template"
    template.mkdir()
    make_template(template, lambda folder: shutil.copytree(cube, folder))
    counts = fuzz(100, 0, template, keep=tmp_path / "whole")
    assert counts.faults == [], "\n".join(line for fault in counts.faults for line in fault.lines())
    assert set(counts.codes) == set(commands())
    fuzz(10, 0, template, keep=tmp_path / "part", first=40)
    whole, part = (
        (tmp_path / name / "inputs.txt").read_text().splitlines() for name in ("whole", "part")
    )
    assert len(whole) == 100 and part == whole[40:50]


def test_the_judges_see_what_is_wrong():
    """Each on an ending that is as it should be in all else."""
    call, before = ["run", "a.yaml"], {"a.yaml": (1, 1)}

    def judged(code=2, err="a.yaml: is wrong", after=before):
        return faults(call, Ended(code, "", err), before, after)

    assert judged() == []
    assert judged(code=None) == ["hangs"]
    assert judged(code=70) == ["exit code 70"]
    assert judged(code=1) == ["exit code 1"]
    assert judged(err="a.yaml: is wrong\nTraceback (most recent call last):") != []
    assert judged(err="") == ["says nothing", "refuses without a line on stderr"]
    assert judged(err="something is wrong") == ["does not say where"]
    assert judged(err="a.yaml: \x1b[1m") == ["says what cannot be printed"]
    assert judged(after=before | {"out/": (0, 0)}) == ["writes out/"]
    assert judged(after={"a.yaml": (2, 1)}) == ["writes a.yaml"]
    assert judged(code=4, after=before | {"out/": (0, 0)}) == []


def refused(folder: Path, *arguments: str) -> list[str]:
    """The lines with which a call is refused; nothing may be written by it."""
    before = listing(folder)
    ended = in_process(arguments, folder, 60.0)
    assert ended.code == 2, ended
    assert listing(folder) == before
    return ended.err.splitlines()


@pytest.mark.parametrize("command", ["report", "compare", "fit", "validate", "run", "sweep"])
def test_an_empty_word_is_not_the_current_folder(tmp_path, command):
    line = refused(tmp_path, command, "")[-1]
    assert line == (
        f"Error: word 2 of the call is empty ('{command} ...'); is a shell variable unset?"
    )


@pytest.mark.parametrize(
    "arguments",
    [
        ("compare", "{}", "b"),
        ("check", "{}"),
        ("validate", "{}"),
        ("list", "laws", "{}"),
        ("run", "{}"),
        ("run", "cube.yaml", "--{}"),
        ("{}",),
        ("schema", "--kind", "{}"),
    ],
    ids=" ".join,
)
def test_words_of_the_call_cannot_steer_a_terminal(tmp_path, arguments):
    lines = refused(tmp_path, *(word.format("a\x1b[1mb\ue000") for word in arguments))
    assert lines and all(line.isprintable() for line in lines)
    assert any("[1mb" in line for line in lines)


def test_a_wrong_set_is_told_once_for_all_specs(tmp_path):
    for name in ("a.yaml", "b.yaml"):
        (tmp_path / name).write_text(CUBE)
    (line,) = refused(tmp_path, "validate", "a.yaml", "b.yaml", "--set", "supports=[x]")
    assert line.startswith("--set supports=[x]: supports.0: 'x' is given")


def test_a_film_that_cannot_be_drawn_leaves_the_folder_as_it_was(cube, tmp_path, monkeypatch):
    monkeypatch.setattr(
        frames, "command", lambda *of: ["/bin/sh", "-c", "echo not here >&2; exit 3"]
    )
    shutil.copytree(cube, tmp_path / "cube")
    (tmp_path / "curve.csv").write_text(MEASURED)
    lines = refused(tmp_path, "report", "cube", "--animate", "gif", "--measured", "curve.csv")
    assert lines == ["cube: drawing ended with code 3: not here"]


def test_a_finished_run_that_is_damaged_gets_no_measured_curve(cube, tmp_path):
    folder = tmp_path / "cube"
    shutil.copytree(cube, folder)
    (tmp_path / "cube.yaml").write_text(CUBE)
    (tmp_path / "measured.csv").write_text(MEASURED)
    text = (folder / "curve.csv").read_text()
    (folder / "curve.csv").write_text(text.replace(".", "~", 1))
    (line,) = refused(
        tmp_path, "run", "cube.yaml", "--resume", "-o", "cube", "--measured", "measured.csv"
    )
    assert line.startswith("cube/curve.csv: is damaged (")


def test_numbers_of_a_fit_that_are_none_are_null():
    stretch = np.linspace(1.0, 2.0, 20)
    test = Test("a", "uniaxial", stretch, 0.2 * (stretch - stretch**-2))
    found = fit([test], CANDIDATES["neo_hookean"], Options(starts=1))
    found = dataclasses.replace(found, error=float("nan"), chi_square=np.float64("inf"))
    (data,) = json.loads(numbers([found]))
    assert data["normalised_error"] is None and data["reduced_chi_square"] is None


@pytest.mark.parametrize("file", ["[1]", "{a: 1}", "3"])
def test_what_is_no_name_of_a_file_is_told_in_words(tmp_path, file):
    (tmp_path / "tests.yaml").write_text(f"tests:\n  - {{file: {file}}}\n")
    (line,) = refused(tmp_path, "fit", "tests.yaml")
    assert line.startswith("tests.yaml:2: tests.0.file: ")
    assert line.endswith("given; the name of a file is wanted")


def test_a_list_of_tests_says_where_it_names_a_file_that_is_not_there(tmp_path):
    (tmp_path / "tests.yaml").write_text("tests:\n  - {file: data.csv}\n  - file: planar\n")
    (tmp_path / "data.csv").write_text(TENSION)
    for command in ("fit", "validate"):
        (line,) = refused(tmp_path, command, "tests.yaml")
        assert line == "tests.yaml:3: tests.1.file: planar: there is no such file"


@pytest.mark.parametrize("number", ["1e200", "-1e308", "1e101"])
def test_a_number_that_would_overflow_is_told_and_not_drawn(tmp_path, number):
    rows = TENSION.splitlines()
    stretch, _ = rows[5].split(",")
    rows[5] = f"{stretch},{number}"
    (tmp_path / "data.csv").write_text("\n".join(rows))
    (line,) = refused(tmp_path, "fit", "data.csv", "--starts", "1")
    assert line.startswith("data.csv:6: ")
    assert line.endswith(f"'{number}' is larger than anything that a test measures")


@pytest.mark.parametrize("fraction", ["3", "-0.5"])
def test_fractions_that_no_step_reaches_are_refused_before_a_run(tmp_path, fraction):
    (tmp_path / "cube.yaml").write_text(CUBE)
    (tmp_path / "data.csv").write_text(f"step_fraction,elongation (mm)\n0.5,0\n{fraction},0.1\n")
    call = ("calibrate", "cube.yaml", "--data", "data.csv", "--vary", "materials.body.c10")
    (line,) = refused(tmp_path, *call)
    assert line.startswith("data.csv: step_fraction goes from ")
    assert line.endswith("in a step of a run it goes from 0 to 1")
