"""Which process gets which cells."""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

from softact.mesh.partition import parts


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_parts_are_alike_and_always_the_same(count):
    places = np.random.default_rng(1).random((1000, 3)) * [100, 20, 30]
    found = parts(places, count)
    sizes = np.bincount(found, minlength=count)
    assert sizes.sum() == 1000 and np.ptp(sizes) <= 1
    np.testing.assert_array_equal(found, parts(places, count))
    if count == 2:  # cut across the longest side
        assert places[found == 0, 0].max() <= places[found == 1, 0].min()


def test_equal_places_keep_their_order():
    assert parts(np.zeros((4, 3)), 2).tolist() == [0, 0, 1, 1]
    assert parts(np.zeros((1, 3)), 3).tolist() == [2]
    assert parts(np.zeros((0, 3)), 3).tolist() == []


PROGRAM = """
import itertools
import numpy as np
from mpi4py import MPI
from softact import compat
from softact.mesh.partition import parts

comm, n = MPI.COMM_WORLD, 5
places = np.array(list(itertools.product(range(n), repeat=3)), float)
corner = [(a * n + b) * n + c for a, b, c in itertools.product(range(n - 1), repeat=3)]
steps = [0, 1, n, n + 1, n * n, n * n + 1, n * n + n, n * n + n + 1]
tets = [(0, 1, 3, 7), (0, 1, 5, 7), (0, 2, 3, 7), (0, 2, 6, 7), (0, 4, 5, 7), (0, 4, 6, 7)]
cells = np.array([[at + steps[k] for k in tet] for at in corner for tet in tets])
wanted = parts(places[cells].mean(axis=1), comm.size)
here = comm.rank == 0
mesh = compat.create_mesh(
    comm,
    cells if here else np.empty((0, 4), np.int64),
    places if here else np.empty((0, 3)),
    wanted if here else np.empty(0, np.int32),
)
own = mesh.topology.index_map(3)
space = compat.function_space(mesh, 2)
got = np.asarray(mesh.topology.original_cell_index)[: own.size_local]
assert own.num_ghosts == 0
assert sorted(got) == sorted(np.flatnonzero(wanted == comm.rank))
# Nodes on a cut belong to one process: or two halves would come apart.
assert comm.allreduce(mesh.topology.index_map(0).size_local) == n**3
assert comm.allreduce(space.dofmap.index_map.size_local) == (2 * n - 1) ** 3
"""


@pytest.mark.skipif(not shutil.which("mpirun"), reason="needs mpirun")
@pytest.mark.parametrize("count", [2, 3, 4])
def test_a_mesh_is_shared_as_wanted_and_holds_together(count):
    command = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(count)]
    run = subprocess.run(
        [*command, sys.executable, "-c", PROGRAM],
        env=dict(os.environ),  # else what an MPI in this process has put into its environment
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
