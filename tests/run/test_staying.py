"""A process that solves one run after another says of each what a process of its own says."""

import os
import signal

import numpy as np
import pytest

from softact.errors import SoftactError
from softact.results.folder import read
from softact.run.start import SolverCrashError, run
from softact.run.staying import Staying
from softact.spec import loads

CUBE = """
geometry: {type: block, length: 4 mm, width: 4 mm, height: 4 mm, mesh_size: 4 mm}
materials: {body: {law: neo_hookean, c10: 0.1 MPa}}
steps: [{name: pull, traction: {surface: x_max, value: [20 kPa, 0 kPa, 0 kPa]}}]
solver: {initial_increment: 1, max_increment: 1}
"""


def cube(length):
    return loads(CUBE.replace("length: 4 mm", f"length: {length} mm"))


def test_runs_are_those_of_processes_of_their_own(tmp_path):
    with Staying() as staying:
        for length in (4, 5, 6):
            outcome = run(cube(length), tmp_path / f"{length}", report=False, staying=staying)
            assert outcome.exit_code == 0
        process = staying._process.pid
        assert len({staying._process.pid, process}) == 1
    alone = run(cube(6), tmp_path / "alone", report=False, threads=1)
    assert alone.exit_code == 0
    one, other = read(tmp_path / "6").curve, read(tmp_path / "alone").curve
    assert one.keys() == other.keys()
    for name in one:
        assert np.array_equal(one[name], other[name]), name
    with pytest.raises(ProcessLookupError):
        os.kill(process, 0)


def test_a_process_that_died_is_told_and_replaced(tmp_path):
    with Staying() as staying:
        run(cube(4), tmp_path / "first", report=False, staying=staying)

        def kill(event):
            if event["stage"] == "solve":
                os.killpg(staying._process.pid, signal.SIGKILL)

        with pytest.raises(SolverCrashError, match="killed by signal 9"):
            run(cube(5), tmp_path / "killed", report=False, staying=staying, progress=kill)
        again = run(cube(5), tmp_path / "again", report=False, staying=staying)
        assert again.exit_code == 0


def test_a_run_that_cannot_be_leaves_the_process_for_the_next(tmp_path):
    """Contact that begins with an overlap is refused by the solver."""
    ball = "obstacles: {ball: {type: sphere, centre: [2 mm, 2 mm, 2 mm], radius: 1 mm}}\n"
    with Staying() as staying:
        run(cube(4), tmp_path / "first", report=False, staying=staying)
        process = staying._process.pid
        with pytest.raises(SoftactError) as refused:
            run(loads(CUBE + ball), tmp_path / "no", report=False, staying=staying)
        assert refused.value.exit_code != 70
        run(cube(5), tmp_path / "next", report=False, staying=staying)
        assert staying._process.pid == process
