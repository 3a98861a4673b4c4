"""Runs from spec to result folder: processes, increments, and loads that go and come back.

The figures must not depend on how they were computed.
"""

import csv
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from softact import spec as specs
from softact.run import recorder
from softact.run import start as runs
from softact.solve.progress import Trying

CONFIG = Path(__file__).parents[2] / "configs" / "pneunet_small.yaml"
# Two chambers and few increments: the physics is the same.
COARSE = (
    "geometry.chambers=2",
    "geometry.mesh_size=6 mm",
    "solver.initial_increment=0.5",
    "solver.max_increment=0.5",
)
# Of how it was computed, not of the actuator.
WORK = {"control", "step", "increment", "step_fraction", "newton_iterations", "residual"}


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """Function from processes and overrides to a result folder; each is solved once."""
    known = {}

    def solve(processes, *changes):
        if (processes, changes) not in known:
            folder = tmp_path_factory.mktemp("run") / "result"
            spec = specs.load(CONFIG, (*COARSE, *changes))
            outcome = runs.run(spec, folder, processes, report=False)
            assert outcome.status == "complete", outcome.message
            known[processes, changes] = folder
        return known[processes, changes]

    return solve


def curve(folder):
    with (folder / "curve.csv").open() as file:
        return list(csv.DictReader(file))


def assert_same(row, other, tolerance):
    """All figures within ``tolerance`` of their size; vectors count as a whole."""
    assert set(row) == set(other)
    figures = {name: float(row[name]) for name in row if name not in WORK}
    for name, value in figures.items():
        scale = max(abs(figures[n]) for n in figures if n == name or same_vector(n, name))
        scale = max(scale, FLOORS.get(name.rsplit("_", 1)[-1], 1e-3))
        assert float(other[name]) == pytest.approx(value, abs=tolerance * scale), name


# What is zero but for rounding is compared with one of these: deg, mm, N, N·mm.
FLOORS = {"deg": 1.0, "mm": 1.0, "N": 0.1, "Nmm": 1.0}


def test_a_run_says_which_walls_have_one_element(solved):
    """In its log, and in run.json where the data sheet finds it."""
    folder = solved(1)
    story = json.loads((folder / "run.json").read_text())
    (said,) = story["mesh"]["remarks"]
    assert said.startswith(
        "one element through outer_wall (1 mm), roof (1 mm) and inner_wall (1 mm)"
    )
    assert said in story["notes"]
    assert (folder / "log.txt").read_text().startswith(said)


def same_vector(name, other):
    return any(
        name.replace(f"_{a}_", "_*_") == other.replace(f"_{b}_", "_*_") and f"_{a}_" in name
        for a in "xyz"
        for b in "xyz"
    )


def test_two_processes_give_the_measures_of_one(solved):
    """mpirun -n 2 against a single process: every figure of every row to 1e-6."""
    one, two = curve(solved(1)), curve(solved(2))
    assert len(one) == len(two) > 4
    for name in [n for n in one[0] if n.startswith("max_principal") and n.endswith("_mm")]:
        del one[0][name], two[0][name]  # the unloaded body has no place of largest stress
    for row, other in zip(one, two, strict=True):
        assert_same(row, other, 1e-6)
    assert json.loads((solved(2) / "run.json").read_text())["processes"] == 2
    assert float(one[-1]["bending_angle_deg"]) > 5 + float(one[0]["bending_angle_deg"])


def test_half_the_increments_give_the_same_end(solved):
    """The state is elastic: how the load was cut up does not matter. Work is by trapezoids."""
    coarse = curve(solved(1))[-1]
    fine = curve(solved(1, "solver.initial_increment=0.25", "solver.max_increment=0.25"))[-1]
    for row in (coarse, fine):
        del row["pressure_work_mJ"]
    assert_same(coarse, fine, 1e-6)


def test_result_folder_tells_its_story(solved):
    """The spec that was solved stands beside the result and loads back to the same spec."""
    folder = solved(1)
    story = json.loads((folder / "run.json").read_text())
    assert story["status"] == "complete"
    again = specs.load(folder / "spec.yaml")
    assert again.hash == story["spec_hash"] == specs.load(CONFIG, COARSE).hash
    increments = [h for h in story["history"] if h["converged"]]
    assert len(increments) == len(curve(folder))
    assert all(h["residuals"][-1] <= 1e-8 for h in increments if h["residuals"])


def test_pressure_up_and_down_returns_to_the_start(solved):
    """Nothing is left of a pressure that was taken off: the measures to 1e-8."""
    steps = (
        "steps=[{name: gravity, gravity: [0, 0, -1]}, {name: up, pressure: 20 kPa}, "
        "{name: down, pressure: 0 kPa}]"
    )
    rows = curve(solved(1, steps))
    before = next(row for row in rows if row["step"] == "gravity" and row["step_fraction"] == "1.0")
    after = rows[-1]
    assert after["step"] == "down"
    assert (
        abs(
            float(max(rows, key=lambda r: float(r["pressure_kPa"]))["bending_angle_deg"])
            - float(before["bending_angle_deg"])
        )
        > 5
    )
    for row in (before, after):
        del row["pressure_work_mJ"]
    assert_same(before, after, 1e-8)


