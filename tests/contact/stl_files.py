"""STL files of a box and of a ball."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np

BOX = np.array(list(product((-0.5, 0.5), repeat=3)))
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def box(size=(1.0, 1.0, 1.0), center=(0.0, 0.0, 0.0)) -> np.ndarray:
    """Corners (12, 3, 3)."""
    triangles = [t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))]
    return (BOX * size + center)[triangles]


def ball(radius: float, center=(0.0, 0.0, 0.0), halvings: int = 4) -> np.ndarray:
    """Corners (8 · 4^halvings, 3, 3) on the sphere, of an octahedron whose edges are halved."""
    signs = list(product((-1, 1), repeat=3))
    corners = np.array([np.diag(s)[:: 1 if np.prod(s) > 0 else -1] for s in signs], float)
    for _ in range(halvings):
        a, b, c = np.moveaxis(corners, 1, 0)
        d, e, f = (_unit(p + q) for p, q in ((a, b), (b, c), (c, a)))
        parts = [(a, d, f), (d, b, e), (f, e, c), (d, e, f)]
        corners = np.concatenate([np.stack(part, axis=1) for part in parts])
    return radius * corners + center


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def write(path: Path, corners: np.ndarray, text: bool = False) -> Path:
    """Write triangles (n, 3, 3) as binary STL, or as text."""
    if text:
        lines = ["solid part"]
        for triangle in corners:
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex " + " ".join(f"{c:.9g}" for c in corner) for corner in triangle]
            lines += ["endloop", "endfacet"]
        path.write_text("\n".join([*lines, "endsolid part"]) + "\n")
        return path
    kind = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    triangles = np.zeros(len(corners), kind)
    triangles["corners"] = corners
    path.write_bytes(bytes(80) + np.uint32(len(corners)).tobytes() + triangles.tobytes())
    return path
