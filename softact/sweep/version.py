"""What a result depends on beside its spec: the sources of softact, and the platform."""

from __future__ import annotations

import hashlib
import platform
from functools import cache
from importlib import metadata
from pathlib import Path

from softact.provenance import gmsh_version

#: What makes no number of a run: how it is shown, fitted, swept, or called.
WITHOUT_EFFECT = ("report", "sweep", "fit", "cards", "cli", "optimise", "converge", "check")
_PACKAGES = ("fenics-dolfinx", "fenics-basix", "petsc4py", "numpy", "scipy")


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
    """Code and platform, in one line."""
    return f"softact {code()}, {machine()}"


def run_key(spec) -> str:
    """32 hexadecimal digits under which the run of a spec is kept."""
    return hashlib.sha256(f"{spec.hash}, {version()}".encode()).hexdigest()[:32]
