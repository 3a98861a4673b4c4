"""A program on two MPI processes."""

import os
import shutil
import subprocess
import sys

import pytest

NO_MPIRUN = pytest.mark.skipif(shutil.which("mpirun") is None, reason="no mpirun here")


def said_by_both(program):
    """What both processes print, whose lines may run into each other; fails where one of them
    does."""
    done = subprocess.run(
        [*"mpirun --allow-run-as-root --oversubscribe -n 2".split(), sys.executable, "-c", program],
        env=dict(os.environ),  # else what an MPI in this process has put into its environment
        capture_output=True, text=True, check=False, timeout=600,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout
