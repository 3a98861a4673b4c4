"""Kernels of OpenBLAS on a processor that it does not know."""

import json
import os
import subprocess
import sys

import pytest

from softact.run import launch
from softact.system import blas

WIDE = {"avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl"}
CPUINFO = "processor\t: 0\nmodel name\t: Some Processor\nflags\t\t: fpu sse3 avx2 fma\nbugs\t\t:\n"
SPEC = """
geometry: {type: block, length: 8 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.14 MPa, bulk_modulus: 100 MPa, density: 1000 kg/m^3}}
supports: [{surface: x_min, fix: [x, y, z]}]
steps: [{gravity: [0, 0, -1]}]
"""


@pytest.mark.parametrize(
    ("taken", "instructions", "better"),
    [
        ("Prescott", {"sse3"}, ""),  # an old processor indeed
        ("Prescott", {"avx2"}, ""),
        ("Prescott", {"avx2", "fma"}, "Haswell"),
        ("Prescott", {"avx2", "fma", "avx512f"}, "Haswell"),
        ("Prescott", {"avx2", "fma", *WIDE}, "SkylakeX"),
        ("Zen", {"avx2", "fma", *WIDE}, ""),  # OpenBLAS knows best
        ("", {"avx2", "fma"}, ""),  # no OpenBLAS
    ],
)
def test_kernels_are_those_of_the_instructions_where_the_processor_is_unknown(
    taken, instructions, better
):
    assert blas.better(taken, instructions) == better


def test_the_instructions_are_read():
    assert blas.instructions(CPUINFO) == {"fpu", "sse3", "avx2", "fma"}
    assert blas.instructions("Features\t: fp asimd\n") == set()


def test_a_choice_of_the_user_stands(monkeypatch, tmp_path):
    monkeypatch.setenv(blas.VARIABLE, "Nehalem")
    assert launch.variables(1, None, tmp_path)[blas.VARIABLE] == "Nehalem"


def test_a_run_tells_its_kernels(tmp_path):
    """And they are those that this module finds for this machine, in a process of its own."""
    clean = {name: value for name, value in os.environ.items() if name != blas.VARIABLE}
    program = """if True:
    from softact.system import blas
    print(blas.variables().get(blas.VARIABLE, blas.taken()))
    """

    def called(*arguments):
        command = [sys.executable, *arguments]
        done = subprocess.run(command, env=clean, cwd=tmp_path, capture_output=True, check=True)
        return done.stdout.decode().strip()

    (tmp_path / "block.yaml").write_text(SPEC)
    called("-m", "softact.cli.main", "run", "block.yaml", "-n", "1", "-o", "result")
    record = json.loads((tmp_path / "result" / "run.json").read_text())
    assert record["factorisation"]["kernels"] == called("-c", program)
