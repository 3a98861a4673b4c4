"""What softact stands on beside its solvers, looked at on this machine."""

import importlib
import importlib.metadata
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterable
from pathlib import Path

from softact.doctor.finding import Finding, missing_module
from softact.doctor.supply import container, own_packages, owner, packages
from softact.files.streams import UTF8


def look_at_python() -> Iterable[Finding]:
    """The interpreter: Debian's, conda's or a container's, or another that has dolfinx."""
    detail = f"{platform.python_version()} at {sys.executable}"
    if owner() == "conda":
        detail += f", of conda in {sys.base_prefix}"
    if found := container():
        detail += f", in a container ({found})"
    try:
        there = importlib.util.find_spec("dolfinx") is not None
    except (ImportError, ValueError):
        there = False
    if owner() == "other" and not there:
        # A virtual environment keeps the version of its base, not always its system packages.
        detail += ": neither Debian's nor conda's, and without dolfinx"
        yield Finding(
            "python",
            "broken",
            detail,
            "/usr/bin/python3 -m venv --clear --system-site-packages .venv, on Debian: make setup",
        )
    else:
        yield Finding("python", "ok", detail)


def look_at_mpi() -> Iterable[Finding]:
    """MPI: the library that mpi4py is built for and the command that starts processes."""
    try:
        MPI = importlib.import_module("mpi4py.MPI")
    except Exception as error:
        yield missing_module("MPI", error, packages("python3-mpi4py"))
        return
    library = MPI.Get_library_version().split(",")[0].strip(" \0\n")
    if launcher := shutil.which("mpirun"):
        yield Finding("MPI", "ok", f"{library}, {launcher}")
    else:
        yield Finding("MPI", "broken", f"{library}, but no mpirun", packages("openmpi-bin"))


def look_at_gmsh() -> Iterable[Finding]:
    """gmsh, which makes the mesh."""
    try:
        gmsh = importlib.import_module("gmsh")
    except Exception as error:
        yield missing_module("gmsh", error, packages("python3-gmsh"))
        return
    gmsh.initialize(readConfigFiles=False)
    try:
        # __version__ is the interface's, which lags behind the library's.
        yield Finding("gmsh", "ok", gmsh.option.getString("General.Version"))
    finally:
        gmsh.finalize()


def look_at_packages() -> Iterable[Finding]:
    """The Python packages: those of the solver first, then those of the spec and the report."""
    debian = ("numpy", "scipy", "h5py")
    for name in (*debian, "pydantic", "pint", "meshio", "pyvista", "plotly", "matplotlib"):
        try:
            module = importlib.import_module(name)
        except Exception as error:
            mend = packages(f"python3-{name}") if name in debian else own_packages()
            yield missing_module(name, error, mend)
            continue
        yield Finding(name, "ok", module.__version__)


def look_at_compiler() -> Iterable[Finding]:
    """The C compiler, tried on Python's header: dolfinx compiles each form on its first use."""
    command = os.environ.get("CC", "cc").split()
    mend = packages("g++", "python3-dev")
    if shutil.which(command[0]) is None:
        yield Finding("C compiler", "broken", f"no {command[0]} on the path", mend)
        return
    include = f"-I{sysconfig.get_path('include')}"
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "trial.c")
        source.write_text("#include <Python.h>\nint main(void) { return 0; }\n", encoding="utf-8")
        done = subprocess.run(
            [*command, include, "-c", str(source), "-o", str(source.with_suffix(".o"))],
            capture_output=True,
            **UTF8,
        )
    if done.returncode:
        reason = (done.stderr.splitlines() or ["no reason given"])[0]
        yield Finding("C compiler", "broken", f"cannot compile against Python: {reason}", mend)
        return
    version = subprocess.run([*command, "--version"], capture_output=True, **UTF8).stdout
    yield Finding("C compiler", "ok", version.splitlines()[0] if version else command[0])


def look_at_cache() -> Iterable[Finding]:
    """The folder in which dolfinx keeps compiled forms: without it every run compiles anew."""
    mend = "export XDG_CACHE_HOME=$(mktemp -d)"
    try:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:
        yield Finding("cache", "broken", "HOME is not set, and the user has none", mend)
        return
    folder = base / "fenics"
    nearest = next(p for p in (folder, *folder.parents) if p.exists())
    try:
        with tempfile.TemporaryFile(dir=nearest):
            yield Finding("cache", "ok", f"{folder} can be written")
    except OSError as error:
        yield Finding("cache", "broken", f"{nearest} cannot be written: {error.strerror}", mend)


def look_at_cores() -> Iterable[Finding]:
    """Cores that this process may use beside the threads that each process would start."""
    cores = len(os.sched_getaffinity(0))
    threads = os.environ.get("OMP_NUM_THREADS")
    detail = f"{cores}, OMP_NUM_THREADS {threads or 'not set'}"
    if threads and threads.isdigit() and int(threads) > cores:
        yield Finding("cores", "slow", detail, "export OMP_NUM_THREADS=1")
    else:
        yield Finding("cores", "ok", detail)


def look_at_pictures() -> Iterable[Finding]:
    """VTK's drawing library, which needs the system's OpenGL: the report's pictures."""
    try:
        importlib.import_module("vtkmodules.vtkRenderingOpenGL2")
    except Exception as error:
        reason = str(error).splitlines()[0]
        mend = f"{packages('libgl1', 'libegl1', 'libxrender1')} && {own_packages()}"
        yield Finding("pictures", "absent", f"VTK cannot draw: {reason}", mend)
        return
    yield Finding("pictures", "ok", f"VTK {importlib.metadata.version('vtk')}")


def look_at_programs() -> Iterable[Finding]:
    """Programs that only tests and benchmarks call."""
    for name, package, use in (
        ("ccx", "calculix-ccx", "the comparison with CalculiX"),
        ("chromium", "chromium", "the tests of the report"),
        ("chromedriver", "chromium-driver", "the tests of the report"),
    ):
        if path := shutil.which(name):
            yield Finding(name, "ok", path)
        else:
            yield Finding(name, "absent", f"not there; only {use} needs it", packages(package))
