"""The command line: what it prints, its exit codes, and that a fault is told in plain lines."""

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import click
import pytest

from softact.cli import main as cli
from softact.cli._progress import ProgressLine
from softact.errors import MeshError, NoEquilibriumError, SpecError
from softact.geometries import GEOMETRIES
from softact.materials import CARDS, LAWS
from softact.measures import MEASURES
from softact.results.own_folder import check_results
from softact.spec import load, loads
from tests import step_files

SOFTACT = [sys.executable, "-m", "softact.cli.main"]

# The smallest thing to solve: one cube, pulled at one face.
BLOCK = """\
name: cube
geometry: {type: block, mesh_size: 10 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps:
  - name: pull
    traction: {surface: x_max, value: [10 kPa, 0 kPa, 0 kPa]}
    max_increment: 1
measures: [elongation]
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("cube.yaml").write_text(BLOCK)
    return tmp_path


def leave(*arguments):
    with pytest.raises(SystemExit) as left:
        cli.main(arguments)
    return left.value.code


def names():
    return cli.softact.list_commands(click.Context(cli.softact))


def test_every_command_file_is_a_command_with_an_example():
    files = {path.stem for path in Path(cli.__file__).parent.glob("[a-z]*.py")} - {"main"}
    assert set(names()) == files
    assert {"run", "validate", "mesh", "list", "report", "schema", "doctor"} <= files


@pytest.mark.parametrize("command", ["run", "validate", "mesh", "list", "report", "schema"])
def test_the_help_of_a_command_shows_an_example(command, capsys):
    assert leave(command, "--help") == 0
    assert f"softact {command} " in capsys.readouterr().out.split("Example")[1]


def test_softact_alone_prints_the_help(capsys):
    assert leave() == 0
    alone = capsys.readouterr().out
    assert leave("--help") == 0
    assert capsys.readouterr().out == alone
    assert "softact run finger.yaml" in alone
    assert alone.index("  run ") < alone.index("  doctor ")


def test_the_help_does_not_wait_for_heavy_modules():
    program = (
        "import sys; from softact.cli.main import main\n"
        "try: main(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'pydantic', 'pint', 'dolfinx', 'yaml', 'rich', 'h5py'}\n"
        "sys.exit(len(heavy & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", program], capture_output=True).returncode == 0


def test_the_version(capsys):
    assert leave("--version") == 0
    assert capsys.readouterr().out.startswith("softact 0.")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["valdate"], "There is no command 'valdate'; did you mean 'validate'?"),
        (["cube.yaml"], "softact run cube.yaml"),
        (["run"], "Missing argument 'SPEC'"),
        (["run", "cube.yaml", "-n", "0"], "0 is not in the range"),
        (["run", "cube.yaml", "-n", "two"], "'two' is not a valid integer"),
        (["run", "cube.yaml", "--colour"], "--colour"),
        (["list"], "Missing argument"),
        (["list", "law"], "'law' is not one of"),
    ],
)
def test_a_wrong_call_is_told_with_exit_2(folder, capsys, arguments, words):
    assert leave(*arguments) == 2
    assert words in capsys.readouterr().err


BUG = (
    "softact: this is a fault in softact, not in your input: {} "
    "(run the same command with --debug to see where, and report it)\n"
)


def raising(error):
    def fail(*arguments, **keywords):
        raise error

    return fail


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (SpecError("one fault", "another"), 2, "one fault\nanother\n"),
        (MeshError("gmsh crashed"), 3, "gmsh crashed\n"),
        (NoEquilibriumError("stopped at 10 kPa"), 4, "stopped at 10 kPa\n"),
        (PermissionError(13, "Permission denied", "results"), 2, "results: Permission denied\n"),
        (KeyboardInterrupt(), 130, "\nsoftact: stopped\n"),
        (ZeroDivisionError("a\nb"), 70, BUG.format("ZeroDivisionError: a b")),
    ],
    ids=lambda value: type(value).__name__ if isinstance(value, BaseException) else None,
)
def test_every_error_has_its_exit_code_and_no_traceback(monkeypatch, capsys, error, code, words):
    monkeypatch.setattr("softact.spec.load", raising(error))
    assert leave("mesh", "cube.yaml") == code
    assert capsys.readouterr().err == words


@pytest.mark.parametrize(
    "arguments", [["--debug", "mesh", "x.yaml"], ["mesh", "x.yaml", "--debug"]]
)
def test_debug_shows_the_traceback(folder, capsys, arguments):
    assert leave(*arguments) == 2
    shown = capsys.readouterr().err
    assert "Traceback (most recent call last)" in shown
    assert shown.endswith("x.yaml: there is no such file\n")


def test_a_reader_that_leaves_early_is_no_fault():
    command = f"{' '.join(SOFTACT)} list laws | head -n 1"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("neo_hookean\n", "")


def test_validate_tells_the_faults_of_every_file(folder, capsys):
    Path("bad.yaml").write_text(BLOCK.replace("10 mm", "10").replace("0.1 MPa", "0.1"))
    assert leave("validate", "cube.yaml", "bad.yaml", "nowhere.yaml") == 2
    out, err = capsys.readouterr()
    assert out == "cube.yaml: ok\n"
    starts = [line.split(" ")[0] for line in err.splitlines()]
    assert starts == ["bad.yaml:2:", "bad.yaml:3:", "nowhere.yaml:"]


def test_validate_says_what_a_step_file_holds_and_what_it_lacks(folder, capsys):
    """One file with two specs: one that names both ends, one that asks for a surface more."""
    step_files.write(folder / "arm.step", step_files.bladder)
    text = (
        "geometry: {type: from_step, file: arm.step%s}\n"
        "materials: {body: ecoflex-00-30}\nsteps: [{pressure: 1 kPa}]\n"
    )
    (folder / "arm.yaml").write_text(text % "")
    (folder / "felt.yaml").write_text(text % ", surfaces: [felt]")
    capsys.readouterr()
    assert leave("validate", "arm.yaml") == 0
    said = capsys.readouterr().out.splitlines()
    assert said[:2] == [
        "arm.yaml: ok",
        "  arm.step: 1 solid with 12 faces, 40 x 14 x 12 mm (the file says mm)",
    ]
    assert leave("validate", "felt.yaml") == 2
    said = capsys.readouterr()
    assert said.err.startswith("felt.yaml: geometry: from_step: arm.step: no face has a name")
    assert sum(line.startswith("  face ") for line in said.out.splitlines()) == 12


def test_validate_applies_overrides(folder, capsys):
    assert leave("validate", "cube.yaml", "--set", "geometry.mesh_size=5") == 2
    assert capsys.readouterr().err.startswith("--set geometry.mesh_size=5: geometry.mesh_size: ")


@pytest.mark.parametrize(
    ("kind", "known"),
    [
        ("laws", LAWS),
        ("materials", CARDS),
        ("geometries", GEOMETRIES),
        ("measures", MEASURES),
        (
            "loads",
            [
                "supports",
                "gravity",
                "pressure",
                "inject",
                "supply",
                "exhaust",
                "sealed",
                "ambient",
                "traction",
                "payload",
                "torque",
                "wrench",
                "surface_pressure",
                "obstacles",
            ],
        ),
    ],
)
def test_list_shows_everything_there_is(capsys, kind, known):
    assert leave("list", kind) == 0
    table = capsys.readouterr().out
    assert leave("list", kind, "--json") == 0
    records = json.loads(capsys.readouterr().out)
    assert [record["name"] for record in records] == list(known)
    for name in known:
        assert name in table


def test_list_tells_units_and_defaults(capsys):
    assert leave("list", "geometries", "pneunet", "--json") == 0
    (pneunet,) = json.loads(capsys.readouterr().out)
    parameters = {entry["name"]: entry for entry in pneunet["parameters"]}
    assert parameters["roof"]["unit"] == "mm"
    assert parameters["roof"]["default"] == "1 mm"
    assert pneunet["cavities"] == ["cavity"]
    assert leave("list", "laws", "yeoh") == 0
    lines = capsys.readouterr().out.splitlines()
    (c10,) = (line.split() for line in lines if line.split()[:1] == ["c10"])
    assert c10[:4] == ["c10", "pressure", "kPa", "needed"]
    assert not any("mooney" in line for line in lines)


def test_list_names_sheets_with_a_line_to_paste(capsys):
    assert leave("list", "geometries", "woven_bending") == 0
    lines = [line.strip() for line in capsys.readouterr().out.splitlines()]
    assert "sheets: fore, aft, clamp, floors, tip, strip" in lines
    assert "curves: middle, seams" in lines
    start = "What its sheets are made of: "
    (example,) = [line.removeprefix(start) for line in lines if line.startswith(start)]
    pasted = f"geometry: {{type: woven_bending}}\n{example}\nsteps: [{{pressure: 1 kPa}}]\n"
    assert list(loads(pasted).sheets) == ["fore", "aft", "clamp", "floors", "tip", "strip"]


def test_the_schema_goes_to_a_file_or_to_the_screen(folder, capsys):
    assert leave("schema") == 0
    printed = capsys.readouterr().out
    assert leave("schema", "-o", "softact.schema.json") == 0
    assert Path("softact.schema.json").read_text() == printed
    assert json.loads(printed)["title"] == "Spec"


def test_mesh_writes_what_the_suffix_says(folder, capsys):
    assert leave("mesh", "cube.yaml") == 0
    assert Path("cube.msh").read_text().startswith("$MeshFormat\n4.1 ")
    assert leave("mesh", "cube.yaml", "-o", "cube.stl") == 0
    # A cube's skin is 12 triangles; a binary STL has 84 bytes and 50 for each.
    assert Path("cube.stl").stat().st_size == 84 + 12 * 50
    assert capsys.readouterr().out == "wrote cube.msh\nwrote cube.stl\n"


def test_run_fills_a_result_folder(folder):
    done = subprocess.run([*SOFTACT, "run", "cube.yaml"], capture_output=True, text=True)
    assert done.stderr == ""
    assert done.returncode == 0
    lines = done.stdout.splitlines()
    assert any(line.endswith("  mesh") for line in lines)
    assert lines[-2] == "solved and trusted"
    assert any("pull 100.00%" in line for line in lines)
    assert lines[-1] == "report: results/cube/report.html"
    results = Path("results/cube")
    assert json.loads((results / "run.json").read_text())["status"] == "complete"
    assert load(results / "spec.yaml") == load("cube.yaml")
    rows = list(csv.DictReader((results / "curve.csv").open()))
    # E = 6 C10 = 0.6 MPa; clamped at one face, so a little stiffer than 10 kPa / E * 10 mm.
    assert 0.1 < float(rows[-1]["elongation_mm"]) < 0.1 / 0.6
    assert {path.name for path in folder.iterdir()} == {"cube.yaml", "results"}
    check_results(results, force=False)  # a second run may replace it


def test_force_keeps_what_else_is_in_the_folder(folder, monkeypatch):
    Path("home").mkdir()
    Path("home/thesis.tex").write_text("years of work")
    asked = []

    def solve(spec, directory, processes, **others):
        asked.append((spec.name, directory, processes))
        raise MeshError("far enough")

    monkeypatch.setattr("softact.run.start.run", solve)
    assert leave("run", "cube.yaml", "-o", "home") == 2
    assert asked == []
    assert leave("run", "cube.yaml", "-o", "home", "--force", "-n", "2") == 3
    assert asked == [("cube", Path("home"), 2)]
    assert Path("home/thesis.tex").read_text() == "years of work"


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_a_run_at_once(folder, number, code):
    process = subprocess.Popen(
        [*SOFTACT, "run", "cube.yaml"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # A shell starts what is in its background with SIGINT ignored, and children inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    assert process.stdout.readline().endswith("  mesh\n")
    process.send_signal(number)
    _, err = process.communicate(timeout=60)
    assert process.returncode == code
    assert err.strip() in ("", "softact: stopped")
    assert not Path("results").exists()


def test_progress_on_a_terminal_is_the_share_of_all_steps(monkeypatch):
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    event = {"stage": "increment", "step": "b", "fraction": 0.5, "iterations": 3}
    with ProgressLine(["a", "b"]) as progress:
        progress(event | {"pressure_kPa": 7.0})
        (task,) = progress._bar.tasks
    # The second of two steps is half done.
    assert task.percentage == pytest.approx(75.0)
    assert "pressure_kPa 7" in task.description


def test_a_note_stays_on_a_terminal(monkeypatch):
    """The line with the bar is written over by the next event."""
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    printed = []
    with ProgressLine(["a"]) as progress:
        console = progress._bar.console
        monkeypatch.setattr(console, "print", lambda *texts, **_: printed.extend(texts))
        progress({"stage": "note", "text": "runs the script arm.py as code"})
        progress({"stage": "mesh"})
    told = [text for text in printed if isinstance(text, str)]  # the bar prints itself
    assert told == ["runs the script arm.py as code"]


def test_a_silent_run_says_what_it_is_at(capsys):
    """A long factorisation sends no event: a line comes all the same."""
    with ProgressLine(["a"], silence=0.05) as progress:
        progress({"stage": "mesh"})
        end = time.monotonic() + 20
        while "still at: mesh" not in (said := capsys.readouterr().out):
            assert time.monotonic() < end, said
            time.sleep(0.02)


def test_what_the_solver_tries_is_a_line(capsys):
    with ProgressLine(["a"]) as progress:
        progress({"stage": "progress", "step": "a", "fraction": 0.25, "control": "dynamics",
                  "iteration": 7, "residual": 0.031, "iterations": 90})  # fmt: skip
    said = capsys.readouterr().out
    assert "a  25.00%  lets the actuator move to its next equilibrium: iteration 7, " in said
    assert "residual 3.1e-02, 90 iterations so far" in said


def test_progress_elsewhere_is_a_line_per_event(capsys):
    with ProgressLine(["a"]) as progress:
        progress({"stage": "mesh"})
        progress({"stage": "solve", "cells": 5, "unknowns": 86})
        progress({"stage": "error", "lines": ["told elsewhere"], "exit_code": 3})
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(" s  ")[1] for line in lines] == [
        "mesh",
        "mesh of 5 tetrahedra, 86 unknowns",
    ]
