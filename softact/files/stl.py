"""STL files, of text or binary: triangles of a surface."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from softact.errors import SpecError
from softact.files.text import read_file

HEAD, EACH = 80, 50  # bytes before the number of triangles, and of each
MOST = 200 * 10**6  # bytes


def read_stl(path: Path) -> np.ndarray:
    """Corners (n, 3, 3) of the triangles of an STL file, in its unit.

    Raises SpecError where it is none.
    """
    data = read_file(path, MOST, "an STL file")
    count = int.from_bytes(data[HEAD : HEAD + 4], "little")
    if len(data) == HEAD + 4 + EACH * count and count:
        kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
        return _finite(path, np.frombuffer(data, kind, count, HEAD + 4)["corners"].astype(float))
    words = data.split()
    if not words or words[0] != b"solid":
        raise SpecError(f"{path}: is no STL file, or a part of one; write it again as STL")
    at = np.flatnonzero(np.array(words) == b"vertex")
    try:
        corners = np.array([words[i + 1 : i + 4] for i in at], dtype=float)
        return _finite(path, corners.reshape(-1, 3, 3))
    except ValueError:
        raise SpecError(
            f"{path}: is no STL file of text: not every triangle has three corners of three numbers"
        ) from None


def _finite(path: Path, corners: np.ndarray) -> np.ndarray:
    if not len(corners) or not np.isfinite(corners).all():
        raise SpecError(f"{path}: has no triangles, or corners that are no numbers")
    return corners
