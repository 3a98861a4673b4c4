"""The doctor's findings, on this machine and on machines that lack something."""

import json
import os
import re
import subprocess
import sys

import pytest
import scipy.optimize
from click.testing import CliRunner

from softact import doctor
from softact.cli.doctor import doctor as command
from softact.doctor import looks, solvers, supply, trial


def by_name(findings):
    return {finding.name: finding for finding in findings}


@pytest.fixture(scope="module")
def here():
    return by_name(doctor.examine())


def run_elsewhere(**environment):
    """The doctor in a process of its own, with another environment: (exit code, name -> record)."""
    code = "from softact.cli.doctor import doctor; doctor(['--json'])"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
    )
    report = json.loads(done.stdout)
    assert report["usable"] == (done.returncode == 0)
    return done.returncode, {record["name"]: record for record in report["findings"]}


def test_the_machine_of_the_tests_is_usable(here):
    assert doctor.usable(here.values())
    assert here["dolfinx"].detail == sys.modules["dolfinx"].__version__
    assert "mumps" in here["solvers"].detail


def test_petsc_factorises_with_openblas(here):
    # .ci/packages.txt installs it and .ci/setup chooses it.
    assert here["BLAS"].state == "ok"
    assert "openblas" in here["BLAS"].detail


def test_mumps_has_its_own_orderings(here):
    # These four are part of MUMPS (users' guide, ICNTL(7)); Scotch and METIS depend on the build.
    assert {"AMD", "AMF", "PORD", "QAMD"} <= set(
        here["orderings"].detail.removeprefix("MUMPS with ").split(", ")
    )


MAPS = """\
7f10-7f20 r-xp 00000000 fe:00 11  /usr/lib/x86_64-linux-gnu/{system}
7f20-7f30 r--p 00010000 fe:00 11  /usr/lib/x86_64-linux-gnu/{system}
7f40-7f50 r-xp 00000000 fe:00 12  /home/a/.venv/lib/numpy.libs/libopenblas64_p-r0.so
7f50-7f60 r-xp 00000000 fe:00 13  /usr/lib/x86_64-linux-gnu/libscalapack-openmpi.so.2.2.1
7f60-7f70 rw-p 00000000 00:00 0
"""


@pytest.mark.parametrize("system", ["blas/libblas.so.3.11.0", "openblas-pthread/libopenblas.so.0"])
def test_the_blas_of_a_wheel_is_not_taken_for_the_solvers(system):
    found = solvers.blas_among(MAPS.format(system=system).splitlines())
    assert found == [f"/usr/lib/x86_64-linux-gnu/{system}"]


def test_the_reference_blas_is_called_slow(monkeypatch):
    monkeypatch.setattr(solvers, "blas_among", lambda maps: ["/usr/lib/blas/libblas.so.3"])
    (finding,) = solvers.look_at_blas()
    assert finding.state == "slow"
    assert "/usr/lib/blas/libblas.so.3" in finding.detail
    assert "update-alternatives --auto libblas.so.3-" in finding.mend


@pytest.mark.parametrize(
    ("module", "name", "package"),
    [
        ("dolfinx", "dolfinx", "python3-dolfinx"),
        ("gmsh", "gmsh", "python3-gmsh"),
        ("h5py", "h5py", "python3-h5py"),
        ("plotly", "plotly", "make setup"),
    ],
)
def test_a_module_that_cannot_be_imported_is_told(tmp_path, module, name, package):
    (tmp_path / f"{module}.py").write_text("raise ImportError('libfoo.so.1: no such file')\n")
    code, findings = run_elsewhere(PYTHONPATH=str(tmp_path))
    assert code == 2
    assert findings[name]["state"] == "broken"
    assert "libfoo.so.1" in findings[name]["detail"]
    assert package in findings[name]["mend"]
    assert [n for n, f in findings.items() if f["state"] == "broken"] == [name]


def test_a_missing_compiler_and_a_read_only_cache_are_told():
    # Nobody, not even root, can make a file in /proc.
    code, findings = run_elsewhere(CC="no-such-compiler", XDG_CACHE_HOME="/proc/cache")
    assert code == 2
    assert "no-such-compiler" in findings["C compiler"]["detail"]
    assert "g++" in findings["C compiler"]["mend"]
    assert "/proc cannot be written" in findings["cache"]["detail"]
    assert "XDG_CACHE_HOME" in findings["cache"]["mend"]


def test_the_header_of_python_is_tried(tmp_path):
    compiler = tmp_path / "compiler"
    compiler.write_text("#!/bin/sh\necho 'trial.c:1: fatal error: Python.h' >&2\nexit 1\n")
    compiler.chmod(0o755)
    code, findings = run_elsewhere(CC=str(compiler))
    assert code == 2
    assert "Python.h" in findings["C compiler"]["detail"]
    assert "python3-dev" in findings["C compiler"]["mend"]