def test_no_equilibrium_keeps_what_was_reached(tmp_path):
    """A pressure far beyond what the walls hold: exit code 4, and the rows up to there."""
    spec = specs.load(
        CONFIG,
        (
            *COARSE,
            "steps=[{name: burst, pressure: 300 kPa}]",
            "contact=none",
            "solver.initial_increment=0.015",
            "solver.max_increment=0.05",
            "solver.min_increment=0.014",
            "solver.dynamics=false",
        ),
    )
    outcome = runs.run(spec, tmp_path / "result", report=False)
    assert (outcome.status, outcome.exit_code) == ("no_equilibrium", 4)
    assert "no equilibrium found beyond" in outcome.message
    rows = curve(tmp_path / "result")
    story = json.loads((tmp_path / "result" / "run.json").read_text())
    assert story["status"] == "no_equilibrium"
    assert outcome.message in story["messages"]
    assert len(rows) == sum(h["converged"] for h in story["history"])
    assert 0 < float(rows[-1]["pressure_kPa"]) < 300
    assert np.isfinite(float(rows[-1]["bending_angle_deg"]))


STRETCHED = """
geometry: {{type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}}
materials: {{body: {{card: elastosil-m4601, stretch_range: [1, {high}]}}}}
supports: [{{surface: x_min, fix: [x, y, z]}}, {{surface: x_max, move: {{x: 2 mm}}}}]
steps: [{{name: hang, gravity: [0, 0, -1]}}]
"""


@pytest.mark.parametrize(("high", "warned"), [(1.2, True), (3.0, False)])
def test_says_what_leaves_the_tested_stretch(high, warned, tmp_path):
    """A block pulled to 1.5 times its length lies beyond a test to 1.2, not beyond one to 3; its
    transverse stretches below 1 are no matter for a test in tension."""
    runs.run(specs.loads(STRETCHED.format(high=high)), tmp_path / "out", report=False)
    assert not (tmp_path / "out/report.html").exists()
    messages = json.loads((tmp_path / "out/run.json").read_text())["messages"]
    assert any("to which elastosil-m4601 was tested" in m for m in messages) == warned


SHORT = """
import re, resource
from scipy import linalg
from softact.run.worker import _start_blas
now = 1024 * int(re.search(r"VmSize:\\s+(\\d+)", open("/proc/self/status").read())[1])
resource.setrlimit(resource.RLIMIT_AS, (now + 2**26, now + 2**26))
try:
    _start_blas()
except MemoryError:
    print("told")
"""


def test_openblas_without_its_buffer_is_told():
    """OpenBLAS itself asks for its 128 MB for ever."""
    done = subprocess.run([sys.executable, "-c", SHORT], capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr) == ("told\n", "")


@pytest.mark.parametrize(
    ("code", "noise", "said"),
    [
        (1, "ImportError: libpetsc.so: failed to map segment from shared object", "ran out of"),
        (-6, "terminate called after throwing an instance of 'std::bad_alloc'", "ran out of"),
        (70, "PETSc.Error: error code 4627\n[0] PetscMallocA() at mal.c:410", "ran out of"),
        (-9, "", "was killed by signal 9 (out of memory?); its last words: none"),
        (-11, "one\ntwo", "was killed by signal 11; its last words: two"),
    ],
)
def test_what_a_solver_died_of_is_told(tmp_path, code, noise, said):
    (tmp_path / "stderr").write_text(noise)
    assert said in runs._crash(code, tmp_path / "stderr")


def test_the_solver_tells_what_it_tries_but_not_too_often(monkeypatch):
    """Nothing while states are accepted, one event for many iterations that lead nowhere."""
    events, clock = [], iter(np.arange(0.0, 100.0, 0.5))
    monkeypatch.setattr(recorder.time, "monotonic", lambda: next(clock))
    writing = recorder.Recorder.__new__(recorder.Recorder)
    writing._tell, writing._told_at = events.append, 0.0
    for iteration in range(40):
        writing._try(Trying("inflate", 0.4, "search", iteration, 1e-2, iteration))
    told = [event["iteration"] for event in events]
    assert all(event["stage"] == "progress" for event in events)
    assert 3 <= len(told) <= 5 and np.all(np.diff(told) >= recorder.SILENCE / 0.5 - 1)


def test_log_and_verdict_stand_in_the_folder(tmp_path):
    """Each line of the log has its seconds; what is thought of the run ends it."""
    outcome = runs.run(specs.loads(STRETCHED.format(high=1.2)), tmp_path / "out", report=False)
    assert outcome.verdict.colour == "amber"
    story = json.loads((tmp_path / "out" / "run.json").read_text())
    assert story["verdict"] == outcome.verdict.data()
    lines = (tmp_path / "out" / "log.txt").read_text().splitlines()
    seconds = [float(line[:8]) for line in lines if line[8:12] == " s  "]
    assert len(seconds) == len(lines) > 5 and seconds == sorted(seconds)
    assert "solved, but:" in lines[-2] and "was tested" in lines[-1]


def test_a_run_may_be_started_from_a_process_under_mpi(tmp_path):
    """Whoever has imported mpi4py hands Open MPI's variables on: mpirun ended with code 1."""
    code = (
        "import sys; from mpi4py import MPI; from softact import spec\n"
        "from softact.run.start import run\n"
        "outcome = run(spec.loads(sys.argv[1]), sys.argv[2], processes=2, report=False)\n"
        "print(outcome.status)"
    )
    arguments = [STRETCHED.format(high=3.0), str(tmp_path / "out")]
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True)
    assert done.stdout == "complete\n", done.stderr


@pytest.mark.parametrize(
    ("more", "cores", "expected"),
    [("", 1, 1), ("", 2, 2), ("", 64, 2), ("contact: [{self: x_max}]", 64, 2)],
)
def test_how_many_processes_are_usual(more, cores, expected, monkeypatch):
    monkeypatch.setattr(runs.os, "sched_getaffinity", lambda pid: set(range(cores)))
    spec = specs.loads(STRETCHED.format(high=3) + more)
    assert runs.usual_processes(spec) == expected
