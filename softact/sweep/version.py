"""What a result depends on beside its spec: the sources of softact, the platform, and what a script
of the user's makes."""

from __future__ import annotations

import hashlib
import os
import platform
from collections.abc import Sequence
from functools import cache
from importlib import metadata
from pathlib import Path

from softact.geometry.imported import Imported, mesh_digest
from softact.run.provenance import gmsh_version
from softact.spec import Spec

#: What makes no number of a run: how it is shown, fitted, swept, or called.
WITHOUT_EFFECT = (
    "cards",
    "check",
    "cli",
    "converge",
    "doctor",
    "estimate",
    "export",
    "fit",
    "optimise",
    "report",
    "sweep",
    "tolerances",
)
_PACKAGES = (
    "fenics-dolfinx",
    "fenics-basix",
    "fenics-ffcx",
    "fenics-ufl",
    "petsc4py",
    "numpy",
    "scipy",
)


@cache
def code() -> str:
    """16 hexadecimal digits that change with any source file that makes a run's numbers."""
    import softact
    import softact.geometries

    roots = {Path(softact.__file__).parent, Path(softact.geometries.__file__).parent}
    digest = hashlib.sha256()
    for root in sorted(roots, key=lambda path: path.name):
        for path in sorted(root.rglob("*")):
            inside = path.relative_to(root)
            if path.suffix in (".py", ".c") and inside.parts[0] not in WITHOUT_EFFECT:
                digest.update(f"{root.name}/{inside.as_posix()}\0".encode())
                digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


@cache
def machine() -> str:
    """Processor, Python and the packages that decide a result, in one line."""
    versions = []
    for name in _PACKAGES:
        try:
            versions.append(f"{name} {metadata.version(name)}")
        except metadata.PackageNotFoundError:
            versions.append(f"{name} unknown")
    versions.append(f"gmsh {gmsh_version()}")
    python = f"python {platform.python_version()}"
    return ", ".join((platform.system(), platform.machine(), python, *versions))


def version() -> str:
    """Code, platform and the options that PETSc takes from the environment, in one line."""
    options = " ".join(os.environ.get("PETSC_OPTIONS", "").split())
    given = f", PETSC_OPTIONS {options}" if options else ""
    return f"softact {code()}, {machine()}{given}"


def run_key(
    spec: Spec,
    mesh: str | None = None,
    processes: int = 1,
    threads: int | None = 1,
    slopes: Sequence[str] = (),
    end_only: bool = False,
    blocked: Sequence[str] | None = None,
) -> str:
    """32 hexadecimal digits under which the run of a spec is kept.

    A script may read whatever it likes: modules, files, the environment, the time. All of it comes
    to bear in the mesh only, so its digest is in the key. mesh: the digest where it is known; None:
    the script is run, once in this process for each geometry. processes, threads: as for ``run``;
    sums in another order differ in their last digits. slopes: paths of the parameters by which its
    measures are differentiated. end_only: whether states before the last may be missing. blocked:
    further runs of a module whose figures are kept as those of the actuator; None: as they are.
    """
    parts = [spec.hash, version()]
    if isinstance(spec.geometry, Imported) and not spec.geometry.self_contained:
        parts.append(mesh_digest(spec.geometry, spec.solver.curved) if mesh is None else mesh)
    if (processes, threads) != (1, 1):
        parts.append(f"{processes} processes, {threads or len(os.sched_getaffinity(0))} threads")
    if slopes:
        parts.append(f"derivatives by {' '.join(slopes)}")
    if end_only:
        parts.append("last state")
    if blocked is not None:
        parts.append(" ".join(("so many modules", *blocked)))
    return hashlib.sha256(", ".join(parts).encode()).hexdigest()[:32]
