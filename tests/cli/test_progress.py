"""How long a run will take, and how it goes on after it was stopped."""

import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from softact.cli._progress import Left, ProgressLine
from softact.cli.run import resume_hint
from softact.files.restart import RESTART
from softact.run.start import SolverCrashError

SOFTACT = [sys.executable, "-m", "softact.cli.main"]
CUBE = """\
name: cube
geometry: {type: block, mesh_size: 10 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps:
  - name: pull
    traction: {surface: x_max, value: [10 kPa, 0 kPa, 0 kPa]}
measures: [elongation]
solver: {initial_increment: 0.02, max_increment: 0.02}
"""


def test_how_long_it_takes_is_told_from_the_pace_so_far():
    now = [100.0]
    left = Left(lambda: now[0])
    assert left.text() == ""
    left.at(0.1)  # the first state: what came before it was the set-up
    now[0] += 20
    assert left.text() == ""  # nothing has moved
    left.at(0.3)
    # 0.2 of the way in 20 s: 0.7 of it take 70 s.
    assert left.text() == "about 1 min 10 s left at this pace"
    now[0] += 20  # the ladder searches: half the pace
    assert left.text() == "about 2 min 20 s left at this pace"
    left.at(1.0)
    assert left.text() == ""


def test_a_first_second_tells_nothing():
    now = [0.0]
    left = Left(lambda: now[0])
    left.at(0.0)
    now[0] = 1.0
    left.at(0.5)
    assert left.text() == ""


@pytest.mark.parametrize("terminal", [False, True])
def test_the_lines_of_a_run_say_it(terminal, monkeypatch, capsys):
    monkeypatch.setattr(sys.stdout, "isatty", lambda: terminal)
    event = {"stage": "increment", "step": "a", "iterations": 3}
    with ProgressLine(["a"]) as progress:
        now = [0.0]
        progress._left = Left(lambda: now[0])
        for fraction in (0.0, 0.5):
            progress(event | {"fraction": fraction})
            now[0] += 30
        tried = {"stage": "progress", "control": "dynamics", "iteration": 7, "residual": 0.031}
        progress(tried | {"step": "a", "fraction": 0.5, "iterations": 90})
        if terminal:
            assert progress._bar.tasks[0].fields["left"] == "about 1 min 0 s left at this pace"
        progress({"stage": "report"})
    if not terminal:
        first, half, trying, report = capsys.readouterr().out.splitlines()
        assert "left" not in first + report
        assert half.endswith("(about 30 s left at this pace)")
        assert trying.endswith("90 iterations so far  (about 1 min 0 s left at this pace)")


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, SolverCrashError, ValueError])
def test_what_was_solved_is_pointed_at(error, tmp_path, capsys):
    for written in (False, True):
        if written:
            (tmp_path / RESTART).touch()
        with pytest.raises(error), resume_hint(tmp_path, "softact run x.yaml --resume"):
            raise error
        hinted = "it goes on with: softact run x.yaml --resume" in capsys.readouterr().err
        assert hinted == (written and error is not ValueError)


def test_a_run_that_is_interrupted_goes_on_with_the_command_it_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("cube.yaml").write_text(CUBE)
    process = subprocess.Popen(
        [*SOFTACT, "run", "cube.yaml", "-n", "1", "--set", "measures=[tip]"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    for line in process.stdout:
        if " 6.00%" in line:
            process.send_signal(signal.SIGINT)
            break
    _, err = process.communicate(timeout=60)
    assert process.returncode == 130
    (hint,) = [line for line in err.splitlines() if "it goes on with: " in line]
    program, *command = shlex.split(hint.split("goes on with: ")[1])
    assert program == "softact" and command[-1] == "--resume"
    done = subprocess.run([*SOFTACT, *command, "-n", "1"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    log = Path("results/cube/log.txt").read_text()
    assert log.count("unknowns, on 20") == 2 and "\nresumed\n" in log
    assert "all steps solved" in log
