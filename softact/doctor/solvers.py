"""dolfinx, PETSc with its direct solvers, and the BLAS below them."""

import ctypes
import importlib
import re
import sysconfig
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from types import ModuleType

from softact.doctor.finding import Finding, missing_module
from softact.doctor.supply import owner, packages, sudo
from softact.system import blas


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
        yield missing_module("dolfinx", error, packages("python3-dolfinx"))
        return
    yield Finding("dolfinx", "ok", dolfinx.__version__)


def look_at_petsc() -> Iterable[Finding]:
    """PETSc with real numbers, and the direct solvers that it was built with."""
    try:
        PETSc = import_petsc()
    except Exception as error:
        yield missing_module("PETSc", error, packages("python3-petsc4py"))
        return
    version = ".".join(map(str, PETSc.Sys.getVersion()))
    if PETSc.ScalarType().dtype.kind == "c":
        yield Finding("PETSc", "broken", f"{version} with complex numbers", "unset PETSC_DIR")
    else:
        yield Finding("PETSc", "ok", version)
    known = ("mumps", "superlu_dist", "superlu", "suitesparse", "mkl_pardiso", "strumpack", "hypre")
    present = [name for name in known if PETSc.Sys.hasExternalPackage(name)]
    if "mumps" not in present:
        yield Finding("solvers", "broken", "PETSc without MUMPS", packages("python3-petsc4py"))
        return
    yield Finding("solvers", "ok", ", ".join(present))
    yield Finding("orderings", "ok", "MUMPS with " + ", ".join(mumps_orderings(PETSc)))
    from softact.solve import pardiso  # numpy takes its time, and the help waits for this module

    if pardiso.library() is not None:
        yield Finding("Pardiso", "ok", "of MKL, for specs with solver: {factor: pardiso}")


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
    mend = packages("libopenblas0-pthread")
    if owner() == "Debian":
        name = f"libblas.so.3-{sysconfig.get_config_var('MULTIARCH')}"
        mend += f" && {sudo()}update-alternatives --auto {name}"
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
        yield Finding("BLAS", "ok", real + blas_threads(real) + blas_kernels())


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


def blas_kernels() -> str:
    """Which kernels OpenBLAS takes, and which softact has it take instead, as a phrase."""
    kernels, better = blas.taken(), blas.variables()
    if not better:
        return f", kernels of {kernels}" if kernels else ""
    instead = better[blas.VARIABLE]
    return f", kernels of {kernels}: it does not know this processor; runs take those of {instead}"
