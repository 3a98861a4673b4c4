"""A worker's processes end together, whatever each of them has left behind."""

import os
import shutil
import subprocess
import sys

import pytest

PROGRAM = """
import sys
from mpi4py import MPI
from petsc4py import PETSc
from softact.run.worker import _leave
kept = PETSc.Vec().createMPI(10, comm=MPI.COMM_WORLD)
if MPI.COMM_WORLD.rank == int(sys.argv[1]):
    kept = None  # PETSc takes it apart when all processes have given it up
_leave(3)
"""


@pytest.mark.skipif(shutil.which("mpirun") is None, reason="no mpirun here")
@pytest.mark.parametrize("rank", [0, 1])
def test_processes_end_together_where_one_alone_gave_something_up(rank):
    """They waited for each other for ever: Python collects its garbage when each process likes."""
    command = "mpirun --allow-run-as-root --oversubscribe -n 2".split()
    done = subprocess.run(
        [*command, sys.executable, "-c", PROGRAM, str(rank)],
        env=dict(os.environ), check=False, capture_output=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 3


COLLECTING = """
import gc, os
from mpi4py import MPI
from petsc4py import PETSc
from softact.run.worker import _leave
end = PETSc._finalize
def watched():
    os.write(2, b"Python may collect" * gc.isenabled())
    end()
PETSc._finalize = watched
_leave(3)
"""


def test_nothing_is_collected_while_mpi_ends():
    """A communicator that was freed after MPI had ended: 'This is disallowed by the MPI standard',
    at the end of two of some thousand runs."""
    command = [sys.executable, "-c", COLLECTING]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (3, "")
