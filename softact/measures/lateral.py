"""How much narrower the actuator gets across its axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from softact.measures.base import Measure

if TYPE_CHECKING:
    from softact.measures.snapshot import Snapshot


def _evaluate(snapshot: Snapshot) -> dict[str, float]:
    model = snapshot.model
    if not model.solids:
        return {}
    along = int(np.argmax(np.abs(snapshot.layout.axis)))
    sums = np.zeros(4)
    for solid in model.solids.values():
        c = solid.right_cauchy_green(snapshot.state.x)
        for i in range(3):  # of fibres along x, y, z: |F e|
            sums[i] += (np.sqrt(c[..., i]) * solid.volumes).sum()
        sums[3] += solid.volumes.sum()
    sums = model.sum(sums)
    mean = sums[:3] / sums[3]
    return {
        f"lateral_contraction_{c}_percent": float(100 * (1 - mean[i]))
        for i, c in enumerate("xyz")
        if i != along
    }


LATERAL = Measure(
    "lateral_contraction",
    "how much shorter fibres across the actuator's axis have become, mean over the volume",
    {
        f"lateral_contraction_{c}_percent": f"one less the mean stretch of the fibres along {c}; "
        "not for the coordinate of the axis"
        for c in "xyz"
    },
    _evaluate,
)
