"""What softact stands on, looked at on this machine, and the command that mends what is missing."""

from collections.abc import Callable, Iterable

from softact.doctor import looks, solvers
from softact.doctor.finding import Finding, as_records, as_text, usable

__all__ = ["Finding", "as_records", "as_text", "examine", "usable"]

LOOKS: tuple[Callable[[], Iterable[Finding]], ...] = (
    looks.look_at_python,
    solvers.look_at_dolfinx,
    solvers.look_at_petsc,
    solvers.look_at_blas,
    looks.look_at_mpi,
    looks.look_at_gmsh,
    looks.look_at_packages,
    looks.look_at_compiler,
    looks.look_at_cache,
    looks.look_at_cores,
    looks.look_at_pictures,
    looks.look_at_programs,
)


def examine() -> list[Finding]:
    """Look at everything softact stands on, and, where nothing is broken, let it solve a block.

    Never raises for what is missing.
    """
    findings = [finding for look in LOOKS for finding in look()]
    if usable(findings):
        from softact.doctor import trial  # it loads numpy, for which the help shall not wait

        findings += trial.look_at_a_block()
    return findings
