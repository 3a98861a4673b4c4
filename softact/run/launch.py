"""How the processes that solve are started: one by itself, several by mpirun."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from softact import forkserver
from softact.child_processes import bound, environment
from softact.system import blas


def command(
    processes: int, arguments: Sequence[str | Path], variables: Mapping[str, str]
) -> list[str]:
    """The command of ``processes`` Python processes with these arguments, which ends with us.

    variables: what ``variables`` gives. A single one gets our process id as its last argument, to
    end with (``end_with``).
    """
    one = forkserver.command(arguments, variables)
    if processes == 1:
        return bound([*one, str(os.getpid())])
    # Unbound, or two runs side by side would share one core.
    return bound(["mpirun", "-n", str(processes), "--oversubscribe", "--bind-to", "none", *one])


# Variables of the MPI job that this process is part of, as is a Python that has imported MPI:
# mpirun would take them for its own.
_OF_A_JOB = (
    "PMIX_", "PMI_", "PRTE_", "ORTE_", "OMPI_COMM_WORLD_", "OMPI_APP_CTX_", "OMPI_UNIVERSE_",
    "OMPI_FIRST_RANKS", "OMPI_FILE_LOCATION", "OMPI_MCA_orte_", "OMPI_MCA_ess", "OMPI_MCA_pmix",
)  # fmt: skip


def variables(processes: int, threads: int | None, scratch: Path) -> dict[str, str]:
    """The environment of such processes.

    threads: of one process, by default all cores, which MUMPS uses in BLAS; several have one each.
    scratch: folder of what one process leaves when it is stopped; mpirun clears up after several.
    """
    usual = str(len(os.sched_getaffinity(0)) if processes == 1 else 1)
    found = {"OPENBLAS_NUM_THREADS": usual, **environment(_OF_A_JOB), "OMP_NUM_THREADS": "1"}
    found |= blas.variables()
    if threads:
        found["OPENBLAS_NUM_THREADS"] = str(threads)
    # All processes are on this machine and talk by shared memory: looking for networks takes each
    # of them 0.2 s, and leaving them at the end 1 s; without one, Open MPI 5 complains of TCP.
    # Python looks for a folder that can be written; Open MPI would end where TMPDIR is none.
    found["TMPDIR"] = tempfile.gettempdir()
    found |= {"OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self,vader"}
    if processes > 1:
        found["OPENBLAS_NUM_THREADS"] = "1"
        # Waiting processes give their core away: another program may need it.
        found["OMPI_MCA_mpi_yield_when_idle"] = "1"
    else:
        found["OMPI_MCA_ess_singleton_isolated"] = "1"  # no daemon beside it
        found["TMPDIR"] = str(scratch)
    if os.geteuid() == 0:
        found |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return found
