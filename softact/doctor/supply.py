"""Whose Python this is, and how it gets packages: Debian's, conda's, or somebody else's."""

import os
import shutil
import sys
from pathlib import Path
from typing import Literal

Owner = Literal["Debian", "conda", "other"]

#: Names in conda-forge of what .ci/packages.txt calls by Debian's; empty where it has none.
CONDA = {
    "python3-dolfinx": "fenics-dolfinx",
    "python3-petsc4py": "petsc4py",
    "python3-mpi4py": "mpi4py",
    "openmpi-bin": "openmpi",
    "libopenblas0-pthread": "'libblas=*=*openblas'",
    "g++": "cxx-compiler",
    "python3-dev": "python",
    "python3-gmsh": "python-gmsh",
    "python3-numpy": "numpy",
    "python3-scipy": "scipy",
    "python3-h5py": "h5py",
    "libgl1": "libgl",
    "libegl1": "libegl",
    "libxrender1": "xorg-libxrender",
    "calculix-ccx": "calculix",
    "chromium": "",
    "chromium-driver": "",
}


def owner() -> Owner:
    """Who supplies this Python, or the one that a virtual environment stands over."""
    base = Path(sys.base_prefix)
    if (base / "conda-meta").is_dir():
        return "conda"
    return "Debian" if base == Path("/usr") and shutil.which("apt-get") else "other"


def container() -> str:
    """Which kind of container this process is in; empty where none is seen."""
    if Path("/.dockerenv").exists():
        return "Docker"
    if Path("/run/.containerenv").exists():
        return "Podman"
    return os.environ.get("container", "")  # systemd's convention


def packages(*debian: str) -> str:
    """The command that installs these packages, for the user who asks."""
    match owner():
        case "conda":
            names = [CONDA[name] for name in debian if CONDA[name]]
            return f"conda install -c conda-forge {' '.join(names)}" if names else ""
        case "Debian":
            return f"{sudo()}apt-get install {' '.join(debian)}"
        case _:
            return f"install what Debian calls {' '.join(debian)}"


def own_packages() -> str:
    """The command that installs what softact has from PyPI."""
    return "make setup" if owner() == "Debian" else f"{sys.executable} -m pip install -e ."


def sudo() -> str:
    """What stands before a command that needs root."""
    return "" if os.geteuid() == 0 else "sudo "
