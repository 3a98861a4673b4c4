"""Rows of numbers that compiled code finds, of which it cannot tell the count beforehand."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np

ROOM = 1024  # for rows at first


def rows(search: Callable[[ctypes.c_int64, ctypes.c_void_p], int], width: int) -> np.ndarray:
    """What ``search`` finds, (m, width) int32.

    search: takes for how many rows there is room, and the address of the first; writes no more than
    these and returns how many there are.
    """
    found = np.empty((ROOM, width), np.int32)
    while True:
        count = search(ctypes.c_int64(len(found)), ctypes.c_void_p(found.ctypes.data))
        if count <= len(found):
            return found[:count]
        found = np.empty((count, width), np.int32)
