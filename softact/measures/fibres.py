"""How far fibres are stretched."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    solids = snapshot.model.solids.values()
    found = [solid.fibre_stretch(snapshot.state.x) for solid in solids if solid.fibres is not None]
    if not found:
        return {}
    largest = max(float(stretch.max(initial=-np.inf)) for stretch in found)
    return {"max_fibre_stretch": max(snapshot.model.comm.allgather(largest))}


FIBRES = Measure(
    "fibres",
    "largest stretch along the fibres of materials that have any",
    {"max_fibre_stretch": "largest stretch along a fibre, at a quadrature point"},
    _evaluate,
)
