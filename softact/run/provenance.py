"""What a result was made with: versions, platform, commit."""

from __future__ import annotations

import platform
import subprocess
from contextlib import suppress
from importlib import metadata
from pathlib import Path

from softact.files.streams import UTF8


def provenance() -> dict:
    """Versions, platform and commit, for ``run.json``."""
    return {
        "softact": metadata.version("softact"),
        "commit": commit(),
        "versions": versions(),
        "platform": platform.platform(),
    }


def versions() -> dict[str, str]:
    """Versions of what decides a result."""
    import dolfinx
    import numpy
    from petsc4py import PETSc

    return {
        "python": platform.python_version(),
        "dolfinx": dolfinx.__version__,
        "petsc": ".".join(map(str, PETSc.Sys.getVersion())),
        "numpy": numpy.__version__,
        "gmsh": gmsh_version(),
    }


def gmsh_version() -> str | None:
    """Version of Debian's gmsh, or of another's package; None where it is not known."""
    # Importing gmsh loads its library and all of OpenCASCADE; the package knows its version.
    with suppress(OSError):
        query = ["dpkg-query", "-W", "-f", "${Version}", "python3-gmsh"]
        found = subprocess.run(query, capture_output=True, **UTF8, check=False).stdout
        if found:
            return found.split("+")[0]
    with suppress(metadata.PackageNotFoundError):
        return metadata.version("gmsh")
    return None


def commit() -> str | None:
    """Commit of the source tree that softact runs from, None outside of a git tree."""
    try:
        done = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=12"],
            cwd=Path(__file__).parent,
            capture_output=True,
            **UTF8,
            check=False,
        )
    except OSError:
        return None
    return done.stdout.strip() or None
