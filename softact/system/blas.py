"""Kernels of OpenBLAS, in which MUMPS spends its time: those of an old processor where OpenBLAS
does not know the present one, unless it is told."""

from __future__ import annotations

import ctypes
import functools
import os
from pathlib import Path

VARIABLE = "OPENBLAS_CORETYPE"
_LIBRARY = "libopenblas.so.0"
# What it takes on x86 where it does not know the processor: 128 bits wide, a sixth of the speed.
UNKNOWN = "Prescott"
# Kernels and the instructions that they are made of, as Linux names them: the widest first.
_KERNELS = (
    ("SkylakeX", {"avx512f", "avx512cd", "avx512bw", "avx512dq", "avx512vl"}),
    ("Haswell", {"avx2", "fma"}),
)


@functools.cache
def taken() -> str:
    """Name of the kernels that OpenBLAS takes in this process, "" where there is no OpenBLAS."""
    try:
        name = ctypes.CDLL(_LIBRARY).openblas_get_corename
    except (OSError, AttributeError):
        return ""
    name.restype = ctypes.c_char_p
    return name().decode()


def better(kernels: str, instructions: set[str]) -> str:
    """Kernels that a processor with these instructions can use where OpenBLAS does not know it,
    "" where it knows it, or has none that are faster."""
    if kernels != UNKNOWN:
        return ""
    return next((name for name, wanted in _KERNELS if wanted <= instructions), "")


def instructions(cpuinfo: str) -> set[str]:
    """Of the first processor in a text like /proc/cpuinfo; none where it names none."""
    lines = (line.partition(":") for line in cpuinfo.splitlines())
    return next((set(names.split()) for key, _, names in lines if key.strip() == "flags"), set())


def variables() -> dict[str, str]:
    """What to put into the environment of a process that solves; the user's own choice stands."""
    if os.environ.get(VARIABLE):
        return {}
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return {}
    found = better(taken(), instructions(text))
    return {VARIABLE: found} if found else {}
