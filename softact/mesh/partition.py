"""Which process gets which cells: the same for the same mesh, however often it is asked.

A resumed run holds what each process remembers beside its own part of the mesh. The partitioners
that dolfinx has on Debian (PT-SCOTCH) cut the same mesh differently from call to call.
"""

from __future__ import annotations

import numpy as np


def parts(places: np.ndarray, count: int) -> np.ndarray:
    """Number of the process (n,) of each cell, by recursive bisection along the longest side.

    places: centres of the cells (n, 3). count: of processes. Parts differ by a cell at most; an
    actuator is longer than wide, so that the cuts between them are small. Equal places keep the
    order of the cells.
    """
    found = np.zeros(len(places), np.int32)
    _cut(places, np.arange(len(places)), 0, count, found)
    return found


def _cut(places: np.ndarray, cells: np.ndarray, first: int, count: int, found: np.ndarray) -> None:
    if count == 1 or not len(cells):
        found[cells] = first
        return
    inside = places[cells]
    along = inside[:, np.argmax(np.ptp(inside, axis=0))]
    order = cells[np.argsort(along, kind="stable")]
    half = count // 2
    at = len(cells) * half // count
    _cut(places, order[:at], first, half, found)
    _cut(places, order[at:], first + half, count - half, found)