def test_more_threads_than_cores_are_slow_but_usable():
    code, findings = run_elsewhere(OMP_NUM_THREADS="1000")
    assert code == 0
    assert findings["cores"]["state"] == "slow"
    assert "OMP_NUM_THREADS=1" in findings["cores"]["mend"]


def test_what_only_a_part_needs_does_not_stop_a_run(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    findings = by_name(looks.look_at_programs())
    assert {finding.state for finding in findings.values()} == {"absent"}
    assert "calculix-ccx" in findings["ccx"].mend
    assert doctor.usable(findings.values())


def test_the_table_shows_the_command_under_the_fault(monkeypatch):
    faults = [doctor.Finding("gmsh", "broken", "gone", "apt-get install python3-gmsh")]
    monkeypatch.setattr("softact.cli.doctor.examine", lambda: faults)
    result = CliRunner().invoke(command)
    assert result.exit_code == 2
    lines = result.output.splitlines()
    assert lines[0].split() == ["broken", "gmsh", "gone"]
    assert lines[1].strip() == "mend it with: apt-get install python3-gmsh"
    assert lines[-1] == "softact cannot run: 1 broken"


def test_a_block_is_solved_by_one_process_and_by_two(here):
    for name in ("a block", "two processes"):
        assert here[name].state == "ok", here[name].detail
        assert re.fullmatch(r"solved, \de-\d\d off the exact answer, in .* s", here[name].detail)


def test_the_pull_on_the_block_is_that_of_the_closed_form():
    # Incompressible: 2 C10 (λ - λ⁻²) = 0.2111 MPa; with K = 10 C10 the block is softer. Seen from
    # the energy: the work of the pull at the least energy over the stretch across.
    def energy(stretch, across):
        volume = stretch * across**2
        mean = (stretch**2 + 2 * across**2) / volume ** (2 / 3)
        return trial.C10 * (mean - 3) + trial.BULK / 2 * (volume - 1) ** 2

    def least(stretch):
        return scipy.optimize.minimize_scalar(
            lambda across: energy(stretch, across), bounds=(0.5, 1.0), options={"xatol": 1e-10}
        ).fun

    step = 1e-4
    slope = (least(trial.STRETCH + step) - least(trial.STRETCH - step)) / (2 * step)
    assert trial.pull() == pytest.approx(slope, rel=1e-6)
    assert 0.18 < trial.pull() < 2 * trial.C10 * (1.5 - 1.5**-2)


@pytest.mark.parametrize(
    ("answer", "state", "words"),
    [
        ({"processes": 1, "stretch": 1.5 + 1e-9}, "ok", "7e-10 off"),
        ({"processes": 1, "stretch": 1.49}, "broken", "stretched to 1.49 where 1.5 is exact"),
        ({"processes": 1, "stretch": float("nan")}, "broken", "stretched to nan"),
        ({"processes": 3, "stretch": 1.5}, "broken", "nothing of each other"),
    ],
)
def test_what_a_block_is_measured_with(monkeypatch, answer, state, words):
    monkeypatch.setattr(trial, "_answer", lambda processes: answer)
    first, *_ = trial.look_at_a_block()
    assert first.state == state
    assert words in first.detail


def test_a_solver_that_crashes_is_told_and_one_without_mpirun_is_slow(monkeypatch, tmp_path):
    monkeypatch.setattr(trial.launch, "command", lambda *_: ["sh", "-c", "echo 'E: gone' >&2"])
    (found,) = trial.look_at_a_block()
    assert (found.state, found.detail) == ("broken", "not solved: E: gone")

    def command(processes, *arguments):
        return ["sh", "-c", 'echo \'{"processes": 1, "stretch": 1.5}\'']

    monkeypatch.setattr(trial.launch, "command", command)
    alone, both = trial.look_at_a_block()
    assert alone.state == "ok"
    assert (both.state, doctor.usable([alone, both])) == ("slow", True)
    assert "softact run -n 1" in both.mend


def test_conda_and_containers_are_known(monkeypatch, tmp_path):
    (tmp_path / "conda-meta").mkdir()
    monkeypatch.setattr(sys, "base_prefix", str(tmp_path))
    monkeypatch.setenv("container", "lxc")
    (found,) = looks.look_at_python()
    assert found.state == "ok"
    assert f"of conda in {tmp_path}" in found.detail and "container" in found.detail
    command = supply.packages("python3-dolfinx", "openmpi-bin")
    assert command == "conda install -c conda-forge fenics-dolfinx openmpi"
    assert supply.packages("chromium") == ""
    assert supply.own_packages().endswith("-m pip install -e .")


def test_another_python_is_taken_where_it_has_dolfinx(monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "base_prefix", str(tmp_path))
    (found,) = looks.look_at_python()
    assert found.state == "ok"
    assert "Debian calls g++" in supply.packages("g++")
    monkeypatch.setattr(looks.importlib.util, "find_spec", lambda name: None)
    (found,) = looks.look_at_python()
    assert (found.state, "make setup" in found.mend) == ("broken", True)
