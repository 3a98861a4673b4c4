"""What softact stands on, looked at on this machine, and the command that mends what is missing."""

import ctypes
import importlib
import importlib.metadata
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from types import ModuleType
from typing import Literal

from softact.files.streams import UTF8

State = Literal["ok", "slow", "absent", "broken"]


@dataclass(frozen=True)
class Finding:
    """One thing that was looked at.

    state: "ok"; "slow" where softact works but could be faster; "absent" where something is
        missing that only a part of softact needs; "broken" where no spec can be solved.
    mend: the command or the advice that mends it; empty when there is nothing to mend.
    """

    name: str
    state: State
    detail: str
    mend: str = ""


def apt(*packages: str) -> str:
    """The command that installs Debian packages, for the user who asks."""
    sudo = "" if os.geteuid() == 0 else "sudo "
    return f"{sudo}apt-get install {' '.join(packages)}"


def missing_module(name: str, error: Exception, mend: str) -> Finding:
    """A finding for a module that cannot be imported, with the first line of the reason."""
    reason = str(error).splitlines()[0] if str(error) else type(error).__name__
    return Finding(name, "broken", f"cannot be imported: {reason}", mend)


def look_at_python() -> Iterable[Finding]:
    """The interpreter: it has to be the one that Debian's dolfinx is built for."""
    detail = f"{platform.python_version()} at {sys.executable}"
    # A virtual environment keeps the version of its base, not always its system packages.
    if sys.prefix != sys.base_prefix and Path(sys.base_prefix) != Path("/usr"):
        yield Finding("python", "broken", f"{detail}, not over /usr/bin/python3", "make setup")
    else:
        yield Finding("python", "ok", detail)


def import_petsc() -> ModuleType:
    """petsc4py.PETSc, without the options in a file of the current folder: one of them loads and
    runs any library."""
    importlib.import_module("petsc4py").init(["softact", "-skip_petscrc"])
    return importlib.import_module("petsc4py.PETSc")


def look_at_dolfinx() -> Iterable[Finding]:
    """dolfinx, which assembles the forms."""
    with suppress(Exception):
        import_petsc()  # or dolfinx would, with those options
    try:
        dolfinx = importlib.import_module("dolfinx")
    except Exception as error:
        yield missing_module("dolfinx", error, apt("python3-dolfinx"))
        return
    yield Finding("dolfinx", "ok", dolfinx.__version__)


def look_at_petsc() -> Iterable[Finding]:
    """PETSc with real numbers, and the direct solvers that it was built with."""
    try:
        PETSc = import_petsc()
    except Exception as error:
        yield missing_module("PETSc", error, apt("python3-petsc4py"))
        return
    version = ".".join(map(str, PETSc.Sys.getVersion()))
    if PETSc.ScalarType().dtype.kind == "c":
        yield Finding("PETSc", "broken", f"{version} with complex numbers", "unset PETSC_DIR")
    else:
        yield Finding("PETSc", "ok", version)
    known = ("mumps", "superlu_dist", "superlu", "suitesparse", "mkl_pardiso", "strumpack", "hypre")
    present = [name for name in known if PETSc.Sys.hasExternalPackage(name)]
    if "mumps" not in present:
        yield Finding("solvers", "broken", "PETSc without MUMPS", apt("python3-petsc4py"))
        return
    yield Finding("solvers", "ok", ", ".join(present))
    yield Finding("orderings", "ok", "MUMPS with " + ", ".join(mumps_orderings(PETSc)))


def mumps_orderings(petsc: ModuleType) -> list[str]:
    """Names of the fill-reducing orderings that this MUMPS has.

    Each is asked for (ICNTL(7)) in a factorisation of a small Laplacian; INFOG(7) tells the one
    that was used (MUMPS users' guide, section 6.1): another one means that it is not built in.
    """
    side = 12
    matrix = petsc.Mat().createAIJ((side**2, side**2), nnz=5, comm=petsc.COMM_SELF)
    for row in range(side**2):
        matrix[row, row] = 4.0
        for column in (row - side, row - 1, row + 1, row + side):
            if 0 <= column < side**2:
                matrix[row, column] = -1.0
    matrix.assemble()
    prefix = "softact_doctor_"
    options = petsc.Options(prefix)
    found = []
    for number, name in {0: "AMD", 2: "AMF", 3: "Scotch", 4: "PORD", 5: "METIS", 6: "QAMD"}.items():
        options["mat_mumps_icntl_7"] = number
        solver = petsc.PC().create(comm=petsc.COMM_SELF)
        solver.setOptionsPrefix(prefix)
        solver.setOperators(matrix)
        solver.setType("lu")
        solver.setFactorSolverType("mumps")
        solver.setFromOptions()
        solver.setUp()
        if solver.getFactorMatrix().getMumpsInfog(7) == number:
            found.append(name)
        solver.destroy()
    options.delValue("mat_mumps_icntl_7")
    matrix.destroy()
    return found


