"""Machine code made at run time: FFCx's element kernels and the assembly loops, both cached.

The cache lives under ``$XDG_CACHE_HOME/softact`` and is keyed by source, compiler flags, versions
and processor, so that a cache shared between machines never serves wrong code. A library appears
there by a rename, so that runs at the same time do not disturb each other and no lock is needed.
Its last bytes are the checksum of the others: one that is damaged is made anew.
With a warm cache neither UFL nor FFCx is run: a form is known by the text of the module that
writes it, its name and its arguments.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import inspect
import os
import platform
import re
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from softact.errors import SoftactError
from softact.files.streams import UTF8

if TYPE_CHECKING:
    import ufl
    from mpi4py import MPI

_CHECKSUM = hashlib.sha256().digest_size

# -Ofast would let the compiler assume that NaN does not occur; a NaN must reach the solver.
FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast")


def cache_folder() -> Path:
    """Folder of all compiled code (created). Raises SoftactError where that cannot be."""
    try:
        folder = _base() / "softact" / f"code-{_machine()}"
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError) as error:  # no home, or one that may not be written
        raise no_room(error) from None
    return folder


def _base() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def concerns(error: OSError) -> bool:
    """Whether an error is about the folder of compiled code, dolfinx's own included, about one
    that it cannot be made in, or about the settings that FFCx looks for."""
    if not isinstance(error.filename, str | os.PathLike):
        return False
    path, base = Path(error.filename), _base()
    return base.is_relative_to(path) or any(
        path.is_relative_to(own)
        for own in (base / "softact", base / "fenics", Path.home() / ".config")
    )


def no_room(error: OSError | RuntimeError) -> SoftactError:
    """What to say, and to do, where compiled code cannot be kept."""
    why = " ".join(str(error).split())
    if isinstance(error, OSError) and error.filename is not None:
        why = f"{os.fspath(error.filename)}: {error.strerror}"
    there = os.environ.get("XDG_CACHE_HOME")
    variable = "XDG_CACHE_HOME" if there and there in why else "HOME"
    return SoftactError(
        f"{why}; softact keeps compiled code there: name a folder that it may write, for example "
        f"export {variable}=$(mktemp -d)"
    )


@functools.cache
def _machine() -> str:
    """Short key of what decides whether machine code fits: processor and software versions."""
    import ffcx
    import ufl

    processor = platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        processor += next((line for line in lines if line.startswith("flags")), "")
    except OSError:
        pass
    key = (processor, platform.libc_ver(), ffcx.__version__, ufl.__version__, FLAGS)
    return hashlib.sha256(repr(key).encode()).hexdigest()[:12]


def load_library(comm: MPI.Comm, source: Path, header: Path | None = None) -> ctypes.CDLL:
    """Compile one C file to a shared library (rank 0, once per machine) and load it.

    header: file on rank 0 that the source includes as ``HEADER``.
    """
    text = source.read_text(encoding="utf-8")
    if header is None:
        return _load(comm, source.stem, text, lambda: text)
    known = header.read_text(encoding="utf-8", errors="replace") if comm.rank == 0 else ""
    text = f'#define HEADER "{header}"\n{text}'
    return _load(comm, source.stem, text + comm.bcast(known), lambda: text)


def load_text(name: str, text: str, comm: MPI.Comm | None = None) -> ctypes.CDLL:
    """Compile C text, once per machine, and load it. comm: of the processes that do so together,
    None: this one alone."""
    from mpi4py import MPI

    return _load(comm or MPI.COMM_SELF, name, text, lambda: text)


def load_kernels(
    comm: MPI.Comm, module: ModuleType, name: str, *arguments: int | None
) -> tuple[ctypes.c_void_p, ...]:
    """Addresses of the element kernels of the forms that ``module.name(*arguments)`` returns.

    Each form has one integral. The kernels have the signature ufcx_tabulate_tensor_float64.
    """
    from softact import compat

    text = inspect.getsource(module) + inspect.getsource(compat)
    key = f"{text}{name}{arguments}"
    library = _load(comm, name, key, lambda: _generate(getattr(module, name)(*arguments)))
    count = ctypes.c_int.in_dll(library, "kernel_count").value
    functions = (ctypes.c_void_p * count).in_dll(library, "kernels")
    return tuple(ctypes.c_void_p(functions[i]) for i in range(count))


def _generate(forms: Sequence[ufl.Form]) -> str:
    """C source of the kernels of ``forms`` and a table of them."""
    from softact import compat

    sources, names = [], []
    for number, form in enumerate(forms):
        source = compat.generate_code(form, f"form{number}")
        (name,) = re.findall(r"^void (tabulate_tensor_\w+)\(", source, re.MULTILINE)
        kernel = _function(source, name)
        # FFCx numbers its kernels per form, so two forms may use one name.
        names.append(f"kernel_{number}")
        sources.append("static " + kernel.replace(name, names[-1]))
    table = ", ".join(f"(void *){name}" for name in names)
    return "\n".join(
        [
            "#include <math.h>",
            "#include <stdint.h>",
            "#include <string.h>",
            *sources,
            f"const int kernel_count = {len(names)};",
            f"void *const kernels[] = {{{table}}};",
        ]
    )


def _function(source: str, name: str) -> str:
    """The C function ``void name(...) {...}``; FFCx 0.9 does not indent, so braces are counted."""
    start, depth = source.index(f"void {name}("), 0
    for brace in re.finditer("[{}]", source[start:]):
        depth += 1 if brace.group() == "{" else -1
        if depth == 0:
            return source[start : start + brace.end()]
    raise ValueError(f"{name} has no end")


def _load(comm: MPI.Comm, name: str, key: str, generate: Callable[[], str]) -> ctypes.CDLL:
    digest = hashlib.sha256(key.encode()).hexdigest()[:16]
    library = failure = None
    try:
        library = cache_folder() / f"{name}-{digest}.so"
        if comm.rank == 0 and not _sound(library):
            _compile(generate(), library)
    except SoftactError as error:
        failure = error
    except OSError as error:  # a folder that is read-only, a home that FFCx cannot look into
        failure = no_room(error)
    failure = next((found for found in comm.allgather(failure) if found is not None), None)
    if failure is not None:
        raise failure
    return ctypes.CDLL(str(library))


def _sound(library: Path) -> bool:
    """Whether a library is there as it was made; loading another could end the process."""
    try:
        content = library.read_bytes()
    except OSError:
        return False
    code, checksum = content[:-_CHECKSUM], content[-_CHECKSUM:]
    return hashlib.sha256(code).digest() == checksum


def _compile(source: str, library: Path) -> None:
    compiler = os.environ.get("CC", "cc")
    with tempfile.TemporaryDirectory(dir=library.parent) as folder:
        code, made = Path(folder) / f"{library.stem}.c", Path(folder) / library.name
        code.write_text(source, encoding="utf-8")
        _call(compiler, code, made)
        checksum = hashlib.sha256(made.read_bytes()).digest()
        with open(made, "ab") as file:  # nobody looks behind the last section of a library
            file.write(checksum)
            file.flush()
            os.fsync(file.fileno())
        os.replace(made, library)


def _call(compiler: str, code: Path, made: Path) -> None:
    command = [compiler, *FLAGS, "-std=c17", "-shared", "-fPIC", "-o", str(made), str(code), "-lm"]
    try:
        done = subprocess.run(command, capture_output=True, check=False, **UTF8)
    except (FileNotFoundError, PermissionError) as error:
        raise SoftactError(
            f"no C compiler '{compiler}': install one with 'apt-get install gcc'"
        ) from error
    if done.returncode:
        raise SoftactError(
            f"'{compiler}' could not compile {code.name}: {done.stderr.strip()[-300:]}"
        )
