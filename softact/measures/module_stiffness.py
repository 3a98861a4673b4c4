"""Stiffness of one module of a chain as the cross-section of a rod."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure
from softact.measures.cross_section import CrossSection
from softact.measures.module import STRAINS

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot

UNITS = ("N", "Nmm", "Nmm2")  # by how many of two strains are curvatures


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    if snapshot.model.repeat is None:
        return {}
    section = CrossSection(snapshot.model, snapshot.state)
    free, columns = np.flatnonzero(section.free), {}
    stiffness = section.stiffness()
    for a, i in enumerate(free):
        for b, j in enumerate(free[a:], start=a):
            unit = UNITS[int(i < 3) + int(j < 3)]
            columns[f"module_stiffness_{STRAINS[i]}_{STRAINS[j]}_{unit}"] = float(stiffness[a, b])
    return columns


MODULE_STIFFNESS = Measure(
    "module_stiffness",
    "of a module of a chain: stiffness of the cross-section of the rod that the chain is, at "
    "constant pressure, in the frame of the left face",
    {
        f"module_stiffness_<strain>_<strain>_{unit}": "derivative of moment or force by a strain"
        for unit in UNITS
    },
    _evaluate,
)
