"""What no command loads before it solves something."""

import subprocess
import sys


def test_knowing_specs_and_commands_loads_no_solver():
    """PETSc sets signal handlers and MPI up where it is loaded: a reader of `softact list` that
    leaves early would be called a fault."""
    code = (
        "import sys, softact.cli.main, softact.spec, softact.loads, softact.measures, "
        "softact.report.report_page, softact.sweep.compute, softact.tolerances.first_order; "
        "print([m for m in ('petsc4py', 'dolfinx', 'mpi4py') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