def look_at_blas() -> Iterable[Finding]:
    """The BLAS that PETSc has really loaded, and the threads that it would take."""
    try:
        import_petsc()
    except Exception:
        return  # told by look_at_petsc
    name = f"libblas.so.3-{sysconfig.get_config_var('MULTIARCH')}"
    sudo = "" if os.geteuid() == 0 else "sudo "
    mend = f"{apt('libopenblas0-pthread')} && {sudo}update-alternatives --auto {name}"
    with open("/proc/self/maps", encoding="utf-8", errors="replace") as maps:
        libraries = blas_among(maps)
    fast = [path for path in libraries if re.search(r"openblas|mkl|blis", path.lower())]
    if not libraries:
        yield Finding("BLAS", "slow", "none is loaded as a library of its own", mend)
    elif not fast:
        yield Finding("BLAS", "slow", f"{libraries[0]}: about four times slower", mend)
    else:
        # The library behind an interface such as .../openblas-pthread/libblas.so.3 tells more.
        real = next((p for p in fast if "openblas" in Path(p).name), fast[0])
        yield Finding("BLAS", "ok", real + blas_threads(real))


def blas_among(maps: Iterable[str]) -> list[str]:
    """Paths of the BLAS libraries in a process's memory map, less those of a wheel's own.

    maps: the lines of /proc/<pid>/maps (proc(5)). numpy's wheel brings an OpenBLAS in a folder
    numpy.libs, which PETSc does not use.
    """
    paths = {line.split(maxsplit=5)[5].strip() for line in maps if "/" in line}
    pattern = re.compile(r"lib(blas|openblas|mkl_rt|mkl_core|blis|atlas)[^/]*\.so")
    return sorted(p for p in paths if pattern.search(Path(p).name) and ".libs/" not in p)


def blas_threads(path: str) -> str:
    """How many threads an OpenBLAS library uses in this process, as a phrase."""
    try:
        threads = ctypes.CDLL(path).openblas_get_num_threads()
    except (OSError, AttributeError):
        return ""
    return f" ({threads} thread{'s' if threads != 1 else ''})"


def look_at_mpi() -> Iterable[Finding]:
    """MPI: the library that mpi4py is built for and the command that starts processes."""
    try:
        MPI = importlib.import_module("mpi4py.MPI")
    except Exception as error:
        yield missing_module("MPI", error, apt("python3-mpi4py"))
        return
    library = MPI.Get_library_version().split(",")[0].strip(" \0\n")
    if launcher := shutil.which("mpirun"):
        yield Finding("MPI", "ok", f"{library}, {launcher}")
    else:
        yield Finding("MPI", "broken", f"{library}, but no mpirun", apt("openmpi-bin"))


def look_at_gmsh() -> Iterable[Finding]:
    """gmsh, which makes the mesh."""
    try:
        gmsh = importlib.import_module("gmsh")
    except Exception as error:
        yield missing_module("gmsh", error, apt("python3-gmsh"))
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
            mend = apt(f"python3-{name}") if name in debian else "make setup"
            yield missing_module(name, error, mend)
            continue
        yield Finding(name, "ok", module.__version__)


def look_at_compiler() -> Iterable[Finding]:
    """The C compiler, tried on Python's header: dolfinx compiles each form on its first use."""
    command = os.environ.get("CC", "cc").split()
    mend = apt("g++", "python3-dev")
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
        mend = apt("libgl1", "libegl1", "libxrender1") + " && make setup"
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
            yield Finding(name, "absent", f"not there; only {use} needs it", apt(package))


LOOKS: tuple[Callable[[], Iterable[Finding]], ...] = (
    look_at_python,
    look_at_dolfinx,
    look_at_petsc,
    look_at_blas,
    look_at_mpi,
    look_at_gmsh,
    look_at_packages,
    look_at_compiler,
    look_at_cache,
    look_at_cores,
    look_at_pictures,
    look_at_programs,
)


def examine() -> list[Finding]:
    """Look at everything softact stands on; never raises for what is missing."""
    return [finding for look in LOOKS for finding in look()]


def usable(findings: Iterable[Finding]) -> bool:
    """Whether a spec can be solved on this machine."""
    return all(finding.state != "broken" for finding in findings)


def as_text(findings: list[Finding]) -> str:
    """The findings as a table; under each that is not "ok" the command that mends it."""
    width = max(len(finding.name) for finding in findings)
    lines = []
    for finding in findings:
        lines.append(f"{finding.state:<7} {finding.name:<{width}}  {finding.detail}")
        if finding.mend:
            lines.append(f"{'':7} {'':{width}}  mend it with: {finding.mend}")
    faults = sum(finding.state == "broken" for finding in findings)
    lines.append(f"\nsoftact cannot run: {faults} broken" if faults else "\nsoftact can run")
    return "\n".join(lines)


def as_records(findings: list[Finding]) -> list[dict[str, str]]:
    """The findings as plain dictionaries with the keys name, state, detail and mend."""
    return [asdict(finding) for finding in findings]
